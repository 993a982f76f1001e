// Layered rendering with point-sampled layers, on the lattice of any view.
//
// A layer is sampled where the rays cross it: P = sum of voxels x f(u) f(v), the reconstructed field itself, since of all
// kernels only the layer's own reach its plane (point_layer.cl). Between two samples the classification is pre-integrated.
// One work-item per tile of VW x TILE_ROWS samples, id = tile_v*tiles_u + tile_u. lattice[J*width + I] = RGBA;
// crossings_u is padded to whole tiles. visible: a bit per block and slab, from slab_visibility.cl.

// The rays of a tile: its columns, its rows, and the outermost of both.
typedef struct {
    realv centre_u, shear_u;
    TileRows v;
    int rows, columns;
    float2 first_u, last_u, first_v, last_v;
} Tile;

inline Tile tile_of(__global const float2 *crossings_u, __global const float2 *crossings_v, int rows, int columns) {
    Tile tile;
    tile.rows = rows, tile.columns = columns;
    float lanes[2 * VW];
    for (int i = 0; i < VW; i++)
        lanes[i] = crossings_u[i].x, lanes[VW + i] = crossings_u[i].y;
    tile.centre_u = LOADV(lanes), tile.shear_u = LOADV(lanes + VW);
    for (int r = 0; r < PADDED_ROWS; r++) {
        const float2 crossing = crossings_v[min(r, rows - 1)];
        tile.v.centre[r] = crossing.x, tile.v.shear[r] = crossing.y;
    }
    tile.first_u = crossings_u[0], tile.last_u = crossings_u[columns - 1];
    tile.first_v = crossings_v[0], tile.last_v = crossings_v[rows - 1];
    return tile;
}

// Voxels [u0, u1] x [v0, v1].
typedef struct {
    int u0, u1, v0, v1;
} Window;

// The voxels below a tile's rays at a plane.
inline Window window_at(const Tile *tile, float depth) {
    Window w;
    voxels_below(tile->first_u, tile->last_u, depth, &w.u0, &w.u1);
    voxels_below(tile->first_v, tile->last_v, depth, &w.v0, &w.v1);
    return w;
}

