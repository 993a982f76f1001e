// The composited lattice onto the screen, by Catmull-Rom interpolation of premultiplied RGBA.
//
// One work-item per block of pixels, block by block in rows. `from_screen` takes pixel coordinates (x, y, 1) to lattice positions (I w, J w, w), sample
// centres at whole numbers. Beyond the lattice all is transparent.

#include "picture/own_samples.cl"
#include "picture/upright.cl"

#ifndef BLOCK_ROWS
#error "BLOCK_ROWS: rows of a block"
#endif

// Four neighbouring samples at once: half the time of one after another.
typedef float16 __attribute__((aligned(16))) Four;
#define FOUR_AT(p) (*(__global const Four *)(p))

// A colour within the range of the four samples around it, two of each row: the filter overshoots at edges, and what is opaque
// and of one colour must stay so; and colours within the opacity.
static inline float4 within(float4 color, float8 upper, float8 lower) {
    const float8 lo = MIN(upper, lower), hi = MAX(upper, lower);
    color = CLAMP(color, MIN(lo.lo, lo.hi), MAX(hi.lo, hi.hi));
    return MIN(color, color.wwww);
}

// Blocks of one pixel are what graphics processors take, which have no registers for all samples at once.
#if BLOCK_COLUMNS * BLOCK_ROWS == 1
#define UNROLL_ROWS _Pragma("unroll 1")
#else
#define UNROLL_ROWS _Pragma("unroll")
#endif

// The 4 x 4 samples from (column, row) on, all in the lattice.
static inline float4 mix_inside(__global const float4 *corner, int width, float4 wu, float4 wv) {
    const float16 upper = FOUR_AT(corner + width);
    float16 rows = wv.x * FOUR_AT(corner) + wv.y * upper;
    float8 lower = 0.0f;
    UNROLL_ROWS
    for (int r = 2; r < 4; r++) {
        const float16 row = FOUR_AT(corner + r * width);
        rows += (r == 2 ? wv.z : wv.w) * row;
        lower = r == 2 ? row.s456789ab : lower;
    }
    const float16 weighted = rows * (float16)(wu.xxxx, wu.yyyy, wu.zzzz, wu.wwww);
    const float8 pairs = weighted.lo + weighted.hi;
    return within(pairs.lo + pairs.hi, upper.s456789ab, lower);
}

// The same where some of them are beyond it, and transparent. Unrolled, so that all indices are constants and nothing lies in memory.
static inline float4 mix_edge(__global const float4 *lattice, int width, int height, int column, int row, float4 wu, float4 wv) {
    const float weight_u[4] = {wu.x, wu.y, wu.z, wu.w}, weight_v[4] = {wv.x, wv.y, wv.z, wv.w};
    float4 sum = 0.0f, around[4] = {0.0f, 0.0f, 0.0f, 0.0f};
#pragma unroll
    for (int r = 0; r < 4; r++) {
#pragma unroll
        for (int c = 0; c < 4; c++) {
            if (row + r < 0 || row + r >= height || column + c < 0 || column + c >= width)
                continue;
            const float4 color = lattice[(size_t)(row + r) * width + column + c];
            sum += weight_v[r] * weight_u[c] * color;
            if ((r == 1 || r == 2) && (c == 1 || c == 2))
                around[2 * (r - 1) + c - 1] = color;
        }
    }
    return within(sum, (float8)(around[0], around[1]), (float8)(around[2], around[3]));
}

// Where a pixel lies in the lattice: (column, row, w), w > 0 where it is in front of the eye.
static inline float3 place(const WarpParams *p, float x, float y) {
    const float *m = p->from_screen;
    // Parallel views need no division.
    if (m[6] == 0.0f && m[7] == 0.0f && m[8] == 1.0f)
        return (float3)(m[0] * x + m[1] * y + m[2], m[3] * x + m[4] * y + m[5], 1.0f);
    const float w = (m[6] * x + m[7] * y + m[8]) * p->forward;
    const float scale = p->forward / w;
    return (float3)((m[0] * x + m[1] * y + m[2]) * scale, (m[3] * x + m[4] * y + m[5]) * scale, w);
}

ALWAYS_INLINE float4 warped(__global const float4 *lattice, const WarpParams *p, float x, float y) {
    const float3 at = place(p, x, y);
    if (!(at.z > 0.0f && at.x > -2.0f && at.x < p->width + 1.0f && at.y > -2.0f && at.y < p->height + 1.0f))
        return 0.0f;
    const int i = whole_below(at.x), j = whole_below(at.y);
    const float4 wu = catmull_rom(at.x - i), wv = catmull_rom(at.y - j);
    const int first = i - 1, top = j - 1;
    return first >= 0 && first + 4 <= p->width && top >= 0 && top + 4 <= p->height
                       ? mix_inside(lattice + (size_t)top * p->width + first, p->width, wu, wv)
                       : mix_edge(lattice, p->width, p->height, first, top, wu, wv);
}

// A pixel: the picture at its middle, or the mean over its whole square.
ALWAYS_INLINE float4 pixel_at(__global const float4 *lattice, const WarpParams *p, int column, int row) {
    if (p->filter == 1)
        return warped(lattice, p, column + 0.5f, row + 0.5f);
    const float step = 1.0f / p->filter;
    float4 sum = 0.0f;
    for (int j = 0; j < p->filter; j++)
        for (int i = 0; i < p->filter; i++)
            sum += warped(lattice, p, column + (i + 0.5f) * step, row + (j + 0.5f) * step);
    return sum * (step * step);
}

