// Tiles of VW x TILE_ROWS screen pixels, for kernels that render directly to the screen.

#include "shared/accumulator.cl"

#ifndef TILE_ROWS
#error "TILE_ROWS: rows of a tile"
#endif

// Rays of VW neighbouring pixels.
typedef struct {
    realv o[3], d[3];
    realv length; // of d, in unit distances
} RowRays;

// Rays of the pixels from a column on; columns beyond the screen repeat the last ray.
static inline RowRays row_rays(const ScreenParams *s, int column, int row) {
    const intv columns = MIN(LANES + column, (intv)(s->width - 1));
    const realv x = CONVERT_REALV(columns) + 0.5f;
    const float y = row + 0.5f;
    RowRays rays;
    realv squares = 0.0f;
    for (int i = 0; i < 3; i++) {
        rays.o[i] = (s->origin[i] + y * s->origin[8 + i]) + x * s->origin[4 + i];
        rays.d[i] = (s->direction[i] + y * s->direction[8 + i]) + x * s->direction[4 + i];
        squares += rays.d[i] * rays.d[i] * (s->step[i] * s->step[i]);
    }
    rays.length = sqrt(squares);
    return rays;
}

// The clip interval of rays. CUT_RAYS: without what is to be drawn before or later.
#ifdef CUT_RAYS
#define SCREEN_INTERVAL(s, ends, rays, column, row) cut_interval(s, clip_rays(ends, (rays)->o, (rays)->d), cuts, column, row)
static inline Interval cut_interval(const ScreenParams *s, Interval interval, __global const float2 *cuts, int column, int row) {
    const intv at = MIN(LANES + column, (intv)(s->width - 1)) + row * s->width;
    for (int i = 0; i < VW; i++) {
        const float2 cut = cuts[((const int *)&at)[i]];
        ((float *)&interval.from)[i] = fmax(((const float *)&interval.from)[i], cut.x);
        ((float *)&interval.to)[i] = fmin(((const float *)&interval.to)[i], cut.y);
    }
    return interval;
}
#else
#define SCREEN_INTERVAL(s, ends, rays, column, row) clip_rays(ends, (rays)->o, (rays)->d)
#endif

// Number of a tile's columns that are on the screen.
static inline int columns_on_screen(const ScreenParams *s, int column) { return min(VW, s->width - column); }

static inline void store_pixels(const ScreenParams *s, const SampleParams *p, __global const float4 *table, int column, int row,
                                const Accumulator *a, const Interval *interval, __global float4 *frame) {
    realv color[4];
    resolve(p, table, a, interval, color);
    store_colors(color, columns_on_screen(s, column), 1, frame + (size_t)row * s->width + column);
}
