// Warp of lattices along their columns (or rows). These lines are interpolated where a row of pixels crosses them, and pixels between
// neighbouring lines. That takes four samples per line and four lines per pixel, instead of sixteen samples per pixel. Lines are vertical on
// the screen in any parallel view that is not rolled about an axis of the volume: then a single line suffices where each column of pixels
// has its own. Elsewhere each row of pixels crosses them in other places.

#include "picture/catmull_rom.cl"

#ifndef BLOCK_COLUMNS
#error "BLOCK_COLUMNS: pixels of a block: about a tile of the lattice"
#endif

// Which lines rows of pixels cross: those of constant u; otherwise those of constant v.
#define LINES_OF_U 1

// The lattice as lines that a row of pixels crosses.
typedef struct {
    int lines, length;          // number of lines, and samples per line
    int to_line, to_sample;     // strides in memory
    float per_pixel, first;     // the line at x is (per_pixel x + first) / (w_per_pixel x + w)
    float w_per_pixel, w;       // 0 and 1 in parallel views
    float slope, origin, pivot; // where the row crosses line l, the sample is slope (l - pivot) + origin
} Lines;

static inline Lines make_lines(const WarpParams *p) {
    const bool lines_of_u = p->lines == LINES_OF_U;
    Lines l;
    l.lines = lines_of_u ? p->width : p->height, l.length = lines_of_u ? p->height : p->width;
    l.to_line = lines_of_u ? 1 : p->width, l.to_sample = lines_of_u ? p->width : 1;
    return l;
}

// Where the row of pixels at y crosses the lines. `x`: a place of that row near the pixels, from which positions are counted, since
// floats are not accurate far from it.
static inline void cross_lines(const WarpParams *p, float x, float y, Lines *l) {
    const float *u = p->from_screen, *v = p->from_screen + 3, *w = p->from_screen + 6;
    const float *across = p->lines == LINES_OF_U ? u : v, *along = p->lines == LINES_OF_U ? v : u;
    l->per_pixel = across[0];
    if (p->upright) {
        l->first = across[1] * (0.5f * p->rows) + across[2];
        l->w_per_pixel = 0.0f, l->w = 1.0f;
        l->slope = along[0] / across[0], l->pivot = 0.0f;
        l->origin = along[1] * y + (along[2] - l->slope * l->first);
        return;
    }
    const float start = along[1] * y + along[2];
    l->first = across[1] * y + across[2];
    l->w_per_pixel = w[0], l->w = w[1] * y + w[2];
    // A row is a straight line on the lattice too.
    l->slope = (along[0] * l->w - start * l->w_per_pixel) / (across[0] * l->w - l->first * l->w_per_pixel);
    const float scale = 1.0f / (l->w_per_pixel * x + l->w);
    l->pivot = (across[0] * x + l->first) * scale, l->origin = (along[0] * x + start) * scale;
}

// Sample j of line i; transparent beyond the lattice.
static inline float4 line_sample(__global const float4 *lattice, const Lines *l, int i, int j) {
    return i >= 0 && i < l->lines && j >= 0 && j < l->length ? lattice[(size_t)i * l->to_line + (size_t)j * l->to_sample] : (float4)(0.0f);
}

// The filter overshoots at edges: the colour is clamped to the range of its two neighbours, and to its opacity.
static inline float4 filter_color(float4 w, float4 before, float4 low, float4 high, float4 behind) {
    const float4 color = w.x * before + w.y * low + w.z * high + w.w * behind;
    const float4 between = CLAMP(color, MIN(low, high), MAX(low, high));
    return WITHIN_OPACITY(between, between.wwww);
}

// A line where the row of pixels crosses it.
static inline float4 one_line(__global const float4 *lattice, const Lines *l, int line) {
    const float place = CLAMP(l->slope * (line - l->pivot) + l->origin, -4.0f, l->length + 4.0f);
    const int j = (int)(place + 4.0f) - 5; // one before the sample below
    return filter_color(catmull_rom(place - (j + 1)), line_sample(lattice, l, line, j), line_sample(lattice, l, line, j + 1),
                        line_sample(lattice, l, line, j + 2), line_sample(lattice, l, line, j + 3));
}

