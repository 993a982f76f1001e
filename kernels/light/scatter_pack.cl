// The light field as samples look it up (shared/light_field.cl): four words per cell, x fastest, without space around the cells.
//
// The first word has the mean radiance in red, green and blue, nine bits each, and their exponent. The others have the flux along x, y and z,
// each in red, green and blue as shares of the radiance, ten bits each, from -1 to 1.

#include "shared/elementary.cl"

#define LARGEST_MANTISSA 511
#define LOWEST_EXPONENT (-15)

// Light of VW cells: planes of the mean radiance, then of the flux along x, y and z.
#define LIGHT_PLANES 12

static inline intv packed_radiance(const realv *radiance) {
    const realv largest = MAX(MAX(radiance[0], radiance[1]), MAX(radiance[2], (realv)(0x1p-20f)));
    // Of largest < 2^exponent, unless it is rounded to that.
    intv exponent = CLAMP_INTV((AS_INTV(largest) >> 23) - 126, LOWEST_EXPONENT, LOWEST_EXPONENT + 31);
    const realv rounded = largest * AS_REALV((127 + 9 - exponent) << 23) + 0.5f;
    exponent = MIN(exponent + COUNT_IF(rounded >= (float)(LARGEST_MANTISSA + 1)), (intv)(LOWEST_EXPONENT + 31));
    const realv scale = AS_REALV((127 + 9 - exponent) << 23);
    intv word = (exponent - LOWEST_EXPONENT) << 27;
#pragma unroll
    for (int c = 0; c < 3; c++)
        word |= MIN(CONVERT_INTV(radiance[c] * scale + 0.5f), (intv)(LARGEST_MANTISSA)) << (9 * c);
    return word;
}

// The words of cells.
static inline void pack_light(const realv *light, intv *words) {
    realv radiance[3];
#pragma unroll
    for (int c = 0; c < 3; c++)
        radiance[c] = MAX(light[c], (realv)(0.0f));
    words[0] = packed_radiance(radiance);
#pragma unroll
    for (int axis = 0; axis < 3; axis++) {
        words[1 + axis] = 0;
#pragma unroll
        for (int c = 0; c < 3; c++) {
            const realv share = light[3 + 3 * axis + c] / MAX(radiance[c], (realv)(1e-9f));
            words[1 + axis] |= CONVERT_INTV(CLAMP(share, (realv)(-1.0f), (realv)(1.0f)) * 511.0f + 511.5f) << (10 * c);
        }
    }
}

// Adds what `pack_light` has packed.
static inline void add_packed(const intv *words, realv *light) {
    const realv scale = AS_REALV((((words[0] >> 27) & 31) + (LOWEST_EXPONENT + 127 - 9)) << 23);
#pragma unroll
    for (int c = 0; c < 3; c++) {
        const realv radiance = scale * CONVERT_REALV((words[0] >> (9 * c)) & LARGEST_MANTISSA);
        light[c] += radiance;
#pragma unroll
        for (int axis = 0; axis < 3; axis++) {
            const realv share = CONVERT_REALV((words[1 + axis] >> (10 * c)) & 1023) * (1.0f / 511.0f) - 1.0f;
            light[3 + 3 * axis + c] += radiance * share;
        }
    }
}

// Words of the first `count` of VW cells that follow one another.
static inline void load_words(__global const int *cells, int count, intv *words) {
    int *each = (int *)words;
    for (int i = 0; i < count; i++)
        for (int n = 0; n < 4; n++)
            each[VW * n + i] = cells[4 * i + n];
}
static inline void store_words(const intv *words, int count, __global int *cells) {
    const int *each = (const int *)words;
    for (int i = 0; i < count; i++)
        for (int n = 0; n < 4; n++)
            cells[4 * i + n] = each[VW * n + i];
}
