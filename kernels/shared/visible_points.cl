// Empty-space skipping at points anywhere in a field.

#include "shared/reconstruction.cl"
#include "shared/volume.cl"

#define LAST_SLAB(view) ((view)->dims_a + (2 * RADIUS - 2))

// visible: a bit per block and slab (slab_visibility.cl). Tests points, in the cells between the two layers of a slab.
static inline intv cells_visible(__global const uchar *visible, int blocks_u, int blocks_v, const VolumeView *view, realv u, realv v, realv a) {
    const intv b = CLAMP_INTV((floor_ints(u) >> BLOCK_U_BITS) + 1, 0, blocks_u - 1);
    const intv c = CLAMP_INTV((floor_ints(v) >> BLOCK_V_BITS) + 1, 0, blocks_v - 1);
    const intv q = CLAMP_INTV(floor_ints(a) + RADIUS, 0, LAST_SLAB(view));
    const intv at = ((q >> 3) * blocks_v + c) * blocks_u + b;
#ifdef GATHER_WORDS
    const intv bits = GATHER_WORDS(visible, at);
#else
    const intv bits = GATHER_AS(intv, visible, at);
#endif
    return -(bits >> (q & 7) & 1);
}

// Whether anything can be visible in a box.
static inline bool visible_between(__global const uchar *visible, int blocks_u, int blocks_v, const VolumeView *view, const float *lowest,
                                   const float *highest) {
    int lo[3], hi[3];
    for (int i = 0; i < 3; i++) {
        lo[i] = (int)CLAMP(lowest[i] - 1e-3f, -1e6f, 1e6f);
        hi[i] = (int)CLAMP(highest[i] + 1e-3f, -1e6f, 1e6f);
        // (int) rounds towards 0.
        lo[i] -= 1;
    }
    const int b0 = clamp((lo[0] >> BLOCK_U_BITS) + 1, 0, blocks_u - 1), b1 = clamp((hi[0] >> BLOCK_U_BITS) + 1, 0, blocks_u - 1);
    const int c0 = clamp((lo[1] >> BLOCK_V_BITS) + 1, 0, blocks_v - 1), c1 = clamp((hi[1] >> BLOCK_V_BITS) + 1, 0, blocks_v - 1);
    const int q0 = clamp(lo[2] + RADIUS, 0, LAST_SLAB(view)) >> 3, q1 = clamp(hi[2] + RADIUS, 0, LAST_SLAB(view)) >> 3;
    for (int q = q0; q <= q1; q++)
        for (int c = c0; c <= c1; c++)
            for (int b = b0; b <= b1; b++)
                if (visible[((size_t)q * blocks_v + c) * blocks_u + b])
                    return true;
    return false;
}

// Whether anything can be visible in the bounding box of two sets of ray points.
static inline bool box_visible(__global const uchar *visible, int blocks_u, int blocks_v, const VolumeView *view, const realv *one,
                               const realv *other) {
    float lowest[3], highest[3];
    for (int i = 0; i < 3; i++)
        lowest[i] = smallest_lane(MIN(one[i], other[i])), highest[i] = largest_lane(MAX(one[i], other[i]));
    return visible_between(visible, blocks_u, blocks_v, view, lowest, highest);
}
