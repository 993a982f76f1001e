// Visibility of a range of values in a transfer table.

#include "shared/elementary.cl"
#include "shared/volume.cl"

// Value limits of a block of a layer, from min_max_blocks.cl. A limit at the end of the voxel type's range also stands for a background
// beyond that range.
static inline void block_limits(__global const VOXEL *limits, float background, float offset, size_t block, float *lo, float *hi) {
    const VOXEL below = VOXEL_BELOW(background + offset), above = VOXEL_ABOVE(background + offset);
    __global const VOXEL *limit = limits + 2 * block;
    const float least = convert_float(limit[0]) - offset, most = convert_float(limit[1]) - offset;
    *lo = limit[0] <= below ? MIN(least, background) : least;
    *hi = limit[1] >= above ? MAX(most, background) : most;
}

// Whether any value between lo and hi can be visible: it has opacity, and lies between `least` and `largest`, the values that matter to
// the blend mode.
static inline bool any_visible(float lo, float hi, float least, float largest, float table_first, float table_per_value, int table_last,
                               __global const uint *visible_before) {
    // Weights sum to 1 only up to rounding: the range is extended slightly, relative to the values and in entries. No more than that:
    // volumes are full of their smallest value, which often is the last invisible one.
    const float slack = 2e-5f * MAX(fabs(lo), fabs(hi)), last = table_last;
    if (hi + slack < least || lo - slack > largest)
        return false;
    const int first = CLAMP((lo - slack - table_first) * table_per_value + 0.48f, 0.0f, last);
    const int end = CLAMP((hi + slack - table_first) * table_per_value + 0.52f, 0.0f, last);
    return visible_before[end + 1] > visible_before[first];
}

#if VW > 1
// The same of vectors of values: all bits set where any can be.
static inline intv any_visible_of(realv lo, realv hi, float least, float largest, float table_first, float table_per_value, int table_last,
                                  __global const uint *visible_before) {
    const realv slack = 2e-5f * MAX(fabs(lo), fabs(hi)), last = table_last;
    const intv first = CONVERT_INTV(CLAMP((lo - slack - table_first) * table_per_value + 0.48f, (realv)(0.0f), last));
    const intv end = CONVERT_INTV(CLAMP((hi + slack - table_first) * table_per_value + 0.52f, (realv)(0.0f), last));
    const intv more = GATHER_AS(uintv, visible_before, end + 1) > GATHER_AS(uintv, visible_before, first);
    return more & ~(hi + slack < least | lo - slack > largest);
}
#endif
