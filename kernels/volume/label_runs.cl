// Distance in voxels of each voxel to the nearest one with another label in its row of a thick slice, negative before it; 0 if there is none
// within reach (label_moments.cl).

#include "volume/label_at.cl"

// One work-item per row along the first axis of slices.
__kernel void label_runs(LABEL_FIELDS, __global float *out, ulong first_item) {
    const ulong row = first_item + get_global_id(0);
    const int u = p.thick == 0 ? 1 : 0, v = 3 - u - p.thick, rows = dims_of(p, v), columns = dims_of(p, u);
    if (row >= (ulong)rows * dims_of(p, p.thick))
        return;
    const Labels of = LABELS_OF_ARGUMENTS;
    const size_t step = stride_of(p, u), first = row % rows * stride_of(p, v) + row / rows * stride_of(p, p.thick);
    const int reach = p.thick == 0 ? p.reach_y : p.reach_x;
    Label label = label_at(&of, first);
    int begin = 0;
    for (int i = 1; i <= columns; i++) {
        if (i < columns) {
            const Label next = label_at(&of, first + i * step);
            if (SAME(next, label))
                continue;
            label = next;
        }
        for (int n = begin; n < i; n++) {
            const int before = begin > 0 ? n - begin + 1 : INT_MAX, behind = i < columns ? i - n : INT_MAX, nearest = min(before, behind);
            out[first + n * step] = nearest > reach ? 0 : nearest == before ? -before : behind;
        }
        begin = i;
    }
}
