// One point-sampled layer under a tile of a lattice: its field at the samples, and how these are lit.
//
// Both factors of f(u) f(v) are small: per voxel row the u factor is applied to all columns of a tile at once (a resampled
// row), and per lattice row the v factor mixes two of these. Sub-layer l = 0 ... (n+1) S, S samples per layer, lies at
// k = l/S - 1; between two layers it mixes them with f. Gradients are central differences of that field over one voxel each
// way, along the layer axis too: the layers around are resampled where the rays cross this one, not where they cross those.

#include "shared/elementary.cl"
#include "shared/accumulator.cl"
#include "shared/volume.cl"

#ifndef TILE_ROWS
#error "TILE_ROWS: samples of a tile along v"
#endif

// Voxels between neighbouring samples, at most; the plan sees to it.
#define VOXELS_PER_SAMPLE 2
// Voxel rows and columns under a tile: the window of a sample is -1 ... 2 for central differences.
#define ROWS (VOXELS_PER_SAMPLE * TILE_ROWS + 4)
#define SPAN_VECTORS ((VOXELS_PER_SAMPLE * VW + 4 + VW - 1) / VW)

// Where a tile's rows cross the middle layer, padded to whole vectors.
#define PADDED_ROWS ((TILE_ROWS + VW - 1) / VW * VW)
typedef struct {
    float centre[PADDED_ROWS], shear[PADDED_ROWS];
} TileRows;

// One sub-layer under a tile.
typedef struct {
    int held;                    // which one
    int lit;                     // rows whose lighting is known, a bit each
    realv field[TILE_ROWS];      // at the samples
    Lighting lighting[TILE_ROWS];
    int below[PADDED_ROWS] __attribute__((aligned(64))); // the voxel row below the samples
    float weight[PADDED_ROWS];     // weight of the next
} Layer;

// First and last voxel below the rays between two crossings.
inline void voxels_below(float2 one, float2 other, float depth, int *lo, int *hi) {
    const float a = one.x + depth * one.y, b = other.x + depth * other.y;
    *lo = whole_below(MIN(a, b));
    *hi = whole_below(MAX(a, b));
}

// The voxels under a tile's columns in one sub-layer.
typedef struct {
    int k;           // layer at or below it
    float next;      // weight of the layer above
    int first;       // voxel of a span's first column: one before the one below the outermost sample
    int vectors;     // of a span
    bool inside;     // no voxel of a span is beside the volume
    intv offset;     // of the voxel below each column, in the span
    realv weight;      // weight of the next voxel
} Columns;

inline Columns columns_under(const VolumeView *view, int samples_per_layer, int l, realv u) {
    Columns c;
    c.k = (l + samples_per_layer) / samples_per_layer - 2;
    const float above = (float)(l - (c.k + 1) * samples_per_layer) / samples_per_layer;
    c.next = SMOOTHSTEP(above);
    const intv below = wholes_below(u);
    c.weight = SMOOTHSTEP(u - CONVERT_REALV(below));
    const int *ends = (const int *)&below;
    c.first = min(ends[0], ends[VW - 1]) - 1;
    c.vectors = (max(ends[0], ends[VW - 1]) + 3 - c.first + VW - 1) / VW;
    c.inside = c.first >= 0 && c.first + c.vectors * VW <= view->dims_u;
    c.offset = below - c.first;
    return c;
}

// Row j of layer k under a tile's columns, `vectors` of them. `inside`: it is known to be in the volume from end to end.
ALWAYS_INLINE void load_span(__global const VOXEL *voxels, const VolumeView *view, const Columns *c, int j, int k,
                                int vectors, bool inside, float *span) {
    if (inside || (c->inside && j >= 0 && j < view->dims_v && k >= 0 && k < view->dims_a)) {
        __global const VOXEL *start = voxels + (k - view->first_a) * view->stride_a + j * view->stride_v + c->first;
        for (int i = 0; i < vectors; i++)
            STOREV(span + i * VW, LOAD_VOXELS(start + i * VW) - view->offset);
    } else {
        load_row(voxels, view, c->first, j, k, vectors, span);
    }
}

// span += weight * (other - span).
ALWAYS_INLINE void mix_span(float *span, const float *other, float weight, int vectors) {
    for (int i = 0; i < vectors * VW; i += VW)
        STOREV(span + i, LOADV(span + i) + weight * (LOADV(other + i) - LOADV(span + i)));
}

// The voxel below each column, or one `step` away from it.
#define UNDER(span, step) PICK(span, vectors, c->offset + (step))

// Resampled voxel rows.
ALWAYS_INLINE void sample_rows(__global const VOXEL *voxels, const VolumeView *view, const Columns *c, int first, int last,
                               int vectors, bool inside, realv *value) {
    for (int j = first; j <= last; j++) {
        float span[SPAN_VECTORS * VW];
        load_span(voxels, view, c, j, c->k, vectors, inside, span);
        if (c->next != 0.0f) {
            float above[SPAN_VECTORS * VW];
            load_span(voxels, view, c, j, c->k + 1, vectors, inside, above);
            mix_span(span, above, c->next, vectors);
        }
        const realv v0 = UNDER(span, 0);
        *value++ = v0 + c->weight * (UNDER(span, 1) - v0);
    }
}

