// Layered rendering with point-sampled layers, on the lattice of any view.
//
// A layer is sampled where the rays cross it: P = sum of voxels x f(u) f(v), the reconstructed field itself, since of all
// kernels only the layer's own reach its plane. Between two layers the classification is pre-integrated. Further
// samples between the layers mix the two with f (paper, Eq. 1).
// Both factors are small: per voxel row the u factor is applied to all columns of a tile at once (a resampled row), and
// per lattice row the v factor mixes two of these. One work-item per tile of VW x TILE_ROWS samples, id =
// tile_v*tiles_u + tile_u. Sub-layer l = 0 ... (n+1) S, S samples per layer, lies at k = l/S - 1.
// lattice[J*width + I] = RGBA; crossings_u is padded to whole tiles.

#ifndef TILE_ROWS
#define TILE_ROWS 8 // samples along v
#endif
// Voxels between neighbouring samples, at most; the plan sees to it.
#define VOXELS_PER_SAMPLE 2
// Voxel rows and columns under a tile: the window of a sample is -1 ... 2 for central differences.
#define ROWS (VOXELS_PER_SAMPLE * TILE_ROWS + 4)
#define SEGMENT_VECTORS ((VOXELS_PER_SAMPLE * VW + 4 + VW - 1) / VW)
// Sub-layers held at a time: a power of two, at least 2 S + 2 for central differences along the axis.
#define RING 8

// Where a tile's rows cross the middle layer, padded to whole vectors.
#define PADDED_ROWS ((TILE_ROWS + VW - 1) / VW * VW)
typedef struct {
    float centre[PADDED_ROWS], shear[PADDED_ROWS];
} TileRows;

// One sub-layer under a tile.
typedef struct {
    int held;                           // which one
    realv field[TILE_ROWS];             // at the samples
    int row[PADDED_ROWS] __attribute__((aligned(64))); // of `value`: the voxel row below the samples
    float rise[PADDED_ROWS];            // weight of the next
    realv value[ROWS], difference[ROWS]; // resampled voxel rows, and twice their central differences along u
} Layer;

// First and last voxel below the rays between two crossings.
inline void voxels_below(float2 one, float2 other, float depth, int *lo, int *hi) {
    const float a = one.x + depth * one.y, b = other.x + depth * other.y;
    *lo = whole_below(MIN(a, b));
    *hi = whole_below(MAX(a, b));
}

// How voxel rows are resampled for a tile's columns.
typedef struct {
    intv offset;  // of the voxel below each column, in the segment
    realv rise;   // weight of the next voxel
    int vectors;  // of the segment
    int shading;
} Columns;

ALWAYS_INLINE void resample_row(const float *segment, const Columns *c, realv *value, realv *difference) {
    const realv v0 = PICK(segment, c->vectors, c->offset), v1 = PICK(segment, c->vectors, c->offset + 1);
    *value = v0 + c->rise * (v1 - v0);
    if (c->shading) {
        const realv lo = v1 - PICK(segment, c->vectors, c->offset - 1), hi = PICK(segment, c->vectors, c->offset + 2) - v0;
        *difference = lo + c->rise * (hi - lo);
    }
}

// Samples sub-layer l. `u`: the columns, `tile_v`: the rows of the tile.
inline void sample_layer(__global const VOXEL *voxels, const VolumeView *view, const RayLatticeParams *p,
                         int samples_per_layer, int l, realv u, const TileRows *tile_v, int rows, int shading,
                         Layer *layer) {
    layer->held = l;
    const int k = (l + samples_per_layer) / samples_per_layer - 2;
    const int between = l - (k + 1) * samples_per_layer;
    const float depth = k + (float)between / samples_per_layer - p->centre_layer;
    int first_row, last_row;
    voxels_below((float2)(tile_v->centre[0], tile_v->shear[0]),
                 (float2)(tile_v->centre[rows - 1], tile_v->shear[rows - 1]), depth, &first_row, &last_row);
    first_row -= 1, last_row += 2;
    for (int r = 0; r < TILE_ROWS; r += VW) {
        const realv v = LOADV(tile_v->centre + r) + depth * LOADV(tile_v->shear + r);
        const intv below = wholes_below(v);
        *(intv *)(layer->row + r) = below - first_row;
        STOREV(layer->rise + r, RISE(v - CONVERT_REALV(below)));
    }
    const intv below = wholes_below(u);
    const realv rise = RISE(u - CONVERT_REALV(below));
    const int *ends = (const int *)&below;
    const int first = min(ends[0], ends[VW - 1]) - 1, span = max(ends[0], ends[VW - 1]) + 3 - first;
    const intv offset = below - first;
    const int vectors = (span + VW - 1) / VW;
    const Columns columns = {offset, rise, vectors, shading};
    const float next = RISE((float)between / samples_per_layer);
    const bool inside = !between && k >= 0 && k < view->dims_a && first >= 0 && first + vectors * VW <= view->dims_u;
    __global const VOXEL *start = voxels + k * view->stride_a + first;
    for (int j = first_row; j <= last_row; j++) {
        float segment[SEGMENT_VECTORS * VW];
        if (inside && j >= 0 && j < view->dims_v) {
            for (int c = 0; c < vectors; c++)
                STOREV(segment + c * VW, LOAD_VOXELS(start + j * view->stride_v + c * VW) - view->offset);
        } else {
            load_row(voxels, view, first, j, k, vectors, segment);
        }
        if (between) {
            float after[SEGMENT_VECTORS * VW];
            load_row(voxels, view, first, j, k + 1, vectors, after);
            for (int c = 0; c < vectors * VW; c += VW)
                STOREV(segment + c, LOADV(segment + c) + next * (LOADV(after + c) - LOADV(segment + c)));
        }
        resample_row(segment, &columns, layer->value + (j - first_row), layer->difference + (j - first_row));
    }
    for (int r = 0; r < rows; r++) {
        const realv *value = layer->value + layer->row[r];
        layer->field[r] = value[0] + layer->rise[r] * (value[1] - value[0]);
    }
}

