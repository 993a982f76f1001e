// What blocks of voxels (voxel_blocks.cl) absorb and scatter: sums over their voxels of the optical depth, of the depth times the albedo, and
// of that times the light of the lights that arrives there.
//
// `entries`: per table entry, optical depth times the albedo of red, green and blue, and optical depth; along the edge of a cell. `light`:
// bytes of the volumes of the lights (light_codes.cl), of which each value covers 2^light_shift voxels along each axis and has a margin of one
// value. blocks[(n * dims_z + z) * dims_y + y) * dims_x + x] is sum n of a block, divided by the voxels of one; layer z is first_layer + z of
// all.

// A field may have colours of its voxels. Those of a field whose voxels are not these lie at `to_own` of its placement.

#define ABSORBER_ENTRY float4
#define BLOCK_INPUTS              \
    const ScatterMediumParams *p; \
    __global const uchar *light;
#define SUMS 7
#include "light/voxel_blocks.cl"
#include "shared/blend_modes.cl"
#include "shared/light_codes.cl"
#include "shared/linear_light.cl"
#include "shared/table_entries.cl"

// Optical depth of an iso-surface, whose matter is a voxel thick, along the edge of a cell.
#define SURFACE_DEPTH 16.0f

#ifdef TINTED
// Replaces depths times the albedo by those of the colours of voxels.
static inline void color_entry(const Absorber *absorber, int i, int j, int k, realv *entry) {
    if (!absorber->shading.tint.strides[0])
        return;
    const realv voxel[3] = {CONVERT_REALV(LANES + i), (realv)(j), (realv)(k)};
    realv own[3], color[3] = {(realv)(0.0f), (realv)(0.0f), (realv)(0.0f)};
    to_own_voxels(absorber->field.place, voxel, 1.0f, own);
    const Point at = {own[0], own[1], own[2]};
    mix_color(&absorber->shading.tint, at, color, color + 1, color + 2);
    for (int c = 0; c < 3; c++)
        entry[c] = albedo(reflectance(color[c])) * entry[3];
}
#endif

// The code of the light that arrives at voxels, or `to_value` values beyond them.
static inline realv arriving(const BlockSource *source, int number, int to_value, intv held, int i, int j, int k) {
    const ScatterMediumParams *p = source->p;
    const int shift = p->light_shift;
    __global const uchar *row = source->light + (size_t)number * p->light_bytes + ((j >> shift) + 1) * p->light_row +
                                (size_t)((k >> shift) + 1 - p->light_first) * p->light_layer;
    // Other lanes read the first voxel of the row, whose neighbours exist.
    return (1.0f / 255.0f) * CONVERT_REALV(GATHER_AS(intv, row + to_value, held ? ((LANES + i) >> shift) + 1 : (intv)(1)));
}

#if BLEND == ISO
// Offset of neighbour n along an axis.
#define BESIDE(n, axis) ((n) >> 1 == (axis) ? ((n) & 1 ? -1 : 1) : 0)

// An iso-surface is opaque: voxels of its side with larger values absorb, which have a neighbour on the other side. `entry`: as of a table.
static inline bool find_surface(const Absorber *absorber, const RayEnds *ends, realv value, intv held, int i, int j, int k, intv *absorbs,
                                realv *entry) {
    const ClassificationParams *c = &absorber->field.sample.classification;
    *absorbs = held && value >= c->iso;
#ifdef CLIPPED
    *absorbs &= unclipped(ends, CONVERT_REALV(LANES + i), (realv)(j), (realv)(k));
#endif
    if (!ANY(*absorbs))
        return false;
    realv least = INFINITY;
    for (int n = 0; n < 6; n++) {
        realv beside;
        for (int lane = 0; lane < VW; lane++)
            ((float *)&beside)[lane] =
                voxel_at(absorber->field.voxels, &absorber->field.view, i + lane + BESIDE(n, 0), j + BESIDE(n, 1), k + BESIDE(n, 2));
        least = MIN(least, beside);
    }
    *absorbs &= least < c->iso;
    entry[0] = SURFACE_DEPTH * albedo((realv)(c->iso_r)), entry[1] = SURFACE_DEPTH * albedo((realv)(c->iso_g));
    entry[2] = SURFACE_DEPTH * albedo((realv)(c->iso_b)), entry[3] = SURFACE_DEPTH;
    return ANY(*absorbs);
}
#endif

#if BLEND != ISO
// The code of the light that arrives in the next layer of values across which its rays run: towards the light (1), or against it (-1).
static inline realv arriving_along(const BlockSource *source, int number, int sign, intv held, int i, int j, int k) {
    const int next = sign * source->p->towards[3 * number];
    const int to_one = sign * source->p->towards[3 * number + 1], to_other = sign * source->p->towards[3 * number + 2];
    const float one = source->p->shears[2 * number], other = source->p->shears[2 * number + 1];
    realv code = arriving(source, number, next, held, i, j, k);
    if (one > 0.0f)
        code += one * (arriving(source, number, next + to_one, held, i, j, k) - code);
    if (other > 0.0f) {
        realv beside = arriving(source, number, next + to_other, held, i, j, k);
        if (one > 0.0f)
            beside += one * (arriving(source, number, next + to_one + to_other, held, i, j, k) - beside);
        code += other * (beside - code);
    }
    return code;
}

