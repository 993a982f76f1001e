// Colours of the voxels of a field among several, in programs with TINTED: instead of those of its transfer function.
//
// A voxel has red, green, blue and a weight, as bytes, so that transparent voxels do not bleed their colour. Colours are interpolated linearly
// by these weights.

#include "shared/elementary.cl"
#include "shared/point.cl"
#include "shared/words.cl"

#if defined(TINTED) && defined(CHANNELS)

typedef struct {
    __global const uchar *voxels;
    const VolumeView *view;
    // Bytes from a voxel to the next along u, v, a; 0 without colours.
    int strides[3];
} Tint;

// Lower voxel of a cell along an axis with `dims` voxels, and the position in the cell, 0 ... 1.
static inline intv color_cell(int dims, realv position, realv *within) {
    const realv clamped = CLAMP(position, (realv)(0.0f), (realv)(dims - 1));
    const intv cell = CLAMP_INTV(CONVERT_INTV(clamped), 0, max(dims - 2, 0));
    *within = clamped - CONVERT_REALV(cell);
    return cell;
}

// Replaces a colour by that of the voxels around a point, which is among the field's voxels.
ALWAYS_INLINE void mix_color(const Tint *tint, Point point, realv *r, realv *g, realv *b) {
    const VolumeView *view = tint->view;
    const int *strides = tint->strides;
    if (!strides[0])
        return;
    realv s, t, u;
    const intv i = color_cell(view->dims_u, point.u, &s), j = color_cell(view->dims_v, point.v, &t);
    const intv k = color_cell(view->dims_a, point.a, &u), first = i * strides[0] + j * strides[1] + k * strides[2];
    // An axis with a single voxel has no next one.
    const int next_u = view->dims_u > 1 ? strides[0] : 0, next_v = view->dims_v > 1 ? strides[1] : 0;
    const int next_a = view->dims_a > 1 ? strides[2] : 0;
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
        const realv share = (n & 1 ? s : 1.0f - s) * (n & 2 ? t : 1.0f - t) * (n & 4 ? u : 1.0f - u);
        const realv weight = (corners == 1 ? (realv)(1.0f) : share) * CONVERT_REALV((words[n] >> 24) & 255);
        sum += weight;
#pragma unroll
        for (int c = 0; c < 3; c++)
            color[c] += weight * CONVERT_REALV((words[n] >> (8 * c)) & 255);
    }
    const intv known = sum > 0.0f;
    const realv scale = (1.0f / 255.0f) * reciprocal(known ? sum : (realv)(1.0f));
    *r = known ? color[0] * scale : *r;
    *g = known ? color[1] * scale : *g;
    *b = known ? color[2] * scale : *b;
}

#endif
