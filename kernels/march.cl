// Marching along the rays of the screen: by ray casting (raycast.cl) or by slicing (slicing.cl), which say how a row of
// rays is marched, and what `table` holds.
//
// One work-item per tile of VW x TILE_ROWS pixels, id = tile_v*tiles_u + tile_u, one row after the other.

__kernel void march(__global const VOXEL *voxels, VolumeView view, __global const uchar *visible,
                    __global const float4 *table, ScreenParams s, MarchParams p, SampleParams sample,
                    __global float4 *frame, __global uint *active_samples) {
    const int id = get_global_id(0);
    if (id >= s.tiles_u * s.tiles_v)
        return;
    const int column = id % s.tiles_u * VW, row = id / s.tiles_u * TILE_ROWS;
    intv active = 0;
    for (int r = row; r < min(row + TILE_ROWS, s.height); r++) {
        const RowRays rays = rays_of_row(&s, column, r);
        const Light light = march_row(voxels, &view, visible, table, &s, &p, &sample, &rays, &active);
        store_pixels(&s, column, r, &light, frame);
    }
    active_samples[id] = counted(&s, column, active);
}
