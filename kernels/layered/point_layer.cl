// Samples and lighting of one point-sampled layer under a tile of a lattice.
//
// The kernel is separable: each voxel row is first interpolated along u at all columns of the tile (a resampled row), then the rows
// around each lattice row are combined along v. Sub-layer l = 0 ... (n - 1 + 2 RADIUS) S, with S samples per layer, lies at k = l/S -
// RADIUS; its voxel rows are combined from the layers around it. A gradient component is the slope along its own axis and the weighted
// sum ACROSS it along the others, also along the layer axis: neighbouring layers are resampled at the crossings of this layer, not of
// theirs.

#include "layered/columns.cl"
#include "shared/span_lighting.cl"

// Samples of a tile's patches: field, and lighting where it has been computed.
typedef struct {
    realv field[TILE_ROWS];
    LitSample lit[TILE_ROWS];
} Samples;

// One sub-layer under a tile.
typedef struct {
    int index;                   // number of the sub-layer
    int sampled, lit;            // bit masks of patches with a known field, and with known lighting
    Samples at;
    RowPlaces rows;
} Layer;

// Runs a statement for each vector of a span of `vectors`; i is its first column. Unrolled: in a loop, arrays would be in memory.
#define ON_SPAN(i)                                    \
    _Pragma("unroll") for (int i = 0; i < SPAN_VECTORS * VW; i += VW) \
        if (i < vectors * VW)

#include "shared/value_voxels.cl"
#include "layered/voxel_spans.cl"

#ifdef SEPARATE_GRADIENTS
#include "shared/gradient_voxels.cl"
#include "layered/voxel_spans.cl"
#else
#define gradient_load_span load_span
#define gradient_weighted_differences weighted_differences
#endif

// Whether tap n, counted from the one before a position, has a weight for values and is not the tap below the position.
#define IS_OTHER_TAP(n) ((n) != 1 && IS_TAP((n) - 1))

// Row j, interpolated between the layers around a sub-layer.
ALWAYS_INLINE void mixed_span(__global const VOXEL *voxels, const VolumeView *view, const Columns *c, int j, int vectors,
                              bool inside, float *span) {
    load_span(voxels, view, c, j, c->k, vectors, inside, span);
    if (!c->mixes)
        return;
    float low[SPAN_VECTORS * VW];
    ON_SPAN(i)
        STOREV(low + i, LOADV(span + i));
#pragma unroll
    for (int n = 0; n < 4; n++) {
        if (!IS_OTHER_TAP(n) || c->layers[n] == 0.0f)
            continue;
        float other[SPAN_VECTORS * VW];
        load_span(voxels, view, c, j, c->k - 1 + n, vectors, inside, other);
        ON_SPAN(i)
            STOREV(span + i, LOADV(span + i) + c->layers[n] * (LOADV(other + i) - LOADV(low + i)));
    }
}

// The voxel below each column, at the offset `step`.
#define UNDER(span, step) PICK(span, vectors, c->offset + (step))
// The same, if that tap has a weight for values, or across gradients.
#define TAP_UNDER(span, step) (IS_TAP(step) ? UNDER(span, step) : (realv)(0.0f))
#define ACROSS_TAP_UNDER(span, step) (IS_ACROSS_TAP(step) ? UNDER(span, step) : (realv)(0.0f))

// Resamples voxel rows along u.
ALWAYS_INLINE void sample_rows(__global const VOXEL *voxels, const VolumeView *view, const Columns *columns, int first, int last,
                               int vectors, bool inside, realv *value) {
    for (int j = first; j <= last; j++) {
        const Columns in_row = columns_in_row(columns, j), *c = &in_row;
        float span[SPAN_VECTORS * VW];
        mixed_span(voxels, view, c, j, vectors, inside, span);
        const realv before = TAP_UNDER(span, -1), low = UNDER(span, 0), high = UNDER(span, 1), behind = TAP_UNDER(span, 2);
        *value++ = MIXED(c->u.tap, before, low, high, behind);
    }
}

// Whether gradients mix several layers across the layer axis.
#if GRADIENTS_AT_VOXELS
#define MIXES_ACROSS(c) true
#else
#define MIXES_ACROSS(c) (c)->mixes
#endif

