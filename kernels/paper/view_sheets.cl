// Image-aligned sheet-buffer splatting: each splat is divided into slabs, one for each sheet that it covers. Sheets hold the mean density
// and gradient of their slab, and are classified, shaded and composited per pixel.
//
// One work-item per tile of VW x TILE_ROWS pixels, id = tile_v*tiles_u + tile_u, which processes its list of splats front to back. A ring
// holds the SHEETS sheets that the current splats can cover; a sheet is composited when the next splat begins behind it. slabs[i*SHEETS +
// n]: weight of the n-th sheet for the i-th of SLAB_STEPS+1 fractions.

#include "shared/sample.cl"
#include "paper/sheet.cl"

#ifndef SHEETS
#error "SHEETS: that a splat reaches"
#endif
#ifndef SLAB_STEPS
#error "SLAB_STEPS: fractions, less one, that slab weights are given for"
#endif

// Slot of a sheet in the ring. On GPUs, where tiles have one row, the sheets are shifted by one slot instead: arrays indexed by a
// variable would be in memory.
#define SHIFTS_RING (VW == 1 && TILE_ROWS == 1)
#if SHIFTS_RING
#define SLOT(sheet) 0
#else
#define SLOT(sheet) ((sheet) % SHEETS)
#endif

// The sheets of a tile; those of a row are contiguous.
typedef struct {
    realv at[TILE_ROWS][SHEETS][CHANNELS];
    uint reached[SHEETS]; // bit masks of the rows covered by splats
} Ring;

struct SampleSource {
    const realv *channels;
    Point point;
};

static inline Point sample_point(const struct SampleSource *source) { return source->point; }

static inline LightVolume sample_light(const struct SampleSource *source) {
    const LightVolume none = NO_LIGHT_VOLUME;
    return none;
}

static inline Gradient sample_gradient(const struct SampleSource *source) {
#if CHANNELS == 4
    const Gradient gradient = {source->channels[1], source->channels[2], source->channels[3]};
#else
    const Gradient gradient = {(realv)(0.0f), (realv)(0.0f), (realv)(0.0f)};
#endif
    return gradient;
}

// State of the rays of a tile, and their length per voxel of depth.
typedef struct {
    Accumulator gathered[TILE_ROWS];
    Interval intervals[TILE_ROWS];
    RowRays rays[TILE_ROWS];
    realv length[TILE_ROWS];
    intv active;
    int rows;
} Tile;

#if SHIFTS_RING
static inline void shift_ring(Ring *ring) {
#pragma unroll
    for (int n = 0; n < SHEETS; n++) {
        ring->reached[n] = n + 1 < SHEETS ? ring->reached[n + 1] : 0;
#pragma unroll
        for (int c = 0; c < CHANNELS; c++)
            ring->at[0][n][c] = n + 1 < SHEETS ? ring->at[0][n + 1][c] : 0.0f;
    }
}
#endif

// Composites a sheet, and clears its slot in the ring. False when the tile is opaque.
ALWAYS_INLINE bool composite_sheet(const SplatParams *p, const SampleParams *sample, __global const float4 *table,
                                   int sheet, Ring *ring, Tile *tile) {
    const int slot = SLOT(sheet);
    const float depth = (sheet + p->first_sheet) * p->sheet_distance;
    // All rows count if the background is visible, or if values are accumulated.
    const uint shown = sample->classification.background_visible || GATHERS_VALUES ? ~0u : ring->reached[slot];
    const bool ahead = depth >= p->nearest_sheet;
    EACH_ROW(r, 0, tile->rows - 1) {
        if (!(shown >> r & 1))
            continue;
        realv *channels = ring->at[r][slot];
        if (ahead) {
            const RowRays *rays = &tile->rays[r];
            const realv at = ray_parameter(p, rays, depth);
            const Point point = {rays->o[0] + at * rays->d[0], rays->o[1] + at * rays->d[1], rays->o[2] + at * rays->d[2]};
            const struct SampleSource source = {channels, point};
            bool lit = false;
            Lighting lighting;
            Share share = 1.0f;
            realv parameters = 1.0f;
#ifdef CLIPPED
            const realv enters = ray_parameter(p, &tile->rays[r], depth - 0.5f * p->sheet_distance);
            const realv leaves = ray_parameter(p, &tile->rays[r], depth + 0.5f * p->sheet_distance);
            const Part part = part_of(&tile->intervals[r], enters, leaves);
            share = part_length(&part), parameters = leaves - enters;
#endif
            accumulate_sample(sample, table, p->background + channels[0], share, tile->length[r] * p->sheet_distance, parameters, &source,
                              &lit, &lighting, &tile->gathered[r], &tile->active);
        }
        for (int c = 0; c < CHANNELS; c++)
            channels[c] = 0.0f;
    }
    ring->reached[slot] = 0;
#if SHIFTS_RING
    shift_ring(ring);
#endif
    return !shown || any_row_open(sample, tile->gathered, tile->rows);
}

