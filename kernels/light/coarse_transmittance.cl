// Mean transmittance of blocks of COARSE^3 voxels, for light volumes of lower resolution.
//
// One work-item per row of blocks; in one lane, per block, so that all is in registers. `transmittance`: of each voxel along the edge of a
// block, per table entry. Voxels outside the clip region count as clear. Blocks at the far faces may be incomplete: what is missing is
// clear. coarse[(z*dims_y + y)*dims_x + x] is block (first_x + x, first_y + y, first_z + z).

#include "shared/clipping.cl"
#include "shared/field.cl"
#include "shared/shading.cl"

#ifndef COARSE
#error "COARSE: voxels per block and axis"
#endif

// Lanes whose voxels lie in the clip region.
static inline intv unclipped(const Clipping *clip, realv u, realv v, realv a) {
    intv inside = u >= clip->lowest[0] && u <= clip->highest[0] && v >= clip->lowest[1] && v <= clip->highest[1] &&
                  a >= clip->lowest[2] && a <= clip->highest[2];
    // Unrolled: GPUs would keep planes indexed by a variable in memory.
#if VW == 1
#pragma unroll
#endif
    for (int n = 0; n < (int)(sizeof clip->planes / sizeof(float)) / 4; n++) {
        if (n >= clip->plane_count)
            break;
        const float *plane = clip->planes + 4 * n;
        inside &= plane[0] * u + plane[1] * v + plane[2] * a + plane[3] >= 0.0f;
    }
    return inside;
}

// The share of the light that those of the voxels with these values absorb that are `held`. False if they absorb none.
static inline bool absorbed_share(const SampleParams *sample, const Clipping *clip, const ShadingSource *source,
                                  __global const float *transmittance, realv value, intv held, realv u, realv v, realv a,
                                  realv *absorbed) {
    const intv index = table_index(sample, value);
    intv absorbs = held && index >= sample->classification.first_visible && index <= sample->classification.last_visible;
#ifdef CLIPPED
    absorbs &= unclipped(clip, u, v, a);
#endif
    if (!ANY(absorbs))
        return false;
    realv share = 1.0f - GATHER(transmittance, index);
#ifdef THINNED
    if (sample->light.thinned) {
        const Gradient gradient = gradient_at(source, &sample->field, u, v, a, absorbs);
        const realv scale = gradient_extinction_scale(sample, gradient_length(sample, gradient));
        share = sample->classification.linear ? share * scale : 1.0f - general_power(1.0f - share, scale);
    }
#endif
    *absorbed = absorbs ? share : (realv)(0.0f);
    return true;
}

#if VW > 1
// Blocks of a row that are reduced together.
#define BLOCKS (4 * VW)
#define COLUMNS (COARSE * BLOCKS)

// `COLUMNS` columns of voxels from `first_u` to `end_u` at most, of the rows of a row of blocks.
static inline bool absorbed_columns(__global const VOXEL *voxels, const VolumeView *view, const SampleParams *sample, const Clipping *clip,
                                    const ShadingSource *source, __global const float *transmittance, int first_u, int end_u,
                                    int first_v, int first_a, float *absorbed_by) {
    for (int c = 0; c < COLUMNS; c += VW)
        STOREV(absorbed_by + c, (realv)(0.0f));
    bool any = false;
    for (int n = 0; n < COARSE * COARSE; n++) {
        const int j = first_v + n % COARSE, k = first_a + n / COARSE;
        if (j >= view->dims_v || k >= view->dims_a)
            continue;
        __global const VOXEL *row = voxels + (k - view->first_a) * view->stride_a + j * view->stride_v;
        for (int c = 0; c < COLUMNS && first_u + c < end_u; c += VW) {
            const int i = first_u + c;
            realv value = (realv)(view->background), absorbed;
            if (i + VW <= end_u)
                value = VOXEL_VALUES(view, LOAD_VOXELS(row + i));
            else
                for (int lane = 0; lane < end_u - i; lane++)
                    ((float *)&value)[lane] = VOXEL_VALUE(view, convert_float(row[i + lane]));
            const intv held = LANES + i < end_u;
            if (absorbed_share(sample, clip, source, transmittance, value, held, CONVERT_REALV(LANES + i), (realv)(j), (realv)(k),
                               &absorbed)) {
                STOREV(absorbed_by + c, LOADV(absorbed_by + c) + absorbed);
                any = true;
            }
        }
    }
    return any;
}
#endif

__kernel void coarse_transmittance(__global const VOXEL *voxels, VolumeView view, __global const GRADIENT_VOXEL *gradient_voxels,
                                   VolumeView gradient_view, __global const float *transmittance, SampleParams sample, Clipping clip,
                                   int first_x, int first_y, int first_z, int dims_x, int dims_y, int dims_z, __global float *coarse,
                                   ulong first_item) {
    const int id = first_item + get_global_id(0);
    voxels += view.first;
    __global const uchar *light = 0, *sky = 0;
    const ShadingSource source = SHADING_SOURCE;
#if VW == 1
    if (id >= dims_x * dims_y * dims_z)
        return;
    const int first_u = (first_x + id % dims_x) * COARSE, first_v = (first_y + id / dims_x % dims_y) * COARSE;
    const int first_a = (first_z + id / dims_x / dims_y) * COARSE;
    float sum = 0.0f;
    for (int n = 0; n < COARSE * COARSE * COARSE; n++) {
        const int i = first_u + n % COARSE, j = first_v + n / COARSE % COARSE, k = first_a + n / (COARSE * COARSE);
        float absorbed;
        if (i < view.dims_u && j < view.dims_v && k < view.dims_a &&
            absorbed_share(&sample, &clip, &source, transmittance, voxel_at(voxels, &view, i, j, k), true, i, j, k, &absorbed))
            sum += absorbed;
    }
    coarse[id] = 1.0f - sum / (COARSE * COARSE * COARSE);
#else
    if (id >= dims_y * dims_z)
        return;
    const int end_u = min((first_x + dims_x) * COARSE, view.dims_u);
    for (int first = 0; first < dims_x; first += BLOCKS) {
        float absorbed_by[COLUMNS];
        const bool any = absorbed_columns(voxels, &view, &sample, &clip, &source, transmittance, (first_x + first) * COARSE, end_u,
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
