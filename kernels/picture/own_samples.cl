// Pixels that each have a sample of their own, for lattices aligned with the pixels along both axes: no interpolation.

#include "picture/display.cl"
#include "shared/stagger.cl"

// Nearest integers to positions on a lattice of `size` samples. Clamped, since an int cannot hold positions far beyond it.
#define NEAREST(realn, convert_intn, place, size) \
    (convert_intn(CLAMP(place, (realn)(-2.0f), (realn)((size) + 2.0f)) + 2.5f) - 2)
// Indices of the samples of pixels (x, y), and whether they are beyond the lattice. Declares the variables at the beginning of a
// function, in floats or in vectors.
#define FIND_SAMPLES(realn, intn, uintn, p, x, y, at, beyond)                                                          \
    const float *m = (p)->from_screen;                                                                                 \
    const realn u = m[0] * (x) + (m[1] * (y) + m[2]), v = m[3] * (x) + (m[4] * (y) + m[5]);                            \
    const intn i = NEAREST(realn, CAT(convert_, intn), u, (p)->width);                                                 \
    const realn stagger = CAT(convert_, realn)(STAGGER_STEPS(p, CAT(as_, uintn)(i))) * STAGGER_STEP;                   \
    const intn j = NEAREST(realn, CAT(convert_, intn), v - stagger, (p)->height);                                      \
    const intn beyond = i < 0 | i >= (p)->width | j < 0 | j >= (p)->height, at = j * (p)->width + i;

// The pixel at (x, y); transparent beyond the lattice.
static inline float4 own_sample(__global const float4 *lattice, const WarpParams *p, float x, float y) {
    FIND_SAMPLES(float, int, uint, p, x, y, at, beyond)
    return beyond ? (float4)(0.0f) : lattice[at];
}

// The samples at sixteen places of the lattice, four in each vector; transparent where they are `beyond` it.
ALWAYS_INLINE void sixteen_samples(__global const float4 *lattice, int16 at, int16 beyond, float16 *fours) {
    const int8 any8 = beyond.lo | beyond.hi;
    const int4 any4 = any8.lo | any8.hi;
    const int *one = (const int *)&at, *is_beyond = (const int *)&beyond;
    if (any4.x | any4.y | any4.z | any4.w) {
        for (int n = 0; n < 16; n++)
            ((float4 *)fours)[n] = is_beyond[n] ? (float4)(0.0f) : lattice[one[n]];
    } else {
#pragma unroll
        for (int n = 0; n < 4; n++, one += 4)
            fours[n] = (float16)(lattice[one[0]], lattice[one[1]], lattice[one[2]], lattice[one[3]]);
    }
}

// Sixteen pixels from (x, y) on, four in each vector.
ALWAYS_INLINE void sixteen_own_samples(__global const float4 *lattice, const WarpParams *p, float x, float y, float16 *fours) {
    const float16 columns = x + (float16)(0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f,
                                          8.0f, 9.0f, 10.0f, 11.0f, 12.0f, 13.0f, 14.0f, 15.0f);
    FIND_SAMPLES(float16, int16, uint16, p, columns, y, at, beyond)
    sixteen_samples(lattice, at, beyond, fours);
}
