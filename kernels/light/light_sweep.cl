// Transmittance to a light, swept through the volume in the direction in which it shines.
//
// Rays from the light form a lattice with one ray per voxel of a layer. The lattice is sheared with the light, so that a ray keeps its
// (I, J) in all layers and its shadow stays sharp at any distance (a sweep from grid cell to grid cell would blur it at every layer). In
// each layer all rays have the same position between the voxels: `offsets`, for layers -1 ... n along u, then along v. The transmittance is
// interpolated once, when it is written to the voxels of the layer.
//
// One work-item per tile of rays. A tile has one column and one row in common with its neighbours, so that each voxel between two rays
// belongs to one tile. Voxels -1 ... n are written along each axis. `transmittance`: of half a layer, per table entry. COARSE: voxels are
// transmittances themselves (coarse_transmittance.cl).

#include "layered/beam.cl"
#include "shared/blend_modes.cl"
#include "shared/clipping.cl"
#include "shared/field.cl"
#include "shared/shading.cl"

#ifndef SWEEP_VECTORS
#error "SWEEP_VECTORS: vectors per row of rays"
#endif
#ifndef SWEEP_ROWS
#error "SWEEP_ROWS: rows of rays per tile"
#endif

// Values of LightSweepParams.sum.
#define STORE 1
#define ADD 2

// Rays per row of a tile.
#define COLUMNS (SWEEP_VECTORS * VW)
// With room for unaligned vectors that begin at the last column.
#define PADDED_COLUMNS (COLUMNS + VW)

// Rays of a tile in one layer.
typedef struct {
    int k;
    int first_u, first_v;        // voxel below the first ray
    float between_u, between_v;  // distance of the rays from it
} RayLayer;

static inline RayLayer ray_layer(const LightSweepParams *p, __global const LayerOffset *offsets, int column, int row, int k) {
    const LayerOffset u = offsets[k + 1], v = offsets[p->layers + 2 + k + 1];
    const RayLayer layer = {k, column + u.base, row + v.base, u.fraction, v.fraction};
    return layer;
}

// Slabs before and behind layer k, bits 0 and 1, in which anything can be visible to the rays of a tile.
static inline int visible_slabs(__global const uchar *visible, const LightSweepParams *p, const RayLayer *layer) {
    const int4 window = {layer->first_u, layer->first_v, layer->first_u + COLUMNS, layer->first_v + SWEEP_ROWS};
    const int before = layer->k, behind = layer->k + 1;
    const int in_before = slabs_in_window(visible, p->blocks_u, p->blocks_v, max(before, 0) >> 3, window) >> (max(before, 0) & 7) & 1;
    const int last = min(behind, p->layers);
    const int in_behind = slabs_in_window(visible, p->blocks_u, p->blocks_v, last >> 3, window) >> (last & 7) & 1;
    return in_before | in_behind << 1;
}

#if BLEND == COMPOSITE
// The transmittance of a multiple of a length, from that of the length.
static inline realv to_power(const SampleParams *p, realv transmittance, realv exponent) {
    const realv scaled =
        p->classification.linear ? 1.0f - (1.0f - transmittance) * exponent : general_power(transmittance, exponent);
    return exponent == 1.0f ? transmittance : scaled;
}

// Transmittance of a whole layer, from that of its half: with linear extinction opacities add up.
static inline realv of_two_halves(const SampleParams *p, realv one, realv other) {
    return p->classification.linear ? MAX(one + other - 1.0f, (realv)(0.0f)) : one * other;
}
#endif

