// Ray casting of a volume of colours: raycast.cl with the four fields of color_lattice.cl, whose ratio is the colour.

#include "rays/marching.cl"
#include "shared/field.cl"
#include "shared/accumulator.cl"
#include "shared/color_absorption.cl"

#if BLEND != COMPOSITE
#error "BLEND: volumes of colours are composited"
#endif

// The fields: extinction last.
typedef struct {
    __global const VOXEL *voxels[4];
    __global const uchar *visible;
    VolumeView view;
    ShadingSource shading;
    SampleParams sample;
} ColorFields;

// Composites a whole step at a point where it is `needed`, or a share of it. `length`: of the whole step.
ALWAYS_INLINE void accumulate_color(const ColorFields *f, const realv *point, intv needed, realv share, float length, Accumulator *a,
                                    intv *active) {
    const SampleParams *sample = &f->sample;
    const realv extinction = value_at(f->voxels[3], &f->view, point[0], point[1], point[2], needed);
    needed &= extinction > 0.0f;
    if (!ANY(needed))
        return;
    const realv per_extinction = reciprocal(needed ? extinction : (realv)(1.0f));
    realv color[3];
    for (int i = 0; i < 3; i++)
        color[i] = value_at(f->voxels[i], &f->view, point[0], point[1], point[2], needed) * per_extinction;
    const realv depth = needed ? color_absorption(sample, extinction) * length : (realv)(0.0f);
    const realv opacity = sample->classification.linear ? MIN(depth, (realv)(1.0f)) * share : absorbed(depth * share);
    *active += COUNT_IF(opacity > 0.0f);
    Lighting lighting;
    if (sample->light.shading) {
        const Point at = {point[0], point[1], point[2]};
        const Gradient gradient = gradient_at(&f->shading, &sample->field, point[0], point[1], point[2], needed);
        lighting = shade(sample, f->shading.light, at, extinction, gradient);
    }
    accumulate_lit(sample, color[0], color[1], color[2], opacity, &lighting, a);
}

// Marches one row of rays.
ALWAYS_INLINE void march_colors(const ColorFields *f, const MarchParams *p, const RowRays *rays, const Interval *interval,
                                Accumulator *gathered, intv *active) {
    const SampleParams *sample = &f->sample;
    const realv step = p->length / rays->length;
    const realv first = interval->from / step, last = interval->to / step;
    const intv hits = first < last;
    const int begin = (int)floor(smallest_lane(hits ? first : (realv)(INFINITY)));
    const int end = (int)ceil(largest_lane(hits ? last : (realv)(-INFINITY)));
    for (int n = begin; n < end; n++) {
        realv point[3];
        if (p->culling && (n - begin) % CHUNK == 0) {
            realv other[3];
            points_at(rays, (realv)(n) * step, point);
            points_at(rays, (realv)(n + CHUNK) * step, other);
            if (!box_visible(f->visible, p, &f->view, point, other)) {
                n += CHUNK - 1;
                continue;
            }
        }
        const float middle = n + 0.5f;
        points_at(rays, middle * step, point);
#ifdef CLIPPED
        const realv share = MAX(MIN(last, (realv)(n + 1.0f)) - MAX(first, (realv)(n)), (realv)(0.0f));
        intv needed = share > 0.0f;
#else
        const realv share = 1.0f;
        intv needed = middle >= first && middle < last;
#endif
        needed &= open_rays(sample, gathered);
        if (p->culling)
            needed &= cells_visible(f->visible, p, &f->view, point[0], point[1], point[2]);
        if (!ANY(needed))
            continue;
#ifdef DEPTHS
        set_depth_range(MAX(first, (realv)(n)) * step, MIN(last, (realv)(n + 1.0f)) * step, gathered);
#endif
        accumulate_color(f, point, needed, share, p->length, gathered, active);
        if (!ANY(hits && open_rays(sample, gathered)))
            break;
    }
}

__kernel void color_raycast(COLOR_FIELDS, ScreenParams s, MarchParams p, ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= s.tiles_u * s.tiles_v)
        return;
    voxels += view.first;
    const ShadingSource shading = SHADING_SOURCE;
    const ColorFields fields = {{red + view.first, green + view.first, blue + view.first, voxels}, visible, view, shading, sample};
    const int column = id % s.tiles_u * VW, row = id / s.tiles_u * TILE_ROWS;
    intv active = 0;
    for (int r = row; r < min(row + TILE_ROWS, s.height); r++) {
        const RowRays rays = row_rays(&s, column, r);
        const Interval interval = clip_rays(&ray_ends, rays.o, rays.d);
        Accumulator gathered = empty_accumulator(&sample);
        if (ANY(interval.from < interval.to))
            march_colors(&fields, &p, &rays, &interval, &gathered, &active);
        store_pixels(&s, &sample, 0, column, r, &gathered, &interval, target);
    }
    active_samples[id] = sum_lanes(active, columns_on_screen(&s, column));
}