// Whether the lattice shows nothing under the pixels [x0, x1] x [y0, y1] and in the filter's reach.
static inline bool nothing_under(__global const float4 *lattice, __global const uint *active_samples, const WarpParams *p,
                          float x0, float x1, float y0, float y1) {
    float u0 = INFINITY, u1 = -INFINITY, v0 = INFINITY, v1 = -INFINITY;
    for (int corner = 0; corner < 4; corner++) {
        const float3 at = place(p, corner & 1 ? x1 : x0, corner & 2 ? y1 : y0);
        if (!(at.z > 0.0f))
            return false;
        u0 = MIN(u0, at.x), u1 = MAX(u1, at.x), v0 = MIN(v0, at.y), v1 = MAX(v1, at.y);
    }
    // Far beyond the lattice an int could not hold the positions; one sample more keeps rounding away.
    const int first = CLAMP(u0 - 3.0f, 0.0f, (float)p->width), last = CLAMP(u1 + 4.0f, -1.0f, p->width - 1.0f);
    const int top = CLAMP(v0 - 3.0f, 0.0f, (float)p->height), bottom = CLAMP(v1 + 4.0f, -1.0f, p->height - 1.0f);
    if (first > last || top > bottom)
        return true;
    const int tiles_u = (p->width + p->tile_columns - 1) / p->tile_columns;
    bool active = false;
    for (int j = top / p->tile_rows; j <= bottom / p->tile_rows; j++)
        for (int i = first / p->tile_columns; i <= last / p->tile_columns; i++)
            for (int n = 0; n < p->counts; n++)
                active |= active_samples[(j * tiles_u + i) * p->counts + n] != 0;
    if (!active || (last - first) * (bottom - top) > BLOCK_COLUMNS * BLOCK_ROWS)
        return !active;
    // Fewer samples than pixels: tiles are large on the screen, and looking at each sample pays.
    float opacity = 0.0f;
    for (int j = top; j <= bottom; j++)
        for (int i = first; i <= last; i++)
            opacity += lattice[(size_t)j * p->width + i].w;
    return opacity == 0.0f;
}

// PRESENT: straight to the 8-bit picture. One pass over the frame's floats less: 0.5 ms of 2 at 512 x 512.
#ifdef PRESENT
#define PIXEL uchar4
#define PUT(place, color) (place) = displayed(color, background)
#define PUT_FOUR(place, colors) vstore16(displayed_four(colors, background), 0, (__global uchar *)(place))
#else
#define PIXEL float4
// Means and shares of what is opaque add up to more than 1 by rounding.
#define PUT(place, color) (place) = MIN((float4)(1.0f), (p.added ? (place) : (float4)(0.0f)) + p.share * (color))
#define PUT_FOUR(place, colors)         \
    {                                   \
        PUT((place)[0], (colors).s0123); \
        PUT((place)[1], (colors).s4567); \
        PUT((place)[2], (colors).s89ab); \
        PUT((place)[3], (colors).scdef); \
    }
#endif

__kernel void warp(__global const float4 *lattice, __global const uint *active_samples, WarpParams p, float4 background,
                   __global PIXEL *picture) {
    const int blocks = (p.columns + BLOCK_COLUMNS - 1) / BLOCK_COLUMNS, block = get_global_id(0);
    if (block >= blocks * ((p.rows + BLOCK_ROWS - 1) / BLOCK_ROWS))
        return;
    const int left = block % blocks * BLOCK_COLUMNS, top = block / blocks * BLOCK_ROWS;
    const int right = min(left + BLOCK_COLUMNS, p.columns), bottom = min(top + BLOCK_ROWS, p.rows);
    const float inset = 0.5f / p.filter;
    const bool nothing =
        nothing_under(lattice, active_samples, &p, left + inset, right - inset, top + inset, bottom - inset);
#ifdef TAKES_LINES
    if (p.upright && !p.for_each_pixel && !nothing) {
        const Lines lines = lines_of(&p);
        ColumnLines columns;
        lines_below(&lines, left, p.on_pixels, &columns);
        for (int line = top; line < bottom; line++) {
            float16 pixels[FOURS_OF_PIXELS];
            upright_row(lattice, &lines, &columns, p.on_pixels, line + 0.5f, pixels);
            __global PIXEL *out = picture + (size_t)line * p.columns + left;
            for (int i = 0; i < (right - left) / 4; i++)
                PUT_FOUR(out + 4 * i, pixels[i]);
            for (int i = (right - left) / 4 * 4; i < right - left; i++)
                PUT(out[i], ((const float4 *)pixels)[i]);
        }
        return;
    }
#endif
    for (int line = top; line < bottom; line++) {
        __global PIXEL *out = picture + (size_t)line * p.columns;
        if (nothing) {
            for (int i = left; i < right; i++)
                PUT(out[i], (float4)(0.0f));
        } else if (p.for_each_pixel) {
            int i = left;
#if BLOCK_COLUMNS % 16 == 0
            for (; i + 16 <= right; i += 16) {
                float16 fours[4];
                sixteen_own_samples(lattice, &p, i + 0.5f, line + 0.5f, fours);
#pragma unroll
                for (int n = 0; n < 4; n++)
                    PUT_FOUR(out + i + 4 * n, fours[n]);
            }
#endif
            for (; i < right; i++)
                PUT(out[i], own_sample(lattice, &p, i + 0.5f, line + 0.5f));
        } else if (p.upright) {
            const Lines lines = lines_of(&p);
            for (int i = left; i < right; i++)
                PUT(out[i], upright_pixel(lattice, &lines, p.on_pixels, i + 0.5f, line + 0.5f));
        } else {
            for (int i = left; i < right; i++)
                PUT(out[i], pixel_at(lattice, &p, i, line));
        }
    }
}
