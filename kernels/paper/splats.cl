// Selects the voxels to splat, in the order of their layout.
//
// One work-item per row of voxels along u. Counts the selected voxels of its row, or with `fill` writes them from counts[row] on, where
// the counts have been replaced by prefix sums. A voxel is selected if its value or gradient differs from the background's, and any value
// between the background and the voxels up to `reach` (at most 3) away can be visible: where neighbours are omitted, sums fall towards
// the background. With a reach of 0, it is selected if it is visible itself; with a negative one, if it differs from the background.
// `slack`: see slab_visibility.cl.

#include "volume/opacity_range.cl"

#define SEGMENT_VECTORS (64 / VW) // processed together
#define PADDED (SEGMENT_VECTORS + 2 * ((3 + VW - 1) / VW))

__kernel void splats(__global const VOXEL *voxels, VolumeView view, int reach, float slack, float table_first, float table_per_value,
                     int table_last, __global const uint *visible_before, int fill, __global uint *counts, __global ushort4 *places,
                     __global float4 *contents, ulong first_item) {
    const int row = first_item + get_global_id(0);
    if (row >= view.dims_v * view.dims_a)
        return;
    voxels += view.first;
    const int v = row % view.dims_v, k = row / view.dims_v;
    const int margin = (PADDED - SEGMENT_VECTORS) / 2 * VW;
    uint count = 0, next = counts[row];
    for (int u0 = 0; u0 < view.dims_u; u0 += SEGMENT_VECTORS * VW) {
        float own[PADDED * VW], lo[PADDED * VW], hi[PADDED * VW];
        load_row(voxels, &view, u0 - margin, v, k, PADDED, own);
        for (int c = 0; c < PADDED; c++) {
            STOREV(lo + c * VW, LOADV(own + c * VW));
            STOREV(hi + c * VW, LOADV(own + c * VW));
        }
        for (int dk = -reach; dk <= reach; dk++)
            for (int dv = -reach; dv <= reach; dv++) {
                if (dk == 0 && dv == 0)
                    continue;
                float other[PADDED * VW];
                load_row(voxels, &view, u0 - margin, v + dv, k + dk, PADDED, other);
                for (int c = 0; c < PADDED * VW; c += VW) {
                    STOREV(lo + c, MIN(LOADV(lo + c), LOADV(other + c)));
                    STOREV(hi + c, MAX(LOADV(hi + c), LOADV(other + c)));
                }
            }
        for (int i = 0; i < min(SEGMENT_VECTORS * VW, view.dims_u - u0); i++) {
            const int at = margin + i;
            float from = lo[at], to = hi[at];
            for (int d = 1; d <= reach; d++) {
                from = MIN(from, MIN(lo[at - d], lo[at + d]));
                to = MAX(to, MAX(hi[at - d], hi[at + d]));
            }
            if (reach > 0) {
                from = MIN(from, view.background), to = MAX(to, view.background);
                if (from == to)
                    continue;
                from -= slack * fabs(from - view.background), to += slack * fabs(to - view.background);
            }
            if (reach >= 0 && !any_visible(from, to, -INFINITY, INFINITY, table_first, table_per_value, table_last, visible_before))
                continue;
            const int u = u0 + i;
            const float4 content = (float4)(
                own[at], 0.5f * (own[at + 1] - own[at - 1]),
                0.5f * (voxel_at(voxels, &view, u, v + 1, k) - voxel_at(voxels, &view, u, v - 1, k)),
                0.5f * (voxel_at(voxels, &view, u, v, k + 1) - voxel_at(voxels, &view, u, v, k - 1)));
            if (reach != 0 && content.x == view.background && content.y == 0.0f && content.z == 0.0f && content.w == 0.0f)
                continue;
            if (fill) {
                places[next] = (ushort4)(u, v, k, 0);
                contents[next] = content;
                next++;
            }
            count++;
        }
    }
    if (!fill)
        counts[row] = count;
}
