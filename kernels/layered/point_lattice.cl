// Layered rendering with point-sampled layers, on the lattice of any view.
//
// A layer is sampled where the rays cross it: the reconstructed field itself, which on the plane of a layer needs that alone, with all
// kernels but the B-spline (point_layer.cl). Between two samples the classification is pre-integrated.
// One work-item per tile of VW x TILE_ROWS samples, id = tile_v*tiles_u + tile_u. lattice[J*width + I] = RGBA;
// visible: a bit per block and slab, from slab_visibility.cl;
// shown_slabs: the first and the last slab in which any is set, counted from the first layer that voxels hold, from shown_slabs.cl.

#include "layered/point_layer.cl"
#include "layered/ray_lattice.cl"
#include "shared/segment.cl"

// The rays of a tile: its columns, its rows, and the outermost of both.
typedef struct {
    realv centre_u, shear_u;
    TileRows v;
    int column, row, columns, rows, bands;
    float2 first_u, last_u, first_v, last_v;
} Tile;

static inline Tile tile_of(const RayLatticeParams *p, int column, int row) {
    Tile tile;
    tile.column = column, tile.row = row;
    tile.rows = min(TILE_ROWS, p->height - row), tile.columns = min(VW, p->width - column);
    tile.bands = (tile.rows + PATCH_ROWS - 1) / PATCH_ROWS;
    crossings_of(p, 0, LANES + column, &tile.centre_u, &tile.shear_u);
    tile.v.stagger = stagger_of_columns(p, LANES + column);
    for (int r = 0; r < PADDED_ROWS; r++) {
        const float2 crossing = crossing_of(p, 1, row + min(r, tile.rows - 1));
        tile.v.centre[r] = crossing.x, tile.v.shear[r] = crossing.y;
    }
    tile.first_u = crossing_of(p, 0, column), tile.last_u = crossing_of(p, 0, column + tile.columns - 1);
    tile.first_v = crossing_of(p, 1, row), tile.last_v = crossing_of(p, 1, row + tile.rows - 1);
#if FARTHEST
    tile.last_v.x += p->rays[5];
#endif
    return tile;
}

// The rays of a patch. Beyond the lattice there are none: `inside`.
static inline SampleRays rays_of_patch(const RayLatticeParams *p, const Tile *tile, int patch) {
    return rays_of_samples(p, columns_of_patch(patch) + tile->column, rows_of_patch(patch) + tile->row);
}
static inline intv inside(const Tile *tile, int patch) {
    return columns_of_patch(patch) < tile->columns && rows_of_patch(patch) < tile->rows;
}

// More than rounding takes from a row of samples.
#define ROUNDED 0.01f

// Voxels [u0, u1] x [v0, v1].
typedef struct {
    int u0, u1, v0, v1;
} Window;

// The voxels below a tile's rays at a plane.
static inline Window window_at(const Tile *tile, float depth) {
    Window w;
    voxels_below(tile->first_u, tile->last_u, depth, &w.u0, &w.u1);
    voxels_below(tile->first_v, tile->last_v, depth, &w.v0, &w.v1);
    return w;
}

// The blocks over a window, and where the bits of the first are.
typedef struct {
    int b0, b1, c0, c1;
    __global const uchar *first;
} Blocks;

static inline Blocks blocks_over(__global const uchar *visible, const RayLatticeParams *p, int chunk, Window w) {
    Blocks blocks;
    blocks.b0 = clamp(block_of(w.u0, BLOCK), 0, p->blocks_u - 1), blocks.b1 = clamp(block_of(w.u1, BLOCK), 0, p->blocks_u - 1);
    blocks.c0 = clamp(block_of(w.v0, POINT_BLOCK_ROWS), 0, p->blocks_v - 1);
    blocks.c1 = clamp(block_of(w.v1, POINT_BLOCK_ROWS), 0, p->blocks_v - 1);
    blocks.first = visible + ((size_t)chunk * p->blocks_v + blocks.c0) * p->blocks_u + blocks.b0;
    return blocks;
}

