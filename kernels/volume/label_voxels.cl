// Voxels of labels as the four fields that are interpolated: extinction times colour, and extinction, per voxel (color_lattice.cl).

#include "shared/volume.cl"

// No label.
#define NONE -1
// The share of a label rises from 0 to 1 between these weights of its voxels among the 27 around a voxel, 1, 2, 1 along each axis, 64
// together. At a plane along the grid, the shares of both sides sum to 1.
#define WITHOUT_SHARE 10.0f
#define WITH_ALL 54.0f
// Least share of a voxel's own label if it is visible, close to that at a plane: labels of a single voxel and thin ones stay.
#define OWN_SHARE 0.9f
// As LARGEST_OPACITY in color_voxels.cl.
#define LARGEST_OPACITY 0.99999f

// Rows of voxels around a row; at the ends of the volume, the nearest ones.
typedef struct {
    __global const VOXEL *rows[9];
    int dims_x;
} Rows;

static inline Rows rows_around(__global const VOXEL *labels, LabelVoxelParams p, int y, int z) {
    Rows around;
    around.dims_x = p.dims_x;
    for (int n = 0; n < 9; n++) {
        const int row_y = clamp(y + n % 3 - 1, 0, p.dims_y - 1), row_z = clamp(z + n / 3 - 1, 0, p.dims_z - 1);
        around.rows[n] = labels + ((size_t)row_z * p.dims_y + row_y) * p.dims_x;
    }
    return around;
}

// The label of all voxels at x of the rows, or NONE if there are several.
static inline int common_label(const Rows *around, int x) {
    const int label = (int)around->rows[4][x];
    int differences = 0;
    for (int n = 0; n < 9; n++)
        differences |= (int)around->rows[n][x] ^ label;
    return differences ? NONE : label;
}

// The largest of the labels, or NONE.
static inline int largest_of(const int8 *labels) {
    const int8 eight = max(max(labels[0], labels[1]), max(labels[2], labels[3]));
    const int4 four = max(eight.lo, eight.hi);
    return max(max(four.x, four.y), max(four.z, four.w));
}

// The weights of the voxels around a voxel that have this label. They become NONE.
static inline int weight_of(int label, int8 *labels) {
    const int8 weights[4] = {(int8)(1, 2, 1, 2, 4, 2, 1, 2), (int8)(1, 2, 4, 2, 4, 8, 4, 2), (int8)(4, 2, 1, 2, 1, 2, 4, 2),
                             (int8)(1, 2, 1, 0, 0, 0, 0, 0)};
    int8 sum = (int8)(0);
    for (int n = 0; n < 4; n++) {
        const int8 equal = labels[n] == label;
        sum += weights[n] & equal;
        labels[n] |= equal;
    }
    const int4 four = sum.lo + sum.hi;
    return four.x + four.y + four.z + four.w;
}

// The entry of a voxel with several labels around it: the opacities and colours of these by their shares. Mixed extinctions would put the
// surface of an opaque label where its share is almost 0, and stairs are most visible there.
static inline float4 mixed_entry(const Rows *around, int x, __global const float4 *entries, int last_entry) {
    const int own = (int)around->rows[4][x];
    int around_here[32];
    for (int n = 0; n < 32; n++)
        around_here[n] = n < 27 ? (int)around->rows[n / 3][clamp(x + n % 3 - 1, 0, around->dims_x - 1)] : NONE;
    // One label after the other: its voxels are counted, and become NONE.
    int8 left[4];
    for (int n = 0; n < 4; n++)
        left[n] = vload8(n, around_here);
    float3 colors = (float3)(0.0f);
    float opacities = 0.0f, shares = 0.0f;
    for (int label = own; label != NONE; label = largest_of(left)) {
        const float4 entry = entries[min(label, last_entry)];
        float share = clamp((weight_of(label, left) - WITHOUT_SHARE) / (WITH_ALL - WITHOUT_SHARE), 0.0f, 1.0f);
        if (label == own && entry.w > 0.0f)
            share = fmax(share, OWN_SHARE);
        shares += share;
        if (share > 0.0f && entry.w > 0.0f) {
            const float opacity = share * -expm1(-entry.w);
            colors += opacity / entry.w * entry.xyz;
            opacities += opacity;
        }
    }
    if (shares == 0.0f)
        return entries[min(own, last_entry)];
    if (opacities == 0.0f)
        return (float4)(0.0f);
    const float extinction = -log1p(-fmin(opacities / shares, LARGEST_OPACITY));
    return (float4)(colors / opacities * extinction, extinction);
}

// entries[voxel]: extinction times red, green, blue, and extinction. One work-item per row.
__kernel void label_voxels(__global const VOXEL *labels, __global const float4 *entries, LabelVoxelParams p,
                           __global float *out_red, __global float *out_green, __global float *out_blue,
                           __global float *out_extinction, ulong first_item) {
    const ulong row = first_item + get_global_id(0);
    if (row >= (ulong)p.dims_y * p.dims_z)
        return;
    const Rows around = rows_around(labels, p, row % p.dims_y, row / p.dims_y);
    const int last_entry = p.entry_count - 1;
    int before = common_label(&around, 0), here = before;
    for (int x = 0; x < p.dims_x; x++) {
        const int after = x + 1 < p.dims_x ? common_label(&around, x + 1) : here;
        const bool is_mixed = p.smooth && (here == NONE || before != here || after != here);
        const size_t id = row * p.dims_x + x;
        float4 entry = is_mixed ? mixed_entry(&around, x, entries, last_entry) : entries[min((int)labels[id], last_entry)];
        if (p.adds)
            entry += (float4)(out_red[id], out_green[id], out_blue[id], out_extinction[id]);
        out_red[id] = entry.x, out_green[id] = entry.y, out_blue[id] = entry.z, out_extinction[id] = entry.w;
        before = here, here = after;
    }
}