// Twice the central differences in a sub-layer.
inline void layer_differences(const Layer *layer, int r, realv *u, realv *v) {
    const realv *value = layer->value + layer->row[r], *difference = layer->difference + layer->row[r];
    const float rise = layer->rise[r];
    *u += difference[0] + rise * (difference[1] - difference[0]);
    const realv lo = value[1] - value[-1], hi = value[2] - value[0];
    *v += lo + rise * (hi - lo);
}

// Whether the slabs of a chunk can show anything over voxels [u0, u1] x [v0, v1]: bit q % 8. A row of blocks is read
// at once; more than eight are not looked at.
inline int slabs_visible(__global const uchar *visible, const RayLatticeParams *p, int chunk, int u0, int u1, int v0,
                         int v1) {
    const int b0 = clamp(block_of(u0, BLOCK), 0, p->blocks_u - 1), b1 = clamp(block_of(u1, BLOCK), 0, p->blocks_u - 1);
    const int c0 = clamp(block_of(v0, POINT_BLOCK_ROWS), 0, p->blocks_v - 1);
    const int c1 = clamp(block_of(v1, POINT_BLOCK_ROWS), 0, p->blocks_v - 1);
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

// Samples a sub-layer of the kernel below unless the ring holds it.
#define HOLD(l)                                                                                                        \
    if (ring[(l) & (RING - 1)].held != (l))                                                                            \
    sample_layer(voxels, &view, &p, s, l, centre_u + ((float)(l) / s - 1.0f - p.centre_layer) * shear_u, &tile_v,      \
                 rows, sample.shading, &ring[(l) & (RING - 1)])

__kernel void point_lattice(__global const VOXEL *voxels, VolumeView view, __global const float2 *crossings_u,
                            __global const float2 *crossings_v, __global const uchar *visible,
                            __global const int4 *integrals, RayLatticeParams p, SampleParams sample,
                            __global float4 *lattice, __global uint *active_samples) {
    const int tile = get_global_id(0);
    if (tile >= p.tiles_u * p.tiles_v)
        return;
    const int column = tile % p.tiles_u * VW, row = tile / p.tiles_u * TILE_ROWS;
    const int rows = min(TILE_ROWS, p.height - row), columns = min(VW, p.width - column);
    crossings_u += column, crossings_v += row;
    float lanes[2 * VW];
    for (int i = 0; i < VW; i++)
        lanes[i] = crossings_u[i].x, lanes[VW + i] = crossings_u[i].y;
    const realv centre_u = LOADV(lanes), shear_u = LOADV(lanes + VW);
    const float2 first_u = crossings_u[0], last_u = crossings_u[columns - 1];
    const float2 first_v = crossings_v[0], last_v = crossings_v[rows - 1];

    TileRows tile_v;
    for (int r = 0; r < PADDED_ROWS; r++) {
        const float2 crossing = crossings_v[min(r, rows - 1)];
        tile_v.centre[r] = crossing.x, tile_v.shear[r] = crossing.y;
    }

    Layer ring[RING];
    for (int i = 0; i < RING; i++)
        ring[i].held = INT_MIN;
    Light gathered[TILE_ROWS];
    Lighting lighting[TILE_ROWS];
    realv dt[TILE_ROWS];
    Node ends[TILE_ROWS]; // where the last stretch ended
    int ends_at[TILE_ROWS];
    intv active = 0;
    for (int r = 0; r < rows; r++) {
        const realv step_u = shear_u * sample.step_u;
        const float step_v = crossings_v[r].y * sample.step_v;
        dt[r] = sqrt(step_u * step_u + (step_v * step_v + sample.step_a * sample.step_a)) * sample.table_unit;
        gathered[r].r = gathered[r].g = gathered[r].b = 0.0f;
        gathered[r].t = 1.0f;
        ends_at[r] = INT_MIN;
    }
    const int s = sample.inner_slabs, slabs = view.dims_a + 1;
    const int back = p.layer_step > 0 ? 0 : 1; // a ray enters slab q at layer q-1+back
    int open = (1 << rows) - 1;                // rows that are not opaque yet
    int chunk = -1, chunk_bits = 0;
    const int first = p.culling ? p.first_slab : 0, last = p.culling ? p.last_slab : slabs - 1;
    for (int n = 0; n <= last - first && open; n++) {
        const int q = back ? last - n : first + n;
        if (p.culling) {
            int u0, u1, v0, v1;
            if (q >> 3 != chunk) {
                chunk = q >> 3;
                const int other = back ? max(q & ~7, first) : min(q | 7, last);
                int u2, u3, v2, v3;
                voxels_below(first_u, last_u, q - 1 + back - p.centre_layer, &u0, &u1);
                voxels_below(first_u, last_u, other - 1 + back - p.centre_layer, &u2, &u3);
                voxels_below(first_v, last_v, q - 1 + back - p.centre_layer, &v0, &v1);
                voxels_below(first_v, last_v, other - 1 + back - p.centre_layer, &v2, &v3);
                chunk_bits = slabs_visible(visible, &p, chunk, min(u0, u2), max(u1, u3), min(v0, v2), max(v1, v3));
                if (!chunk_bits) {
                    n += back ? q - other : other - q;
                    continue;
                }
            }
            if (!(chunk_bits >> (q & 7) & 1))
                continue;
            voxels_below(first_u, last_u, q - 1 + back - p.centre_layer, &u0, &u1);
            voxels_below(first_v, last_v, q - 1 + back - p.centre_layer, &v0, &v1);
            if (!(slabs_visible(visible, &p, chunk, u0, u1, v0, v1) >> (q & 7) & 1))
                continue;
        }
        for (int i = 0; i < s; i++) {
            const int l0 = back ? (q + 1) * s - i : q * s + i, l1 = l0 + p.layer_step;
            for (int l = min(l0, l1); l <= max(l0, l1); l++)
                HOLD(l);
            const Layer *front = &ring[l0 & (RING - 1)], *behind = &ring[l1 & (RING - 1)];
            int shown = 0;
            for (int r = 0; r < rows; r++) {
                const realv from = front->field[r], to = behind->field[r];
                shown |= ANY(MAX(from, to) >= p.visible_from && MIN(from, to) <= p.visible_to) << r;
            }
            shown &= open;
            if (!shown)
                continue;
            if (sample.shading) {
                const int lo = min(l0, l1), hi = max(l0, l1);
                HOLD(lo - s);
                HOLD(hi - s);
                HOLD(lo + s);
                HOLD(hi + s);
                const Layer *before_lo = &ring[(lo - s) & (RING - 1)], *before_hi = &ring[(hi - s) & (RING - 1)];
                const Layer *after_lo = &ring[(lo + s) & (RING - 1)], *after_hi = &ring[(hi + s) & (RING - 1)];
                for (int r = 0; r < rows; r++) {
                    if (!(shown >> r & 1))
                        continue;
                    realv u = 0.0f, v = 0.0f;
                    layer_differences(front, r, &u, &v);
                    layer_differences(behind, r, &u, &v);
                    u *= 0.25f, v *= 0.25f;
                    const realv a = 0.25f * (after_lo->field[r] + after_hi->field[r] - before_lo->field[r] - before_hi->field[r]);
                    lighting[r] = light_gradient(&sample, u, v, a - shear_u * u - crossings_v[r].y * v);
                }
            }
            for (int r = 0; r < rows; r++) {
                if (!(shown >> r & 1))
                    continue;
                realv inside = 1.0f;
                if (sample.background_visible) {
                    const float depth = 0.5f * (l0 + l1) / s - 1.0f - p.centre_layer;
                    const realv u = centre_u + depth * shear_u;
                    const float v = crossings_v[r].x + depth * crossings_v[r].y;
                    const bool beside = v < -1.0f || v > view.dims_v;
                    inside = CONVERT_REALV(COUNT_IF(u >= -1.0f && u <= (realv)(view.dims_u))) * (beside ? 0.0f : 1.0f);
                }
                if (ends_at[r] != l0)
                    ends[r] = node_of(&sample, integrals, front->field[r], l0 & 1);
                const Node node = node_of(&sample, integrals, behind->field[r], l1 & 1);
                composite_stretch(&sample, &ends[r], &node, dt[r], inside, &lighting[r], &gathered[r], &active);
                ends[r] = node;
                ends_at[r] = l1;
                if (!ANY(gathered[r].t > sample.opaque))
                    open &= ~(1 << r);
            }
        }
    }

    uint total = 0;
    for (int i = 0; i < columns; i++)
        total += ((const int *)&active)[i];
    active_samples[tile] = total;
    for (int r = 0; r < rows; r++) {
        __global float4 *out = lattice + (size_t)(row + r) * p.width + column;
        const float *g = (const float *)&gathered[r];
        for (int i = 0; i < columns; i++)
            out[i] = (float4)(g[i], g[VW + i], g[2 * VW + i], 1.0f - g[3 * VW + i]);
    }
}
