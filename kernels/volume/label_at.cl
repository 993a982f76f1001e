// What a voxel of labels holds: the label itself or, LAYERED where labels overlap, the four fields of label_voxels.cl.

#include "shared/volume.cl"

#ifdef LAYERED
typedef float4 Label;
#define SAME(one, other) all((one) == (other))
#else
typedef int Label;
#define SAME(one, other) ((one) == (other))
#endif

// Arguments of a kernel.
#define LABEL_FIELDS                                                                                                        \
    __global const VOXEL *labels, __global const float4 *entries, __global const float *red, __global const float *green, \
        __global const float *blue, __global const float *extinction, LabelVoxelParams p

typedef struct {
    __global const VOXEL *labels;
    __global const float4 *entries;
    __global const float *red, *green, *blue, *extinction;
    int last;
} Labels;
#define LABELS_OF_ARGUMENTS {labels, entries, red, green, blue, extinction, p.entry_count - 1}

static inline Label label_at(const Labels *of, size_t at) {
#ifdef LAYERED
    return (float4)(of->red[at], of->green[at], of->blue[at], of->extinction[at]);
#else
    return (int)of->labels[at];
#endif
}

// Extinction times red, green, blue, and extinction.
static inline float4 entry_of(const Labels *of, Label label) {
#ifdef LAYERED
    return label;
#else
    return of->entries[min(label, of->last)];
#endif
}

// Number of voxels to the next along an axis.
static inline size_t stride_of(LabelVoxelParams p, int axis) {
    return axis == 0 ? 1 : axis == 1 ? (size_t)p.dims_x : (size_t)p.dims_x * p.dims_y;
}
static inline int dims_of(LabelVoxelParams p, int axis) { return axis == 0 ? p.dims_x : axis == 1 ? p.dims_y : p.dims_z; }
