// Columns of a tile between the voxels of a row, and their weights.

#include "layered/tile.cl"
#include "shared/volume.cl"

// Largest number of voxels between neighbouring samples: MAX_VOXELS_PER_POINT in src/host/layers/lattice, rounded up.
#define VOXELS_PER_SAMPLE 2
// Voxel rows and columns under a tile. A sample uses the voxels -1 ... 2.
#define ROWS (VOXELS_PER_SAMPLE * TILE_ROWS + 4 + FARTHEST)
#define SPAN_VECTORS ((VOXELS_PER_SAMPLE * VW + 4 + MOST_LEAN + VW - 1) / VW)

// Voxels under the columns of a tile in one sub-layer.
typedef struct {
    int k;           // layer at or below it
    float above;     // distance from that layer, 0, to the next, 1
    float layers[4]; // weights of layers k-1 ... k+2
    bool mixes;      // layers other than k have a weight
    int first;       // voxel column where spans begin: one before the cell of the outermost sample, or earlier
    int vectors;     // of a span
    bool inside;     // all columns of a span are inside the volume
    intv offset;     // of the voxel below each column, in the span
    realv between;   // distance of each column from it, 0, to the next, 1
    Weights u;       // weights of voxels -1 ... 2
#ifdef PIXEL_RAYS
    ColumnLine line;
#endif
} Columns;

// Stores weights that are equal in all lanes as scalars.
static inline void store_first(const Weights *w, float *out) {
    for (int n = 0; n < 4; n++)
        out[n] = ((const float *)&w->tap[n])[0];
}

// Places columns at `u` between the voxels of a span.
ALWAYS_INLINE void place_columns(realv u, Columns *c) {
    const intv below = floor_ints(u);
    c->offset = below - c->first;
    c->between = u - CONVERT_REALV(below);
    c->u = value_weights(c->between);
}

// The columns in voxel row j.
ALWAYS_INLINE Columns columns_in_row(const Columns *columns, int j) {
    Columns c = *columns;
#ifdef PIXEL_RAYS
    place_columns(column_in_row(&c.line, j), &c);
#endif
    return c;
}

// Lowest and highest voxel below columns; the outermost columns are the first and the last.
static inline int2 voxels_below(realv u) {
    const intv below = floor_ints(u);
    const int *ends = (const int *)&below;
    return (int2)(min(ends[0], ends[VW - 1]), max(ends[0], ends[VW - 1]));
}

// Columns of a tile in sub-layer l, for voxel rows `first_row` to `last_row`.
static inline Columns columns_under(const VolumeView *view, float centre_layer, int samples_per_layer, int l, const Tile *tile, int first_row,
                                    int last_row) {
    const float depth = (float)l / samples_per_layer - RADIUS - centre_layer;
    Columns c;
    c.k = l / samples_per_layer - RADIUS;
    c.above = (float)(l % samples_per_layer) / samples_per_layer;
    const Weights layers = value_weights((realv)(c.above));
    store_first(&layers, c.layers);
    c.mixes = KERNEL == BSPLINE || c.above > 0.0f;
#ifdef PIXEL_RAYS
    c.line = columns_at(tile, depth);
    const int2 under_first = voxels_below(column_in_row(&c.line, first_row)), under_last = voxels_below(column_in_row(&c.line, last_row));
    const int2 below = (int2)(min(under_first.x, under_last.x), max(under_first.y, under_last.y));
#else
    const realv u = tile->centre_u + depth * tile->shear_u;
    const int2 below = voxels_below(u);
#endif
    const int first = below.x - 1, behind = below.y + 3;
    c.vectors = (behind - first + VW - 1) / VW;
    c.inside = first >= 0 && behind <= view->dims_u && c.vectors * VW <= view->dims_u;
    // A span is at least as wide as the columns: it may begin earlier, so that it ends inside the volume.
    c.first = c.inside ? min(first, view->dims_u - c.vectors * VW) : first;
#ifndef PIXEL_RAYS
    place_columns(u, &c);
#endif
    return c;
}
