// Axis-aligned sheet-buffer splatting: voxels are classified and shaded first; those of a slice are summed in one sheet, as extinction
// and as colour times extinction, and the sheets are composited.
//
// One work-item per tile of VW x TILE_ROWS pixels, id = tile_v*tiles_u + tile_u, which processes its list of splats slice by slice, front
// to back.

#include "paper/sheet.cl"

// State of the rays of a tile, and their length per voxel of depth.
typedef struct {
    Accumulator gathered[TILE_ROWS];
    Interval intervals[TILE_ROWS];
    RowRays rays[TILE_ROWS];
    realv length[TILE_ROWS];
} Tile;

// Composites the rows [from, to] of the sheet, and clears them.
ALWAYS_INLINE void composite_sheet(const SampleParams *sample, Tile *tile, float layer, int from, int to, realv sheet[TILE_ROWS][4],
                                   intv *active) {
    EACH_ROW(r, from, to) {
        realv length = tile->length[r];
#ifdef CLIPPED
        const realv along = tile->rays[r].d[2], sign = along > 0.0f ? (realv)(0.5f) : (realv)(-0.5f);
        const realv at = layer - tile->rays[r].o[2];
        const Part part = part_of(&tile->intervals[r], (at - sign) / along, (at + sign) / along);
        length *= part_length(&part);
#endif
        const realv extinction = sheet[r][3], depth = extinction * length;
        const realv opacity = opacity_of_depth(sample, depth);
        Accumulator *gathered = &tile->gathered[r];
        const realv weight = gathered->t * opacity / MAX(extinction, (realv)(1e-30f));
        gathered->r += weight * sheet[r][0];
        gathered->g += weight * sheet[r][1];
        gathered->b += weight * sheet[r][2];
        gathered->t -= gathered->t * opacity;
        *active += COUNT_IF(opacity > 0.0f);
        for (int c = 0; c < 4; c++)
            sheet[r][c] = 0.0f;
    }
}

__kernel void axis_sheets(__global const Splat *sorted, __global const uint *ends, __global const uint *lists, int chunks, ScreenParams s,
                          SplatParams p, SampleParams sample, RayEnds ray_ends, OUTPUT, ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= s.tiles_u * s.tiles_v)
        return;
    const int column = id % s.tiles_u * VW, row = id / s.tiles_u * TILE_ROWS, rows = min(TILE_ROWS, s.height - row);
    realv sheet[TILE_ROWS][4];
    Tile tile;
    intv active = 0;
    EACH_ROW(r, 0, rows - 1) {
        tile.rays[r] = row_rays(&s, column, row + r);
        tile.length[r] = length_per_depth(&p, &tile.rays[r]);
        tile.gathered[r] = empty_accumulator(&sample);
#ifdef CLIPPED
        // Splats in front of the eye are rendered unclipped.
        tile.intervals[r] = clip_rays(&ray_ends, tile.rays[r].o, tile.rays[r].d);
#endif
        for (int c = 0; c < 4; c++)
            sheet[r][c] = 0.0f;
    }
    const uint2 list = tile_list(ends, &s, chunks, id);
    float layer = -1.0f;
    int from = TILE_ROWS, to = -1;
    for (uint e = list.x; e < list.y; e++) {
        PREFETCH(sorted + lists[min(e + PREFETCH_DISTANCE, list.y - 1)]);
        const Splat splat = sorted[lists[e]];
        if (splat.reach != layer) {
            composite_sheet(&sample, &tile, layer, from, to, sheet, &active);
            layer = splat.reach;
            from = TILE_ROWS, to = -1;
            if (!any_row_open(&sample, tile.gathered, rows))
                break;
        }
        const Footprint f = splat_footprint(&p, &splat, column, row, rows);
        from = min(from, f.from), to = max(to, f.to);
        EACH_ROW(r, f.from, f.to) {
            const realv footprint = footprint_row(&p, &splat, &f, r);
            sheet[r][0] += splat.content.x * footprint;
            sheet[r][1] += splat.content.y * footprint;
            sheet[r][2] += splat.content.z * footprint;
            sheet[r][3] += splat.content.w * footprint;
        }
    }
    composite_sheet(&sample, &tile, layer, from, to, sheet, &active);
    EACH_ROW(r, 0, rows - 1)
        store_pixels(&s, &sample, 0, column, row + r, &tile.gathered[r], &tile.intervals[r], target);
    active_samples[id] = sum_lanes(active, columns_on_screen(&s, column));
}
