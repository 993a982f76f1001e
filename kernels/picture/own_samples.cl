// Pixels of which each has a sample of its own, as where samples of a lattice lie on pixels along both axes: nothing is interpolated.

#include "picture/display.cl"
#include "shared/stagger.cl"

// The whole number nearest to a place on the lattice, which has so many samples.
#define NEAREST(place, size) (whole_below(CLAMP(place, -2.0f, (size) + 2.0f) + 0.5f))

// At (x, y). Beyond the lattice all is transparent.
static inline float4 own_sample(__global const float4 *lattice, const WarpParams *p, float x, float y) {
    const float *m = p->from_screen;
    // Far beyond the lattice an int could not hold the place.
    const int i = NEAREST(m[0] * x + m[1] * y + m[2], p->width);
    const int j = NEAREST(m[3] * x + m[4] * y + m[5] - convert_float(STAGGER_STEPS(p, (uint)i)) * STAGGER_STEP, p->height);
    return i >= 0 && i < p->width && j >= 0 && j < p->height ? lattice[(size_t)j * p->width + i] : (float4)(0.0f);
}

// Of four pixels from (x, y) on.
ALWAYS_INLINE float16 four_own_samples(__global const float4 *lattice, const WarpParams *p, float x, float y) {
    const float *m = p->from_screen;
    const float4 columns = x + (float4)(0.0f, 1.0f, 2.0f, 3.0f);
    const float4 u = m[0] * columns + (m[1] * y + m[2]), v = m[3] * columns + (m[4] * y + m[5]);
    const int4 i = convert_int4(CLAMP(u, (float4)(-2.0f), (float4)(p->width + 2.0f)) + 2.5f) - 2;
    const float4 row = v - convert_float4(STAGGER_STEPS(p, as_uint4(i))) * STAGGER_STEP;
    const int4 j = convert_int4(CLAMP(row, (float4)(-2.0f), (float4)(p->height + 2.0f)) + 2.5f) - 2;
    const int4 beyond = i < 0 | i >= p->width | j < 0 | j >= p->height, at = j * p->width + i;
    if (beyond.x | beyond.y | beyond.z | beyond.w)
        return (float16)(own_sample(lattice, p, x, y), own_sample(lattice, p, x + 1.0f, y), own_sample(lattice, p, x + 2.0f, y),
                         own_sample(lattice, p, x + 3.0f, y));
    return (float16)(lattice[at.x], lattice[at.y], lattice[at.z], lattice[at.w]);
}
