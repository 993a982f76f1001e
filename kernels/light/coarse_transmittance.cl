// Mean transmittance of blocks of COARSE^3 voxels, for light volumes of lower resolution.
//
// One work-item per row of blocks; in one lane, per block, so that all is in registers. `transmittance`: of each voxel along the edge of a
// block, per table entry. Voxels outside the clip region count as clear. Blocks at the far faces may be incomplete: what is missing is
// clear. coarse[(z*dims_y + y)*dims_x + x] is block (first_x + x, first_y + y, first_z + z).

#include "shared/channel.cl"
#include "shared/clipping.cl"
#include "shared/shading.cl"

#ifndef COARSE
#error "COARSE: voxels per block and axis"
#endif

// Lanes whose voxels lie in the clip region.
static inline intv unclipped(const RayEnds *ends, realv u, realv v, realv a) {
    intv inside = u >= ends->lowest[0] && u <= ends->highest[0] && v >= ends->lowest[1] && v <= ends->highest[1] &&
                  a >= ends->lowest[2] && a <= ends->highest[2];
    // Unrolled: GPUs would keep planes indexed by a variable in memory.
#if VW == 1
#pragma unroll
#endif
    for (int n = 0; n < (int)(sizeof ends->planes / sizeof(float)) / 4; n++) {
        if (n >= ends->plane_count)
            break;
        const float *plane = ends->planes + 4 * n;
        inside &= plane[0] * u + plane[1] * v + plane[2] * a + plane[3] >= 0.0f;
    }
    return inside;
}

// A field that absorbs light, with the transmittance of its table entries.
typedef struct {
    ChannelField field;
    __global const float *transmittance;
} Absorber;

// Adds the share of the light that those of a field's voxels with these values absorb that are `held`. False if they absorb none.
static inline bool add_absorbed_share(const Absorber *absorber, const RayEnds *ends, realv value, intv held, realv u, realv v, realv a,
                                      realv *absorbed) {
    const SampleParams *sample = &absorber->field.sample;
    const intv index = table_index(sample, value);
    intv absorbs = held && index >= sample->classification.first_visible && index <= sample->classification.last_visible;
#ifdef CLIPPED
    absorbs &= unclipped(ends, u, v, a);
#endif
    if (!ANY(absorbs))
        return false;
    realv share = 1.0f - GATHER(absorber->transmittance, index);
#ifdef THINNED
    if (sample->light.thinned) {
        const ShadingSource source = shading_of(&absorber->field);
        const Gradient gradient = gradient_at(&source, &sample->field, u, v, a, absorbs);
        const realv scale = gradient_extinction_scale(sample, gradient_length(sample, gradient));
        share = sample->classification.linear ? share * scale : 1.0f - general_power(1.0f - share, scale);
    }
#endif
    // Of one field: its share, to the bit.
    const realv left = 1.0f - *absorbed;
    *absorbed += absorbs ? (sample->classification.linear ? MIN(share, left) : share * left) : (realv)(0.0f);
    return true;
}

#if VW > 1
// Blocks of a row that are reduced together.
#define BLOCKS (4 * VW)
#define COLUMNS (COARSE * BLOCKS)