// Resampled voxel rows, as gradients across them see them, and their slopes along u and the layer axis.
typedef struct {
    realv value[ROWS], along_u[ROWS], along_a[ROWS];
} Slopes;

// Weights of slopes along u, and of gradients across it.
typedef struct {
    Weights u, across_u;
} ColumnSlopes;

// Weights of slopes along the layer axis, and of gradients across it; and those of columns if these are the same in all rows.
typedef struct {
    float layers[4], across_layers[4];
    float smoothing_u;
#ifndef PIXEL_RAYS
    ColumnSlopes columns;
#endif
} SlopeWeights;

static inline ColumnSlopes slopes_of_columns(const Columns *c, float smoothing) {
    ColumnSlopes w;
    w.u = slope_weights(c->between);
#if GRADIENTS_AT_VOXELS
    w.across_u = across_weights(c->between, smoothing);
#else
    w.across_u = c->u;
#endif
    return w;
}

static inline SlopeWeights slope_weights_under(const Columns *c, const FieldParams *field) {
    SlopeWeights w;
    w.smoothing_u = field->smoothing_u;
#ifndef PIXEL_RAYS
    w.columns = slopes_of_columns(c, field->smoothing_u);
#endif
    const Weights layers = slope_weights((realv)(c->above));
    store_first(&layers, w.layers);
#if GRADIENTS_AT_VOXELS
    const Weights across_layers = across_weights((realv)(c->above), field->smoothing_a);
    store_first(&across_layers, w.across_layers);
#else
    for (int n = 0; n < 4; n++)
        w.across_layers[n] = c->layers[n];
#endif
    return w;
}

// Row j, as gradients across the layer axis see it, and its slope along the layer axis.
ALWAYS_INLINE void differentiate_span(const ShadingSource *source, const Columns *c, const SlopeWeights *w, int j,
                                      int vectors, bool inside, float *own, float *across) {
    gradient_load_span(source->voxels, source->view, c, j, c->k, vectors, inside, own);
#if GRADIENT == SMOOTHED
    // On a layer: its two neighbours alone.
    if (c->above == 0.0f) {
        float before[SPAN_VECTORS * VW];
        gradient_load_span(source->voxels, source->view, c, j, c->k - 1, vectors, inside, before);
        gradient_load_span(source->voxels, source->view, c, j, c->k + 1, vectors, inside, across);
        ON_SPAN(i) {
            const realv low = LOADV(own + i), one = LOADV(before + i) - low, other = LOADV(across + i) - low;
            STOREV(own + i, low + w->across_layers[0] * (one + other));
            STOREV(across + i, w->layers[2] * (other - one));
        }
        return;
    }
#elif RADIUS == 1 || GRADIENTS_AT_VOXELS
    // On a layer: central differences of the two neighbours.
    if (c->above == 0.0f) {
        if (inside) {
            gradient_weighted_differences(source->voxels, source->view, c, j, w->layers[2], vectors, across);
        } else {
            float before[SPAN_VECTORS * VW];
            gradient_load_span(source->voxels, source->view, c, j, c->k - 1, vectors, inside, before);
            gradient_load_span(source->voxels, source->view, c, j, c->k + 1, vectors, inside, across);
            ON_SPAN(i)
                STOREV(across + i, w->layers[2] * (LOADV(across + i) - LOADV(before + i)));
        }
        return;
    }
#endif
    float low[SPAN_VECTORS * VW];
    ON_SPAN(i) {
        STOREV(low + i, LOADV(own + i));
        STOREV(across + i, (realv)(0.0f));
    }
#pragma unroll
    for (int n = 0; n < 4; n++) {
        if (n == 1 || w->layers[n] == 0.0f)
            continue;
        float other[SPAN_VECTORS * VW];
        gradient_load_span(source->voxels, source->view, c, j, c->k - 1 + n, vectors, inside, other);
        ON_SPAN(i) {
            const realv difference = LOADV(other + i) - LOADV(low + i);
            STOREV(across + i, LOADV(across + i) + w->layers[n] * difference);
            if (MIXES_ACROSS(c) && IS_ACROSS_TAP(n - 1))
                STOREV(own + i, LOADV(own + i) + w->across_layers[n] * difference);
        }
    }
}

