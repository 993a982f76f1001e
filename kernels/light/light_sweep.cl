// Transmittance to a light, swept through the volume in the direction in which it shines.
//
// Rays from the light form a lattice with one ray per voxel of a layer. The lattice is sheared with the light, so that a ray keeps its
// (I, J) in all layers and its shadow stays sharp at any distance (a sweep from grid cell to grid cell would blur it at every layer). In
// each layer all rays have the same position between the voxels: `offsets`, for layers -1 ... n along u, then along v. The transmittance is
// interpolated once, when it is written to the voxels of the layer.
//
// One work-item per tile of rays. A tile has one column and one row in common with its neighbours, so that each voxel between two rays
// belongs to one tile. Voxels -1 ... n are written along each axis. A sweep may visit some of the layers only, numbered from 0 in the order
// of the light: then each tile continues from its rays in `state` and leaves them there, SWEEP_ROWS rows of COLUMNS. Segments between two layers are pre-integrated, as those of views are
// (`integrals`: preintegration.cl). COARSE: voxels are transmittances (coarse_transmittance.cl), of which each layer has half a length.

#include "layered/beam.cl"
#include "shared/blend_modes.cl"
#include "shared/clipping.cl"
#include "shared/field.cl"
#include "shared/integral_nodes.cl"
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

// Whether anything can be visible to the rays of a tile between two neighbouring layers.
static inline bool is_slab_visible_between(__global const uchar *visible, const LightSweepParams *p, int first_held,
                                           const RayLayer *one, const RayLayer *other) {
    const int4 window = {min(one->first_u, other->first_u), min(one->first_v, other->first_v),
                         max(one->first_u, other->first_u) + COLUMNS, max(one->first_v, other->first_v) + SWEEP_ROWS};
    const int slab = max(one->k, other->k) - first_held;
    return slabs_in_window(visible, p->blocks_u, p->blocks_v, slab >> 3, window) >> (slab & 7) & 1;
}

static inline bool is_beside_volume(const LightSweepParams *p, const RayLayer *layer) {
    return layer->first_u > p->dims_u || layer->first_u + COLUMNS < -1 || layer->first_v > p->dims_v ||
           layer->first_v + SWEEP_ROWS < -1;
}

#if BLEND == COMPOSITE && !defined(COARSE)
// A sample in the table of integrals: its node, the integral of the extinction up to there, and its distance from the table, in nodes.
typedef struct {
    intv node, integral;
    realv outside;
} RaySample;

static inline RaySample ray_sample(const SampleParams *p, __global const int4 *integrals, realv value, int odd) {
    RaySample s;
    s.node = node_index(p, value, odd);
    const realv place = (value - p->classification.table_first) * p->classification.table_per_value;
    s.outside = place - CLAMP(place, (realv)(0.0f), (realv)(p->classification.table_last));
    s.integral = 0;
    // Values below all visible ones need no look-up.
    if (ANY(value >= p->classification.shown_from)) {
        const intv at = s.node * 4 + 3;
        s.integral = GATHER_AS(intv, (__global const int *)NODES(integrals), at);
    }
    return s;
}

// Difference of the integrals between two samples. Outside the table its first and last extinction apply.
static inline realv extinction_between(const SampleParams *p, __global const int4 *integrals, const RaySample *from, const RaySample *to) {
    __global const int4 *at_nodes = NODES(integrals) + p->classification.table_last + 1;
    const float first = as_float(at_nodes[0].w), last = as_float(at_nodes[p->classification.table_last].w);
    const realv above = MAX(to->outside, (realv)(0.0f)) - MAX(from->outside, (realv)(0.0f));
    const realv below = MIN(to->outside, (realv)(0.0f)) - MIN(from->outside, (realv)(0.0f));
    return CONVERT_REALV(to->integral - from->integral) + (last * above + first * below);
}
#endif

#ifdef COARSE
// The transmittance of a multiple of a length, from that of the length.
static inline realv to_power(const SampleParams *p, realv transmittance, float exponent) {
    const realv scaled =
        p->classification.linear ? 1.0f - (1.0f - transmittance) * exponent : general_power(transmittance, (realv)(exponent));
    return transmittance < 1.0f ? scaled : (realv)(1.0f);
}

