// Colours of labels over a scan that is drawn alone, in programs with TINTED. Those of fields among several: voxel_colors.cl.
//
// A voxel of the labels has the index of a colour: red, green and blue times their weight, and the weight, as bytes, so that voxels without
// a label do not bleed a colour. Colour 0 is that of no label. These four are interpolated linearly, on a grid of their own. Beyond it, the
// outer voxels go on for a while.

#include "shared/cell_corners.cl"
#include "shared/point.cl"
#include "shared/words.cl"

#if defined(TINTED) && !defined(CHANNELS)

// Arguments of a kernel, and the last member of the ShadingSource that it makes of them.
#define TINT_ARGUMENTS __global const uchar *label_voxels, __global const uchar *label_colors, TintParams tint_params,
#define TINT_SOURCE , {label_voxels, label_colors, &tint_params}

typedef struct {
    __global const uchar *voxels, *colors;
    const TintParams *params;
} Tint;

// Position along axis n of the labels, in their voxels.
static inline realv label_position(const TintParams *p, int n, Point point) {
    const float *row = p->to_voxels + 4 * n;
    return row[0] * point.u + (row[1] * point.v + (row[2] * point.a + row[3]));
}

// Mixes a colour with that of the labels at a point: (1 - w) C + c, where c is their colour times the weight w.
ALWAYS_INLINE void mix_color(const Tint *tint, Point point, realv *r, realv *g, realv *b) {
    const TintParams *p = tint->params;
    const realv x = label_position(p, 0, point), y = label_position(p, 1, point), z = label_position(p, 2, point);
    const float before = -p->beyond, behind = p->beyond - 1.0f;
    const intv inside = x >= before && x <= p->dims_x + behind && y >= before && y <= p->dims_y + behind && z >= before &&
                        z <= p->dims_z + behind;
    if (!ANY(inside))
        return;
    realv within[3];
    const intv i = lower_voxel(p->dims_x, x, within), j = lower_voxel(p->dims_y, y, within + 1), k = lower_voxel(p->dims_z, z, within + 2);
    const intv first = (i + p->dims_x * (j + p->dims_y * k)) * p->bytes;
    // To the next row and plane. Along x, a word has both voxels.
    const int next_y = to_next_voxel(p->dims_y, p->dims_x * p->bytes), next_z = to_next_voxel(p->dims_z, p->dims_x * p->dims_y * p->bytes);
    const int bits = 8 * p->bytes, mask = (1 << bits) - 1;
    intv indices[8], any = 0, uneven = 0;
#pragma unroll
    for (int n = 0; n < 4; n++) {
        const intv word = WORDS_AT(tint->voxels, first + ((n & 1) * next_y + (n >> 1) * next_z));
        indices[2 * n] = word & mask, indices[2 * n + 1] = (word >> bits) & mask;
        any |= indices[2 * n] | indices[2 * n + 1];
        uneven |= (indices[2 * n] ^ indices[0]) | (indices[2 * n + 1] ^ indices[0]);
    }
    if (!ANY(inside && any != 0))
        return;
    realv color[4] = {(realv)(0.0f), (realv)(0.0f), (realv)(0.0f), (realv)(0.0f)};
    // Most cells lie within one label.
    const int corners = ANY(inside && uneven != 0) ? 8 : 1;
    for (int n = 0; n < corners; n++) {
        const intv word = WORDS_AT(tint->colors, indices[n] * 4);
        const realv share = corners == 1 ? (realv)(1.0f) : corner_share(n, within);
#pragma unroll
        for (int c = 0; c < 4; c++)
            color[c] += share * byte_of_words(word, c);
    }
    const realv scale = inside ? (realv)(1.0f / 255.0f) : (realv)(0.0f);
    const realv left = 1.0f - color[3] * scale;
    *r = left * *r + color[0] * scale;
    *g = left * *g + color[1] * scale;
    *b = left * *b + color[2] * scale;
}

#else
#define TINT_ARGUMENTS
#define TINT_SOURCE
#endif