ALWAYS_INLINE void differentiate_rows(const ShadingSource *source, const Columns *columns, const SlopeWeights *w,
                                      int first, int last, int vectors, bool inside, Slopes *s) {
    for (int j = first, row = 0; j <= last; j++, row++) {
        float own[SPAN_VECTORS * VW], across[SPAN_VECTORS * VW];
        const Columns in_row = columns_in_row(columns, j), *c = &in_row;
        differentiate_span(source, c, w, j, vectors, inside, own, across);
#ifdef PIXEL_RAYS
        const ColumnSlopes slopes = slopes_of_columns(c, w->smoothing_u);
#else
        const ColumnSlopes slopes = w->columns;
#endif
        const realv o0 = UNDER(own, -1), o1 = UNDER(own, 0), o2 = UNDER(own, 1), o3 = UNDER(own, 2);
        s->value[row] = ACROSS(slopes.across_u.tap, o0, o1, o2, o3);
        s->along_u[row] = SLOPE(slopes.u.tap, o0, o1, o2, o3);
        const realv a0 = ACROSS_TAP_UNDER(across, -1), a1 = UNDER(across, 0), a2 = UNDER(across, 1), a3 = ACROSS_TAP_UNDER(across, 2);
        s->along_a[row] = ACROSS(slopes.across_u.tap, a0, a1, a2, a3);
    }
}

// Columns that lean reach under more voxels.
#if defined(PIXEL_RAYS) && VW < 16
#define ON_LONG_ROWS(WORK) else if (inside && columns.vectors == 3) WORK(3, true);
#else
#define ON_LONG_ROWS(WORK)
#endif

// Runs WORK(vectors, inside) on rows [first, last] of layers [from, to], with constant arguments in the most frequent cases, which
// removes branches and loops.
#define ON_ROWS(WORK, first, last, from, to)                                                                           \
    const bool inside =                                                                                                \
        columns.inside && (first) >= 0 && (last) < view->dims_v && (from) >= 0 && (to) < view->dims_a;                 \
    if (inside && columns.vectors == 1)                                                                                \
        WORK(1, true);                                                                                                 \
    else if (inside && columns.vectors == 2)                                                                           \
        WORK(2, true);                                                                                                 \
    ON_LONG_ROWS(WORK)                                                                                                 \
    else                                                                                                               \
        WORK(columns.vectors, false)

// Interpolates the patches of some bands along v, from resampled voxel rows that begin with row `first`.
ALWAYS_INLINE void mix_rows(const RowPlaces *rows, const realv *value, int first, int first_band, int last_band, int farthest,
                            realv *patches) {
    for (int band = first_band; band <= last_band; band++) {
        realv field[PATCH_ROWS];
#pragma unroll
        for (int i = 0; i < PATCH_ROWS; i++) {
            const int r = band * PATCH_ROWS + i;
            // From the row before the one below on. Only rows with a weight are present.
            const realv *v = value + (rows->below[r] - 1 - first);
            const RowMix mix = row_mix(rows, r, farthest);
            field[i] = MIXED_ROWS(mix, v, farthest);
        }
        regroup(field);
#pragma unroll
        for (int i = 0; i < PATCH_ROWS; i++)
            patches[band * PATCH_ROWS + i] = field[i];
    }
}

// Samples the missing patches of sub-layer l: all bands from the first to the last that lacks one.
static inline void sample_layer(__global const VOXEL *voxels, const VolumeView *view, float centre_layer, int samples_per_layer, int l,
                                const Tile *tile, int patches, Layer *layer) {
    if (layer->index != l) {
        layer->index = l, layer->sampled = layer->lit = 0;
        place_rows(&tile->v, (float)l / samples_per_layer - RADIUS - centre_layer, &layer->rows);
    }
    patches &= ~layer->sampled;
    layer->sampled |= patches;
    const int first_band = LOWEST_BIT(patches) / PATCH_ROWS, last_band = HIGHEST_BIT(patches) / PATCH_ROWS;
    const int one = layer->rows.below[first_band * PATCH_ROWS], other = layer->rows.below[(last_band + 1) * PATCH_ROWS - 1];
    const int first = min(one, other) + FIRST_TAP, last = max(one, other) + LAST_TAP + layer->rows.farthest;
    const Columns columns = columns_under(view, centre_layer, samples_per_layer, l, tile, first, last);
    realv value[ROWS];
#define SAMPLE(vectors, inside) sample_rows(voxels, view, &columns, first, last, vectors, inside, value)
    ON_ROWS(SAMPLE, first, last, columns.k + FIRST_TAP, columns.k + LAST_TAP);
#define MIX(farthest) mix_rows(&layer->rows, value, first, first_band, last_band, farthest, layer->at.field)
    ON_STAGGERED(MIX, layer->rows.farthest);
}

