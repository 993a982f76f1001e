// One point-sampled layer under a tile of a lattice: its field at the samples, and how these are lit.
//
// All factors of a separable kernel are small: per voxel row that of u is applied to all columns of a tile at once (a resampled
// row), and per lattice row that of v mixes the rows around it. Sub-layer l = 0 ... (n - 1 + 2 RADIUS) S, S samples per layer, lies at
// k = l/S - RADIUS; its voxel rows are those of the layers around it, mixed. Gradients are slopes along their own axis and values along
// the others, along the layer axis too: the layers around are resampled where the rays cross this one, not where they cross those.

#include "shared/accumulator.cl"
#include "shared/lit_way.cl"
#include "shared/volume.cl"

#ifndef TILE_ROWS
#error "TILE_ROWS: samples of a tile along v"
#endif

// Voxels between neighbouring samples, at most; the plan sees to it.
#define VOXELS_PER_SAMPLE 2
// Voxel rows and columns under a tile: the window of a sample is -1 ... 2.
#define ROWS (VOXELS_PER_SAMPLE * TILE_ROWS + 4)
#define SPAN_VECTORS ((VOXELS_PER_SAMPLE * VW + 4 + VW - 1) / VW)

// Where a tile's rows cross the middle layer, padded to whole vectors.
#define PADDED_ROWS ((TILE_ROWS + VW - 1) / VW * VW)
typedef struct {
    float centre[PADDED_ROWS], shear[PADDED_ROWS];
} TileRows;

// Weights of voxel rows -1 ... 2, per row of a tile.
typedef struct {
    float of[4][PADDED_ROWS];
} RowWeights;

// Samples of a tile's rows: the field there, and the light, where that is known.
typedef struct {
    realv field[TILE_ROWS];
    Lit lit[TILE_ROWS];
} Samples;

// One sub-layer under a tile.
typedef struct {
    int held;                    // which one
    int lit;                     // rows whose light is known, a bit each
    Samples at;
    int below[PADDED_ROWS] __attribute__((aligned(64))); // the voxel row below the samples
    float between[PADDED_ROWS];  // where they lie from it, 0, to the next, 1
    RowWeights weights;
} Layer;

// First and last voxel below the rays between two crossings.
static inline void voxels_below(float2 one, float2 other, float depth, int *lo, int *hi) {
    const float a = one.x + depth * one.y, b = other.x + depth * other.y;
    *lo = whole_below(MIN(a, b));
    *hi = whole_below(MAX(a, b));
}

// The voxels under a tile's columns in one sub-layer.
typedef struct {
    int k;           // layer at or below it
    float above;     // where it lies from that, 0, to the next, 1
    float layers[4]; // what layers k-1 ... k+2 count
    bool mixes;      // others than k do
    int first;       // voxel of a span's first column: one before the one below the outermost sample
    int vectors;     // of a span
    bool inside;     // no voxel of a span is beside the volume
    intv offset;     // of the voxel below each column, in the span
    realv between;   // where each column lies from it, 0, to the next, 1
    Weights u;       // what voxels -1 ... 2 count
} Columns;

// Weights as numbers, of which all lanes are the same.
static inline void store_first(const Weights *w, float *out) {
    for (int n = 0; n < 4; n++)
        out[n] = ((const float *)&w->of[n])[0];
}

static inline Columns columns_under(const VolumeView *view, int samples_per_layer, int l, realv u) {
    Columns c;
    c.k = l / samples_per_layer - RADIUS;
    c.above = (float)(l % samples_per_layer) / samples_per_layer;
    const Weights layers = value_weights((realv)(c.above));
    store_first(&layers, c.layers);
    c.mixes = KERNEL == BSPLINE || c.above > 0.0f;
    const intv below = wholes_below(u);
    c.between = u - CONVERT_REALV(below);
    c.u = value_weights(c.between);
    const int *ends = (const int *)&below;
    c.first = min(ends[0], ends[VW - 1]) - 1;
    c.vectors = (max(ends[0], ends[VW - 1]) + 3 - c.first + VW - 1) / VW;
    c.inside = c.first >= 0 && c.first + c.vectors * VW <= view->dims_u;
    c.offset = below - c.first;
    return c;
}

static inline void store_weights(const Weights *w, int row, RowWeights *rows) {
    for (int n = 0; n < 4; n++)
        STOREV(rows->of[n] + row, w->of[n]);
}

// A number of the rows around a tile's row r, from four neighbouring ones: MIXED or SLOPE.
#define OF_ROWS(TAKE, weights, r, number) \
    TAKE(((const float[4]){(weights).of[0][r], 0.0f, (weights).of[2][r], (weights).of[3][r]}), (number)[0], (number)[1], (number)[2], (number)[3])

