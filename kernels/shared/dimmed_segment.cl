// Deep segments through several hues: light lost inside dims what lies behind it, so that the colour is none that a mean over
// the values can tell. DIMMED: they are composited in parts, each with the field's own values at its ends (field.cl).

#include "shared/preintegration.cl"

#if BLEND == COMPOSITE

#ifdef DIMMED
// Optical depth from which on a segment is cut into parts, and that of a part; more than MOST_PARTS are not made.
#define DEEP 0.3f
#define PART_DEPTH 0.3f
#define MOST_PARTS 32
// Depth that the whole segment would have from which on a part is opaque: tables are cut off at OPAQUE_DEPTH of
// src/transfer/integrals.rs.
#define OPAQUE_PART 12.0f
#endif

#ifdef DIMMED
// The deeper a segment, the more parts: their number need not be whole, so that nothing jumps; the last one is cut off.
static inline void composite_parts(__global const VOXEL *voxels, const VolumeView *view, const SampleParams *p,
                            __global const int4 *integrals, const Way *way, const Part *part, intv lanes, realv depth, realv dt,
                            const Lit *lit_front, const Lit *lit_back, Accumulator *a) {
    const realv step = reciprocal(CLAMP(depth * (1.0f / PART_DEPTH), (realv)(2.0f), (realv)(MOST_PARTS)));
    realv t = lanes ? (realv)(0.0f) : (realv)(1.0f);
    realv value = value_on(voxels, view, way, IN_PART(part, (realv)(0.0f)), lanes);
    Node node = node_of(p, integrals, value, 0);
    for (int i = 1; i <= MOST_PARTS && ANY(t < 1.0f && a->t > p->segments.opaque); i++) {
        const realv next_t = MIN(i * step, (realv)(1.0f));
        const realv next_value = value_on(voxels, view, way, IN_PART(part, next_t), lanes);
        const Node next = node_of(p, integrals, next_value, i & 1);
        const Difference d = difference_between(p, integrals, &node, &next, value, next_value);
        const realv per_extinction = reciprocal(d.extinction == 0.0f ? (realv)(1.0f) : d.extinction);
        const realv whole = d.extinction * (dt * reciprocal(d.distance));
        const realv opacity = (whole > OPAQUE_PART ? (realv)(1.0f) : absorbed(whole * (next_t - t)));
        Lighting lighting;
        if (p->light.shading)
            lighting = light_on(p, lit_front, lit_back, IN_PART(part, 0.5f * (t + next_t)));
        accumulate_lit(p, d.r * per_extinction, d.g * per_extinction, d.b * per_extinction, opacity, &lighting, a);
        t = next_t, value = next_value, node = next;
    }
}
#endif

// Composites one segment, in parts of its own where it must. `dt`: the length of the part that counts, times the table's unit.
ALWAYS_INLINE void composite_way(__global const VOXEL *voxels, const VolumeView *view, const SampleParams *p,
                                 __global const int4 *integrals, const Segment *s, const Part *part, const Way *way, realv dt,
                                 const Lit *lit_front, const Lit *lit_back, Accumulator *a, intv *active) {
#ifdef DIMMED
    const Accumulator before = *a;
#endif
    composite_segment(p, s, part, opacity_of_depth(p, s->depth), lit_front, lit_back, a, active);
#ifdef DIMMED
    const intv deep = s->depth > DEEP;
    if (ANY(deep)) {
        Accumulator in_parts = before;
        composite_parts(voxels, view, p, integrals, way, part, deep, s->depth, dt, lit_front, lit_back, &in_parts);
        a->r = deep ? in_parts.r : a->r;
        a->g = deep ? in_parts.g : a->g;
        a->b = deep ? in_parts.b : a->b;
        a->t = deep ? in_parts.t : a->t;
    }
#endif
}

#endif
