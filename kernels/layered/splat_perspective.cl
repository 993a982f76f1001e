// Layered splatting on the lattice of a perspective view: a ray has the same (I, J) in all layers, and crosses layer k at u = c_u + (k -
// k_c) s_u(I), v = c_v + (k - k_c) s_v(J).
//
// The integrated footprint is a sum of products over NODES quadrature nodes z: F = sum w f(x + s_u z) f(y + s_v z). Each voxel row is
// first interpolated along u at all columns of a tile, for each node (a resampled row); for each lattice row, the v factors then combine
// two of these. One work-item per tile of VW x TILE_ROWS samples, id = tile_v*tiles_u + tile_u. lattice[J*width + I] = RGBA.

#include "layered/ray_lattice.cl"
#include "layered/splat_gradient.cl"
#include "layered/visible_layers.cl"
#include "shared/sample.cl"
#include "shared/volume.cl"

#ifndef TILE_ROWS
#error "TILE_ROWS: samples of a tile along v"
#endif

#define NODES 8
// Voxels around the one below a sample, for |s| <= 2 and a central difference: -3 ... 4.
#define TAPS 8
#define FIRST_SPLATTED (-3)
// Ring of resampled rows: a power of two, at least the rows that one lattice row needs.
#define RING 8
// Voxels under the columns of a tile: at most 7 per sample (ensured by the plan), and the taps; a multiple of VW.
#define SPAN_VECTORS ((7 * VW + 2 * TAPS + VW - 1) / VW)

// Resampled voxel rows of one layer: values at each node, and their central differences along u.
typedef struct {
    int index[RING];
    realv value[RING][NODES], difference[RING][NODES];
} Rows;

// Weights for resampling the rows of one layer at the columns of a tile.
typedef struct {
    int first;               // voxel of span[0]
    intv offset;             // of each column's first tap, in the span
    realv weight[NODES][TAPS - 2];
} Columns;

static inline Columns place_columns(realv u, realv shear, __global const float2 *nodes) {
    Columns columns;
    const realv below = floor(u);
    const float *ends = (const float *)&below;
    columns.first = convert_int(fmin(ends[0], ends[VW - 1])) + FIRST_SPLATTED;
    columns.offset = CONVERT_INTV(below) + (FIRST_SPLATTED - columns.first);
    for (int q = 0; q < NODES; q++)
        for (int a = 0; a < TAPS - 2; a++) {
            const realv x = fmin(fabs(u - below + shear * nodes[q].x - (float)(a + FIRST_SPLATTED + 1)), (realv)(1.0f));
            columns.weight[q][a] = 1.0f - SMOOTHSTEP(x);
        }
    return columns;
}

// `across`: resamples the difference of the two neighbouring layers instead of layer k.
static inline void resample_row(__global const VOXEL *voxels, const VolumeView *view, const Columns *columns, int v, int k, bool across,
                                int shading, Rows *rows) {
    const int at = v & (RING - 1);
    if (rows->index[at] == v)
        return;
    rows->index[at] = v;
    float span[SPAN_VECTORS * VW];
    load_row(voxels, view, columns->first, v, across ? k + 1 : k, SPAN_VECTORS, span);
    if (across) {
        float before[SPAN_VECTORS * VW];
        load_row(voxels, view, columns->first, v, k - 1, SPAN_VECTORS, before);
        for (int i = 0; i < SPAN_VECTORS * VW; i += VW)
            STOREV(span + i, LOADV(span + i) - LOADV(before + i));
    }
    realv tap[TAPS];
    for (int a = 0; a < TAPS; a++)
        tap[a] = GATHER(span + a, columns->offset);
    for (int q = 0; q < NODES; q++) {
        realv value = 0.0f;
        for (int a = 0; a < TAPS - 2; a++)
            value += columns->weight[q][a] * tap[a + 1];
        rows->value[at][q] = value;
        if (shading) {
            realv difference = 0.0f;
            for (int a = 0; a < TAPS - 2; a++)
                difference += columns->weight[q][a] * (tap[a + 2] - tap[a]);
            rows->difference[at][q] = 0.5f * difference;
        }
    }
}