// Whether the slabs of a chunk can show anything over a window: bit q % 8. A row of blocks is read at once; more than
// eight are not looked at.
inline int slabs_visible(__global const uchar *visible, const RayLatticeParams *p, int chunk, Window w) {
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
// chunks first, then a slab of its own. `enters`: 0 or 1, a ray enters slab q at layer q-1+enters.
ALWAYS_INLINE int slabs_to_skip(__global const uchar *visible, const RayLatticeParams *p, const Tile *tile, int q,
                                int last, int enters, Chunk *chunk) {
    const float to_plane = enters - 1 - p->centre_layer;
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

// 0 where a tile's rays are beside the field's support at a plane, else 1.
inline realv inside_support(const VolumeView *view, const Tile *tile, int r, float depth) {
    const realv u = tile->centre_u + depth * tile->shear_u;
    const float v = tile->v.centre[r] + depth * tile->v.shear[r];
    const bool beside = v < -1.0f || v > view->dims_v;
    return CONVERT_REALV(COUNT_IF(u >= -1.0f && u <= (realv)(view->dims_u))) * (beside ? 0.0f : 1.0f);
}

// The sub-layers at both ends of a stretch. Samples one unless it is held.
#define HELD(l) (&held[(l) & 1])
#define COLUMNS_AT(l) (tile.centre_u + ((float)(l) / s - 1.0f - p.centre_layer) * tile.shear_u)
#define HOLD(l)                                                                                                        \
    if (HELD(l)->held != (l))                                                                                          \
    sample_layer(voxels, &view, p.centre_layer, s, l, COLUMNS_AT(l), &tile.v, tile.rows, HELD(l))

__kernel void point_lattice(__global const VOXEL *voxels, VolumeView view, __global const float2 *crossings_u,
                            __global const float2 *crossings_v, __global const uchar *visible,
                            __global const int4 *integrals, RayLatticeParams p, SampleParams sample,
                            __global float4 *lattice, __global uint *active_samples) {
    const int id = get_global_id(0);
    if (id >= p.tiles_u * p.tiles_v)
        return;
    const int column = id % p.tiles_u * VW, row = id / p.tiles_u * TILE_ROWS;
    const Tile tile = tile_of(crossings_u + column, crossings_v + row, min(TILE_ROWS, p.height - row),
                              min(VW, p.width - column));
    Layer held[2];
    held[0].held = held[1].held = INT_MIN;
    Light gathered[TILE_ROWS];
    realv dt[TILE_ROWS];
    Node ends[TILE_ROWS]; // where the last stretch ended
    int ends_at[TILE_ROWS];
    intv active = 0;
    for (int r = 0; r < tile.rows; r++) {
        const realv step_u = tile.shear_u * sample.step_u;
        const float step_v = tile.v.shear[r] * sample.step_v;
        dt[r] = sqrt(step_u * step_u + (step_v * step_v + sample.step_a * sample.step_a)) * sample.table_unit;
        gathered[r].r = gathered[r].g = gathered[r].b = 0.0f;
        gathered[r].t = 1.0f;
        ends_at[r] = INT_MIN;
    }

    const int s = sample.inner_slabs, enters = p.layer_step > 0 ? 0 : 1;
    const int lowest = p.culling ? p.first_slab : 0, highest = p.culling ? p.last_slab : view.dims_a;
    int open = (1 << tile.rows) - 1; // rows that are not opaque yet
    Chunk chunk = {-1, 0};
    for (int n = 0; n <= highest - lowest && open; n++) {
        const int q = enters ? highest - n : lowest + n;
        const int skip =
            p.culling ? slabs_to_skip(visible, &p, &tile, q, enters ? lowest : highest, enters, &chunk) : 0;
        if (skip) {
            n += skip - 1;
            continue;
        }
        for (int i = 0; i < s; i++) {
            const int l0 = enters ? (q + 1) * s - i : q * s + i, l1 = l0 + p.layer_step;
            HOLD(l0);
            HOLD(l1);
            Layer *front = HELD(l0), *behind = HELD(l1);
            const float2 weights = ends_of(&sample, l0, l1);
            int shown = 0;
            for (int r = 0; r < tile.rows; r++) {
                const realv from = front->field[r], to = behind->field[r];
                shown |= ANY(MAX(from, to) >= p.visible_from && MIN(from, to) <= p.visible_to) << r;
            }
            shown &= open;
            if (!shown)
                continue;
            // All lighting before all look-ups: shorter loops overlap better, 5 % on engine.
            if (sample.shading) {
                light_layer(voxels, &view, &sample, s, COLUMNS_AT(l0), shown, front);
                light_layer(voxels, &view, &sample, s, COLUMNS_AT(l1), shown, behind);
            }
            Stretch stretches[TILE_ROWS];
            for (int r = 0; r < tile.rows; r++) {
                if (!(shown >> r & 1))
                    continue;
                if (ends_at[r] != l0)
                    ends[r] = node_of(&sample, integrals, front->field[r], l0 & 1);
                const Node node = node_of(&sample, integrals, behind->field[r], l1 & 1);
                stretches[r] = stretch_between(&sample, integrals, &ends[r], &node, front->field[r], behind->field[r],
                                               weights, dt[r]);
                ends[r] = node;
                ends_at[r] = l1;
            }
            for (int r = 0; r < tile.rows; r++) {
                if (!(shown >> r & 1))
                    continue;
                realv inside = 1.0f;
                if (sample.background_visible)
                    inside = inside_support(&view, &tile, r, 0.5f * (l0 + l1) / s - 1.0f - p.centre_layer);
                const float k = (float)l0 / s - 1.0f, step = (float)p.layer_step / s;
                const Way way = {{COLUMNS_AT(l0), tile.v.centre[r] + (k - p.centre_layer) * tile.v.shear[r], k},
                                 {step * tile.shear_u, step * tile.v.shear[r], step}};
                composite_way(voxels, &view, &sample, integrals, &stretches[r], &way, dt[r], inside, &front->lighting[r],
                              &behind->lighting[r], &gathered[r], &active);
                if (!ANY(gathered[r].t > sample.opaque))
                    open &= ~(1 << r);
            }
        }
    }

    uint total = 0;
    for (int i = 0; i < tile.columns; i++)
        total += ((const int *)&active)[i];
    active_samples[id] = total;
    for (int r = 0; r < tile.rows; r++) {
        __global float4 *out = lattice + (size_t)(row + r) * p.width + column;
        const float *g = (const float *)&gathered[r];
        for (int i = 0; i < tile.columns; i++)
            out[i] = (float4)(g[i], g[VW + i], g[2 * VW + i], 1.0f - g[3 * VW + i]);
    }
}
