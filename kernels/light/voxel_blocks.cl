// Sums over blocks of PER_BLOCK_U x PER_BLOCK_V x PER_BLOCK_A voxels of the fields that absorb light, for lights of lower resolution.
//
// One work-item per row of blocks; in one lane, per block, so that all is in registers. Blocks at the far faces may be incomplete: what is
// missing is clear. A program defines SUMS, their number, and voxel_sums().

#include "shared/channel.cl"
#include "shared/clipping.cl"
#include "shared/shading.cl"

#if !defined(PER_BLOCK_U) || !defined(PER_BLOCK_V) || !defined(PER_BLOCK_A)
#error "PER_BLOCK_U, PER_BLOCK_V, PER_BLOCK_A: voxels per block along each axis"
#endif

// A field that absorbs light, with what a program has of its table entries.
typedef struct {
    ChannelField field;
#ifdef TINTED
    // The colours alone: with pointers to the field, GPUs would keep it in memory.
    ShadingSource shading;
#endif
    __global const ABSORBER_ENTRY *entries;
} Absorber;

// The fields, where light is not absorbed because it is clipped away, and what else a program needs.
typedef struct {
    Absorber absorbers[CHANNELS];
    int count;
    const RayEnds *ends;
    BLOCK_INPUTS
} BlockSource;

// Adds to the sums what those of the voxels (i ... i + VW - 1, j, k) absorb that are held. Their values: of each field. False if they absorb
// nothing.
static inline bool voxel_sums(const BlockSource *source, const realv *values, intv held, int i, int j, int k, realv *sums);

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

// Table entries of a field's voxels with these values, those of the held ones that absorb light, and the factor of their extinction by
// gradients (THINNED). False if none does.
static inline bool find_absorbing(const Absorber *absorber, const RayEnds *ends, realv value, intv held, int i, int j, int k, intv *absorbs,
                                  intv *index, realv *scale) {
    const SampleParams *sample = &absorber->field.sample;
    *index = table_index(sample, value);
    *absorbs = held && *index >= sample->classification.first_visible && *index <= sample->classification.last_visible;
    const realv u = CONVERT_REALV(LANES + i), v = (realv)(j), a = (realv)(k);
#ifdef CLIPPED
    *absorbs &= unclipped(ends, u, v, a);
#endif
    if (!ANY(*absorbs))
        return false;
#ifdef THINNED
    *scale = 1.0f;
    if (sample->light.thinned) {
        const ShadingSource shading = shading_of(&absorber->field);
        const Gradient gradient = gradient_at(&shading, &sample->field, u, v, a, *absorbs);
        *scale = gradient_extinction_scale(sample, gradient_length(sample, gradient));
    }
#endif
    return true;
}

#define SET_BLOCK_SOURCE(source)                                                                                               \
    __global const VOXEL *const all_voxels[MAX_CHANNELS] = EACH(voxels);                                                       \
    __global const GRADIENT_VOXEL *const all_gradient_voxels[MAX_CHANNELS] = EACH(gradient_voxels);                            \
    __global const ABSORBER_ENTRY *const all_entries[MAX_CHANNELS] = EACH(entries);                                            \
    (source).count = FIELDS(count), (source).ends = &ray_ends;                                                                 \
    for (int m = 0; m < (source).count; m++) {                                                                                 \
        set_field(channel_params + m, all_voxels[m], all_gradient_voxels[m], 0, 0, &(source).absorbers[m].field);              \
        (source).absorbers[m].entries = all_entries[m];                                                                        \
    }

#if VW == 1
// The sums of the block whose first voxel is (first_u, first_v, first_a).
static inline void block_sums(const BlockSource *source, int first_u, int first_v, int first_a, float *sums) {
    const VolumeView *grid = &source->absorbers[0].field.view;
    for (int s = 0; s < SUMS; s++)
        sums[s] = 0.0f;
    for (int n = 0; n < PER_BLOCK_U * PER_BLOCK_V * PER_BLOCK_A; n++) {
        const int i = first_u + n % PER_BLOCK_U, j = first_v + n / PER_BLOCK_U % PER_BLOCK_V, k = first_a + n / (PER_BLOCK_U * PER_BLOCK_V);
        if (i >= grid->dims_u || j >= grid->dims_v || k >= grid->dims_a)
            continue;
        float values[CHANNELS];
        for (int m = 0; m < source->count; m++)
            values[m] = voxel_at(source->absorbers[m].field.voxels, &source->absorbers[m].field.view, i, j, k);
        voxel_sums(source, values, 1, i, j, k, sums);
    }
}
#else
// Blocks of a row that are reduced together.
#define BLOCKS (4 * VW)
#define COLUMNS (PER_BLOCK_U * BLOCKS)

// Sums over `COLUMNS` columns of voxels from `first_u` to `end_u` at most, of the rows of a row of blocks.
static inline bool column_sums(const BlockSource *source, int first_u, int end_u, int first_v, int first_a, float (*columns)[COLUMNS]) {
    for (int s = 0; s < SUMS; s++)
        for (int c = 0; c < COLUMNS; c += VW)
            STOREV(columns[s] + c, (realv)(0.0f));
    bool any = false;
    const VolumeView *grid = &source->absorbers[0].field.view;
    for (int n = 0; n < PER_BLOCK_V * PER_BLOCK_A; n++) {
        const int j = first_v + n % PER_BLOCK_V, k = first_a + n / PER_BLOCK_V;
        if (j >= grid->dims_v || k >= grid->dims_a)
            continue;
        for (int c = 0; c < COLUMNS && first_u + c < end_u; c += VW) {
            const int i = first_u + c;
            realv values[CHANNELS];
            for (int m = 0; m < source->count; m++) {
                const VolumeView *view = &source->absorbers[m].field.view;
                __global const VOXEL *row =
                    source->absorbers[m].field.voxels + (k - view->first_a) * view->stride_a + j * view->stride_v;
                values[m] = (realv)(view->background);
                if (i + VW <= end_u)
                    values[m] = VOXEL_VALUES(view, LOAD_VOXELS(row + i));
                else
                    for (int lane = 0; lane < end_u - i; lane++)
                        ((float *)(values + m))[lane] = VOXEL_VALUE(view, convert_float(row[i + lane]));
            }
            realv sums[SUMS];
            for (int s = 0; s < SUMS; s++)
                sums[s] = 0.0f;
            if (voxel_sums(source, values, LANES + i < end_u, i, j, k, sums)) {
                for (int s = 0; s < SUMS; s++)
                    STOREV(columns[s] + c, LOADV(columns[s] + c) + sums[s]);
                any = true;
            }
        }
    }
    return any;
}

// The sum over the columns of a block.
static inline float sum_of_block(const float *columns, int block) {
    float sum = 0.0f;
    for (int c = 0; c < PER_BLOCK_U; c++)
        sum += columns[block * PER_BLOCK_U + c];
    return sum;
}
#endif
