// Segments between two samples of the reconstructed field, cut to the clip interval and accumulated by blend mode. Programs with CHANNELS
// include shared/channel.cl before.

#include "shared/dimmed_segment.cl"

// Samples per layer. WHOLE_LAYERS: a program knows that it is one, so that each sample lies on a layer.
#ifdef WHOLE_LAYERS
#define SAMPLES_PER_LAYER(p) 1
#else
#define SAMPLES_PER_LAYER(p) ((p)->segments.inner_slabs)
#endif

#if GATHERS_VALUES
// Accumulates the part of a segment between two values. Where the segment is cut, the value is read from the field itself, which has a
// kink at the outer voxels.
ALWAYS_INLINE void accumulate_span(__global const VOXEL *voxels, const VolumeView *view, const Part *part, const RaySpan *span,
                                   realv length, Accumulator *a, intv *active) {
    realv from = span->from, to = span->to;
    if (any_clipped(part)) {
        const intv contributes = part->from < part->to;
        from = part->from > 0.0f ? value_on_span(voxels, view, span, part->from, contributes) : from;
        to = part->to < 1.0f ? value_on_span(voxels, view, span, part->to, contributes) : to;
    }
    accumulate_values(from, to, length, a, active);
}
#endif

#if BLEND == ISO
// Iterations of false position on the reconstructed field. With three, one ray in a hundred is lit wrongly by a tenth. An end that does
// not move is weighted by a half (Dowell & Jarratt 1971): otherwise a curved field keeps all iterations on the other side.
#define REFINEMENTS 5

// Accumulates an iso-surface: where the value interpolated between the ends crosses the iso value or, REFINED, where the field itself
// does. Crossings outside the part are ignored. `lit`: the span along the axes of the lights. `crossing`: receives the parameters of the
// span where it is crossed.
ALWAYS_INLINE void accumulate_crossing(__global const VOXEL *voxels, const VolumeView *view, const ShadingSource *shading,
                                      const SampleParams *p, const Part *part, const RaySpan *span, const RaySpan *lit,
                                      const LitSample *lit_front, const LitSample *lit_back, realv *crossing, Accumulator *a,
                                      intv *active) {
    const ClassificationParams *c = &p->classification;
    const realv from = span->from, to = span->to;
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
        const realv at = value_on_span(voxels, view, span, t, crosses) - c->iso;
        const intv before = (at_near < 0.0f) == (at < 0.0f);
        near = before ? t : near, at_near = before ? at : near_stayed ? 0.5f * at_near : at_near;
        far = before ? far : t, at_far = before ? (far_stayed ? 0.5f * at_far : at_far) : at;
        near_stayed = !before, far_stayed = before;
        const realv rise = at_far - at_near;
        t = near + (far - near) * CLAMP(-at_near / (rise == 0.0f ? (realv)(1.0f) : rise), (realv)(0.0f), (realv)(1.0f));
    }
    if (p->light.shading) {
        const Point point = point_on_span(span, t);
        Gradient gradient = gradient_at(shading, &p->field, point.u, point.v, point.a, crosses);
#ifdef CHANNELS
        gradient = along_frame(shading->place, gradient);
#endif
        lighting = shade(p, shading->light, point_on_span(lit, t), (realv)(c->iso), gradient);
    }
#else
    if (p->light.shading)
        lighting = interpolate_lighting(p, lit_front, lit_back, t);
#endif
    crosses &= t >= part->from && t <= part->to;
    *active += COUNT_IF(crosses);
    *crossing = crosses ? t : *crossing;
#ifdef DEPTHS
    const realv depth = a->from + t * a->span;
    set_depth_range(depth, depth, a);
#endif
    realv r = c->iso_r, g = c->iso_g, b = c->iso_b;
#ifdef TINTED
    mix_color(&shading->tint, point_on_span(span, t), &r, &g, &b);
#endif
    accumulate_lit(p, r, g, b, CONVERT_REALV(COUNT_IF(crosses)), &lighting, a);
}

ALWAYS_INLINE void accumulate_surface(__global const VOXEL *voxels, const VolumeView *view, const ShadingSource *shading,
                                      const SampleParams *p, const Part *part, const RaySpan *span, const LitSample *lit_front,
                                      const LitSample *lit_back, Accumulator *a, intv *active) {
    realv crossing;
    accumulate_crossing(voxels, view, shading, p, part, span, span, lit_front, lit_back, &crossing, a, active);
}
#endif