// Voxels -1 ... n of layer k that lie between the rays of a tile: interpolates the transmittance of the rays around them.
static inline void store_layer(const LightSweepParams *p, const RayLayer *layer, const float (*rays)[PADDED_COLUMNS], bool lit,
                               __global uchar *light, __global ushort *sums) {
    light += (size_t)p->volume * p->volume_bytes;
    const int i = layer->first_u + 1, j = layer->first_v + 1;
    const int from_row = max(0, -1 - j), to_row = min(SWEEP_ROWS - 1, p->dims_v + 1 - j);
    const int from = max(0, -1 - i), to = min(COLUMNS - 1, p->dims_u + 1 - i);
    const realv before_u = layer->between_u, before_v = layer->between_v;
    for (int r = from_row; r < to_row; r++) {
        const size_t first =
            (size_t)(layer->k + 1) * p->stride_a + (size_t)(j + r + 1) * p->stride_v + (size_t)(i + 1) * p->stride_u;
        for (int c = from; c < to; c += VW) {
            realv level = 1.0f;
            if (!lit) {
                const realv one = LOADV(rays[r] + c), to_one = LOADV(rays[r] + c + 1);
                const realv other = LOADV(rays[r + 1] + c), to_other = LOADV(rays[r + 1] + c + 1);
                const realv near = to_one + before_u * (one - to_one), far = to_other + before_u * (other - to_other);
                level = far + before_v * (near - far);
            }
            // Interpolation rounds.
            level = CLAMP(level * p->gain, (realv)(0.0f), (realv)(1.0f));
            const int count = min(VW, to - c);
            const intv steps = CONVERT_INTV(level * p->steps + 0.5f);
            const size_t at = first + (size_t)c * p->stride_u;
#if VW > 1
            if (count == VW && p->stride_u == 1) {
                if (p->sum == ADD)
                    CAT(vstore, VW)(CAT(vload, VW)(0, sums + at) + CAT(convert_ushort, VW)(steps), 0, sums + at);
                else if (p->sum == STORE)
                    CAT(vstore, VW)(CAT(convert_ushort, VW)(steps), 0, sums + at);
                else
                    CAT(vstore, VW)(CAT(convert_uchar, VW)(steps), 0, light + at);
                continue;
            }
#endif
            const int *step = (const int *)&steps;
            for (int n = 0; n < count; n++) {
                const size_t voxel = at + (size_t)n * p->stride_u;
                if (p->sum == ADD)
                    sums[voxel] += step[n];
                else if (p->sum == STORE)
                    sums[voxel] = step[n];
                else
                    light[voxel] = step[n];
            }
        }
    }
}

// Copies the transmittance of all rays.
static inline void copy_rays(const float (*from)[COLUMNS], float (*to)[PADDED_COLUMNS]) {
    for (int r = 0; r < SWEEP_ROWS; r++)
        for (int c = 0; c < COLUMNS; c += VW)
            STOREV(to[r] + c, LOADV(from[r] + c));
}