// Resampled voxel rows, and twice their central differences along u and the layer axis.
typedef struct {
    realv value[ROWS], along_u[ROWS], along_a[ROWS];
} Differences;

ALWAYS_INLINE void differentiate_rows(__global const VOXEL *voxels, const VolumeView *view, const Columns *c, int first,
                                      int last, int vectors, bool inside, Differences *d) {
    for (int j = first, n = 0; j <= last; j++, n++) {
        float own[SPAN_VECTORS * VW], before[SPAN_VECTORS * VW], behind[SPAN_VECTORS * VW];
        load_span(voxels, view, c, j, c->k, vectors, inside, own);
        load_span(voxels, view, c, j, c->k - 1, vectors, inside, before);
        load_span(voxels, view, c, j, c->k + 1, vectors, inside, behind);
        if (c->next != 0.0f) {
            float farther[SPAN_VECTORS * VW];
            load_span(voxels, view, c, j, c->k + 2, vectors, inside, farther);
            mix_span(before, own, c->next, vectors);
            mix_span(own, behind, c->next, vectors);
            mix_span(behind, farther, c->next, vectors);
        }
        for (int i = 0; i < vectors * VW; i += VW)
            STOREV(behind + i, LOADV(behind + i) - LOADV(before + i));
        const realv v0 = UNDER(own, 0), v1 = UNDER(own, 1);
        const realv lo = v1 - UNDER(own, -1), hi = UNDER(own, 2) - v0;
        const realv a0 = UNDER(behind, 0), a1 = UNDER(behind, 1);
        d->value[n] = v0 + c->weight * (v1 - v0);
        d->along_u[n] = lo + c->weight * (hi - lo);
        d->along_a[n] = a0 + c->weight * (a1 - a0);
    }
}

// Runs WORK(vectors, inside) on rows [first, last] of layers [from, to], with constants where these are most frequent: that is,
// without branches and loops.
#define ON_ROWS(WORK, first, last, from, to)                                                                           \
    if (columns.vectors == 1 && columns.inside && (first) >= 0 && (last) < view->dims_v && (from) >= 0 &&              \
        (to) < view->dims_a)                                                                                           \
        WORK(1, true);                                                                                                 \
    else                                                                                                               \
        WORK(columns.vectors, false)

// Samples sub-layer l. `u`: the columns, `tile_v`: the rows of the tile.
inline void sample_layer(__global const VOXEL *voxels, const VolumeView *view, float centre_layer, int samples_per_layer,
                         int l, realv u, const TileRows *tile_v, int rows, Layer *layer) {
    layer->held = l, layer->lit = 0;
    const float depth = (float)l / samples_per_layer - 1.0f - centre_layer;
    for (int r = 0; r < TILE_ROWS; r += VW) {
        const realv v = LOADV(tile_v->centre + r) + depth * LOADV(tile_v->shear + r);
        const intv below = wholes_below(v);
        *(intv *)(layer->below + r) = below;
        STOREV(layer->weight + r, SMOOTHSTEP(v - CONVERT_REALV(below)));
    }
    const int first = min(layer->below[0], layer->below[rows - 1]), last = max(layer->below[0], layer->below[rows - 1]) + 1;
    const Columns columns = columns_under(view, samples_per_layer, l, u);
    realv value[ROWS];
#define SAMPLE(vectors, inside) sample_rows(voxels, view, &columns, first, last, vectors, inside, value)
    ON_ROWS(SAMPLE, first, last, columns.k, columns.k + 1);
    for (int r = 0; r < rows; r++) {
        const realv *v = value + (layer->below[r] - first);
        layer->field[r] = v[0] + layer->weight[r] * (v[1] - v[0]);
    }
}

// Lights the samples of some of a tile's rows, a bit each, by central differences.
inline void light_layer(__global const VOXEL *voxels, const VolumeView *view, const SampleParams *p, int samples_per_layer,
                        realv u, int tile_rows, Layer *layer) {
    tile_rows &= ~layer->lit;
    if (!tile_rows)
        return;
    layer->lit |= tile_rows;
    const int one = layer->below[31 - clz(tile_rows)], other = layer->below[31 - clz(tile_rows & -tile_rows)];
    const int first = min(one, other) - 1, last = max(one, other) + 2;
    const Columns columns = columns_under(view, samples_per_layer, layer->held, u);
    Differences d;
#define DIFFERENTIATE(vectors, inside) differentiate_rows(voxels, view, &columns, first, last, vectors, inside, &d)
    ON_ROWS(DIFFERENTIATE, first, last, columns.k - 1, columns.k + 2);
    for (int rows = tile_rows; rows; rows &= rows - 1) {
        const int r = 31 - clz(rows & -rows), j = layer->below[r] - first;
        const float weight = layer->weight[r];
        const realv u = d.along_u[j] + weight * (d.along_u[j + 1] - d.along_u[j]);
        const realv lo = d.value[j + 1] - d.value[j - 1], hi = d.value[j + 2] - d.value[j];
        const realv a = d.along_a[j] + weight * (d.along_a[j + 1] - d.along_a[j]);
        layer->lighting[r] = light_gradient(p, 0.5f * u, 0.5f * (lo + weight * (hi - lo)), 0.5f * a);
    }
}