// A row of blocks is read at once; more than eight are not looked at.
#define MOST_BLOCKS 8
static inline ulong bits_of(__global const uchar *row, const Blocks *blocks) {
    return as_ulong(vload8(0, row)) << 8 * (MOST_BLOCKS - 1 - (blocks->b1 - blocks->b0));
}

// Whether the slabs of a chunk can show anything over a window: bit q % 8.
static inline int slabs_visible(__global const uchar *visible, const RayLatticeParams *p, int chunk, Window w) {
    const Blocks blocks = blocks_over(visible, p, chunk, w);
    if (blocks.b1 - blocks.b0 >= MOST_BLOCKS)
        return 0xff;
    __global const uchar *row = blocks.first;
    ulong bits = 0;
    for (int c = blocks.c0; c <= blocks.c1; c++, row += p->blocks_u)
        bits |= bits_of(row, &blocks);
    bits |= bits >> 32;
    bits |= bits >> 16;
    bits |= bits >> 8;
    return bits & 0xff;
}

// The patches of a tile over which a slab of a chunk can show anything: from the first to the last row of blocks that can.
static inline int patches_visible(__global const uchar *visible, const RayLatticeParams *p, int chunk, int slab, const Tile *tile, float depth) {
    const int all = FIRST_FEW(tile->bands * PATCH_ROWS);
    const Blocks blocks = blocks_over(visible, p, chunk, window_at(tile, depth));
    if (blocks.b1 - blocks.b0 >= MOST_BLOCKS)
        return all;
    __global const uchar *row = blocks.first;
    int first = INT_MAX, last = INT_MIN;
    for (int c = blocks.c0; c <= blocks.c1; c++, row += p->blocks_u)
        if (bits_of(row, &blocks) & 0x0101010101010101ul << slab)
            first = min(first, c), last = c;
    if (first > last)
        return 0;
    if (first == blocks.c0 && last == blocks.c1)
        return all;
    // Rows of samples over them: blocks at the edges have all that is beyond too.
    const float v = tile->first_v.x + depth * tile->first_v.y, spacing = p->rays[5] + depth * p->rays[7];
    const float above = first == 0 ? -INFINITY : FIRST_OF_BLOCK(first, POINT_BLOCK_ROWS) - v;
    const float below = last == p->blocks_v - 1 ? INFINITY : FIRST_OF_BLOCK(last + 1, POINT_BLOCK_ROWS) - v;
    const float one = above / spacing, other = below / spacing;
    // A staggered column lies less than a row behind.
    const int top = CLAMP(MIN(one, other) - (FARTHEST ? 1.0f : 0.0f) - ROUNDED, 0.0f, (float)TILE_ROWS);
    const int bottom = CLAMP(MAX(one, other) + ROUNDED, -1.0f, tile->rows - 1.0f);
    return FIRST_FEW(bottom / PATCH_ROWS * PATCH_ROWS + PATCH_ROWS) & ~FIRST_FEW(top / PATCH_ROWS * PATCH_ROWS);
}

// Bits of the chunk of slabs that a tile is in.
typedef struct {
    int index, bits;
} Chunk;

// How many slabs from q on, up to `last` of a ray's order, can show nothing under a tile, as far as that is known: whole
// chunks first, then a slab of its own, of which the `patches` are told. `visible` counts slabs from `first`, the first layer that voxels hold.
// `enters`: 0 or 1, a ray enters slab q at layer q-RADIUS+enters.
ALWAYS_INLINE int slabs_to_skip(__global const uchar *visible, const RayLatticeParams *p, int first, const Tile *tile, int q,
                                int last, int enters, Chunk *chunk, int *patches) {
    const float to_plane = first + enters - RADIUS - p->centre_layer;
    q -= first, last -= first;
    if (q >> 3 != chunk->index) {
        chunk->index = q >> 3;
        const int end = enters ? max(q & ~7, last) : min(q | 7, last);
        const Window a = window_at(tile, q + to_plane), b = window_at(tile, end + to_plane);
        const Window both = {min(a.u0, b.u0), max(a.u1, b.u1), min(a.v0, b.v0), max(a.v1, b.v1)};
        chunk->bits = slabs_visible(visible, p, chunk->index, both);
        if (!chunk->bits)
            return abs(end - q) + 1;
    }
    if (!(chunk->bits >> (q & 7) & 1))
        return 1;
    *patches = patches_visible(visible, p, chunk->index, q & 7, tile, q + to_plane);
    return !*patches;
}

