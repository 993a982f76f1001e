// Counts to places: the sums of all counts before each one, bucket by bucket and chunk by chunk in each of them, so that sorting
// keeps the order of chunks.
//
// One work-item. counts[chunk*buckets + bucket]; *total is the sum of all, of use only if it is no more than a uint holds.

__kernel void scan(__global uint *counts, int chunks, int buckets, __global ulong *total) {
    if (get_global_id(0) != 0)
        return;
    ulong sum = 0;
    for (int b = 0; b < buckets; b++)
        for (int c = 0; c < chunks; c++) {
            const size_t at = (size_t)c * buckets + b;
            const uint count = counts[at];
            counts[at] = (uint)sum;
            sum += count;
        }
    *total = sum;
}