// A single pixel. One line after another: GPUs lack the registers for all samples at once.
static inline float4 pixel_between_lines(__global const float4 *lattice, const Lines *l, bool on_pixels, float x) {
    const float at = (l->per_pixel * x + l->first) / (l->w_per_pixel * x + l->w);
    const float place = CLAMP(at + (on_pixels ? 0.5f : 0.0f), -8.0f, l->lines + 8.0f);
    const int line = floor_int(place);
    if (on_pixels)
        return one_line(lattice, l, line);
    const float4 w = catmull_rom(place - line);
    float4 before = 0.0f, low = 0.0f, high = 0.0f, behind = 0.0f;
#pragma unroll 1
    for (int n = -1; n < 3; n++)
        before = low, low = high, high = behind, behind = one_line(lattice, l, line + n);
    return filter_color(w, before, low, high, behind);
}

#if BLOCK_COLUMNS % 4 == 0 && BLOCK_COLUMNS <= 64
// Pixels and lines four at a time.
#define FOUR_LINES_AT_ONCE

// Lines under a block of pixels and within the filter's support, in fours.
#define MOST_LINES_PER_PIXEL 4
#define FOURS_OF_LINES ((MOST_LINES_PER_PIXEL * BLOCK_COLUMNS + 8) / 4)
#define FOURS_OF_PIXELS (BLOCK_COLUMNS / 4)

// Repeats each of four numbers four times.
static inline float16 spread_to_colors(float4 x) {
#ifdef PERMUTE
    const float16 each = (float16)(x, x, x, x);
    return PERMUTE(each, each, (int16)(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3));
#else
    return (float16)(x.xxxx, x.yyyy, x.zzzz, x.wwww);
#endif
}

// Catmull-Rom weights of the samples -1 ... 2, counted from the one below, for four positions at once.
typedef struct {
    float16 tap[4];
} FourWeights;

static inline FourWeights catmull_rom_four(float4 t) {
    const float4 before = t * (t * (1.0f - 0.5f * t) - 0.5f), behind = t * t * (0.5f * t - 0.5f);
    const float4 low = t * t * (1.5f * t - 2.5f) + 1.0f, high = t * (t * (2.0f - 1.5f * t) + 0.5f);
    const FourWeights w = {{spread_to_colors(before), spread_to_colors(low), spread_to_colors(high), spread_to_colors(behind)}};
    return w;
}

// The same as filter_color for four colours.
static inline float16 filter_four(const FourWeights *w, float16 before, float16 low, float16 high, float16 behind) {
    const float16 color = w->tap[0] * before + w->tap[1] * low + w->tap[2] * high + w->tap[3] * behind;
    const float16 between = CLAMP(color, MIN(low, high), MAX(low, high));
    return WITHIN_OPACITY(between, OPACITIES(between));
}