// Transmittance of two halves of a layer. With linear extinction opacities add up.
static inline realv of_two_halves(const SampleParams *p, realv one, realv other) {
    return p->classification.linear ? MAX(one + other - 1.0f, (realv)(0.0f)) : one * other;
}
#endif

// Transmittance of an optical depth, or of alpha times length.
static inline realv transmitted(const SampleParams *p, realv depth) { return 1.0f - opacity_of_depth(p, depth); }

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
            (size_t)(layer->k - p->first_stored) * p->stride_a + (size_t)(j + r + 1) * p->stride_v + (size_t)(i + 1) * p->stride_u;
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

// With a limited reach, light comes back with the distance from what absorbed it: half of a step before, half behind its absorption.
static inline void recover(float (*rays)[PADDED_COLUMNS], float recovered) {
    for (int r = 0; recovered < 1.0f && r < SWEEP_ROWS; r++)
        for (int c = 0; c < COLUMNS; c += VW)
            STOREV(rays[r] + c, 1.0f - recovered * (1.0f - LOADV(rays[r] + c)));
}

__kernel void light_sweep(__global const VOXEL *voxels, VolumeView view, __global const GRADIENT_VOXEL *gradient_voxels,
                          VolumeView gradient_view, __global const uchar *visible, __global const int4 *integrals,
                          __global const LayerOffset *offsets, LightSweepParams p, SampleParams sample, Clipping clip,
                          __global uchar *light, __global ushort *sums, __global float *state, ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= p.tiles_u * p.tiles_v)
        return;
    voxels += view.first;
    state += (size_t)id * (SWEEP_ROWS * COLUMNS);
    const int column = id % p.tiles_u * (COLUMNS - 1), row = id / p.tiles_u * (SWEEP_ROWS - 1);
    // Transmittance of the rays, and their samples in the layer before: table nodes and their integrals, transmittances of half a layer
    // (COARSE), or values (ISO).
    float rays[SWEEP_ROWS][PADDED_COLUMNS];
    for (int r = 0; r < SWEEP_ROWS; r++)
        for (int c = 0; c < PADDED_COLUMNS; c += VW)
            STOREV(rays[r] + c, (realv)(1.0f));
#if BLEND == COMPOSITE && !defined(COARSE)
    RaySample before[SWEEP_ROWS][SWEEP_VECTORS];
#else
    float before[SWEEP_ROWS][COLUMNS];
#endif
#ifdef THINNED
    float scales_before[SWEEP_ROWS][COLUMNS];
    __global const uchar *sky = 0;
    const ShadingSource gradients = SHADING_SOURCE;