// Splat sums of one layer in a tile, and their central differences within the layer. For differences across layers: only the sums, which
// are twice the central differences.
typedef struct {
    realv sum[TILE_ROWS], u[TILE_ROWS], v[TILE_ROWS];
} Sums;

static inline void splat_layer(__global const VOXEL *voxels, const VolumeView *view, const RayLatticeParams *p,
                               __global const float2 *nodes, realv centre_u, realv shear_u, int row, int tile_rows, int k, bool across,
                               int shading, Rows *rows, Sums *sums) {
    if (!across && IS_OUTSIDE(k, view)) {
        for (int r = 0; r < tile_rows; r++) {
            sums->sum[r] = view->background;
            sums->u[r] = sums->v[r] = 0.0f;
        }
        return;
    }
    const Columns columns = place_columns(centre_u + (k - p->centre_layer) * shear_u, shear_u, nodes);
    for (int i = 0; i < RING; i++)
        rows->index[i] = INT_MIN;
    for (int r = 0; r < tile_rows; r++) {
        const float2 crossing = axis_crossing(p, 1, row + r);
        const float v = crossing.x + (k - p->centre_layer) * crossing.y;
        const float span = fabs(crossing.y);
        const int first = convert_int(floor(v - span)) - 1, last = convert_int(floor(v + span)) + 2;
        for (int j = first; j <= last; j++)
            resample_row(voxels, view, &columns, j, k, across, shading, rows);
        realv sum = 0.0f, along_u = 0.0f, along_v = 0.0f;
        for (int q = 0; q < NODES; q++) {
            const float y = v + crossing.y * nodes[q].x, below = floor(y), t = SMOOTHSTEP(y - below), w = nodes[q].y;
            const int j = convert_int(below);
            const realv r0 = rows->value[j & (RING - 1)][q], r1 = rows->value[(j + 1) & (RING - 1)][q];
            sum += w * (r0 + t * (r1 - r0));
            if (shading) {
                const realv d0 = rows->difference[j & (RING - 1)][q], d1 = rows->difference[(j + 1) & (RING - 1)][q];
                along_u += w * (d0 + t * (d1 - d0));
                const realv lo = r1 - rows->value[(j - 1) & (RING - 1)][q], hi = rows->value[(j + 2) & (RING - 1)][q] - r0;
                along_v += 0.5f * w * (lo + t * (hi - lo));
            }
        }
        sums->sum[r] = sum;
        sums->u[r] = along_u;
        sums->v[r] = along_v;
    }
}

struct SampleSource {
    Point point;
    Gradient splatted;
    SmoothedGradients smoothed;
};

static inline LightVolume sample_light(const struct SampleSource *s) { return s->smoothed.shading->light; }

static inline Point sample_point(const struct SampleSource *s) { return s->point; }

static inline Gradient sample_gradient(const struct SampleSource *s) {
#if SPLATS_GRADIENTS
    return s->splatted;
#else
    return smoothed_gradient(&s->smoothed, s->point);
#endif
}

