// Colours of the voxels of a field among several, in programs with TINTED: instead of those of its transfer function.
//
// A voxel has red, green, blue and a weight, as bytes, so that transparent voxels do not bleed their colour. Colours are interpolated linearly
// by these weights.

#include "shared/cell_corners.cl"
#include "shared/linear_light.cl"
#include "shared/point.cl"
#include "shared/words.cl"

#if defined(TINTED) && defined(CHANNELS)

typedef struct {
    __global const uchar *voxels;
    // Bytes from a voxel to the next along u, v, a; 0 without colours.
    int strides[3], dims[3];
} Tint;

// Replaces a colour by that of the voxels around a point, which is among the voxels with colours.
ALWAYS_INLINE void mix_color(const Tint *tint, Point point, realv *r, realv *g, realv *b) {
    const int *strides = tint->strides, *dims = tint->dims;
    if (!strides[0])
        return;
    realv within[3];
    const intv i = lower_voxel(dims[0], point.u, within), j = lower_voxel(dims[1], point.v, within + 1);
    const intv k = lower_voxel(dims[2], point.a, within + 2), first = i * strides[0] + j * strides[1] + k * strides[2];
    const int next_u = to_next_voxel(dims[0], strides[0]), next_v = to_next_voxel(dims[1], strides[1]);
    const int next_a = to_next_voxel(dims[2], strides[2]);
    intv words[8], uneven = 0;
#pragma unroll
    for (int n = 0; n < 8; n++) {
        words[n] = WORDS_AT(tint->voxels, first + ((n & 1) * next_u + (n >> 1 & 1) * next_v + (n >> 2) * next_a));
        uneven |= words[n] ^ words[0];
    }
    realv color[3] = {(realv)(0.0f), (realv)(0.0f), (realv)(0.0f)}, sum = 0.0f;
    // Most cells of labels lie within one of them.
    const int corners = ANY(uneven != 0) ? 8 : 1;
    for (int n = 0; n < corners; n++) {
        const realv weight = (corners == 1 ? (realv)(1.0f) : corner_share(n, within)) * byte_of_words(words[n], 3);
        sum += weight;
#pragma unroll
        for (int c = 0; c < 3; c++)
            color[c] += weight * byte_of_words(words[n], c);
    }
    const intv known = sum > 0.0f;
    const realv scale = (1.0f / 255.0f) * reciprocal(known ? sum : (realv)(1.0f));
    *r = known ? LIT_COLOR(color[0] * scale) : *r;
    *g = known ? LIT_COLOR(color[1] * scale) : *g;
    *b = known ? LIT_COLOR(color[2] * scale) : *b;
}

#endif
