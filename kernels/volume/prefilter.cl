// Filters along one axis after another: the prefilter of the interpolating B-spline (src/host/layers/prefilter.rs), and smoothing for gradients
// (src/host/layers/gradient.rs). `taps` is one half of a symmetric filter, from its centre on. Voxels are mirrored at the ends of the whole
// axis; BACKGROUND_OUTSIDE: outside is the background.
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
static inline int resident(int i, int first, int held, int whole) {
#ifndef BACKGROUND_OUTSIDE
    const int period = max(2 * (whole - 1), 1);
    i = abs(first + i) % period;
    i = (i < whole ? i : period - i) - first;
#endif
    return clamp(i, 0, held - 1);
}

// Voxel i of this type, which is `number` if it lies inside.
#ifdef BACKGROUND_OUTSIDE
#define OR_BACKGROUND(type, i, number) (first + (i) < 0 || first + (i) >= whole ? (type)(background) : (number))
#else
#define OR_BACKGROUND(type, i, number) (number)
#endif
