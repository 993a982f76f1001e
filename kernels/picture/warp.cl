// Warps the composited lattice to the screen, by Catmull-Rom interpolation of premultiplied RGBA.
//
// One work-item per block of pixels, numbered row by row. `from_screen` maps pixel coordinates (x, y, 1) to lattice positions (I w, J w,
// w), with sample centres at whole numbers. Beyond the lattice all is transparent.

#include "picture/crossed_columns.cl"
#include "picture/lines.cl"
#include "picture/own_samples.cl"

#ifndef BLOCK_ROWS
#error "BLOCK_ROWS: rows of a block"
#endif

// Four neighbouring samples in one load: half the time of single loads.
typedef float16 __attribute__((aligned(16))) Four;
#define FOUR_AT(p) (*(__global const Four *)(p))

// Clamps a colour to the range of the four samples around it, two per row, and to its opacity: the filter overshoots at edges, and opaque
// regions of constant colour must stay so.
static inline float4 clamp_color(float4 color, float8 upper, float8 lower) {
    const float8 lo = MIN(upper, lower), hi = MAX(upper, lower);
    color = CLAMP(color, MIN(lo.lo, lo.hi), MAX(hi.lo, hi.hi));
    return WITHIN_OPACITY(color, color.wwww);
}

// GPUs use blocks of one pixel, and lack the registers for all samples at once.
#if BLOCK_COLUMNS * BLOCK_ROWS == 1
#define UNROLL_ROWS _Pragma("unroll 1")
#else
#define UNROLL_ROWS _Pragma("unroll")
#endif

// Interpolates the 4 x 4 samples from (column, row) on, all inside the lattice.
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
    return clamp_color(pairs.lo + pairs.hi, upper.s456789ab, lower);
}

// The same where some samples are beyond the lattice, and transparent. Unrolled, so that all indices are constants and no array is in
// memory.
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
    return clamp_color(sum, (float8)(around[0], around[1]), (float8)(around[2], around[3]));
}

// Lattice position of a pixel: (column, row, w), w > 0 in front of the eye.
static inline float3 lattice_position(const WarpParams *p, float x, float y) {
    const float *m = p->from_screen;
    // Parallel views need no division.
    if (m[6] == 0.0f && m[7] == 0.0f && m[8] == 1.0f)
        return (float3)(m[0] * x + m[1] * y + m[2], m[3] * x + m[4] * y + m[5], 1.0f);
    const float w = (m[6] * x + m[7] * y + m[8]) * p->forward;
    const float scale = p->forward / w;
    return (float3)((m[0] * x + m[1] * y + m[2]) * scale, (m[3] * x + m[4] * y + m[5]) * scale, w);
}

ALWAYS_INLINE float4 interpolated(__global const float4 *lattice, const WarpParams *p, float x, float y) {
    const float3 at = lattice_position(p, x, y);
    if (!(at.z > 0.0f && at.x > -2.0f && at.x < p->width + 1.0f && at.y > -2.0f && at.y < p->height + 1.0f))
        return 0.0f;
    const int i = floor_int(at.x), j = floor_int(at.y);
    const float4 wu = catmull_rom(at.x - i), wv = catmull_rom(at.y - j);
    const int first = i - 1, top = j - 1;
    return first >= 0 && first + 4 <= p->width && top >= 0 && top + 4 <= p->height
                       ? mix_inside(lattice + (size_t)top * p->width + first, p->width, wu, wv)
                       : mix_edge(lattice, p->width, p->height, first, top, wu, wv);
}

// A pixel: the mean over `filter` x `filter` positions in its square. With a filter of 1, its centre.
static inline float4 pixel_at(__global const float4 *lattice, const WarpParams *p, int column, int row) {
    const float step = 1.0f / p->filter;
    float4 sum = 0.0f;
    for (int j = 0; j < p->filter; j++)
        for (int i = 0; i < p->filter; i++)
            sum += interpolated(lattice, p, column + (i + 0.5f) * step, row + (j + 0.5f) * step);
    return sum * (step * step);
}

// Whether the lattice is empty under the pixels [x0, x1] x [y0, y1] and within the filter's support.
static inline bool is_empty_under(__global const float4 *lattice, __global const uint *active_samples, const WarpParams *p, float x0,
                                  float x1, float y0, float y1) {
    float u0 = INFINITY, u1 = -INFINITY, v0 = INFINITY, v1 = -INFINITY;
    for (int corner = 0; corner < 4; corner++) {
        const float3 at = lattice_position(p, corner & 1 ? x1 : x0, corner & 2 ? y1 : y0);
        if (!(at.z > 0.0f))
            return false;
        u0 = MIN(u0, at.x), u1 = MAX(u1, at.x), v0 = MIN(v0, at.y), v1 = MAX(v1, at.y);
    }
    // Clamped, since an int cannot hold positions far beyond the lattice. One more sample on each side allows for rounding.
    const int first = CLAMP(u0 - 3.0f, 0.0f, (float)p->width), last = CLAMP(u1 + 4.0f, -1.0f, p->width - 1.0f);
    const int top = CLAMP(v0 - 3.0f, 0.0f, (float)p->height), bottom = CLAMP(v1 + 4.0f, -1.0f, p->height - 1.0f);
    if (first > last || top > bottom)
        return true;
    const int tiles_u = (p->width + p->tile_columns - 1) / p->tile_columns;
    bool active = false;
    for (int j = top / p->tile_rows; j <= (bottom + p->tile_lead) / p->tile_rows; j++)
        for (int i = first / p->tile_columns; i <= last / p->tile_columns; i++)
            active |= active_samples[j * tiles_u + i] != 0;
    if (!active || (last - first) * (bottom - top) > BLOCK_COLUMNS * BLOCK_ROWS)
        return !active;
    // Fewer samples than pixels: tiles are large on the screen, and testing each sample is worthwhile.
    float opacity = 0.0f;
    for (int j = top; j <= bottom; j++)
        for (int i = first; i <= last; i++)
            opacity += lattice[(size_t)j * p->width + i].w;
    return opacity == 0.0f;
}