// Four consecutive lines, starting with `line`, where the row of pixels crosses them.
ALWAYS_INLINE float16 four_lines(__global const float4 *lattice, const Lines *l, int line) {
    const int4 lines = line + (int4)(0, 1, 2, 3);
    // Clamped, since an int cannot hold positions far beyond the lattice.
    const float4 place =
        CLAMP(l->slope * (convert_float4(lines) - l->pivot) + l->origin, (float4)(-4.0f), (float4)(l->length + 4.0f));
    const int4 first = convert_int4(place + 4.0f) - 5;
    const FourWeights w = catmull_rom_four(place - convert_float4(first + 1));
    const int4 beyond = (first < 0) | (first + 4 > l->length);
    if (line >= 0 && line + 4 <= l->lines && !(beyond.x | beyond.y | beyond.z | beyond.w)) {
        __global const float4 *start = lattice + (size_t)line * l->to_line;
        __global const float4 *a = start + (size_t)first.x * l->to_sample, *b = start + l->to_line + (size_t)first.y * l->to_sample;
        __global const float4 *c = start + 2 * l->to_line + (size_t)first.z * l->to_sample;
        __global const float4 *d = start + 3 * l->to_line + (size_t)first.w * l->to_sample;
#define SAMPLES(n) (float16)(a[(n) * l->to_sample], b[(n) * l->to_sample], c[(n) * l->to_sample], d[(n) * l->to_sample])
        return filter_four(&w, SAMPLES(0), SAMPLES(1), SAMPLES(2), SAMPLES(3));
    }
    // Samples at an edge are loaded in a loop: this case is rare, and unrolled it takes compilers as long as all the rest.
    float16 samples[4];
    const int *below = (const int *)&first;
    for (int n = 0; n < 16; n++)
        ((float4 *)samples)[n] = line_sample(lattice, l, line + n % 4, below[n % 4] + n / 4);
    return filter_four(&w, samples[0], samples[1], samples[2], samples[3]);
}

// Lines below the columns of pixels, counted from the first line of the block, and their weights.
typedef struct {
    int line, fours;            // first line, and number of fours
    int at[4 * FOURS_OF_PIXELS]; // the line below each column
    FourWeights weights[FOURS_OF_PIXELS];
} ColumnLines;

// The lines at places x of the row.
#define LINES_AT_PLACES(l, x) (((l)->per_pixel * (x) + (l)->first) / ((l)->w_per_pixel * (x) + (l)->w))

static inline void lines_below(const Lines *l, int left, int right, bool on_pixels, ColumnLines *c) {
    const float one = LINES_AT_PLACES(l, left + 0.5f), other = LINES_AT_PLACES(l, right - 0.5f);
    const float lowest = CLAMP(MIN(one, other), -8.0f, l->lines + 8.0f), highest = CLAMP(MAX(one, other), -8.0f, l->lines + 8.0f);
    c->line = floor_int(lowest) - 1;
    c->fours = min((floor_int(highest) + 3 - c->line + 3) / 4, FOURS_OF_LINES);
    for (int g = 0; g < FOURS_OF_PIXELS; g++) {
        const float4 x = (float)(left + 4 * g) + (float4)(0.5f, 1.5f, 2.5f, 3.5f);
        const float4 place = LINES_AT_PLACES(l, x) - (c->line - (on_pixels ? 0.5f : 0.0f));
        // Columns beyond the picture, or far beyond the lattice, may have any position.
        const float4 held = CLAMP(place, (float4)(1.0f), (float4)(4 * c->fours - 2.5f));
        const int4 at = MIN(convert_int4(held), (int4)(4 * c->fours - 3));
        vstore4(at, g, c->at);
        c->weights[g] = catmull_rom_four(CLAMP(place - convert_float4(at), (float4)(0.0f), (float4)(1.0f)));
    }
}

// A row of pixels of a block.
ALWAYS_INLINE void row_between_lines(__global const float4 *lattice, const Lines *l, const ColumnLines *c, bool on_pixels,
                                     float16 *pixels) {
    float16 lines[FOURS_OF_LINES];
    for (int n = 0; n < c->fours; n++)
        lines[n] = four_lines(lattice, l, c->line + 4 * n);
    const float4 *line = (const float4 *)lines;
    for (int g = 0; g < FOURS_OF_PIXELS; g++) {
        const int *at = c->at + 4 * g;
        const float4 *one = line + at[0], *two = line + at[1], *three = line + at[2], *four = line + at[3];
#define LINES_FROM(n) (float16)(one[n], two[n], three[n], four[n])
        pixels[g] = on_pixels ? LINES_FROM(0)
                              : filter_four(&c->weights[g], LINES_FROM(-1), LINES_FROM(0), LINES_FROM(1), LINES_FROM(2));
    }
}
#endif
