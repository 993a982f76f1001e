// Layered splatting on the lattice of a perspective view: a ray has the same (I, J) in all layers, and crosses layer k at u = c_u + (k -
// k_c) s_u(I), v = c_v + (k - k_c) s_v(J).
//
// The integrated footprint is a sum of products over NODES quadrature nodes z: F = sum w f(x + s_u z) f(y + s_v z). Each voxel row is
// first interpolated along u at all columns of a tile, for each node (a resampled row); for each lattice row, the v factors then combine
// two of these. One work-item per tile of VW x TILE_ROWS samples, id = tile_v*tiles_u + tile_u. lattice[J*width + I] = RGBA.

#include "layered/resampled_rows.cl"

__kernel void splat_perspective(__global const VOXEL *voxels, VolumeView view, __global const GRADIENT_VOXEL *gradient_voxels,
                                VolumeView gradient_view, __global const uchar *light, __global const uchar *sky,
                                __global const float2 *nodes, __global const uchar *visible, __global const float4 *table,
                                __global const float4 *slabs, RayLatticeParams p, SampleParams sample, Clipping clip,
                                __global float4 *lattice, __global uint *active_samples, ulong first_item) {
    const int tile = first_item + get_global_id(0);
    if (tile >= p.tiles_u * p.tiles_v)
        return;
    voxels += view.first;
    const ShadingSource shading = SHADING_SOURCE;
    const int column = tile % p.tiles_u * VW, row = tile / p.tiles_u * TILE_ROWS;
    const int tile_rows = min(TILE_ROWS, p.height - row), columns = min(VW, p.width - column);
    const Beam beam = make_beam(&p, column, row, columns, tile_rows);
    const float2 reach = max(splat_reach(beam.shear.lo), splat_reach(beam.shear.hi));
    const int last_slab = min(p.last_layer + 1, view.dims_a) - view.first_a; // a part of a volume may lack further slabs
    LayerChunk layer_chunk = {-1, 0};
    realv centre_u, shear_u;
    axis_crossings(&p, 0, LANES + column, &centre_u, &shear_u);

    Rows ring;
    Sums sums[3], across;
    int sums_layer[3] = {INT_MIN, INT_MIN, INT_MIN};
    Accumulator gathered[TILE_ROWS];
    Interval intervals[TILE_ROWS];
    for (int r = 0; r < TILE_ROWS; r++) {
        gathered[r] = p.continues && r < tile_rows ? load_raw(&sample, lattice + (size_t)(row + r) * p.width + column, columns, 1)
                                                   : empty_accumulator(&sample);
#ifdef CLIPPED
        const SampleRays rays = sample_rays(&p, LANES + column, (intv)(row + r));
        intervals[r] = clip_sample_rays(&p, &clip, &rays);
#endif
    }
    const int splats_gradients = GATHERS_VALUES ? 0 : SPLATS_GRADIENTS ? sample.light.shading : 0;
    intv active = 0;
    const int layers = view.dims_a + 2;
    bool finished = p.continues;
    for (int r = 0; r < tile_rows && finished; r++)
        finished = !any_open_lanes(&sample, &gathered[r], columns);
    for (int n = 0; n < layers && !finished; n++) {
        const int k = p.layer_step > 0 ? n - 1 : view.dims_a - n;
        if (k < p.first_layer || k > p.last_layer)
            continue;
        const float depth = k - p.centre_layer;
        if (p.culling) {
            const int2 shown = visible_rows(visible, p.blocks_u, p.blocks_v, last_slab, &beam, tile_rows, reach,
                                            view.first_a - p.centre_layer, k - view.first_a, &layer_chunk);
            if (shown.x > shown.y)
                continue;
        }
        for (int j = k - 1; j <= k + 1; j++) {
            if (sums_layer[slot(j)] == j)
                continue;
            sums_layer[slot(j)] = j;
            splat_layer(voxels, &view, &p, nodes, centre_u, shear_u, row, tile_rows, j, false, splats_gradients,
                        &ring, &sums[slot(j)]);
        }
        if (splats_gradients)
            splat_layer(voxels, &view, &p, nodes, centre_u, shear_u, row, tile_rows, k, true, 0, &ring, &across);
        int first, count;
        layer_slabs(&sample, n, layers, &first, &count);
        const Sums *before = &sums[slot(k - p.layer_step)], *own = &sums[slot(k)], *after = &sums[slot(k + p.layer_step)];
        finished = true;
        for (int r = 0; r < tile_rows; r++) {
            const SampleRays rays = sample_rays(&p, LANES + column, (intv)(row + r));
            LayerSpan layer_span;
            layer_span.dt = length_per_layer(&sample, &rays);
#ifdef CLIPPED
            layer_span.interval.from = intervals[r].from - depth * p.layer_step;
            layer_span.interval.to = intervals[r].to - depth * p.layer_step;
#endif
            const struct SampleSource source = {
                {rays.centre_u + depth * rays.shear_u, rays.centre_v + depth * rays.shear_v, (realv)(k)},
                {own->u[r], own->v[r], 0.5f * across.sum[r]},
                {&shading, &sample.field}};
            accumulate_layer(&sample, slabs, first, count, table, before->sum[r], own->sum[r], after->sum[r], &layer_span, &source,
                             &gathered[r], &active);
            finished = finished && !any_open_lanes(&sample, &gathered[r], columns);
        }
    }

    uint total = sum_lanes(active, columns);
    for (int r = 0; r < tile_rows; r++)
        STORE_RAYS(p, sample, table, &gathered[r], &intervals[r], columns, 1, lattice + (size_t)(row + r) * p.width + column, total)
    active_samples[tile] = total;
}