// Adds a splat to the sheets from `first` on.
ALWAYS_INLINE void splat_slabs(const SplatParams *p, __global const float *slabs, const Splat *splat, int first, int column,
                               int row, Ring *ring, const Tile *tile) {
    const float fraction = (first - splat->reach) * SLAB_STEPS;
    const int step = min((int)fraction, SLAB_STEPS - 1);
    __global const float *weights = slabs + step * SHEETS;
    const Footprint f = splat_footprint(p, splat, column, row, tile->rows);
    const float4 content = splat->content;
    const uint rows = f.from <= f.to ? (2u << f.to) - (1u << f.from) : 0;
    float4 amount[SHEETS];
    int slot = SLOT(first);
#pragma unroll
    for (int n = 0; n < SHEETS; n++) {
        amount[slot] = mix(weights[n], weights[n + SHEETS], fraction - step) * content;
        ring->reached[n] |= rows;
        slot = slot + 1 == SHEETS ? 0 : slot + 1;
    }
    EACH_ROW(r, f.from, f.to) {
        const realv footprint = footprint_row(p, splat, &f, r);
#pragma unroll
        for (int n = 0; n < SHEETS; n++)
#pragma unroll
            for (int c = 0; c < CHANNELS; c++)
                ring->at[r][n][c] += ((const float *)&amount[n])[c] * footprint;
    }
}

__kernel void view_sheets(__global const Splat *sorted, __global const uint *ends, __global const uint *lists, int chunks,
                          __global const float *slabs, __global const float4 *table, ScreenParams s, SplatParams p, SampleParams sample,
                          RayEnds ray_ends, OUTPUT, ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= s.tiles_u * s.tiles_v)
        return;
    const int column = id % s.tiles_u * VW, row = id / s.tiles_u * TILE_ROWS;
    Tile tile;
    tile.rows = min(TILE_ROWS, s.height - row);
    tile.active = 0;
    EACH_ROW(r, 0, tile.rows - 1) {
        tile.rays[r] = row_rays(&s, column, row + r);
        tile.length[r] = length_per_depth(&p, &tile.rays[r]);
        tile.gathered[r] = empty_accumulator(&sample);
#ifdef CLIPPED
        // Sheets at the eye are omitted as a whole.
        tile.intervals[r] = clip_rays(&ray_ends, tile.rays[r].o, tile.rays[r].d);
#endif
    }
    const uint2 list = tile_list(ends, &s, chunks, id);
    const int sheets = p.last_sheet - p.first_sheet + 1;
    if (list.x < list.y || sample.classification.background_visible || GATHERS_VALUES) {
        Ring ring;
        for (int n = 0; n < SHEETS; n++) {
            ring.reached[n] = 0;
            for (int r = 0; r < TILE_ROWS; r++)
                for (int c = 0; c < CHANNELS; c++)
                    ring.at[r][n][c] = 0.0f;
        }
        bool open = true;
        int current = 0; // the first sheet that is not composited yet
        for (uint e = list.x; e < list.y && open; e++) {
            PREFETCH(sorted + lists[min(e + PREFETCH_DISTANCE, list.y - 1)]);
            const Splat splat = sorted[lists[e]];
            const int first = first_sheet(splat.reach);
            while (current < first && open)
                open = composite_sheet(&p, &sample, table, current++, &ring, &tile);
            splat_slabs(&p, slabs, &splat, first, column, row, &ring, &tile);
        }
        while (current < sheets && open)
            open = composite_sheet(&p, &sample, table, current++, &ring, &tile);
    }
    EACH_ROW(r, 0, tile.rows - 1)
        store_pixels(&s, &sample, table, column, row + r, &tile.gathered[r], &tile.intervals[r], target);
    active_samples[id] = sum_lanes(tile.active, columns_on_screen(&s, column));
}