// Stores a pixel in the float frame or, `displayed`, directly in the 8-bit picture. The latter saves a pass over the frame: 0.5 ms of 2
// at 512 x 512. One kernel serves both, since only the lattice kernels take longer to compile.
ALWAYS_INLINE void store_pixel(const WarpParams *p, float4 color, float4 background, float4 curve, __global uchar *picture, size_t at) {
    if (p->displayed) {
        ((__global uchar4 *)picture)[at] = displayed(color, background, curve);
    } else {
        __global float4 *out = (__global float4 *)picture + at;
        *out = MIN(BRIGHTEST, (p->added ? *out : (float4)(0.0f)) + p->share * color);
    }
}

// Stores four pixels.
ALWAYS_INLINE void store_four(const WarpParams *p, float16 colors, float4 background, float4 curve, __global uchar *picture, size_t at) {
    if (p->displayed) {
        vstore16(displayed_four(colors, background, curve), 0, picture + 4 * at);
    } else {
        __global Four *out = (__global Four *)((__global float4 *)picture + at);
        *out = MIN((float16)(BRIGHTEST, BRIGHTEST, BRIGHTEST, BRIGHTEST), (p->added ? *out : (float16)(0.0f)) + p->share * colors);
    }
}

__kernel void warp(__global const float4 *lattice, __global const uint *active_samples, WarpParams p, float4 background, float4 curve,
                   __global uchar *picture, ulong first_item) {
    const int blocks = (p.columns + BLOCK_COLUMNS - 1) / BLOCK_COLUMNS, block = first_item + get_global_id(0);
    if (block >= blocks * ((p.rows + BLOCK_ROWS - 1) / BLOCK_ROWS))
        return;
    const int left = block % blocks * BLOCK_COLUMNS, top = block / blocks * BLOCK_ROWS;
    const int right = min(left + BLOCK_COLUMNS, p.columns), bottom = min(top + BLOCK_ROWS, p.rows);
    // A constant where it is one, so that GPUs keep the pixel in registers.
    const int count = BLOCK_COLUMNS == 1 ? 1 : right - left;
    const float inset = 0.5f / p.filter;
    const bool is_empty =
        is_empty_under(lattice, active_samples, &p, left + inset, right - inset, top + inset, bottom - inset);
    if (is_empty) {
        // A separate loop, so that the displayed colour is computed once.
        for (int line = top; line < bottom; line++)
            for (int i = 0; i < count; i++)
                store_pixel(&p, (float4)(0.0f), background, curve, picture, (size_t)line * p.columns + left + i);
        return;
    }
    const bool has_lines = p.lines && !p.for_each_pixel;
    Lines lines;
    if (has_lines)
        lines = make_lines(&p);
#ifdef FOUR_LINES_AT_ONCE
    ColumnLines columns;
#endif
    for (int line = top; line < bottom; line++) {
        float16 row[(BLOCK_COLUMNS + 3) / 4];
        float4 *pixels = (float4 *)row;
        const size_t at = (size_t)line * p.columns + left;
        if (p.for_each_pixel) {
            for (int i = 0; i < count;) {
#if BLOCK_COLUMNS % 16 == 0
                if (i + 16 <= count) {
                    sixteen_own_samples(lattice, &p, left + i + 0.5f, line + 0.5f, row + i / 4);
                    i += 16;
                    continue;
                }
#endif
                pixels[i] = own_sample(lattice, &p, left + i + 0.5f, line + 0.5f);
                i++;
            }
        } else if (p.crossed_along) {
#ifdef FOUR_LINES_AT_ONCE
            for (int i = 0; i < count; i += 4)
                row[i / 4] = four_between_columns(lattice, &p, left + i + 0.5f, line + 0.5f);
#else
            for (int i = 0; i < count; i++)
                pixels[i] = between_columns(lattice, &p, left + i + 0.5f, line + 0.5f);
#endif
        } else if (has_lines) {
            cross_lines(&p, left + 0.5f, line + 0.5f, &lines);
#ifdef FOUR_LINES_AT_ONCE
            if (line == top || !p.upright)
                lines_below(&lines, left, right, p.on_pixels, &columns);
            row_between_lines(lattice, &lines, &columns, p.on_pixels, row);
#else
            for (int i = 0; i < count; i++)
                pixels[i] = pixel_between_lines(lattice, &lines, p.on_pixels, left + i + 0.5f);
#endif
        } else {
            for (int i = 0; i < count; i++)
                pixels[i] = pixel_at(lattice, &p, left + i, line);
        }
        int i = 0;
#if BLOCK_COLUMNS % 4 == 0
        for (; i + 4 <= count; i += 4)
            store_four(&p, row[i / 4], background, curve, picture, at + i);
#endif
        for (; i < count; i++)
            store_pixel(&p, pixels[i], background, curve, picture, at + i);
    }
}
