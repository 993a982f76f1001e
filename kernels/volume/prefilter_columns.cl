// Filter along y or z, in place. One work-item per column of at most VW numbers, id = line * chunks + chunk: `line_stride` from line
// to line, `stride` between consecutive numbers of a column.

#include "volume/prefilter.cl"

// Number of unfiltered numbers of a column in the ring, a power of two.
#define RING_SIZE 32
#if VW == 1
// The ring is indexed by a variable: on GPUs it is in local memory, which the work-items of a group share.
#define DECLARE_RING __local float ring[RING_SIZE * GROUP]
#define RING_AT(n) ring[((n) & (RING_SIZE - 1)) * GROUP + get_local_id(0)]
#else
#define DECLARE_RING realv ring[RING_SIZE]
#define RING_AT(n) ring[(n) & (RING_SIZE - 1)]
#endif

static inline realv load_partial(__global const float *from, int count) {
    if (count == VW)
        return LOAD_VOXELS(from);
    realv partial = 0.0f;
    for (int n = 0; n < count; n++)
        ((float *)&partial)[n] = from[n];
    return partial;
}

__kernel void prefilter_columns(__global float *filtered, __global const float *taps, int first, int held, int whole, ulong stride,
                                int chunks, int width, int lines, ulong line_stride, float background, ulong first_item) {
    DECLARE_RING;
    const size_t id = first_item + get_global_id(0);
    if (id >= (size_t)chunks * lines)
        return;
    const int chunk = id % chunks, count = min(VW, width - VW * chunk);
    __global float *column = filtered + id / chunks * line_stride + VW * chunk;
    for (int n = -PREFILTER_RADIUS; n < PREFILTER_RADIUS; n++)
        RING_AT(n) = OR_BACKGROUND(realv, n, load_partial(column + resident(n, first, held, whole) * stride, count));
    for (int n = 0; n < held; n++) {
        // Numbers of the column that are used beyond its end are still in the ring.
        const int next = n + PREFILTER_RADIUS;
        RING_AT(next) = next < held ? load_partial(column + next * stride, count)
                                    : OR_BACKGROUND(realv, next, RING_AT(resident(next, first, held, whole)));
        realv sum = taps[0] * RING_AT(n);
        for (int k = 1; k <= PREFILTER_RADIUS; k++)
            sum += taps[k] * (RING_AT(n - k) + RING_AT(n + k));
        for (int i = 0; i < count; i++)
            column[n * stride + i] = ((const float *)&sum)[i];
    }
}
