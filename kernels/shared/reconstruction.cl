// Weights, along one axis, of the reconstruction kernel that a program is built for (KERNEL), and of its estimate of gradients (GRADIENT).
// Taps are the voxels -1 ... 2, counted from the one below the sample. Mirrors `Kernel` and `GradientEstimator` in src/host/layers.

#include "shared/elementary.cl"

#define LINEAR 0
#define CUBIC 1
#define CATMULL_ROM 2
#define BSPLINE 3
#define GAUSSIAN 4
#ifndef KERNEL
#error "KERNEL: LINEAR, CUBIC, CATMULL_ROM, BSPLINE or GAUSSIAN"
#endif

#define CENTRAL 0
#define SMOOTHED 1
#define OWN 2
#ifndef GRADIENT
#error "GRADIENT: CENTRAL, SMOOTHED or OWN"
#endif

#if KERNEL == LINEAR || KERNEL == CUBIC
#define RADIUS 1
#else
#define RADIUS 2
#endif
// Taps with a weight for values; gradients use all four.
#define FIRST_TAP (1 - RADIUS)
#define LAST_TAP RADIUS
#define IS_TAP(n) ((n) >= FIRST_TAP && (n) <= LAST_TAP)

// SEPARATE_GRADIENTS: gradients are estimated from voxels of their own, GRADIENT_VOXEL: those that a B-spline interpolates, or smoothed
// ones.
#ifdef SEPARATE_GRADIENTS
#define OF_OTHER_VOXELS 1
#else
#define OF_OTHER_VOXELS 0
#define GRADIENT_VOXEL VOXEL
#endif

// Whether gradients are estimated at the voxels and interpolated linearly, whatever the kernel. Otherwise they are slopes of the kernel.
#define GRADIENTS_AT_VOXELS (GRADIENT == SMOOTHED || (GRADIENT == CENTRAL && (KERNEL == CATMULL_ROM || OF_OTHER_VOXELS)))

// Weights of taps -1 ... 2; those that neither MIXED nor SLOPE reads are 0.
typedef struct {
    realv tap[4];
} Weights;

// Weighted sum of four numbers. Weights of values sum to one, and weights of slopes to zero: sums of differences from one of the numbers
// keep constant fields exact to the bit. `w`: floats or vectors.
#if KERNEL == GAUSSIAN
#define MIXED(w, before, low, high, behind) ((w)[0] * (before) + (w)[1] * (low) + ((w)[2] * (high) + (w)[3] * (behind)))
#elif RADIUS == 1
#define MIXED(w, before, low, high, behind) ((low) + (w)[2] * ((high) - (low)))
#else
#define MIXED(w, before, low, high, behind) \
    ((low) + (w)[0] * ((before) - (low)) + ((w)[2] * ((high) - (low)) + (w)[3] * ((behind) - (low))))
#endif
#if RADIUS == 1 || GRADIENTS_AT_VOXELS
// Central differences of the two neighbours: their weights add up to a constant.
#define SLOPE(w, before, low, high, behind) ((w)[2] * ((high) - (before)) + (w)[3] * ((behind) - (low)))
#else
#define SLOPE(w, before, low, high, behind) \
    ((w)[0] * ((before) - (low)) + ((w)[2] * ((high) - (low)) + (w)[3] * ((behind) - (low))))
#endif

// Weights of the value at `t`, 0 ... 1 from the voxel below to the next.
static inline Weights value_weights(realv t) {
    Weights w = {{0.0f, 0.0f, 0.0f, 0.0f}};
#if KERNEL == LINEAR
    w.tap[2] = t;
#elif KERNEL == CUBIC
    w.tap[2] = SMOOTHSTEP(t);
#elif KERNEL == CATMULL_ROM
    w.tap[0] = t * (t * (1.0f - 0.5f * t) - 0.5f);
    w.tap[2] = t * (t * (2.0f - 1.5f * t) + 0.5f);
    w.tap[3] = t * t * (0.5f * t - 0.5f);
#elif KERNEL == BSPLINE
    const realv s = 1.0f - t;
    w.tap[0] = s * s * s * (1.0f / 6.0f);
    w.tap[2] = s * s * (0.5f * s - 1.0f) + (2.0f / 3.0f);
    w.tap[3] = t * t * t * (1.0f / 6.0f);
#else
    // c1 exp(-2 x^2), c1 = sqrt(2/pi) / erf(2 sqrt 2).
    for (int n = 0; n < 4; n++) {
        const realv x = t - (n - 1.0f);
        w.tap[n] = 0.7979350f * fast_exp2(x * x * -2.8853900818f);
    }
#endif
    return w;
}

#if KERNEL != GAUSSIAN
// Weights of the slope along the axis: the derivative of the kernel, or central differences of the field over one voxel in each direction.
// GRADIENTS_AT_VOXELS: central differences at the two voxels, interpolated.
static inline Weights slope_weights(realv t) {
    Weights w = {{0.0f, 0.0f, 0.0f, 0.0f}};
#if GRADIENTS_AT_VOXELS
    w.tap[0] = 0.5f * t - 0.5f, w.tap[2] = -w.tap[0], w.tap[3] = 0.5f * t;
#elif KERNEL == CATMULL_ROM
    w.tap[0] = t * (2.0f - 1.5f * t) - 0.5f;
    w.tap[2] = t * (4.0f - 4.5f * t) + 0.5f;
    w.tap[3] = t * (1.5f * t - 1.0f);
#elif KERNEL == BSPLINE
    const realv s = 1.0f - t;
    w.tap[0] = -0.5f * s * s;
    w.tap[2] = -s * (1.5f * s - 2.0f);
    w.tap[3] = 0.5f * t * t;
#else
    const realv next = value_weights(t).tap[2];
    w.tap[0] = 0.5f * next - 0.5f, w.tap[2] = -w.tap[0], w.tap[3] = 0.5f * next;
#endif
    return w;
}

// Weights of a gradient across its direction: those of values or, GRADIENTS_AT_VOXELS, of estimates at the two voxels.
// SMOOTHED: `smoothing` is the weight of each neighbour of a voxel.
static inline Weights across_weights(realv t, float smoothing) {
#if GRADIENTS_AT_VOXELS
    Weights w = {{0.0f, 0.0f, 0.0f, 0.0f}};
#if GRADIENT == SMOOTHED
    w.tap[0] = smoothing - smoothing * t, w.tap[2] = smoothing + (1.0f - 3.0f * smoothing) * t, w.tap[3] = smoothing * t;
#else
    w.tap[2] = t;
#endif
    return w;
#else
    return value_weights(t);
#endif
}
#endif

// Weighted sum of four numbers across the direction of a gradient, and the taps that it reads.
#if GRADIENT == SMOOTHED
#define ACROSS(w, before, low, high, behind) \
    ((low) + (w)[0] * ((before) - (low)) + ((w)[2] * ((high) - (low)) + (w)[3] * ((behind) - (low))))
#define IS_ACROSS_TAP(n) ((n) >= -1 && (n) <= 2)
#elif GRADIENTS_AT_VOXELS
#define ACROSS(w, before, low, high, behind) ((low) + (w)[2] * ((high) - (low)))
#define IS_ACROSS_TAP(n) ((n) == 0 || (n) == 1)
#else
#define ACROSS MIXED
#define IS_ACROSS_TAP IS_TAP
#endif
