// Transmittance to a light, swept through the volume in the direction in which it shines.
//
// Rays from the light form a lattice with one ray per voxel of a layer. The lattice is sheared with the light, so that a ray keeps its
// (I, J) in all layers and its shadow stays sharp at any distance (a sweep from grid cell to grid cell would blur it at every layer). In
// each layer all rays have the same position between the voxels: `offsets`, for layers -1 ... n along u, then along v. The transmittance is
// interpolated once, when it is written to the voxels of the layer.
//
// The extinctions of all fields of a scene add. One work-item per tile of rays. A tile has three columns and rows in common with its
// neighbours (COMMON_RAYS), so that each voxel belongs to one tile. Voxels -1 ... n are written along each axis. A sweep may visit some of
// the layers only, numbered from 0 in the order of the light: then each tile continues from its rays in `state` and leaves them there,
// SWEEP_ROWS rows of COLUMNS. Segments between two layers are pre-integrated, as those of views are (`integrals`: preintegration.cl).
// COARSE: voxels are transmittances (coarse_transmittance.cl), of which each layer has half a length.

#ifndef SWEEP_VECTORS
#error "SWEEP_VECTORS: vectors per row of rays"
#endif
#ifndef SWEEP_ROWS
#error "SWEEP_ROWS: rows of rays per tile"
#endif

// Rays per row of a tile.
#define COLUMNS (SWEEP_VECTORS * VW)
// With room for unaligned vectors that begin at the last column, or two before it.
#define PADDED_COLUMNS (COLUMNS + VW)

// Layers before the first one of a sweep that are sampled, too: that in which the first segment begins, and with gradient opacity the one
// before, since the opacity at a sample is thinned if the segment before it absorbs light.
#ifdef THINNED
#define SAMPLED_BEFORE 2
#else
#define SAMPLED_BEFORE 1
#endif

#include "light/ray_sample.cl"

// Whether a field is not sampled in a layer in which one is.
#define IS_IDLE(absorber) (CHANNELS > 1 && !is_sampled(absorber))

// Voxels -1 ... n of layer k that lie between the rays of a tile: interpolates the transmittance of the rays around them.
static inline void store_layer(const LightSweepParams *p, const RayLayer *layer, const float (*rays)[PADDED_COLUMNS], bool lit,
                               __global uchar *light, __global ushort *sums) {
    light += (size_t)p->volume * p->volume_bytes;
    const int i = layer->first_u + 2, j = layer->first_v + 2;
    const int from_row = max(0, -1 - j), to_row = min(SWEEP_ROWS - COMMON_RAYS, p->dims_v + 1 - j);
    const int from = max(0, -1 - i), to = min(COLUMNS - COMMON_RAYS, p->dims_u + 1 - i);
    const float4 across_columns = ray_weights(layer->between_u), across_rows = ray_weights(layer->between_v);
    // Values of rays interpolated along u.
    float columns[SWEEP_ROWS][PADDED_COLUMNS];
    if (!lit && to_row > from_row)
        for (int r = from_row; r < to_row + COMMON_RAYS; r++) {
            float row[PADDED_COLUMNS];
            for (int c = 0; c < PADDED_COLUMNS; c += VW)
                STOREV(row + c, value_of_ray(p, LOADV(rays[r] + c)));
            for (int c = from; c < to; c += VW)
                STOREV(columns[r] + c,
                       mixed_rays(across_columns, LOADV(row + c), LOADV(row + c + 1), LOADV(row + c + 2), LOADV(row + c + 3)));
        }
    for (int r = from_row; r < to_row; r++) {
        const size_t first =
            (size_t)(layer->k - p->first_stored) * p->stride_a + (size_t)(j + r + 1) * p->stride_v + (size_t)(i + 1) * p->stride_u;
        for (int c = from; c < to; c += VW) {
            const int count = min(VW, to - c);
            const realv mixed = lit ? (realv)(1.0f)
                                    : mixed_rays(across_rows, LOADV(columns[r] + c), LOADV(columns[r + 1] + c), LOADV(columns[r + 2] + c),
                                                 LOADV(columns[r + 3] + c));
            const intv steps = light_steps(p, mixed);
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
            for (int n = 0; n < count; n++)
                store_light(p, at + (size_t)n * p->stride_u, step[n], light, sums);
        }
    }
}

static inline void recover(const LightSweepParams *p, float (*rays)[PADDED_COLUMNS]) {
    for (int r = 0; p->recovered < 1.0f && r < SWEEP_ROWS; r++)
        for (int c = 0; c < COLUMNS; c += VW)
            STOREV(rays[r] + c, recovered(p, LOADV(rays[r] + c)));
}

