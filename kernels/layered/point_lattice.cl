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
    int rows, columns;
    float2 first_u, last_u, first_v, last_v;
} Tile;

static inline Tile tile_of(const RayLatticeParams *p, int column, int row) {
    Tile tile;
    tile.rows = min(TILE_ROWS, p->height - row), tile.columns = min(VW, p->width - column);
    crossings_of_columns(p, column, &tile.centre_u, &tile.shear_u);
    tile.v.stagger = stagger_of_columns(p, column);
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

// Whether the slabs of a chunk can show anything over a window: bit q % 8. A row of blocks is read at once; more than
// eight are not looked at.
static inline int slabs_visible(__global const uchar *visible, const RayLatticeParams *p, int chunk, Window w) {
    const int b0 = clamp(block_of(w.u0, BLOCK), 0, p->blocks_u - 1), b1 = clamp(block_of(w.u1, BLOCK), 0, p->blocks_u - 1);
    const int c0 = clamp(block_of(w.v0, POINT_BLOCK_ROWS), 0, p->blocks_v - 1);
    const int c1 = clamp(block_of(w.v1, POINT_BLOCK_ROWS), 0, p->blocks_v - 1);
    if (b1 - b0 > 7)
        return 0xff;
    __global const uchar *block = visible + ((size_t)chunk * p->blocks_v + c0) * p->blocks_u + b0;
    ulong bits = 0;
    for (int c = c0; c <= c1; c++, block += p->blocks_u)
        bits |= as_ulong(vload8(0, block));
    bits <<= 8 * (7 - (b1 - b0));
    bits |= bits >> 32;
    bits |= bits >> 16;
    bits |= bits >> 8;
    return bits & 0xff;
}

// Bits of the chunk of slabs that a tile is in.
typedef struct {
    int index, bits;
} Chunk;

// How many slabs from q on, up to `last` of a ray's order, can show nothing under a tile, as far as that is known: whole
// chunks first, then a slab of its own. `visible` counts slabs from `first`, the first layer that voxels hold. `enters`: 0 or 1, a ray enters
// slab q at layer q-RADIUS+enters.
ALWAYS_INLINE int slabs_to_skip(__global const uchar *visible, const RayLatticeParams *p, int first, const Tile *tile, int q,
                                int last, int enters, Chunk *chunk) {
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
    return !(slabs_visible(visible, p, chunk->index, window_at(tile, q + to_plane)) >> (q & 7) & 1);
}

#ifdef CLIPPED
// The outermost ends of a tile's intervals.
static inline void bounds_of(const Interval *intervals, int rows, float *from, float *to) {
    *from = INFINITY, *to = -INFINITY;
    for (int r = 0; r < rows; r++) {
        const intv met = intervals[r].from < intervals[r].to;
        *from = MIN(*from, smallest_lane(met ? intervals[r].from : (realv)(INFINITY)));
        *to = MAX(*to, largest_lane(met ? intervals[r].to : (realv)(-INFINITY)));
    }
}
#endif

// The sub-layers at both ends of a segment. Samples one unless it is held.
#define HELD(l) (&held[(l) & 1])
#define COLUMNS_AT(l) (tile.centre_u + ((float)(l) / s - RADIUS - p.centre_layer) * tile.shear_u)
#define HOLD(l)                                                                                                        \
    if (HELD(l)->held != (l))                                                                                          \
    sample_layer(voxels, &view, p.centre_layer, s, l, COLUMNS_AT(l), &tile.v, tile.rows, HELD(l))

// Asks for the voxels of a layer under a tile, which the slab after the next looks at: layers wait for memory. A part need not hold it:
// asking for what is not there does nothing.
static inline void fetch_ahead(__global const VOXEL *voxels, const VolumeView *view, const RayLatticeParams *p, const Tile *tile, int k) {
    if (k < 0 || k >= view->dims_a)
        return;
    const Window w = window_at(tile, k - p->centre_layer);
    const int first_u = clamp(w.u0 - 1, 0, view->dims_u - 1), last_u = clamp(w.u1 + 2, 0, view->dims_u - 1);
    const int first = max(w.v0 - 1, 0), last = min(w.v1 + 2, view->dims_v - 1);
    __global const VOXEL *row = voxels + (k - view->first_a) * view->stride_a + first * view->stride_v;
    for (int j = first; j <= last; j++, row += view->stride_v) {
        PREFETCH(row + first_u);
        PREFETCH(row + last_u);
    }
}

// The way of a tile's row from plane k on.
static inline Way way_of(const Tile *tile, float centre_layer, int r, float k, float step, const Samples *one, const Samples *other) {
    return way_on(tile->centre_u, tile->shear_u, tile->v.centre[r] + tile->v.stagger, tile->v.shear[r], centre_layer, k, step,
                  one->field[r], other->field[r]);
}

#if HAS_SLOPES && LIT_AT_ENDS
// Samples in the middle between those of two planes, of some rows, a bit each.
static inline void find_middle(const SampleParams *p, __global const int4 *integrals, const Tile *tile, float centre_layer, float k,
                        float step, int tile_rows, const Samples *const *ends, Samples *middle) {
    for (int rows = tile_rows; rows; rows &= rows - 1) {
        const int r = LOWEST_ROW(rows);
        const Way way = way_of(tile, centre_layer, r, k, step, ends[0], ends[1]);
        const intv counts = counts_between(p, integrals, way.from, way.to);
        middle->lit[r] = lit_in_the_middle(p, &way, counts, &ends[0]->lit[r], &ends[1]->lit[r], &middle->field[r]);
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
#if BLEND == COMPOSITE
    realv dt[TILE_ROWS];
    // Of the samples at even places and at odd ones, and which places these are.
    Node nodes[2][TILE_ROWS];
    int nodes_at[2][TILE_ROWS];
#endif
    intv active = 0;
    for (int r = 0; r < tile.rows; r++) {
        gathered[r] = p.continues ? load_raw(&sample, lattice + (size_t)(row + r) * p.width + column, tile.columns, 1)
                                  : empty_accumulator(&sample);
#ifdef CLIPPED
        intervals[r] = interval_of_columns(&p, &clip, tile.centre_u, tile.shear_u, tile.v.stagger, row + r);
#endif
#if BLEND == COMPOSITE
        const realv step_u = tile.shear_u * sample.step_u;
        const float step_v = tile.v.shear[r] * sample.step_v;
        dt[r] = sqrt(step_u * step_u + (step_v * step_v + sample.step_a * sample.step_a)) * sample.table_unit;
        nodes_at[0][r] = nodes_at[1][r] = INT_MIN;
#endif
    }
#ifdef CLIPPED
    float begin, end;
    bounds_of(intervals, tile.rows, &begin, &end);
#endif

    const int s = sample.inner_slabs, enters = p.layer_step > 0 ? 0 : 1;
    int lowest = p.first_layer, highest = p.last_layer;
    if (p.culling)
        lowest = max(lowest, shown_slabs[0] + view.first_a), highest = min(highest, shown_slabs[1] + view.first_a);
    int open = (1 << tile.rows) - 1; // rows that anything more can change
    if (p.continues)
        for (int r = 0; r < tile.rows; r++)
            open &= ~(any_open_of(&sample, &gathered[r], tile.columns) ? 0 : 1 << r);
    Chunk chunk = {-1, 0};
    for (int n = 0; n <= highest - lowest && open; n++) {
        const int q = enters ? highest - n : lowest + n;
#ifdef CLIPPED
        const float entry = p.layer_step * (q - RADIUS + enters - p.centre_layer);
        if (entry >= end || entry + 1.0f <= begin)
            continue;
#endif
        const int skip =
            p.culling ? slabs_to_skip(visible, &p, view.first_a, &tile, q, enters ? lowest : highest, enters, &chunk) : 0;
        if (skip) {
            n += skip - 1;
            continue;
        }
        fetch_ahead(voxels, &view, &p, &tile, q - RADIUS + 1 - enters + (RADIUS + 1) * p.layer_step);
        for (int i = 0; i < s; i++) {
            const int l0 = enters ? (q + 1) * s - i : q * s + i, l1 = l0 + p.layer_step;
            HOLD(l0);
            HOLD(l1);
            Layer *front = HELD(l0), *behind = HELD(l1);
            int shown = open;
#if !GATHERS_VALUES
            for (int r = 0; r < tile.rows; r++) {
                const realv from = front->at.field[r], to = behind->at.field[r];
                if (!ANY(shows(&sample, from, to)))
                    shown &= ~(1 << r);
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
                find_middle(&sample, integrals, &tile, p.centre_layer, k, step, shown, samples, &middle);
                samples[1] = &middle, samples[2] = &behind->at, ways = 2;
            }
#endif
            for (int w = 0; w < ways; w++) {
                const Samples *one = samples[w], *other = samples[w + 1];
                const float length = 1.0f / ways, from_k = k + w * length * step;
                Part parts[TILE_ROWS];
#ifdef CLIPPED
                const float enters_at = p.layer_step * (from_k - p.centre_layer);
                for (int r = 0; r < tile.rows; r++)
                    parts[r] = part_of(&intervals[r], (realv)(enters_at), (realv)(enters_at + length / s));
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
                    for (int rows = shown; rows; rows &= rows - 1) {
                        const int r = LOWEST_ROW(rows);
                        if (nodes_at[odd][r] == place)
                            continue;
                        nodes[odd][r] = node_of(&sample, integrals, here->field[r], odd);
                        nodes_at[odd][r] = place;
                    }
                }
                Segment segments[TILE_ROWS];
                for (int rows = shown; rows; rows &= rows - 1) {
                    const int r = LOWEST_ROW(rows);
                    const realv from = one->field[r], to = other->field[r], unit = length * dt[r];
#ifdef CLIPPED
                    if (any_cut(&parts[r])) {
                        const realv cut_from = between(from, to, parts[r].from), cut_to = between(from, to, parts[r].to);
                        const Node at_cut = node_of(&sample, integrals, cut_from, places[0] & 1);
                        const Node behind_cut = node_of(&sample, integrals, cut_to, places[1] & 1);
                        segments[r] = segment_between(&sample, integrals, &at_cut, &behind_cut, cut_from, cut_to, weights,
                                                      unit * share_of(&parts[r]));
                        continue;
                    }
#endif
                    segments[r] = segment_between(&sample, integrals, &at_front[r], &at_back[r], from, to, weights,
                                                  PART_OF(unit, &parts[r]));
                }
#endif
                for (int rows = shown; rows; rows &= rows - 1) {
                    const int r = LOWEST_ROW(rows);
                    const Way way = way_of(&tile, p.centre_layer, r, from_k, length * step, one, other);
#if BLEND == COMPOSITE
                    composite_way(voxels, &view, &sample, integrals, &segments[r], &parts[r], &way,
                                  PART_OF(length * dt[r], &parts[r]), &one->lit[r], &other->lit[r], &gathered[r], &active);
#elif BLEND == ISO
                    take_crossing(voxels, &view, &sample, &parts[r], &way, &one->lit[r], &other->lit[r], &gathered[r], &active);
#else
                    take_values(voxels, &view, &parts[r], &way, share_of(&parts[r]) / s, &gathered[r], &active);
#endif
                    if (!any_open_of(&sample, &gathered[r], tile.columns))
                        open &= ~(1 << r);
                }
            }
        }
    }

    uint total = counted(active, tile.columns);
    for (int r = 0; r < tile.rows; r++)
        END_RAYS(p, sample, table, &gathered[r], &intervals[r], tile.columns, 1, lattice + (size_t)(row + r) * p.width + column, total)
    active_samples[id] = total;
}