#ifdef CLIPPED
// The outermost ends of a tile's intervals.
static inline void bounds_of(const Interval *intervals, int patches, float *from, float *to) {
    *from = INFINITY, *to = -INFINITY;
    for (int n = 0; n < patches; n++) {
        const intv met = intervals[n].from < intervals[n].to;
        *from = MIN(*from, smallest_lane(met ? intervals[n].from : (realv)(INFINITY)));
        *to = MAX(*to, largest_lane(met ? intervals[n].to : (realv)(-INFINITY)));
    }
}
#endif

// The sub-layers at both ends of a segment. Samples the patches of one that are not held.
#define HELD(l) (&held[(l) & 1])
#define COLUMNS_AT(l) (tile.centre_u + ((float)(l) / s - RADIUS - p.centre_layer) * tile.shear_u)
#define HOLD(l)                                                                                                        \
    if (HELD(l)->held != (l) || over & ~HELD(l)->sampled)                                                              \
    sample_layer(voxels, &view, p.centre_layer, s, l, COLUMNS_AT(l), &tile.v, over, HELD(l))

// Bytes that a processor fetches at once.
#define LINE 64

// Asks for the voxels of a layer under a tile, which the slab after the next looks at: layers wait for memory. A part need not hold it:
// asking for what is not there does nothing.
static inline void fetch_ahead(__global const VOXEL *voxels, const VolumeView *view, const RayLatticeParams *p, const Tile *tile, int k) {
    if (k < 0 || k >= view->dims_a)
        return;
    const Window w = window_at(tile, k - p->centre_layer);
    const int first_u = clamp(w.u0 - 1, 0, view->dims_u - 1), last_u = clamp(w.u1 + 2, 0, view->dims_u - 1);
    const int first = max(w.v0 - 1, 0), last = min(w.v1 + 2, view->dims_v - 1);
    __global const VOXEL *row = voxels + (k - view->first_a) * view->stride_a + first * view->stride_v;
    // Rows of whole lines have their voxels in one of each, or in two.
    const bool in_one = view->stride_v * sizeof(VOXEL) % LINE == 0 && (ulong)(row + first_u) / LINE == (ulong)(row + last_u) / LINE;
    for (int j = first; j <= last; j++, row += view->stride_v) {
        PREFETCH(row + first_u);
        if (!in_one)
            PREFETCH(row + last_u);
    }
}

// The way of a patch's rays from plane k on.
static inline Way way_of(const RayLatticeParams *p, const Tile *tile, int patch, float k, float step, realv from, realv to) {
    const SampleRays rays = rays_of_patch(p, tile, patch);
    return way_on(rays.centre_u, rays.shear_u, rays.centre_v, rays.shear_v, p->centre_layer, k, step, from, to);
}

#if HAS_SLOPES && LIT_AT_ENDS
// Samples in the middle between those of two planes, of some patches.
static inline void find_middle(const RayLatticeParams *p, const SampleParams *sample, __global const int4 *integrals, const Tile *tile,
                               float k, float step, int patches, const Samples *const *ends, Samples *middle) {
    for (int left = patches; left; left &= left - 1) {
        const int n = LOWEST_OF(left);
        const Way way = way_of(p, tile, n, k, step, ends[0]->field[n], ends[1]->field[n]);
        const intv counts = counts_between(sample, integrals, way.from, way.to);
        middle->lit[n] = lit_in_the_middle(sample, &way, counts, &ends[0]->lit[n], &ends[1]->lit[n], &middle->field[n]);
    }
}
#endif