// The light that voxels take of what is lost between their middles and those of neighbours, as far as it is their part of the depth in between.
// `before`, `behind`: codes. `half_way`: the depth of the voxels on their half of this way.
static inline realv taken(realv before, realv behind, realv half_way) {
    const realv between = DARKEST * ((1.0f - behind) * (1.0f - behind) - (1.0f - before) * (1.0f - before));
    const realv lost = MAX(light_of_code(before) - light_of_code(behind), (realv)(0.0f));
    return lost * MIN(half_way / MAX(between, (realv)(1e-3f)), (realv)(1.0f));
}
#endif

// The light that matter of this depth absorbs at voxels. A voxel of a surface absorbs the light beside it times the cosine, which is 1/2 on
// average, times the voxels along the edge of a cell, which are 2: the factor is 1. In dense matter most light is absorbed before it reaches the
// middles of voxels, so what it loses between them counts. In thin matter that difference has too few steps, and the light at the middles counts.
static inline realv absorbed_light(const BlockSource *source, int number, realv depth, intv held, int i, int j, int k) {
#if BLEND == ISO
    realv most = 0.0f;
    for (int n = 0; n < 6; n++)
        most = MAX(most, arriving(source, number, 0, held, i + BESIDE(n, 0), j + BESIDE(n, 1), k + BESIDE(n, 2)));
    return depth > 0.0f ? light_of_code(most) : (realv)(0.0f);
#else
    const realv middle = arriving(source, number, 0, held, i, j, k);
    const float crossing = source->p->crossings[number];
    const realv half_way = 0.5f * crossing * depth;
    const realv lost = taken(arriving_along(source, number, 1, held, i, j, k), middle, half_way) +
                       taken(middle, arriving_along(source, number, -1, held, i, j, k), half_way);
    const realv dense = CLAMP((half_way - 0.05f) * 10.0f, (realv)(0.0f), (realv)(1.0f)), at_middle = depth * light_of_code(middle);
    return at_middle + dense * (lost * (1.0f / crossing) - at_middle);
#endif
}

static inline bool voxel_sums(const BlockSource *source, const realv *values, intv held, int i, int j, int k, realv *sums) {
    const ScatterMediumParams *p = source->p;
    realv own[4] = {(realv)(0.0f), (realv)(0.0f), (realv)(0.0f), (realv)(0.0f)};
    bool any = false;
    for (int m = 0; m < source->count; m++) {
        const Absorber *absorber = source->absorbers + m;
        intv absorbs, index = 0;
        realv scale, entry[4];
#if BLEND == ISO
        if (!find_surface(absorber, source->ends, values[m], held, i, j, k, &absorbs, entry))
            continue;
#else
        if (!find_absorbing(absorber, source->ends, values[m], held, i, j, k, &absorbs, &index, &scale))
            continue;
        table_entries(absorber->entries, index, entry, entry + 1, entry + 2, entry + 3);
#endif
#ifdef TINTED
        color_entry(absorber, i, j, k, entry);
#endif
        for (int n = 0; n < 4; n++) {
#if defined(THINNED) && BLEND != ISO
            entry[n] *= scale;
#endif
            own[n] += absorbs ? entry[n] : (realv)(0.0f);
        }
        any = true;
    }
    if (!any)
        return false;
    sums[0] += own[3];
    for (int c = 0; c < 3; c++)
        sums[1 + c] += own[c];
    // Unrolled: GPUs would keep lights indexed by a variable in memory.
#if VW == 1
#pragma unroll
#endif
    for (int l = 0; l < (int)(sizeof p->crossings / sizeof(float)); l++) {
        if (l >= p->lights)
            break;
        const realv light = absorbed_light(source, l, own[3], held, i, j, k);
        for (int c = 0; c < 3; c++)
            sums[4 + c] += p->irradiance[3 * l + c] * light;
    }
    return true;
}

__kernel void scatter_medium(CHANNEL_FIELDS, PER_CHANNEL(__global const float4 *, entries), RayEnds ray_ends, __global const uchar *light,
                             ScatterMediumParams p, __global float *blocks, CHANNEL_COLORS ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= (VW == 1 ? p.dims_x : 1) * p.dims_y * p.dims_z)
        return;
    BlockSource source;
    SET_BLOCK_SOURCE(source);
    SET_COLORS(source.absorbers, source.count);
    source.p = &p, source.light = light;
    const float per_voxel = 1.0f / (PER_BLOCK_U * PER_BLOCK_V * PER_BLOCK_A);
    const size_t plane = (size_t)p.dims_x * p.dims_y * p.dims_z;
#if VW == 1
    float sums[SUMS];
    block_sums(&source, id % p.dims_x * PER_BLOCK_U, id / p.dims_x % p.dims_y * PER_BLOCK_V,
               (p.first_layer + id / p.dims_x / p.dims_y) * PER_BLOCK_A, sums);
    for (int s = 0; s < SUMS; s++)
        blocks[s * plane + id] = sums[s] * per_voxel;
#else
    const int end_u = min(p.dims_x * PER_BLOCK_U, source.absorbers[0].field.view.dims_u);
    for (int first = 0; first < p.dims_x; first += BLOCKS) {
        float columns[SUMS][COLUMNS];
        const bool any = column_sums(&source, first * PER_BLOCK_U, end_u, id % p.dims_y * PER_BLOCK_V,
                                     (p.first_layer + id / p.dims_y) * PER_BLOCK_A, columns);
        __global float *out = blocks + (size_t)id * p.dims_x + first;
        for (int s = 0; s < SUMS; s++)
            for (int b = 0; b < min(BLOCKS, p.dims_x - first); b++)
                out[s * plane + b] = any ? sum_of_block(columns[s], b) * per_voxel : 0.0f;
    }
#endif
}
