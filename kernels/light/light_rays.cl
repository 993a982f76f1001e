// Transmittance to a light, as in light_sweep.cl, with a work-item per ray, for GPUs.
//
// One work-group per tile of rays. In each layer its work-items exchange their values through local memory, and each writes one
// voxel, from its own and the next rays. VW is 1, and so is the number of fields. A sweep visits all layers: `state` is not used.

#include "layered/sample_tile.cl"

#define COLUMNS SAMPLE_COLUMNS
#define SWEEP_ROWS SAMPLE_ROWS

#include "light/ray_sample.cl"

// The field where a ray crosses a layer, interpolated from four voxels: first along v, as rows of a tile are.
static inline float value_on_layer(__global const VOXEL *voxels, const VolumeView *view, const RayLayer *layer, int2 place) {
    const int i = layer->first_u + place.x, j = layer->first_v + place.y;
    const Weights across_rows = value_weights(layer->between_v), across_columns = value_weights(layer->between_u);
    float columns[2];
#pragma unroll
    for (int c = 0; c < 2; c++) {
        const float low = voxel_at(voxels, view, i + c, j, layer->k), high = voxel_at(voxels, view, i + c, j + 1, layer->k);
        columns[c] = low + across_rows.tap[2] * (high - low);
    }
    return columns[0] + across_columns.tap[2] * (columns[1] - columns[0]);
}

// Writes the voxel that lies between the second and the third of four rays in a row, and in a column, of which the first is at a place of a
// tile.
static inline void store_voxel(const LightSweepParams *p, const RayLayer *layer, __local const float *rays, int2 place,
                               __global uchar *light, __global ushort *sums) {
    const int i = layer->first_u + 2 + place.x, j = layer->first_v + 2 + place.y;
    if (place.x >= COLUMNS - COMMON_RAYS || place.y >= SWEEP_ROWS - COMMON_RAYS || i < -1 || i > p->dims_u || j < -1 || j > p->dims_v)
        return;
    const float4 across_columns = ray_weights(layer->between_u), across_rows = ray_weights(layer->between_v);
    float columns[COMMON_RAYS + 1];
#pragma unroll
    for (int r = 0; r <= COMMON_RAYS; r++) {
        __local const float *ray = rays + (place.y + r) * COLUMNS + place.x;
        columns[r] = mixed_rays(across_columns, ray[0], ray[1], ray[2], ray[3]);
    }
    const int steps = light_steps(p, mixed_rays(across_rows, columns[0], columns[1], columns[2], columns[3]));
    const size_t voxel = (size_t)(layer->k - p->first_stored) * p->stride_a + (size_t)(j + 1) * p->stride_v + (size_t)(i + 1) * p->stride_u;
    store_light(p, voxel, steps, light + (size_t)p->volume * p->volume_bytes, sums);
}

__attribute__((reqd_work_group_size(SAMPLE_COLUMNS * SAMPLE_ROWS, 1, 1)))
__kernel void light_rays(CHANNEL_FIELDS, PER_CHANNEL(__global const uchar *, visible), PER_CHANNEL(__global const int4 *, integrals),
                         __global const LayerOffset *offsets, LightSweepParams p, RayEnds ray_ends, __global uchar *light,
                         __global ushort *sums, __global float *state, ulong first_item) {
    // Of even and of odd layers: a work-item may write its value while others still read those of the layer before.
    __local float rays[2][SAMPLE_COLUMNS * SAMPLE_ROWS];
    const int tile = FIRST_GROUP + get_group_id(0);
    if (tile >= p.tiles_u * p.tiles_v)
        return;
    Absorber absorbers[1];
    SET_ABSORBERS(absorbers, 1);
    Absorber *absorber = &absorbers[0];
    const ChannelField *field = &absorber->field;
    const int column = tile % p.tiles_u * (COLUMNS - COMMON_RAYS), row = tile / p.tiles_u * (SWEEP_ROWS - COMMON_RAYS);
    const int2 place = place_in_tile(get_local_id(0));
    float transmittance = 1.0f;
    RaySample before;
    for (int n = 0; n < p.layers + 2; n++) {
        const int k = p.layer_step > 0 ? n - 1 : p.layers - n;
        const RayLayer layer = ray_layer(&p, offsets, column, row, k);
        const bool beside = is_beside_volume(&p, &layer);
        if (!beside) {
            transmittance = recovered(&p, transmittance);
            absorber->crossing = crossing_of(absorber->visible, &p, field->view.first_a, offsets, column, row, n, &layer);
            if (is_sampled(absorber)) {
                const int odd = n & 1;
                // The layer before lies beside the volume, or nothing is visible between the two.
                if (absorber->sampled_last != n - 1)
                    before = sample_beside(&field->sample, &field->view, absorber->integrals, !odd);
                absorber->sampled_last = n;
                const float value = value_on_layer(field->voxels, &field->view, &layer, place);
                const float u = layer.first_u + place.x + layer.between_u, v = layer.first_v + place.y + layer.between_v;
                float absorbs;
                if (cross_to_layer(&p, absorber, &ray_ends, k, odd, value, u, v, &before, &absorbs))
                    transmittance *= let_through(&field->sample, absorbs);
            }
            transmittance = recovered(&p, transmittance);
            rays[n & 1][place.y * COLUMNS + place.x] = value_of_ray(&p, transmittance);
        }
        barrier(CLK_LOCAL_MEM_FENCE);
        if (!beside)
            store_voxel(&p, &layer, rays[n & 1], place, light, sums);
    }
}
