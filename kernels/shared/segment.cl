// A segment between two samples of the reconstructed field, cut to the part that counts and taken as the blend mode will have it.

#include "shared/dimmed_segment.cl"

// Samples of a layer. Where a program knows that it is one, each lies in the plane of a layer.
#ifdef WHOLE_LAYERS
#define SAMPLES_PER_LAYER(p) 1
#else
#define SAMPLES_PER_LAYER(p) ((p)->segments.inner_slabs)
#endif

#if GATHERS_VALUES
// Takes the part of a segment between two values. Where it is cut the field itself tells the value: it bends at the outer voxels.
ALWAYS_INLINE void take_values(__global const VOXEL *voxels, const VolumeView *view, const Part *part, const Way *way, realv length,
                               Accumulator *a, intv *active) {
    realv from = way->from, to = way->to;
    if (any_cut(part)) {
        const intv counts = part->from < part->to;
        from = part->from > 0.0f ? value_on(voxels, view, way, part->from, counts) : from;
        to = part->to < 1.0f ? value_on(voxels, view, way, part->to, counts) : to;
    }
    accumulate_values(from, to, length, a, active);
}
#endif

#if BLEND == ISO
// Steps of false position on the reconstructed field: three leave one ray in a hundred lit by a tenth too much or too little. An end that
// stays where it is counts half (Dowell & Jarratt 1971): where the field bends, it would hold all steps on the other side.
#define REFINEMENTS 5

// Takes a segment of an iso-surface: where the value between its ends crosses the iso value; REFINED: where the field itself does. It counts
// if that lies in the part that does.
ALWAYS_INLINE void take_crossing(__global const VOXEL *voxels, const VolumeView *view, const SampleParams *p, const Part *part,
                                 const Way *way, const Lit *lit_front, const Lit *lit_back, Accumulator *a, intv *active) {
    const ClassificationParams *c = &p->classification;
    const realv from = way->from, to = way->to;
    intv crosses =
        part->from < part->to && a->t > 0.5f && ((from < c->iso && to >= c->iso) || (from >= c->iso && to < c->iso));
    if (!ANY(crosses))
        return;
    realv t = (c->iso - from) / (crosses ? to - from : (realv)(1.0f));
    t = CLAMP(t, (realv)(0.0f), (realv)(1.0f));
    Lighting lighting;
#ifdef REFINED
    realv near = 0.0f, far = 1.0f, at_near = from - c->iso, at_far = to - c->iso;
    intv near_stayed = 0, far_stayed = 0;
    for (int i = 0; i < REFINEMENTS; i++) {
        const realv at = value_on(voxels, view, way, t, crosses) - c->iso;
        const intv before = (at_near < 0.0f) == (at < 0.0f);
        near = before ? t : near, at_near = before ? at : near_stayed ? 0.5f * at_near : at_near;
        far = before ? far : t, at_far = before ? (far_stayed ? 0.5f * at_far : at_far) : at;
        near_stayed = !before, far_stayed = before;
        const realv span = at_far - at_near;
        t = near + (far - near) * CLAMP(-at_near / (span == 0.0f ? (realv)(1.0f) : span), (realv)(0.0f), (realv)(1.0f));
    }
    if (p->light.shading) {
        const Point point = point_on(way, t);
        Gradient gradient;
        gradient_at(voxels, view, point.u, point.v, point.a, crosses, &gradient.u, &gradient.v, &gradient.a);
        lighting = shade(p, point, (realv)(c->iso), gradient);
    }
#else
    if (p->light.shading)
        lighting = light_on(p, lit_front, lit_back, t);
#endif
    crosses &= t >= part->from && t <= part->to;
    *active += COUNT_IF(crosses);
#ifdef DEPTHS
    const realv crossing = a->from + t * a->way;
    is_between(crossing, crossing, a);
#endif
    accumulate_lit(p, (realv)(c->iso_r), (realv)(c->iso_g), (realv)(c->iso_b), CONVERT_REALV(COUNT_IF(crosses)), &lighting, a);
}
#endif
