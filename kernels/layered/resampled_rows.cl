// Splat sums of a tile of the lattice of a perspective view (splat_perspective.cl): resampled voxel rows, sums and samples.

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
