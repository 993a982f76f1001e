// Mean transmittance of blocks of voxels (voxel_blocks.cl), for light volumes of lower resolution.
//
// `entries`: the transmittance of each voxel along the edge of a block, per table entry. Voxels outside the clip region count as clear.
// coarse[(z*dims_y + y)*dims_x + x] is block (first_x + x, first_y + y, first_z + z).

#define ABSORBER_ENTRY float
#define BLOCK_INPUTS
#define SUMS 1
#include "light/voxel_blocks.cl"

static inline bool voxel_sums(const BlockSource *source, const realv *values, intv held, int i, int j, int k, realv *sums) {
    realv absorbed = 0.0f;
    bool any = false;
    for (int m = 0; m < source->count; m++) {
        const Absorber *absorber = source->absorbers + m;
        const SampleParams *sample = &absorber->field.sample;
        intv absorbs, index;
        realv scale;
        if (!find_absorbing(absorber, source->ends, values[m], held, i, j, k, &absorbs, &index, &scale))
            continue;
        realv share = 1.0f - GATHER(absorber->entries, index);
#ifdef THINNED
        if (sample->light.thinned)
            share = sample->classification.linear ? share * scale : 1.0f - general_power(1.0f - share, scale);
#endif
        // Of one field: its share, to the bit.
        const realv left = 1.0f - absorbed;
        absorbed += absorbs ? (sample->classification.linear ? MIN(share, left) : share * left) : (realv)(0.0f);
        any = true;
    }
    *sums += absorbed;
    return any;
}

__kernel void coarse_transmittance(CHANNEL_FIELDS, PER_CHANNEL(__global const float *, entries), RayEnds ray_ends, int first_x,
                                   int first_y, int first_z, int dims_x, int dims_y, int dims_z, __global float *coarse, ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= (VW == 1 ? dims_x : 1) * dims_y * dims_z)
        return;
    BlockSource source;
    SET_BLOCK_SOURCE(source);
    const float voxels = PER_BLOCK_U * PER_BLOCK_V * PER_BLOCK_A;
#if VW == 1
    float sum;
    block_sums(&source, (first_x + id % dims_x) * PER_BLOCK_U, (first_y + id / dims_x % dims_y) * PER_BLOCK_V,
               (first_z + id / dims_x / dims_y) * PER_BLOCK_A, &sum);
    coarse[id] = 1.0f - sum / voxels;
#else
    const int end_u = min((first_x + dims_x) * PER_BLOCK_U, source.absorbers[0].field.view.dims_u);
    for (int first = 0; first < dims_x; first += BLOCKS) {
        float columns[SUMS][COLUMNS];
        const bool any = column_sums(&source, (first_x + first) * PER_BLOCK_U, end_u, (first_y + id % dims_y) * PER_BLOCK_V,
                                     (first_z + id / dims_y) * PER_BLOCK_A, columns);
        __global float *out = coarse + (size_t)id * dims_x + first;
        for (int b = 0; b < min(BLOCKS, dims_x - first); b++)
            out[b] = 1.0f - (any ? sum_of_block(columns[0], b) : 0.0f) / voxels;
    }
#endif
}
