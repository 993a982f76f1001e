// Axis-aligned sheet-buffer splatting: voxels are classified and shaded before; those of a slice are summed in one sheet,
// as extinction and as colour times extinction, and sheets are composited.
//
// One work-item per tile of VW x TILE_ROWS pixels, id = tile_v*tiles_u + tile_u, which walks its list of splats, slice by
// slice from the front.

// Composites the sheet of rows [from, to], and empties it.
ALWAYS_INLINE void composite_sheet(const SampleParams *sample, const realv *length, int from, int to,
                                   realv sheet[TILE_ROWS][4], Light *light, intv *active) {
    for (int r = from; r <= to; r++) {
        const realv extinction = sheet[r][3], depth = extinction * length[r];
        const realv opacity = opacity_of_depth(sample, depth);
        const realv weight = light[r].t * opacity / MAX(extinction, (realv)(1e-30f));
        light[r].r += weight * sheet[r][0];
        light[r].g += weight * sheet[r][1];
        light[r].b += weight * sheet[r][2];
        light[r].t -= light[r].t * opacity;
        *active += COUNT_IF(opacity > 0.0f);
        for (int c = 0; c < 4; c++)
            sheet[r][c] = 0.0f;
    }
}

__kernel void axis_sheets(__global const Splat *sorted, __global const uint *ends, __global const uint *lists, int chunks,
                          ScreenParams s, SplatParams p, SampleParams sample, __global float4 *frame,
                          __global uint *active_samples) {
    const int id = get_global_id(0);
    if (id >= s.tiles_u * s.tiles_v)
        return;
    const int column = id % s.tiles_u * VW, row = id / s.tiles_u * TILE_ROWS, rows = min(TILE_ROWS, s.height - row);
    realv sheet[TILE_ROWS][4], length[TILE_ROWS];
    Light light[TILE_ROWS];
    intv active = 0;
    for (int r = 0; r < rows; r++) {
        const RowRays rays = rays_of_row(&s, column, row + r);
        length[r] = length_per_depth(&p, &rays);
        light[r].r = light[r].g = light[r].b = 0.0f;
        light[r].t = 1.0f;
        for (int c = 0; c < 4; c++)
            sheet[r][c] = 0.0f;
    }
    const uint2 list = list_of(ends, s.tiles_u * s.tiles_v, chunks, id);
    float layer = -1.0f;
    int from = TILE_ROWS, to = -1;
    for (uint e = list.x; e < list.y; e++) {
        PREFETCH(sorted + lists[min(e + AHEAD, list.y - 1)]);
        const Splat splat = sorted[lists[e]];
        if (splat.reach != layer) {
            composite_sheet(&sample, length, from, to, sheet, light, &active);
            layer = splat.reach;
            from = TILE_ROWS, to = -1;
            if (!any_open(&sample, light, rows))
                break;
        }
        const Footprint f = footprint_of(&p, &splat, column, row, rows);
        from = min(from, f.from), to = max(to, f.to);
        for (int r = f.from; r <= f.to; r++) {
            const realv footprint = weights_on(&p, &splat, &f, r);
            sheet[r][0] += splat.content.x * footprint;
            sheet[r][1] += splat.content.y * footprint;
            sheet[r][2] += splat.content.z * footprint;
            sheet[r][3] += splat.content.w * footprint;
        }
    }
    composite_sheet(&sample, length, from, to, sheet, light, &active);
    for (int r = 0; r < rows; r++)
        store_pixels(&s, column, row + r, &light[r], frame);
    active_samples[id] = counted(&s, column, active);
}