// Row j of layer k under a tile's columns, `vectors` of them. `inside`: it is known to be in the volume from end to end.
ALWAYS_INLINE void load_span(__global const VOXEL *voxels, const VolumeView *view, const Columns *c, int j, int k,
                                int vectors, bool inside, float *span) {
    if (inside || (c->inside && j >= 0 && j < view->dims_v && k >= 0 && k < view->dims_a)) {
        __global const VOXEL *start = voxels + (k - view->first_a) * view->stride_a + j * view->stride_v + c->first;
        for (int i = 0; i < vectors; i++)
            STOREV(span + i * VW, VALUES_OF(view, LOAD_VOXELS(start + i * VW)));
    } else {
        load_row(voxels, view, c->first, j, k, vectors, span);
    }
}

// Whether a voxel row, column or layer, counted from the one before a place, counts for values beside the one below it.
#define IS_OTHER_TAP(n) ((n) != 1 && IS_TAP((n) - 1))

// Row j of the layers around a sub-layer, mixed.
ALWAYS_INLINE void mixed_span(__global const VOXEL *voxels, const VolumeView *view, const Columns *c, int j, int vectors,
                              bool inside, float *span) {
    load_span(voxels, view, c, j, c->k, vectors, inside, span);
    if (!c->mixes)
        return;
    float low[SPAN_VECTORS * VW];
    for (int i = 0; i < vectors * VW; i += VW)
        STOREV(low + i, LOADV(span + i));
#pragma unroll
    for (int n = 0; n < 4; n++) {
        if (!IS_OTHER_TAP(n) || c->layers[n] == 0.0f)
            continue;
        float other[SPAN_VECTORS * VW];
        load_span(voxels, view, c, j, c->k - 1 + n, vectors, inside, other);
        for (int i = 0; i < vectors * VW; i += VW)
            STOREV(span + i, LOADV(span + i) + c->layers[n] * (LOADV(other + i) - LOADV(low + i)));
    }
}

// The voxel below each column, or one `step` away from it.
#define UNDER(span, step) PICK(span, vectors, c->offset + (step))
// And only if it counts for values.
#define TAP_UNDER(span, step) (IS_TAP(step) ? UNDER(span, step) : (realv)(0.0f))

// Resampled voxel rows.
ALWAYS_INLINE void sample_rows(__global const VOXEL *voxels, const VolumeView *view, const Columns *c, int first, int last,
                               int vectors, bool inside, realv *value) {
    for (int j = first; j <= last; j++) {
        float span[SPAN_VECTORS * VW];
        mixed_span(voxels, view, c, j, vectors, inside, span);
        const realv before = TAP_UNDER(span, -1), low = UNDER(span, 0), high = UNDER(span, 1), behind = TAP_UNDER(span, 2);
        *value++ = MIXED(c->u.of, before, low, high, behind);
    }
}

// Resampled voxel rows, and their slopes along u and the layer axis.
typedef struct {
    realv value[ROWS], along_u[ROWS], along_a[ROWS];
} Slopes;

// What voxels count for slopes, along u, and layers along theirs.
typedef struct {
    Weights u;
    float layers[4];
} SlopeWeights;

ALWAYS_INLINE void differentiate_rows(__global const VOXEL *voxels, const VolumeView *view, const Columns *c, const SlopeWeights *w,
                                      int first, int last, int vectors, bool inside, Slopes *s) {
    for (int j = first, row = 0; j <= last; j++, row++) {
        float low[SPAN_VECTORS * VW], own[SPAN_VECTORS * VW], across[SPAN_VECTORS * VW];
        load_span(voxels, view, c, j, c->k, vectors, inside, low);
        for (int i = 0; i < vectors * VW; i += VW) {
            STOREV(own + i, LOADV(low + i));
            STOREV(across + i, (realv)(0.0f));
        }
#pragma unroll
        for (int n = 0; n < 4; n++) {
            if (n == 1 || w->layers[n] == 0.0f)
                continue;
            float other[SPAN_VECTORS * VW];
            load_span(voxels, view, c, j, c->k - 1 + n, vectors, inside, other);
            for (int i = 0; i < vectors * VW; i += VW) {
                const realv difference = LOADV(other + i) - LOADV(low + i);
                STOREV(across + i, LOADV(across + i) + w->layers[n] * difference);
                if (c->mixes && IS_OTHER_TAP(n))
                    STOREV(own + i, LOADV(own + i) + c->layers[n] * difference);
            }
        }
        const realv o0 = UNDER(own, -1), o1 = UNDER(own, 0), o2 = UNDER(own, 1), o3 = UNDER(own, 2);
        s->value[row] = MIXED(c->u.of, o0, o1, o2, o3);
        s->along_u[row] = SLOPE(w->u.of, o0, o1, o2, o3);
        const realv a0 = TAP_UNDER(across, -1), a1 = UNDER(across, 0), a2 = UNDER(across, 1), a3 = TAP_UNDER(across, 2);
        s->along_a[row] = MIXED(c->u.of, a0, a1, a2, a3);
    }
}

