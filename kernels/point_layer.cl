// One point-sampled layer under a tile of a lattice: its field at the samples, and what gradients need.
//
// Both factors of f(u) f(v) are small: per voxel row the u factor is applied to all columns of a tile at once (a resampled
// row), and per lattice row the v factor mixes two of these. Sub-layer l = 0 ... (n+1) S, S samples per layer, lies at
// k = l/S - 1; between two layers it mixes them with f.

#ifndef TILE_ROWS
#define TILE_ROWS 8 // samples along v
#endif
// Voxels between neighbouring samples, at most; the plan sees to it.
#define VOXELS_PER_SAMPLE 2
// Voxel rows and columns under a tile: the window of a sample is -1 ... 2 for central differences.
#define ROWS (VOXELS_PER_SAMPLE * TILE_ROWS + 4)
#define SEGMENT_VECTORS ((VOXELS_PER_SAMPLE * VW + 4 + VW - 1) / VW)

// Where a tile's rows cross the middle layer, padded to whole vectors.
#define PADDED_ROWS ((TILE_ROWS + VW - 1) / VW * VW)
typedef struct {
    float centre[PADDED_ROWS], shear[PADDED_ROWS];
} TileRows;

// One sub-layer under a tile.
typedef struct {
    int held;                           // which one
    realv field[TILE_ROWS];             // at the samples
    int row[PADDED_ROWS] __attribute__((aligned(64))); // of `value`: the voxel row below the samples
    float rise[PADDED_ROWS];            // weight of the next
    realv value[ROWS], difference[ROWS]; // resampled voxel rows, and twice their central differences along u
} Layer;

// First and last voxel below the rays between two crossings.
inline void voxels_below(float2 one, float2 other, float depth, int *lo, int *hi) {
    const float a = one.x + depth * one.y, b = other.x + depth * other.y;
    *lo = whole_below(MIN(a, b));
    *hi = whole_below(MAX(a, b));
}

// How voxel rows are resampled for a tile's columns.
typedef struct {
    intv offset;  // of the voxel below each column, in the segment
    realv rise;   // weight of the next voxel
    int vectors;  // of the segment
    int shading;
} Columns;

ALWAYS_INLINE void resample_row(const float *segment, const Columns *c, realv *value, realv *difference) {
    const realv v0 = PICK(segment, c->vectors, c->offset), v1 = PICK(segment, c->vectors, c->offset + 1);
    *value = v0 + c->rise * (v1 - v0);
    if (c->shading) {
        const realv lo = v1 - PICK(segment, c->vectors, c->offset - 1), hi = PICK(segment, c->vectors, c->offset + 2) - v0;
        *difference = lo + c->rise * (hi - lo);
    }
}

// Samples sub-layer l. `u`: the columns, `tile_v`: the rows of the tile.
inline void sample_layer(__global const VOXEL *voxels, const VolumeView *view, const RayLatticeParams *p,
                         int samples_per_layer, int l, realv u, const TileRows *tile_v, int rows, int shading,
                         Layer *layer) {
    layer->held = l;
    const int k = (l + samples_per_layer) / samples_per_layer - 2;
    const int between = l - (k + 1) * samples_per_layer;
    const float depth = k + (float)between / samples_per_layer - p->centre_layer;
    int first_row, last_row;
    voxels_below((float2)(tile_v->centre[0], tile_v->shear[0]),
                 (float2)(tile_v->centre[rows - 1], tile_v->shear[rows - 1]), depth, &first_row, &last_row);
    first_row -= 1, last_row += 2;
    for (int r = 0; r < TILE_ROWS; r += VW) {
        const realv v = LOADV(tile_v->centre + r) + depth * LOADV(tile_v->shear + r);
        const intv below = wholes_below(v);
        *(intv *)(layer->row + r) = below - first_row;
        STOREV(layer->rise + r, RISE(v - CONVERT_REALV(below)));
    }
    const intv below = wholes_below(u);
    const realv rise = RISE(u - CONVERT_REALV(below));
    const int *ends = (const int *)&below;
    const int first = min(ends[0], ends[VW - 1]) - 1, span = max(ends[0], ends[VW - 1]) + 3 - first;
    const intv offset = below - first;
    const int vectors = (span + VW - 1) / VW;
    const Columns columns = {offset, rise, vectors, shading};
    const float next = RISE((float)between / samples_per_layer);
    const bool inside = !between && k >= 0 && k < view->dims_a && first >= 0 && first + vectors * VW <= view->dims_u;
    __global const VOXEL *start = voxels + k * view->stride_a + first;
    for (int j = first_row; j <= last_row; j++) {
        float segment[SEGMENT_VECTORS * VW];
        if (inside && j >= 0 && j < view->dims_v) {
            for (int c = 0; c < vectors; c++)
                STOREV(segment + c * VW, LOAD_VOXELS(start + j * view->stride_v + c * VW) - view->offset);
        } else {
            load_row(voxels, view, first, j, k, vectors, segment);
        }
        if (between) {
            float after[SEGMENT_VECTORS * VW];
            load_row(voxels, view, first, j, k + 1, vectors, after);
            for (int c = 0; c < vectors * VW; c += VW)
                STOREV(segment + c, LOADV(segment + c) + next * (LOADV(after + c) - LOADV(segment + c)));
        }
        resample_row(segment, &columns, layer->value + (j - first_row), layer->difference + (j - first_row));
    }
    for (int r = 0; r < rows; r++) {
        const realv *value = layer->value + layer->row[r];
        layer->field[r] = value[0] + layer->rise[r] * (value[1] - value[0]);
    }
}

// Twice the central differences in a sub-layer.
inline void layer_differences(const Layer *layer, int r, realv *u, realv *v) {
    const realv *value = layer->value + layer->row[r], *difference = layer->difference + layer->row[r];
    const float rise = layer->rise[r];
    *u += difference[0] + rise * (difference[1] - difference[0]);
    const realv lo = value[1] - value[-1], hi = value[2] - value[0];
    *v += lo + rise * (hi - lo);
}

// Central differences of a stretch's ends along u and v.
inline void stretch_differences(const Layer *one, const Layer *other, int r, realv *u, realv *v) {
    *u = *v = 0.0f;
    layer_differences(one, r, u, v);
    layer_differences(other, r, u, v);
    *u *= 0.25f, *v *= 0.25f;
}
