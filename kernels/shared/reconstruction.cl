// The kernel that reconstructs the field, by what a program is built for (KERNEL): its weights along one axis, of the four voxels
// around a place: -1 ... 2 from the one below it. Mirrors `Kernel` in src/layers.

#include "shared/elementary.cl"

#define LINEAR 0
#define CUBIC 1
#define CATMULL_ROM 2
#define BSPLINE 3
#define GAUSSIAN 4
#ifndef KERNEL
#error "KERNEL: LINEAR, CUBIC, CATMULL_ROM, BSPLINE or GAUSSIAN"
#endif

#if KERNEL == LINEAR || KERNEL == CUBIC
#define RADIUS 1
#else
#define RADIUS 2
#endif
// The voxels that a value has a share of; gradients have one of all four.
#define FIRST_TAP (1 - RADIUS)
#define LAST_TAP RADIUS
#define IS_TAP(n) ((n) >= FIRST_TAP && (n) <= LAST_TAP)

// Of voxels -1 ... 2; those that neither MIXED nor SLOPE takes are 0.
typedef struct {
    realv of[4];
} Weights;

// A weighted sum of four numbers; weights sum to one, of slopes to nothing: taken as differences from one of the numbers, what is flat
// stays flat to the bit. `w`: numbers or vectors.
#if KERNEL == GAUSSIAN
#define MIXED(w, before, low, high, behind) ((w)[0] * (before) + (w)[1] * (low) + ((w)[2] * (high) + (w)[3] * (behind)))
#elif RADIUS == 1
#define MIXED(w, before, low, high, behind) ((low) + (w)[2] * ((high) - (low)))
#else
#define MIXED(w, before, low, high, behind) \
    ((low) + (w)[0] * ((before) - (low)) + ((w)[2] * ((high) - (low)) + (w)[3] * ((behind) - (low))))
#endif
#if RADIUS == 1
// Central differences of the two around: those of one are as much less as those of the other are more.
#define SLOPE(w, before, low, high, behind) ((w)[2] * ((high) - (before)) + (w)[3] * ((behind) - (low)))
#else
#define SLOPE(w, before, low, high, behind) \
    ((w)[0] * ((before) - (low)) + ((w)[2] * ((high) - (low)) + (w)[3] * ((behind) - (low))))
#endif

// What voxels count for the value at `t`, 0 ... 1 from the one below to the next.
static inline Weights value_weights(realv t) {
    Weights w = {{0.0f, 0.0f, 0.0f, 0.0f}};
#if KERNEL == LINEAR
    w.of[2] = t;
#elif KERNEL == CUBIC
    w.of[2] = SMOOTHSTEP(t);
#elif KERNEL == CATMULL_ROM
    w.of[0] = t * (t * (1.0f - 0.5f * t) - 0.5f);
    w.of[2] = t * (t * (2.0f - 1.5f * t) + 0.5f);
    w.of[3] = t * t * (0.5f * t - 0.5f);
#elif KERNEL == BSPLINE
    const realv s = 1.0f - t;
    w.of[0] = s * s * s * (1.0f / 6.0f);
    w.of[2] = s * s * (0.5f * s - 1.0f) + (2.0f / 3.0f);
    w.of[3] = t * t * t * (1.0f / 6.0f);
#else
    // c1 exp(-2 x^2), c1 = sqrt(2/pi) / erf(2 sqrt 2).
    for (int n = 0; n < 4; n++) {
        const realv x = t - (n - 1.0f);
        w.of[n] = 0.7979350f * exp2_of(x * x * -2.8853900818f);
    }
#endif
    return w;
}

#if KERNEL != GAUSSIAN
// What voxels count for the gradient along the axis: the kernel's own derivative, or, of LINEAR and CUBIC, central differences of the
// field over one voxel each way.
static inline Weights slope_weights(realv t) {
    Weights w = {{0.0f, 0.0f, 0.0f, 0.0f}};
#if KERNEL == CATMULL_ROM
    w.of[0] = t * (2.0f - 1.5f * t) - 0.5f;
    w.of[2] = t * (4.0f - 4.5f * t) + 0.5f;
    w.of[3] = t * (1.5f * t - 1.0f);
#elif KERNEL == BSPLINE
    const realv s = 1.0f - t;
    w.of[0] = -0.5f * s * s;
    w.of[2] = -s * (1.5f * s - 2.0f);
    w.of[3] = 0.5f * t * t;
#else
    const realv next = value_weights(t).of[2];
    w.of[0] = 0.5f * next - 0.5f, w.of[2] = -w.of[0], w.of[3] = 0.5f * next;
#endif
    return w;
}
#endif
