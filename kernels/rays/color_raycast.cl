// Ray casting of a volume of colours: raycast.cl with the fields of color_lattice.cl, whose ratio is the colour.

#include "rays/steps.cl"
#include "shared/field.cl"
#include "shared/accumulator.cl"
#include "shared/color_absorption.cl"

#if BLEND != COMPOSITE
#error "BLEND: volumes of colours are composited"
#endif

// The fields.
struct Marched {
    __global const VOXEL *voxels[FIELDS];
    __global const uchar *visible;
    VolumeView view;
    ShadingSource shading;
    SampleParams sample;
    LabelParams labels;
};

ALWAYS_INLINE bool box_shows(struct Marched *m, const MarchParams *p, const realv *one, const realv *other) {
    return box_visible(m->visible, p->blocks_u, p->blocks_v, &m->view, one, other);
}

ALWAYS_INLINE intv points_show(const struct Marched *m, const MarchParams *p, const realv *point, intv needed) {
    return cells_visible(m->visible, p->blocks_u, p->blocks_v, &m->view, point[0], point[1], point[2]);
}

ALWAYS_INLINE void accumulate_step(const struct Marched *m, const MarchParams *p, int n, const realv *point, intv needed, realv share,
                                   realv step, Accumulator *gathered, intv *active) {
    const SampleParams *sample = &m->sample;
    const realv shaded = value_at(m->voxels[SHADED], &m->view, point[0], point[1], point[2], needed);
    needed &= shaded > 0.0f;
    if (!ANY(needed))
        return;
    const realv per_shaded = reciprocal(needed ? shaded : (realv)(1.0f));
    realv color[3];
    for (int i = 0; i < 3; i++)
        color[i] = LIT_COLOR(value_at(m->voxels[i], &m->view, point[0], point[1], point[2], needed) * per_shaded);
#ifdef LABELS
#ifdef VARIED_OPACITIES
    const realv second = value_at(m->voxels[SECOND], &m->view, point[0], point[1], point[2], needed);
    const realv third = value_at(m->voxels[THIRD], &m->view, point[0], point[1], point[2], needed);
#else
    const realv second = m->labels.most * shaded, third = m->labels.most * second;
#endif
    const LabelOpacity of_unit = label_opacity(&m->labels, shaded, second, third);
    const realv unit_opacity = needed ? of_unit.at_point : (realv)(0.0f);
    const realv opacity = sample->classification.linear ? MIN(unit_opacity * p->length, (realv)(1.0f)) * share
                                                        : 1.0f - general_power(1.0f - unit_opacity, p->length * share);
#else
    const realv depth = needed ? color_absorption(sample, shaded) * p->length : (realv)(0.0f);
    const realv opacity = sample->classification.linear ? MIN(depth, (realv)(1.0f)) * share : absorbed(depth * share);
#endif
    *active += COUNT_IF(opacity > 0.0f);
    Lighting lighting;
    if (sample->light.shading) {
        const Point at = {point[0], point[1], point[2]};
        const Gradient gradient = gradient_at(&m->shading, &sample->field, point[0], point[1], point[2], needed);
        lighting = shade(sample, m->shading.light, at, shaded, gradient);
#ifdef LABELS
        light_label(of_unit, value_at(m->voxels[SMOOTHED_OPACITY], m->shading.view, point[0], point[1], point[2], needed), &lighting);
#endif
    }
    accumulate_lit(sample, color[0], color[1], color[2], opacity, &lighting, gathered);
}

__kernel void color_raycast(COLOR_FIELDS, ScreenParams s, MarchParams p, ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= s.tiles_u * s.tiles_v)
        return;
    voxels += view.first;
    const ShadingSource shading = SHADING_SOURCE;
    struct Marched fields = {FIELD_VOXELS, visible, view, shading, sample, labels};
    const int column = id % s.tiles_u * VW, row = id / s.tiles_u * TILE_ROWS;
    intv active = 0;
    for (int r = row; r < min(row + TILE_ROWS, s.height); r++) {
        const RowRays rays = row_rays(&s, column, r);
        const Interval interval = SCREEN_INTERVAL(&s, &ray_ends, &rays, column, r);
        Accumulator gathered = empty_accumulator(&sample);
        if (ANY(interval.from < interval.to))
            march_steps(&fields, &sample, &p, &rays, &interval, &gathered, &active);
        store_pixels(&s, &sample, 0, column, r, &gathered, &interval, target);
    }
    active_samples[id] = sum_lanes(active, columns_on_screen(&s, column));
}
