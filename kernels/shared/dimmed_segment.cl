// Subdivision of optically deep segments. Absorption inside a segment dims what lies behind it, so with several hues the mean colour over
// its values is wrong. DIMMED: deep segments are composited in subsegments between values of the field itself (field.cl).

#include "shared/preintegration.cl"

#if BLEND == COMPOSITE

#ifdef DIMMED
// Optical depth above which a segment is subdivided, depth of a subsegment, and the largest number of them.
#define SUBDIVISION_DEPTH 0.3f
#define SUBSEGMENT_DEPTH 0.3f
#define MAX_SUBSEGMENTS 32
// A subsegment counts as opaque if the whole segment at its extinction would exceed this depth. Tables are cut off at OPAQUE_DEPTH of
// src/host/transfer/integrals.rs.
#define OPAQUE_DEPTH 12.0f
#endif

#ifdef DIMMED
// The number of subsegments grows with the depth and need not be whole, which avoids discontinuities; the last one is shorter.
static inline void composite_subsegments(__global const VOXEL *voxels, const VolumeView *view, const SampleParams *p,
                                         const ShadingSource *shading, __global const int4 *integrals, const RaySpan *span,
                                         const Part *part, intv lanes, realv depth, realv dt, const LitSample *lit_front,
                                         const LitSample *lit_back, Accumulator *a) {
    const realv step = reciprocal(CLAMP(depth * (1.0f / SUBSEGMENT_DEPTH), (realv)(2.0f), (realv)(MAX_SUBSEGMENTS)));
    realv t = lanes ? (realv)(0.0f) : (realv)(1.0f);
    realv value = value_on_span(voxels, view, span, SEGMENT_PARAMETER(part, (realv)(0.0f)), lanes);
    Node node = look_up_node(p, integrals, value, 0);
    for (int i = 1; i <= MAX_SUBSEGMENTS && ANY(t < 1.0f && a->t > p->segments.opaque); i++) {
        const realv next_t = MIN(i * step, (realv)(1.0f));
        const realv next_value = value_on_span(voxels, view, span, SEGMENT_PARAMETER(part, next_t), lanes);
        const Node next = look_up_node(p, integrals, next_value, i & 1);
        const Difference d = difference_between(p, integrals, &node, &next, value, next_value);
        const realv per_extinction = reciprocal(d.extinction == 0.0f ? (realv)(1.0f) : d.extinction);
        const realv whole_depth = d.extinction * (dt * reciprocal(d.distance));
        const realv opacity = (whole_depth > OPAQUE_DEPTH ? (realv)(1.0f) : absorbed(whole_depth * (next_t - t)));
        Lighting lighting;
        if (p->light.shading)
            lighting = interpolate_lighting(p, lit_front, lit_back, SEGMENT_PARAMETER(part, 0.5f * (t + next_t)));
        realv r = d.r * per_extinction, g = d.g * per_extinction, b = d.b * per_extinction;
#ifdef TINTED
        mix_color(&shading->tint, point_on_span(span, SEGMENT_PARAMETER(part, 0.5f * (t + next_t))), &r, &g, &b);
#endif
        accumulate_lit(p, r, g, b, opacity, &lighting, a);
        t = next_t, value = next_value, node = next;
    }
}
#endif

// Composites one segment, subdivided if necessary. `dt`: length of the part inside the clip interval, times the table's unit.
ALWAYS_INLINE void composite_span(__global const VOXEL *voxels, const VolumeView *view, const SampleParams *p,
                                  const ShadingSource *shading, __global const int4 *integrals, const Segment *s, const Part *part,
                                  const RaySpan *span, realv dt, const LitSample *lit_front, const LitSample *lit_back, Accumulator *a,
                                  intv *active) {
#ifdef TINTED
    // Where the segment's visible light originates, as its lighting.
    Segment tinted = *s;
    if (ANY(s->depth > 0.0f))
        mix_color(&shading->tint, point_on_span(span, SEGMENT_PARAMETER(part, visible_origin(s, s->depth))), &tinted.r, &tinted.g,
                        &tinted.b);
    s = &tinted;
#endif
#ifdef DIMMED
    const Accumulator before = *a;
#endif
    composite_segment(p, s, part, opacity_of_depth(p, s->depth), lit_front, lit_back, a, active);
#ifdef DIMMED
    const intv deep = s->depth > SUBDIVISION_DEPTH;
    if (ANY(deep)) {
        Accumulator subdivided = before;
        composite_subsegments(voxels, view, p, shading, integrals, span, part, deep, s->depth, dt, lit_front, lit_back, &subdivided);
        a->r = deep ? subdivided.r : a->r;
        a->g = deep ? subdivided.g : a->g;
        a->b = deep ? subdivided.b : a->b;
        a->t = deep ? subdivided.t : a->t;
    }
#endif
}

#endif
