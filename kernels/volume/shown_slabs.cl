// The first and the last slab in which anything can be visible (slab_visibility.cl), rounded to whole chunks. If there is none, the first
// is beyond the last.
//
// Two passes: `shown_chunks`, one work-item per chunk of 8 slabs, tests whether any of its blocks can be visible; `shown_slabs`, one
// work-item, finds the outermost visible chunks.

__kernel void shown_chunks(__global const uchar *visible, int per_layer, int chunks, __global uchar *shows, ulong first_item) {
    const int chunk = first_item + get_global_id(0);
    if (chunk >= chunks)
        return;
    __global const uchar *block = visible + (size_t)chunk * per_layer;
    uchar any = 0;
    for (int n = 0; n < per_layer; n++)
        any |= block[n];
    shows[chunk] = any;
}

__kernel void shown_slabs(__global const uchar *shows, int chunks, int slabs, __global int *shown, ulong first_item) {
    if (first_item + get_global_id(0) > 0)
        return;
    int first = 0, last = chunks - 1;
    while (first < chunks && !shows[first])
        first++;
    while (last >= first && !shows[last])
        last--;
    shown[0] = 8 * first;
    shown[1] = min(8 * last + 7, slabs - 1);
}