// Runs WORK(vectors, inside) on rows [first, last] of layers [from, to], with constants where these are most frequent: that is,
// without branches and loops.
#define ON_ROWS(WORK, first, last, from, to)                                                                           \
    const bool inside =                                                                                                \
        columns.inside && (first) >= 0 && (last) < view->dims_v && (from) >= 0 && (to) < view->dims_a;                 \
    if (inside && columns.vectors == 1)                                                                                \
        WORK(1, true);                                                                                                 \
    else if (inside && columns.vectors == 2)                                                                           \
        WORK(2, true);                                                                                                 \
    else                                                                                                               \
        WORK(columns.vectors, false)

// Samples sub-layer l. `u`: the columns, `tile_v`: the rows of the tile.
static inline void sample_layer(__global const VOXEL *voxels, const VolumeView *view, float centre_layer, int samples_per_layer,
                         int l, realv u, const TileRows *tile_v, int rows, Layer *layer) {
    layer->held = l, layer->lit = 0;
    const float depth = (float)l / samples_per_layer - RADIUS - centre_layer;
    for (int r = 0; r < TILE_ROWS; r += VW) {
        const realv v = LOADV(tile_v->centre + r) + depth * LOADV(tile_v->shear + r);
        const intv below = wholes_below(v);
        *(intv *)(layer->below + r) = below;
        const realv between = v - CONVERT_REALV(below);
        STOREV(layer->between + r, between);
        const Weights weights = value_weights(between);
        store_weights(&weights, r, &layer->weights);
    }
    const int one = layer->below[0], other = layer->below[rows - 1];
    const int first = min(one, other) + FIRST_TAP, last = max(one, other) + LAST_TAP;
    const Columns columns = columns_under(view, samples_per_layer, l, u);
    realv value[ROWS];
#define SAMPLE(vectors, inside) sample_rows(voxels, view, &columns, first, last, vectors, inside, value)
    ON_ROWS(SAMPLE, first, last, columns.k + FIRST_TAP, columns.k + LAST_TAP);
    for (int r = 0; r < rows; r++) {
        // From the row before the one below on; only those that count are there.
        const realv *v = value + (layer->below[r] - 1 - first);
        layer->at.field[r] = OF_ROWS(MIXED, layer->weights, r, v);
    }
}

// Lights the samples of some of a tile's rows, a bit each.
static inline void light_layer(__global const VOXEL *voxels, const VolumeView *view, const SampleParams *p, int samples_per_layer,
                        realv u, int tile_rows, Layer *layer) {
    tile_rows &= ~layer->lit;
    if (!tile_rows)
        return;
    layer->lit |= tile_rows;
    const int one = layer->below[31 - clz(tile_rows)], other = layer->below[31 - clz(tile_rows & -tile_rows)];
    const int first = min(one, other) - 1, last = max(one, other) + 2;
    const Columns columns = columns_under(view, samples_per_layer, layer->held, u);
    SlopeWeights weights;
    weights.u = slope_weights(columns.between);
    const Weights layers = slope_weights((realv)(columns.above));
    store_first(&layers, weights.layers);
    RowWeights slopes_v;
    for (int r = 0; r < TILE_ROWS; r += VW) {
        const Weights w = slope_weights(LOADV(layer->between + r));
        store_weights(&w, r, &slopes_v);
    }
    Slopes slopes;
#define DIFFERENTIATE(vectors, inside) \
    differentiate_rows(voxels, view, &columns, &weights, first, last, vectors, inside, &slopes)
    ON_ROWS(DIFFERENTIATE, first, last, columns.k - 1, columns.k + 2);
    for (int rows = tile_rows; rows; rows &= rows - 1) {
        const int r = 31 - clz(rows & -rows), j = layer->below[r] - 1 - first;
        const realv along_u = OF_ROWS(MIXED, layer->weights, r, slopes.along_u + j);
        const realv along_v = OF_ROWS(SLOPE, slopes_v, r, slopes.value + j);
        const realv along_a = OF_ROWS(MIXED, layer->weights, r, slopes.along_a + j);
        layer->at.lit[r] = lit_by(p, along_u, along_v, along_a);
    }
}
