// Prefix sums of counts: the sum of all counts before each one, by bucket and, within a bucket, by chunk. Sorting by these keeps the
// order of chunks.
//
// One work-group of up to SCAN_GROUP work-items, each with a range of consecutive counts. counts[chunk*buckets + bucket]; *total is the
// sum of all, and the counts are valid only if it fits in a uint.

#ifndef SCAN_GROUP
#error "SCAN_GROUP: work-items of a group, at most"
#endif

// Advances to the next count in the order of the sums. Dividing for each would take longer than all else.
static inline void next_count(int chunks, int *chunk, int *bucket) {
    const bool is_last = *chunk + 1 == chunks;
    *bucket += is_last ? 1 : 0;
    *chunk = is_last ? 0 : *chunk + 1;
}

__kernel void scan(__global uint *counts, int chunks, int buckets, __global ulong *total, ulong first_item) {
    __local ulong sums[SCAN_GROUP];
    // Work-groups can be smaller than requested: the first one does all the work.
    if (get_group_id(0) > 0 || !chunks)
        return;
    const uint id = get_local_id(0), size = get_local_size(0);
    const ulong all = (ulong)chunks * buckets, begin = all * id / size, end = all * (id + 1) / size;
    ulong sum = 0;
    int chunk = begin % chunks, bucket = begin / chunks;
    // The sum of the last work-item is never used; a single work-item thus reads the counts only once.
    for (ulong n = begin; n < end && id + 1 < size; n++) {
        sum += counts[(size_t)chunk * buckets + bucket];
        next_count(chunks, &chunk, &bucket);
    }
    sums[id] = sum;
    barrier(CLK_LOCAL_MEM_FENCE);
    sum = 0;
    for (uint before = 0; before < id; before++)
        sum += sums[before];
    chunk = begin % chunks, bucket = begin / chunks;
    for (ulong n = begin; n < end; n++) {
        const size_t at = (size_t)chunk * buckets + bucket;
        const uint count = counts[at];
        counts[at] = (uint)sum;
        sum += count;
        next_count(chunks, &chunk, &bucket);
    }
    if (id == size - 1)
        *total = sum;
}