#endif
    bool lit = true;          // no ray of the tile is dimmed
    for (int r = 0; p.continues && r < SWEEP_ROWS; r++) {
        for (int c = 0; c < COLUMNS; c += VW) {
            const realv ray = CAT(vload, VW)(0, state + r * COLUMNS + c);
            lit = lit && !ANY(ray != 1.0f);
            STOREV(rays[r] + c, ray);
        }
    }
    int sampled_last = -2;    // number of the layer that the samples before belong to
    for (int n = max(p.from - 1, 0); n < p.to; n++) {
        // The layer before the first one has the samples at which the first segment begins.
        const bool begins = n < p.from;
        const int k = p.layer_step > 0 ? n - 1 : p.layers - n;
        const RayLayer layer = ray_layer(&p, offsets, column, row, k);
        if (is_beside_volume(&p, &layer))
            continue;
        if (!lit && !begins)
            recover(rays, p.recovered);
        bool crossed = n > 0 && !begins, crosses_next = n < p.to - 1;
        if (p.culling && crossed) {
            const RayLayer last = ray_layer(&p, offsets, column, row, k - p.layer_step);
            crossed = is_slab_visible_between(visible, &p, view.first_a, &last, &layer);
        }
        if (p.culling && crosses_next) {
            const RayLayer next = ray_layer(&p, offsets, column, row, k + p.layer_step);
            crosses_next = is_slab_visible_between(visible, &p, view.first_a, &layer, &next);
        }
        if (crossed || crosses_next) {
            const int odd = n & 1;
            if (sampled_last != n - 1) {
                // The layer before lies beside the volume, or nothing is visible between the two.
                for (int r = 0; r < SWEEP_ROWS; r++) {
                    for (int c = 0; c < COLUMNS; c += VW) {
#if BLEND == ISO
                        STOREV(before[r] + c, (realv)(view.background));
#elif defined(COARSE)
                        STOREV(before[r] + c, (realv)(1.0f));
#else
                        before[r][c / VW] = ray_sample(&sample, integrals, (realv)(view.background), !odd);
#endif
#ifdef THINNED
                        STOREV(scales_before[r] + c, (realv)(1.0f));
#endif
                    }
                }
            }
            sampled_last = n;
            float rows[2][PADDED_COLUMNS];
            load_row(voxels, &view, layer.first_u, layer.first_v, layer.k, SWEEP_VECTORS + 1, rows[0]);
            const Weights across_rows = value_weights((realv)(layer.between_v));
            const Weights across_columns = value_weights((realv)(layer.between_u));
            for (int r = 0; r < SWEEP_ROWS; r++) {
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
#if BLEND == ISO
                    const float iso = sample.classification.iso;
                    const realv last = LOADV(before[r] + c) - iso, own = value - iso;
                    STOREV(before[r] + c, value);
                    intv blocks = (last < 0.0f) != (own < 0.0f);
#ifdef CLIPPED
                    const realv surface = depth - own / (blocks ? own - last : (realv)(1.0f));
                    blocks &= surface >= hit.from && surface <= hit.to;
#endif
                    if (!crossed || !ANY(blocks))
                        continue;
                    const realv through = blocks ? (realv)(0.0f) : (realv)(1.0f);
#elif defined(COARSE)
                    const realv own = to_power(&sample, value, p.half_layer), last = LOADV(before[r] + c);
                    STOREV(before[r] + c, own);
                    if (!crossed || !ANY(own < 1.0f || last < 1.0f))
                        continue;
                    const realv through = of_two_halves(&sample, last, own);
#else
                    const RaySample own = ray_sample(&sample, integrals, value, odd), last = before[r][c / VW];
                    before[r][c / VW] = own;
                    const realv extinction = extinction_between(&sample, integrals, &last, &own);
                    const intv absorbs = extinction != 0.0f;
#ifdef THINNED
                    const realv last_scale = LOADV(scales_before[r] + c);
                    realv scale = 1.0f;
                    const intv shown = value >= sample.classification.shown_from && value <= sample.classification.shown_to;
                    if (sample.light.thinned && ANY(absorbs || shown)) {
                        const Gradient gradient = gradient_at(&gradients, &sample.field, u, v, (realv)(layer.k), absorbs || shown);
                        scale = gradient_extinction_scale(&sample, gradient_length(&sample, gradient));
                    }
                    STOREV(scales_before[r] + c, scale);
#endif
                    if (!crossed || !ANY(absorbs))
                        continue;
                    // Nodes of neighbouring layers are even and odd: never equal.
                    const realv mean = extinction * reciprocal(CONVERT_REALV(own.node - last.node) + (own.outside - last.outside));
                    realv length = (realv)(p.layer_length);
#ifdef CLIPPED
                    const Part part = part_of(&hit, (realv)(depth - 1.0f), (realv)(depth));
                    length *= part_length(&part);
#endif
#ifdef THINNED
                    length *= 0.5f * (scale + last_scale);
#endif
                    const realv through = transmitted(&sample, mean * length);
#endif
                    lit = false;
                    STOREV(rays[r] + c, LOADV(rays[r] + c) * through);
                }
            }
        }
        if (begins)
            continue;
        if (!lit)
            recover(rays, p.recovered);
        store_layer(&p, &layer, rays, lit, light, sums);
    }
    for (int r = 0; p.to < p.layers + 2 && r < SWEEP_ROWS; r++)
        for (int c = 0; c < COLUMNS; c += VW)
            CAT(vstore, VW)(LOADV(rays[r] + c), 0, state + r * COLUMNS + c);
}