__kernel void light_sweep(__global const VOXEL *voxels, VolumeView view, __global const GRADIENT_VOXEL *gradient_voxels,
                          VolumeView gradient_view, __global const uchar *visible, __global const float *transmittance,
                          __global const LayerOffset *offsets, LightSweepParams p, SampleParams sample, Clipping clip,
                          __global uchar *light, __global ushort *sums) {
    const int id = get_global_id(0);
    if (id >= p.tiles_u * p.tiles_v)
        return;
    voxels += view.first;
    const int column = id % p.tiles_u * (COLUMNS - 1), row = id / p.tiles_u * (SWEEP_ROWS - 1);
    // Transmittance of the rays: behind the layers that they have crossed, and in the plane of the layer.
    float behind[SWEEP_ROWS][COLUMNS], in_plane[SWEEP_ROWS][PADDED_COLUMNS];
    for (int r = 0; r < SWEEP_ROWS; r++) {
        for (int c = 0; c < COLUMNS; c += VW)
            STOREV(behind[r] + c, (realv)(1.0f));
        for (int c = 0; c < PADDED_COLUMNS; c += VW)
            STOREV(in_plane[r] + c, (realv)(1.0f));
    }
#if BLEND == ISO
    float values_before[SWEEP_ROWS][COLUMNS];
    for (int r = 0; r < SWEEP_ROWS; r++)
        for (int c = 0; c < COLUMNS; c += VW)
            STOREV(values_before[r] + c, (realv)(view.background));
#endif
#ifdef THINNED
    __global const uchar *sky = 0;
    const ShadingSource gradients = SHADING_SOURCE;
#endif
    bool lit = true; // no ray of the tile is dimmed
    for (int n = 0; n < p.layers + 2; n++) {
        const RayLayer layer = ray_layer(&p, offsets, column, row, p.layer_step > 0 ? n - 1 : p.layers - n);
        if (layer.first_u > p.dims_u || layer.first_u + COLUMNS < -1 || layer.first_v > p.dims_v || layer.first_v + SWEEP_ROWS < -1)
            continue;
        const int slabs = p.culling ? visible_slabs(visible, &p, &layer) : 3;
#if BLEND == ISO
        // Whether a surface can be in the slab that rays have crossed to this layer.
        const bool crossed = n > 0 && slabs & (p.layer_step > 0 ? 1 : 2);
        const bool sampled = slabs != 0;
#else
        // The plane of the layer belongs to both slabs.
        const bool sampled = slabs == 3;
#endif
        float rows[2][PADDED_COLUMNS];
        if (sampled)
            load_row(voxels, &view, layer.first_u, layer.first_v, layer.k, SWEEP_VECTORS + 1, rows[0]);
        const Weights across_rows = value_weights((realv)(layer.between_v)), across_columns = value_weights((realv)(layer.between_u));
        for (int r = 0; sampled && r < SWEEP_ROWS; r++) {
            float *low = rows[r & 1], *high = rows[~r & 1];
            load_row(voxels, &view, layer.first_u, layer.first_v + r + 1, layer.k, SWEEP_VECTORS + 1, high);
            for (int c = 0; c < PADDED_COLUMNS; c += VW)
                STOREV(low + c, LOADV(low + c) + across_rows.tap[2] * (LOADV(high + c) - LOADV(low + c)));
            for (int c = 0; c < COLUMNS; c += VW) {
                const realv left = LOADV(low + c), value = left + across_columns.tap[2] * (LOADV(low + c + 1) - left);
#if defined(CLIPPED) || defined(THINNED)
                const realv u = CONVERT_REALV(LANES + layer.first_u + c) + layer.between_u;
                const realv v = (realv)(layer.first_v + r + layer.between_v);
#endif
#ifdef CLIPPED
                // Depths: layers from that of the centre, in the direction of the light.
                const float depth = p.layer_step * (layer.k - p.centre_layer);
                const realv origin[3] = {u - depth * p.along_u, v - depth * p.along_v, (realv)(p.centre_layer)};
                const realv direction[3] = {(realv)(p.along_u), (realv)(p.along_v), (realv)(p.layer_step)};
                const Interval hit = clip_rays(&clip, origin, direction, -INFINITY);
#endif
                const realv arriving = LOADV(behind[r] + c);
#if BLEND == ISO
                const realv before = LOADV(values_before[r] + c) - sample.classification.iso, own = value - sample.classification.iso;
                STOREV(values_before[r] + c, value);
                intv blocks = (before < 0.0f) != (own < 0.0f);
#ifdef CLIPPED
                const realv surface = depth - own / (blocks ? own - before : (realv)(1.0f));
                blocks &= surface >= hit.from && surface <= hit.to;
#endif
                if (!crossed || !ANY(blocks))
                    continue;
                lit = false;
                STOREV(behind[r] + c, blocks ? (realv)(0.0f) : arriving);
#else
#ifdef COARSE
                const intv absorbs = value < 1.0f;
#else
                const intv index = table_index(&sample, value);
                const intv absorbs = index >= sample.classification.first_visible && index <= sample.classification.last_visible;
#endif
                if (!ANY(absorbs)) {
                    STOREV(in_plane[r] + c, arriving);
                    continue;
                }
                lit = false;
#ifdef COARSE
                realv half_layer = to_power(&sample, value, (realv)(p.half_layer));
#else
                realv half_layer = GATHER(transmittance, index);
#endif
#ifdef THINNED
                if (sample.light.thinned) {
                    const Gradient gradient = gradient_at(&gradients, &sample.field, u, v, (realv)(layer.k), absorbs);
                    const realv scale = gradient_extinction_scale(&sample, gradient_length(&sample, gradient));
                    half_layer = to_power(&sample, half_layer, scale);
                }
#endif
                realv arrives = half_layer, leaves = half_layer;
#ifdef CLIPPED
                const Part front = part_of(&hit, (realv)(depth - 0.5f), (realv)(depth));
                const Part back = part_of(&hit, (realv)(depth), (realv)(depth + 0.5f));
                arrives = to_power(&sample, half_layer, part_length(&front));
                leaves = to_power(&sample, half_layer, part_length(&back));
#endif
                STOREV(in_plane[r] + c, arriving * arrives);
                STOREV(behind[r] + c, arriving * of_two_halves(&sample, arrives, leaves));
#endif
            }
        }
#if BLEND == COMPOSITE
        // Otherwise the rays in the plane are known.
        if (!sampled && !lit)
            copy_rays(behind, in_plane);
#else
        if (!lit)
            copy_rays(behind, in_plane);
#endif
        store_layer(&p, &layer, in_plane, lit, light, sums);
        // With a limited reach, light comes back with the distance from what absorbed it.
        for (int r = 0; p.recovered < 1.0f && !lit && r < SWEEP_ROWS; r++)
            for (int c = 0; c < COLUMNS; c += VW)
                STOREV(behind[r] + c, 1.0f - p.recovered * (1.0f - LOADV(behind[r] + c)));
    }
}
