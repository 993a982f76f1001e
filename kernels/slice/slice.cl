// A slice: the field on the pixels of a plane, where pixels lie in the voxels' boxes. Elsewhere the picture is transparent.
//
// One work-item per tile of VW x TILE_ROWS pixels, id = tile_v*tiles_u + tile_u, one row after another. The rays of `s` only give the points
// of the plane. `table`: (r, g, b, tau) per value.

#include "shared/field.cl"
#include "shared/screen.cl"

// What a slice shows, `shows` of SliceParams; otherwise the colours of the table.
#define SHOWS_VALUES 0
#define SHOWS_GREY 1

// Premultiplied colour of a value.
static inline void slice_color(const SliceParams *p, const SampleParams *sample, __global const float4 *table, realv value, realv *color) {
    if (p->shows == SHOWS_VALUES) {
        color[0] = value, color[1] = (realv)(0.0f), color[2] = (realv)(0.0f), color[3] = (realv)(1.0f);
    } else if (p->shows == SHOWS_GREY) {
        color[0] = CLAMP((value - p->black) * p->per_value, (realv)(0.0f), (realv)(1.0f));
        color[1] = color[0], color[2] = color[0], color[3] = (realv)(1.0f);
    } else {
        realv extinction;
        table_entries(table, table_index(sample, value), &color[0], &color[1], &color[2], &extinction);
        color[3] = absorbed(extinction * p->thickness);
        for (int i = 0; i < 3; i++)
            color[i] *= color[3];
    }
}

__kernel void slice(__global const VOXEL *voxels, VolumeView view, __global const float4 *table, ScreenParams s, SliceParams p,
                    SampleParams sample, __global float4 *frame, ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= s.tiles_u * s.tiles_v)
        return;
    voxels += view.first;
    const int column = id % s.tiles_u * VW, row = id / s.tiles_u * TILE_ROWS;
    for (int r = row; r < min(row + TILE_ROWS, s.height); r++) {
        const RowRays rays = row_rays(&s, column, r);
        const realv u = rays.o[0], v = rays.o[1], a = rays.o[2];
        const intv needed = u >= -0.5f && u <= view.dims_u - 0.5f && v >= -0.5f && v <= view.dims_v - 0.5f && a >= -0.5f &&
                            a <= view.dims_a - 0.5f;
        realv color[4] = {(realv)(0.0f), (realv)(0.0f), (realv)(0.0f), (realv)(0.0f)};
        if (ANY(needed)) {
            realv value = value_at(voxels, &view, u, v, a, needed);
#if KERNEL == GAUSSIAN
            // Its weights do not sum to one exactly.
            value = CLAMP(value, (realv)(sample.field.least), (realv)(sample.field.largest));
#endif
            slice_color(&p, &sample, table, value, color);
            for (int i = 0; i < 4; i++)
                color[i] = needed ? color[i] : (realv)(0.0f);
        }
        store_colors(color, columns_on_screen(&s, column), 1, frame + (size_t)r * s.width + column);
    }
}
