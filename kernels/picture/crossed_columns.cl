// Warp of lattices whose staggered columns have a sample wherever a row (or a column) of pixels crosses them
// (src/host/layers/lattice/aligned.rs). A pixel is interpolated between four columns, along that row. That takes four samples per pixel, instead
// of sixteen.

#include "picture/own_samples.cl"
#include "picture/lines.cl"

// Rows of the lattice per column, along rows (or columns) of pixels. Without variable indices, for which GPUs keep arguments in memory.
static inline float crossing_slope(const WarpParams *p) {
    const float *m = p->from_screen;
    const bool along_rows = p->crossed_along == 1;
    return (along_rows ? m[3] : m[4]) / (along_rows ? m[0] : m[1]);
}

// The sample of column i where the row of pixels through (column, row) crosses it; transparent beyond the lattice.
static inline float4 crossed_sample(__global const float4 *lattice, const WarpParams *p, int i, float column, float row) {
    const float place = row + (i - column) * crossing_slope(p) - STAGGER_STEPS(p, (uint)i) * STAGGER_STEP;
    const int j = NEAREST(float, convert_int, place, p->height);
    return i >= 0 && i < p->width && j >= 0 && j < p->height ? lattice[(size_t)j * p->width + i] : (float4)(0.0f);
}

// The pixel at (x, y). One column after another: GPUs lack the registers for all samples at once.
static inline float4 between_columns(__global const float4 *lattice, const WarpParams *p, float x, float y) {
    const float *m = p->from_screen;
    const float row = m[3] * x + (m[4] * y + m[5]);
    // Clamped, since an int cannot hold positions far beyond the lattice.
    const float column = CLAMP(m[0] * x + (m[1] * y + m[2]), -4.0f, p->width + 4.0f);
    const int below = floor_int(column);
    float4 before = 0.0f, low = 0.0f, high = 0.0f, behind = 0.0f;
#pragma unroll 1
    for (int n = -1; n < 3; n++)
        before = low, low = high, high = behind, behind = crossed_sample(lattice, p, below + n, column, row);
    return filter_color(catmull_rom(column - below), before, low, high, behind);
}

#ifdef FOUR_LINES_AT_ONCE
// Four pixels from (x, y) on.
ALWAYS_INLINE float16 four_between_columns(__global const float4 *lattice, const WarpParams *p, float x, float y) {
    const float *m = p->from_screen;
    const float4 across = x + (float4)(0.0f, 1.0f, 2.0f, 3.0f);
    const float4 row = m[3] * across + (m[4] * y + m[5]);
    const float4 column = CLAMP(m[0] * across + (m[1] * y + m[2]), (float4)(-4.0f), (float4)(p->width + 4.0f));
    const int4 below = convert_int4(column + 4.0f) - 4;
    // Four lanes per column: one for each pixel.
    const int16 i = (int16)(below - 1, below, below + 1, below + 2);
    const float16 stagger = convert_float16(as_int16(STAGGER_STEPS(p, as_uint16(i)))) * STAGGER_STEP;
    const float16 place = (float16)(row, row, row, row) - stagger +
                          (convert_float16(i) - (float16)(column, column, column, column)) * crossing_slope(p);
    const int16 j = NEAREST(float16, convert_int16, place, p->height);
    const int16 beyond = i < 0 | i >= p->width | j < 0 | j >= p->height, at = j * p->width + i;
    const FourWeights w = catmull_rom_four(column - convert_float4(below));
    float16 samples[4];
    sixteen_samples(lattice, at, beyond, samples);
    return filter_four(&w, samples[0], samples[1], samples[2], samples[3]);
}
#endif