__kernel void splat_perspective(__global const VOXEL *voxels, VolumeView view, __global const GRADIENT_VOXEL *gradient_voxels,
                                VolumeView gradient_view, __global const uchar *light, __global const uchar *sky,
                                __global const float2 *nodes, __global const uchar *visible, __global const float4 *table,
                                __global const float4 *slabs, RayLatticeParams p, SampleParams sample, Clipping clip,
                                __global float4 *lattice, __global uint *active_samples, ulong first_item) {
    const int tile = first_item + get_global_id(0);
    if (tile >= p.tiles_u * p.tiles_v)
        return;
    voxels += view.first;
    const ShadingSource shading = SHADING_SOURCE;
    const int column = tile % p.tiles_u * VW, row = tile / p.tiles_u * TILE_ROWS;
    const int tile_rows = min(TILE_ROWS, p.height - row), columns = min(VW, p.width - column);
    const Beam beam = make_beam(&p, column, row, columns, tile_rows);
    const float2 reach = max(splat_reach(beam.shear.lo), splat_reach(beam.shear.hi));
    const int last_slab = min(p.last_layer + 1, view.dims_a) - view.first_a; // a part of a volume may lack further slabs
    LayerChunk layer_chunk = {-1, 0};
    realv centre_u, shear_u;
    axis_crossings(&p, 0, LANES + column, &centre_u, &shear_u);

    Rows ring;
    Sums sums[3], across;
    int sums_layer[3] = {INT_MIN, INT_MIN, INT_MIN};
    Accumulator gathered[TILE_ROWS];
    Interval intervals[TILE_ROWS];
    for (int r = 0; r < TILE_ROWS; r++) {
        gathered[r] = p.continues && r < tile_rows ? load_raw(&sample, lattice + (size_t)(row + r) * p.width + column, columns, 1)
                                                   : empty_accumulator(&sample);
#ifdef CLIPPED
        const SampleRays rays = sample_rays(&p, LANES + column, (intv)(row + r));
        intervals[r] = clip_sample_rays(&p, &clip, &rays);
#endif
    }
    const int splats_gradients = GATHERS_VALUES ? 0 : SPLATS_GRADIENTS ? sample.light.shading : 0;
    intv active = 0;
    const int layers = view.dims_a + 2;
    bool finished = p.continues;
    for (int r = 0; r < tile_rows && finished; r++)
        finished = !any_open_lanes(&sample, &gathered[r], columns);
    for (int n = 0; n < layers && !finished; n++) {
        const int k = p.layer_step > 0 ? n - 1 : view.dims_a - n;
        if (k < p.first_layer || k > p.last_layer)
            continue;
        const float depth = k - p.centre_layer;
        if (p.culling) {
            const int2 shown = visible_rows(visible, p.blocks_u, p.blocks_v, last_slab, &beam, tile_rows, reach,
                                            view.first_a - p.centre_layer, k - view.first_a, &layer_chunk);
            if (shown.x > shown.y)
                continue;
        }
        for (int j = k - 1; j <= k + 1; j++) {
            if (sums_layer[slot(j)] == j)
                continue;
            sums_layer[slot(j)] = j;
            splat_layer(voxels, &view, &p, nodes, centre_u, shear_u, row, tile_rows, j, false, splats_gradients,
                        &ring, &sums[slot(j)]);
        }
        if (splats_gradients)
            splat_layer(voxels, &view, &p, nodes, centre_u, shear_u, row, tile_rows, k, true, 0, &ring, &across);
        int first, count;
        layer_slabs(&sample, n, layers, &first, &count);
        const Sums *before = &sums[slot(k - p.layer_step)], *own = &sums[slot(k)], *after = &sums[slot(k + p.layer_step)];
        finished = true;
        for (int r = 0; r < tile_rows; r++) {
            const SampleRays rays = sample_rays(&p, LANES + column, (intv)(row + r));
            LayerSpan layer_span;
            layer_span.dt = length_per_layer(&sample, &rays);
#ifdef CLIPPED
            layer_span.interval.from = intervals[r].from - depth * p.layer_step;
            layer_span.interval.to = intervals[r].to - depth * p.layer_step;
#endif
            const struct SampleSource source = {
                {rays.centre_u + depth * rays.shear_u, rays.centre_v + depth * rays.shear_v, (realv)(k)},
                {own->u[r], own->v[r], 0.5f * across.sum[r]},
                {&shading, &sample.field}};
            accumulate_layer(&sample, slabs, first, count, table, before->sum[r], own->sum[r], after->sum[r], &layer_span, &source,
                             &gathered[r], &active);
            finished = finished && !any_open_lanes(&sample, &gathered[r], columns);
        }
    }

    uint total = sum_lanes(active, columns);
    for (int r = 0; r < tile_rows; r++)
        STORE_RAYS(p, sample, table, &gathered[r], &intervals[r], columns, 1, lattice + (size_t)(row + r) * p.width + column, total)
    active_samples[tile] = total;
}