// `COLUMNS` columns of voxels from `first_u` to `end_u` at most, of the rows of a row of blocks.
static inline bool absorbed_columns(const Absorber *absorbers, int count, const RayEnds *ends, int first_u, int end_u, int first_v,
                                    int first_a, float *absorbed_by) {
    for (int c = 0; c < COLUMNS; c += VW)
        STOREV(absorbed_by + c, (realv)(0.0f));
    bool any = false;
    const VolumeView *grid = &absorbers[0].field.view;
    for (int n = 0; n < COARSE * COARSE; n++) {
        const int j = first_v + n % COARSE, k = first_a + n / COARSE;
        if (j >= grid->dims_v || k >= grid->dims_a)
            continue;
        for (int c = 0; c < COLUMNS && first_u + c < end_u; c += VW) {
            const int i = first_u + c;
            realv absorbed = 0.0f;
            bool absorbs = false;
            for (int m = 0; m < count; m++) {
                const VolumeView *view = &absorbers[m].field.view;
                __global const VOXEL *row = absorbers[m].field.voxels + (k - view->first_a) * view->stride_a + j * view->stride_v;
                realv value = (realv)(view->background);
                if (i + VW <= end_u)
                    value = VOXEL_VALUES(view, LOAD_VOXELS(row + i));
                else
                    for (int lane = 0; lane < end_u - i; lane++)
                        ((float *)&value)[lane] = VOXEL_VALUE(view, convert_float(row[i + lane]));
                absorbs |= add_absorbed_share(&absorbers[m], ends, value, LANES + i < end_u, CONVERT_REALV(LANES + i), (realv)(j),
                                              (realv)(k), &absorbed);
            }
            if (absorbs) {
                STOREV(absorbed_by + c, LOADV(absorbed_by + c) + absorbed);
                any = true;
            }
        }
    }
    return any;
}
#endif

__kernel void coarse_transmittance(CHANNEL_FIELDS, PER_CHANNEL(__global const float *, transmittance), RayEnds ray_ends, int first_x,
                                   int first_y, int first_z, int dims_x, int dims_y, int dims_z, __global float *coarse, ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= (VW == 1 ? dims_x : 1) * dims_y * dims_z)
        return;
    __global const VOXEL *const all_voxels[MAX_CHANNELS] = EACH(voxels);
    __global const GRADIENT_VOXEL *const all_gradient_voxels[MAX_CHANNELS] = EACH(gradient_voxels);
    __global const float *const all_transmittances[MAX_CHANNELS] = EACH(transmittance);
    Absorber absorbers[CHANNELS];
    for (int m = 0; m < FIELDS(count); m++) {
        set_field(channel_params + m, all_voxels[m], all_gradient_voxels[m], 0, 0, &absorbers[m].field);
        absorbers[m].transmittance = all_transmittances[m];
    }
    const VolumeView *grid = &absorbers[0].field.view;
#if VW == 1
    const int first_u = (first_x + id % dims_x) * COARSE, first_v = (first_y + id / dims_x % dims_y) * COARSE;
    const int first_a = (first_z + id / dims_x / dims_y) * COARSE;
    float sum = 0.0f;
    for (int n = 0; n < COARSE * COARSE * COARSE; n++) {
        const int i = first_u + n % COARSE, j = first_v + n / COARSE % COARSE, k = first_a + n / (COARSE * COARSE);
        if (i >= grid->dims_u || j >= grid->dims_v || k >= grid->dims_a)
            continue;
        float absorbed = 0.0f;
        for (int m = 0; m < FIELDS(count); m++) {
            const float value = voxel_at(absorbers[m].field.voxels, &absorbers[m].field.view, i, j, k);
            add_absorbed_share(&absorbers[m], &ray_ends, value, true, i, j, k, &absorbed);
        }
        sum += absorbed;
    }
    coarse[id] = 1.0f - sum / (COARSE * COARSE * COARSE);
#else
    const int end_u = min((first_x + dims_x) * COARSE, grid->dims_u);
    for (int first = 0; first < dims_x; first += BLOCKS) {
        float absorbed_by[COLUMNS];
        const bool any = absorbed_columns(absorbers, FIELDS(count), &ray_ends, (first_x + first) * COARSE, end_u,
                                          (first_y + id % dims_y) * COARSE, (first_z + id / dims_y) * COARSE, absorbed_by);
        __global float *out = coarse + (size_t)id * dims_x + first;
        for (int b = 0; b < min(BLOCKS, dims_x - first); b++) {
            float sum = 0.0f;
            for (int c = 0; any && c < COARSE; c++)
                sum += absorbed_by[b * COARSE + c];
            out[b] = 1.0f - sum / (COARSE * COARSE * COARSE);
        }
    }
#endif
}