// Gradients of some patches, from resampled voxel rows that begin with row `first`.
ALWAYS_INLINE void mix_slopes(const Tile *tile, const RowPlaces *rows, const Slopes *slopes, int first, int first_band, int last_band,
                              int patches, int farthest, Gradient *gradients) {
    for (int band = first_band; band <= last_band; band++) {
        if (!(patches & LOW_BITS(PATCH_ROWS) << band * PATCH_ROWS))
            continue;
        realv along_u[PATCH_ROWS], along_v[PATCH_ROWS], along_a[PATCH_ROWS];
#pragma unroll
        for (int i = 0; i < PATCH_ROWS; i++) {
            const int r = band * PATCH_ROWS + i, j = rows->below[r] - 1 - first;
            const RowMix mix = row_mix(rows, r, farthest);
            along_u[i] = ACROSS_ROWS(mix, slopes->along_u + j, farthest);
            along_v[i] = SLOPE_ROWS(mix, slopes->value + j, farthest);
#ifdef PIXEL_RAYS
            // That was the slope along the column, which leans.
            along_v[i] -= tile->lean * along_u[i];
#endif
            along_a[i] = ACROSS_ROWS(mix, slopes->along_a + j, farthest);
        }
        regroup(along_u), regroup(along_v), regroup(along_a);
#pragma unroll
        for (int i = 0; i < PATCH_ROWS; i++) {
            Gradient *gradient = &gradients[band * PATCH_ROWS + i];
            gradient->u = along_u[i], gradient->v = along_v[i], gradient->a = along_a[i];
        }
    }
}

// Where the rays of a patch cross plane k.
static inline Point patch_points(const RayLatticeParams *p, const Tile *tile, int patch, float k) {
    const SampleRays rays = patch_rays(p, tile, patch);
    const float depth = k - p->centre_layer;
    const Point point = {rays.centre_u + depth * rays.shear_u, rays.centre_v + depth * rays.shear_v, (realv)(k)};
    return point;
}

// Lights the samples of some patches of a tile.
static inline void light_layer(const ShadingSource *source, const RayLatticeParams *p, const SampleParams *sample, const Tile *tile,
                               int samples_per_layer, int patches, Layer *layer) {
    patches &= ~layer->lit;
    if (!patches)
        return;
    layer->lit |= patches;
    const int first_band = LOWEST_BIT(patches) / PATCH_ROWS, last_band = HIGHEST_BIT(patches) / PATCH_ROWS;
    const int one = layer->rows.below[first_band * PATCH_ROWS], other = layer->rows.below[(last_band + 1) * PATCH_ROWS - 1];
    const int first = min(one, other) - 1, last = max(one, other) + 2 + layer->rows.farthest;
    const VolumeView *view = source->view;
    const Columns columns = columns_under(view, p->centre_layer, samples_per_layer, layer->index, tile, first, last);
    const SlopeWeights weights = slope_weights_under(&columns, &sample->field);
    prepare_slopes(&layer->rows, sample->field.smoothing_v);
    Slopes slopes;
#define DIFFERENTIATE(vectors, inside) \
    differentiate_rows(source, &columns, &weights, first, last, vectors, inside, &slopes)
    ON_ROWS(DIFFERENTIATE, first, last, columns.k - 1, columns.k + 2);
    // All gradients before any lighting: shorter loops overlap better, 10 % on engine.
    Gradient gradients[TILE_ROWS];
#define MIX_SLOPES(farthest) mix_slopes(tile, &layer->rows, &slopes, first, first_band, last_band, patches, farthest, gradients)
    ON_STAGGERED(MIX_SLOPES, layer->rows.farthest);
    for (int left = patches; left; left &= left - 1) {
        const int n = LOWEST_BIT(left);
        const Point point = patch_points(p, tile, n, (float)layer->index / samples_per_layer - RADIUS);
        layer->at.lit[n] = light_sample(sample, source->light, point, layer->at.field[n], gradients[n]);
    }
}
