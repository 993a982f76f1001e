// The coefficients of the interpolating B-spline, along one axis after the other: `taps` (src/layers/prefilter.rs), a symmetric filter
// from its middle on, over numbers that are mirrored at the ends of the whole axis.
//
// Of an axis of `whole` voxels `held` are here, from `first` on. Where others would be needed, what comes out is of no use: parts hold
// enough of them. All sums are taken in vectors and in one order, so that coefficients are those of the whole volume to the bit.

#include "shared/vector.cl"

#ifndef PREFILTER_RADIUS
#error "PREFILTER_RADIUS: taps to either side"
#endif
#ifndef GROUP
#error "GROUP: work-items of a group, at most"
#endif

// Which of the held voxels stands for voxel i of them.
static inline int mirrored(int i, int first, int held, int whole) {
    const int period = max(2 * (whole - 1), 1);
    i = abs(first + i) % period;
    return clamp((i < whole ? i : period - i) - first, 0, held - 1);
}