__kernel void light_sweep(CHANNEL_FIELDS, PER_CHANNEL(__global const uchar *, visible), PER_CHANNEL(__global const int4 *, integrals),
                          __global const LayerOffset *offsets, LightSweepParams p, RayEnds ray_ends, __global uchar *light,
                          __global ushort *sums, __global float *state, ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= p.tiles_u * p.tiles_v)
        return;
    state += (size_t)id * (SWEEP_ROWS * COLUMNS);
    const int column = id % p.tiles_u * (COLUMNS - COMMON_RAYS), row = id / p.tiles_u * (SWEEP_ROWS - COMMON_RAYS);
    Absorber absorbers[CHANNELS];
    SET_ABSORBERS(absorbers, FIELDS(count));
    // Transmittance of the rays, and their samples in the layer before.
    float rays[SWEEP_ROWS][PADDED_COLUMNS];
    for (int r = 0; r < SWEEP_ROWS; r++)
        for (int c = 0; c < PADDED_COLUMNS; c += VW)
            STOREV(rays[r] + c, (realv)(1.0f));
    RaySample before[CHANNELS][SWEEP_ROWS][SWEEP_VECTORS];
    bool lit = true;          // no ray of the tile is dimmed
    for (int r = 0; p.continues && r < SWEEP_ROWS; r++) {
        for (int c = 0; c < COLUMNS; c += VW) {
            const realv ray = CAT(vload, VW)(0, state + r * COLUMNS + c);
            lit = lit && !ANY(ray != 1.0f);
            STOREV(rays[r] + c, ray);
        }
    }
    for (int n = max(p.from - SAMPLED_BEFORE, 0); n < p.to; n++) {
        const bool begins = n < p.from;
        const int k = p.layer_step > 0 ? n - 1 : p.layers - n, odd = n & 1;
        const RayLayer layer = ray_layer(&p, offsets, column, row, k);
        if (is_beside_volume(&p, &layer))
            continue;
        if (!lit && !begins)
            recover(&p, rays);
        bool crossed = false;
        float rows[CHANNELS][2][PADDED_COLUMNS];
        for (int i = 0; i < FIELDS(count); i++) {
            Absorber *absorber = &absorbers[i];
            const VolumeView *view = &absorber->field.view;
            absorber->crossing = crossing_of(absorber->visible, &p, view->first_a, offsets, column, row, n, &layer);
            if (!is_sampled(absorber))
                continue;
            crossed = true;
            if (absorber->sampled_last != n - 1) {
                // The layer before lies beside the volume, or nothing is visible between the two.
                const RaySample beside = sample_beside(&absorber->field.sample, view, absorber->integrals, !odd);
                for (int r = 0; r < SWEEP_ROWS; r++)
                    for (int c = 0; c < SWEEP_VECTORS; c++)
                        before[i][r][c] = beside;
            }
            absorber->sampled_last = n;
            load_row(absorber->field.voxels, view, layer.first_u, layer.first_v, layer.k, SWEEP_VECTORS + 1, rows[i][0]);
        }
        if (crossed) {
            const Weights across_rows = value_weights((realv)(layer.between_v));
            const Weights across_columns = value_weights((realv)(layer.between_u));
            for (int r = 0; r < SWEEP_ROWS; r++) {
                for (int i = 0; i < FIELDS(count); i++) {
                    const ChannelField *field = &absorbers[i].field;
                    if (IS_IDLE(&absorbers[i]))
                        continue;
                    float *low = rows[i][r & 1], *high = rows[i][~r & 1];
                    load_row(field->voxels, &field->view, layer.first_u, layer.first_v + r + 1, layer.k, SWEEP_VECTORS + 1, high);
                    for (int c = 0; c < PADDED_COLUMNS; c += VW)
                        STOREV(low + c, LOADV(low + c) + across_rows.tap[2] * (LOADV(high + c) - LOADV(low + c)));
                }
                for (int c = 0; c < COLUMNS; c += VW) {
                    const realv u = CONVERT_REALV(LANES + layer.first_u + c) + layer.between_u;
                    const realv v = (realv)(layer.first_v + r + layer.between_v);
                    realv absorbs;
                    bool dims = false;
                    for (int i = 0; i < FIELDS(count); i++) {
                        const Absorber *absorber = &absorbers[i];
                        if (IS_IDLE(absorber))
                            continue;
                        const float *mixed = rows[i][r & 1] + c;
                        const realv left = LOADV(mixed), value = left + across_columns.tap[2] * (LOADV(mixed + 1) - left);
                        realv own;
                        if (cross_to_layer(&p, absorber, &ray_ends, k, odd, value, u, v, &before[i][r][c / VW], &own)) {
                            absorbs = dims ? absorbed_by_both(&absorber->field.sample, absorbs, own) : own;
                            dims = true;
                        }
                    }
                    if (dims) {
                        lit = false;
                        STOREV(rays[r] + c, LOADV(rays[r] + c) * let_through(&absorbers[0].field.sample, absorbs));
                    }
                }
            }
        }
        if (begins)
            continue;
        if (!lit)
            recover(&p, rays);
        store_layer(&p, &layer, rays, lit, light, sums);
    }
    for (int r = 0; p.to < p.layers + 2 && r < SWEEP_ROWS; r++)
        for (int c = 0; c < COLUMNS; c += VW)
            CAT(vstore, VW)(LOADV(rays[r] + c), 0, state + r * COLUMNS + c);
}
