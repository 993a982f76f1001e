// Coefficients of the interpolating B-spline, computed along one axis after another. `taps` (src/layers/prefilter.rs) is one half of a
// symmetric filter, from its centre on; voxels are mirrored at the ends of the whole axis.
//
// Of the `whole` voxels along an axis, `held` are resident, starting with `first`. Where others would be needed, the results are invalid:
// parts of a volume include enough of them. All sums are in vectors and in one order, so that the coefficients are those of the whole
// volume to the bit.

#include "shared/vector.cl"

#ifndef PREFILTER_RADIUS
#error "PREFILTER_RADIUS: taps to either side"
#endif
#ifndef GROUP
#error "GROUP: work-items of a group, at most"
#endif

// Index, among the resident voxels, of the one used for voxel i, which can lie outside.
static inline int mirrored(int i, int first, int held, int whole) {
    const int period = max(2 * (whole - 1), 1);
    i = abs(first + i) % period;
    return clamp((i < whole ? i : period - i) - first, 0, held - 1);
}
