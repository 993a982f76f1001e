// Splatting into the sheet buffer of a tile.

#include "shared/screen.cl"
#include "paper/splat.cl"

#ifndef CHANNELS
#error "CHANNELS: per pixel of a sheet"
#endif

#ifndef LIST_TILES
#error "LIST_TILES: tiles, along both axes, that have one list of splats"
#endif

// Loop over rows of a tile. On GPUs tiles have one row, which makes the index a constant.
#if TILE_ROWS == 1
#define EACH_ROW(r, from, to) for (int r = 0; r < 1 && (from) <= 0 && (to) >= 0; r++)
#else
#define EACH_ROW(r, from, to) for (int r = (from); r <= (to); r++)
#endif

// Prefetch distance in splats, which are scattered in memory.
#define PREFETCH_DISTANCE 16

// Begin and end of the list of splats of a tile.
static inline uint2 tile_list(__global const uint *ends, const ScreenParams *s, int chunks, int tile) {
    const int lists_u = (s->tiles_u + LIST_TILES - 1) / LIST_TILES, lists_v = (s->tiles_v + LIST_TILES - 1) / LIST_TILES;
    const int list = tile / s->tiles_u / LIST_TILES * lists_u + tile % s->tiles_u / LIST_TILES;
    __global const uint *last = ends + (size_t)(chunks - 1) * lists_u * lists_v;
    return (uint2)(list > 0 ? last[list - 1] : 0, last[list]);
}

// c2 exp(-2 r^2) for r < 2: integral 1.
#define FOOTPRINT_FACTOR 0.6368334f
#define SQUARED_RADIUS (GAUSSIAN_RADIUS * GAUSSIAN_RADIUS)
static inline realv gaussian(realv squared) {
    return fast_exp2(MAX(squared * -2.8853900818f, (realv)(-126.0f)));
}

// The footprint of a splat at the columns of a tile and, also in vectors, at its rows. If the pixel axes are perpendicular in the view
// plane, it is a product of both; otherwise each row is evaluated separately.
#define ROW_VECTORS ((TILE_ROWS + VW - 1) / VW)
typedef struct {
    realv dx;                      // pixel offsets
    realv squared, weight;         // of the columns: squared distance in voxels, and weight
    float row_squared[ROW_VECTORS * VW], row_weight[ROW_VECTORS * VW], row_dy[ROW_VECTORS * VW];
    int from, to;                  // rows of the tile that it covers
} Footprint;

ALWAYS_INLINE Footprint splat_footprint(const SplatParams *p, const Splat *splat, int column, int row, int rows) {
    Footprint f;
    const float hy = p->half_height / splat->w + 0.5f;
    f.from = floor_int(MAX(splat->y - hy - row, -1.0f)) + 1;
    f.to = floor_int(MIN(splat->y + hy - row, (float)rows)) - 1;
    f.dx = CONVERT_REALV(LANES) + (column + 0.5f - splat->x);
    const realv ex = f.dx * (p->footprint[0] * splat->w);
    f.squared = ex * ex;
    f.weight = FOOTPRINT_FACTOR * gaussian(f.squared);
    for (int r = 0; r < ROW_VECTORS * VW; r += VW) {
        const realv dy = CONVERT_REALV(LANES) + (row + r + 0.5f - splat->y);
        const realv ey = dy * (p->footprint[2] * splat->w);
        STOREV(f.row_dy + r, dy);
        STOREV(f.row_squared + r, ey * ey);
        STOREV(f.row_weight + r, gaussian(ey * ey));
    }
    return f;
}

// Footprint weights on one row.
ALWAYS_INLINE realv footprint_row(const SplatParams *p, const Splat *splat, const Footprint *f, int r) {
    if (p->footprint[1] == 0.0f)
        return f->squared < (realv)(SQUARED_RADIUS - f->row_squared[r]) ? f->weight * f->row_weight[r] : (realv)(0.0f);
    const realv ex = (p->footprint[0] * f->dx + p->footprint[1] * f->row_dy[r]) * splat->w;
    const realv squared = ex * ex + f->row_squared[r];
    return squared < SQUARED_RADIUS ? FOOTPRINT_FACTOR * gaussian(squared) : (realv)(0.0f);
}

// Depth difference along a vector.
static inline realv depth_along(const SplatParams *p, const realv *vector) {
    return p->along[0] * vector[0] + p->along[1] * vector[1] + p->along[2] * vector[2];
}

// Length of the rays of a row per voxel of depth, in unit distances.
static inline realv length_per_depth(const SplatParams *p, const RowRays *rays) { return rays->length / depth_along(p, rays->d); }

// Whether further splats can change any ray of a tile. (With a flag instead of the returns, image-aligned sheets take 25 % longer on
// PoCL.)
ALWAYS_INLINE bool any_row_open(const SampleParams *sample, const Accumulator *gathered, int rows) {
    EACH_ROW(r, 0, rows - 1)
        if (any_open(sample, &gathered[r]))
            return true;
    return false;
}

// The ray parameter at a depth.
static inline realv ray_parameter(const SplatParams *p, const RowRays *rays, float depth) {
    return (depth - (depth_along(p, rays->o) + p->along[3])) / depth_along(p, rays->d);
}
