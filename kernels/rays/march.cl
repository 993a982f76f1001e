// Ray marching over the screen. The including file defines how a row of rays is marched, and what `table` holds.
//
// One work-item per tile of VW x TILE_ROWS pixels, id = tile_v*tiles_u + tile_u, one row after another.

__kernel void march(SHADED_FIELD, __global const uchar *visible, ScreenParams s, MarchParams p, SampleParams sample, RayEnds ray_ends,
                    OUTPUT, __global const TABLE *table, TINT_ARGUMENTS ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= s.tiles_u * s.tiles_v)
        return;
    voxels += view.first;
    const ShadingSource shading = SHADING_SOURCE;
    const int column = id % s.tiles_u * VW, row = id / s.tiles_u * TILE_ROWS;
    intv active = 0;
    for (int r = row; r < min(row + TILE_ROWS, s.height); r++) {
        const RowRays rays = row_rays(&s, column, r);
        const Interval interval = SCREEN_INTERVAL(&s, &ray_ends, &rays, column, r);
        Accumulator gathered = empty_accumulator(&sample);
        if (ANY(interval.from < interval.to))
            march_row(voxels, &view, &shading, visible, table, &p, &sample, &rays, &interval, &gathered, &active);
        store_pixels(&s, &sample, (__global const float4 *)table, column, r, &gathered, &interval, target);
    }
    active_samples[id] = sum_lanes(active, columns_on_screen(&s, column));
}