__kernel void point_lattice(__global const VOXEL *voxels, VolumeView view, __global const uchar *visible,
                            __global const int *shown_slabs, __global const int4 *integrals, __global const float4 *table, RayLatticeParams p,
                            SampleParams sample, Clipping clip, __global float4 *lattice, __global uint *active_samples) {
    const int id = get_global_id(0);
    if (id >= p.tiles_u * p.tiles_v)
        return;
    voxels += view.first;
    const int column = id % p.tiles_u * VW, row = id / p.tiles_u * TILE_ROWS;
    const Tile tile = tile_of(&p, column, row);
    Layer held[2];
    held[0].held = held[1].held = INT_MIN;
    Accumulator gathered[TILE_ROWS];
    Interval intervals[TILE_ROWS];
    intv has_ray[TILE_ROWS];
#if BLEND == COMPOSITE
    realv dt[TILE_ROWS];
    // Of the samples at even places and at odd ones, and which places these are.
    Node nodes[2][TILE_ROWS];
    int nodes_at[2][TILE_ROWS];
#endif
    intv active = 0;
    const int patches = tile.bands * PATCH_ROWS;
    for (int r = 0; r < patches; r++) {
        gathered[r] = p.continues && r < tile.rows
                          ? load_raw(&sample, lattice + (size_t)(row + r) * p.width + column, tile.columns, 1)
                          : empty_accumulator(&sample);
    }
    regroup_all((realv *)gathered, RAW_NUMBERS, tile.bands);
    for (int n = 0; n < patches; n++) {
        const SampleRays rays = rays_of_patch(&p, &tile, n);
        has_ray[n] = inside(&tile, n);
#ifdef CLIPPED
        intervals[n] = interval_of_rays(&p, &clip, &rays);
#endif
#if BLEND == COMPOSITE
        dt[n] = length_of_rays(&sample, &rays) * sample.table_unit;
        nodes_at[0][n] = nodes_at[1][n] = INT_MIN;
#endif
    }
#ifdef CLIPPED
    float begin, end;
    bounds_of(intervals, patches, &begin, &end);
#endif

    const int s = sample.inner_slabs, enters = p.layer_step > 0 ? 0 : 1;
    int lowest = p.first_layer, highest = p.last_layer;
    if (p.culling)
        lowest = max(lowest, shown_slabs[0] + view.first_a), highest = min(highest, shown_slabs[1] + view.first_a);
    int open = FIRST_FEW(patches); // patches that anything more can change
    if (p.continues)
        for (int n = 0; n < patches; n++)
            open &= ~(ANY(has_ray[n] && open_rays(&sample, &gathered[n])) ? 0 : 1 << n);
    Chunk chunk = {-1, 0};
    for (int passed = 0; passed <= highest - lowest && open; passed++) {
        const int q = enters ? highest - passed : lowest + passed;
#ifdef CLIPPED
        const float entry = p.layer_step * (q - RADIUS + enters - p.centre_layer);
        if (entry >= end || entry + 1.0f <= begin)
            continue;
#endif
        int over = FIRST_FEW(patches);
        const int skip =
            p.culling ? slabs_to_skip(visible, &p, view.first_a, &tile, q, enters ? lowest : highest, enters, &chunk, &over) : 0;
        if (skip) {
            passed += skip - 1;
            continue;
        }
        fetch_ahead(voxels, &view, &p, &tile, q - RADIUS + 1 - enters + (RADIUS + 1) * p.layer_step);
        for (int i = 0; i < s; i++) {
            const int l0 = enters ? (q + 1) * s - i : q * s + i, l1 = l0 + p.layer_step;
            HOLD(l0);
            HOLD(l1);
            Layer *front = HELD(l0), *behind = HELD(l1);
            int shown = open & over;
#if !GATHERS_VALUES
            for (int left = shown; left; left &= left - 1) {
                const int n = LOWEST_OF(left);
                const intv shows_any = shows(&sample, front->at.field[n], behind->at.field[n]);
                if (!ANY(shows_any))
                    shown &= ~(1 << n);
            }
#endif
            if (!shown)
                continue;
            // All lighting before all look-ups: shorter loops overlap better, 5 % on engine.
            if (sample.shading && LIT_AT_ENDS) {
                light_layer(voxels, &view, &sample, s, COLUMNS_AT(l0), shown, front);
                light_layer(voxels, &view, &sample, s, COLUMNS_AT(l1), shown, behind);
            }
            // Of the plane at which rays enter, and the distance to that at which they leave.
            const float k = (float)l0 / s - RADIUS, step = (float)p.layer_step / s;
            const Samples *samples[3] = {&front->at, &behind->at, 0};
            int ways = 1;
#if HAS_SLOPES && LIT_AT_ENDS
            Samples middle;
            if (sample.shading) {
                find_middle(&p, &sample, integrals, &tile, k, step, shown, samples, &middle);
                samples[1] = &middle, samples[2] = &behind->at, ways = 2;
            }
#endif
            for (int w = 0; w < ways; w++) {
                const Samples *one = samples[w], *other = samples[w + 1];
                const float length = 1.0f / ways, from_k = k + w * length * step;
                Part parts[TILE_ROWS];
#ifdef CLIPPED
                const float enters_at = p.layer_step * (from_k - p.centre_layer);
                for (int n = 0; n < patches; n++)
                    parts[n] = part_of(&intervals[n], (realv)(enters_at), (realv)(enters_at + length / s));
#endif
#if BLEND == COMPOSITE
                const float2 weights = ends_of(&sample, l0, l1);
                // Samples alternate between even and odd nodes. All look-ups before all segments: shorter loops overlap better, 4 % on
                // engine.
                const int places[2] = {ways * l0 + w * p.layer_step, ways * l0 + (w + 1) * p.layer_step};
                Node *at_front = nodes[places[0] & 1], *at_back = nodes[places[1] & 1];
                for (int end = 0; end < 2; end++) {
                    const int place = places[end], odd = place & 1;
                    const Samples *here = end ? other : one;
                    for (int left = shown; left; left &= left - 1) {
                        const int n = LOWEST_OF(left);
                        if (nodes_at[odd][n] == place)
                            continue;
                        nodes[odd][n] = node_of(&sample, integrals, here->field[n], odd);
                        nodes_at[odd][n] = place;
                    }
                }
                Segment segments[TILE_ROWS];
                for (int left = shown; left; left &= left - 1) {
                    const int n = LOWEST_OF(left);
                    const realv from = one->field[n], to = other->field[n], unit = length * dt[n];
#ifdef CLIPPED
                    if (any_cut(&parts[n])) {
                        const realv cut_from = between(from, to, parts[n].from), cut_to = between(from, to, parts[n].to);
                        const Node at_cut = node_of(&sample, integrals, cut_from, places[0] & 1);
                        const Node behind_cut = node_of(&sample, integrals, cut_to, places[1] & 1);
                        segments[n] = segment_between(&sample, integrals, &at_cut, &behind_cut, cut_from, cut_to, weights,
                                                      unit * share_of(&parts[n]));
                        continue;
                    }
#endif
                    segments[n] = segment_between(&sample, integrals, &at_front[n], &at_back[n], from, to, weights,
                                                  PART_OF(unit, &parts[n]));
                }
#endif
                for (int left = shown; left; left &= left - 1) {
                    const int n = LOWEST_OF(left);
                    const Way way = way_of(&p, &tile, n, from_k, length * step, one->field[n], other->field[n]);
                    intv counts = 0;
#if BLEND == COMPOSITE
                    composite_way(voxels, &view, &sample, integrals, &segments[n], &parts[n], &way,
                                  PART_OF(length * dt[n], &parts[n]), &one->lit[n], &other->lit[n], &gathered[n], &counts);
#elif BLEND == ISO
                    take_crossing(voxels, &view, &sample, &parts[n], &way, &one->lit[n], &other->lit[n], &gathered[n], &counts);
#else
                    take_values(voxels, &view, &parts[n], &way, share_of(&parts[n]) / s, &gathered[n], &counts);
#endif
                    active += counts & has_ray[n];
                    if (!ANY(has_ray[n] && open_rays(&sample, &gathered[n])))
                        open &= ~(1 << n);
                }
            }
        }
    }

    regroup_all((realv *)gathered, RAW_NUMBERS, tile.bands);
#ifdef CLIPPED
    regroup_all((realv *)intervals, sizeof(Interval) / sizeof(realv), tile.bands);
#endif
    uint total = counted(active, VW);
    for (int r = 0; r < tile.rows; r++)
        END_RAYS(p, sample, table, &gathered[r], &intervals[r], tile.columns, 1, lattice + (size_t)(row + r) * p.width + column, total)
    active_samples[id] = total;
}
