// Deep stretches through several hues: light lost inside dims what lies behind it, so that the colour is none that a mean over
// the values can tell. DIMMED: they are composited in parts, each with the field's own values at its ends (field.cl).

#ifdef DIMMED
// Optical depth from which on a stretch is cut into parts, and that of a part; more than MOST_PARTS are not made.
#define DEEP 0.3f
#define PART_DEPTH 0.3f
#define MOST_PARTS 32
// Depth that the whole stretch would have from which on a part is opaque: tables are cut off at OPAQUE_DEPTH of
// src/transfer/integrals.rs.
#define OPAQUE_PART 12.0f
#endif

// A ray from one sample to the next: a place of the one, and the step to the other, in voxels.
typedef struct {
    realv place[3], step[3];
} Way;

#ifdef DIMMED
// The deeper a stretch, the more parts: their number need not be whole, so that nothing jumps; the last one is cut off.
inline void composite_parts(__global const VOXEL *voxels, const VolumeView *view, const SampleParams *p,
                            __global const int4 *integrals, const Way *way, intv lanes, realv depth, realv dt, realv inside,
                            const Lighting *lit_front, const Lighting *lit_back, Light *light) {
    const realv step = reciprocal(CLAMP(depth * (1.0f / PART_DEPTH), (realv)(2.0f), (realv)(MOST_PARTS)));
    realv t = lanes ? (realv)(0.0f) : (realv)(1.0f);
    realv value = value_at(voxels, view, way->place[0], way->place[1], way->place[2], lanes);
    Node node = node_of(p, integrals, value, 0);
    for (int i = 1; i <= MOST_PARTS && ANY(t < 1.0f && light->t > p->opaque); i++) {
        const realv next_t = MIN(i * step, (realv)(1.0f));
        const realv next_value = value_at(voxels, view, way->place[0] + next_t * way->step[0],
                                          way->place[1] + next_t * way->step[1], way->place[2] + next_t * way->step[2], lanes);
        const Node next = node_of(p, integrals, next_value, i & 1);
        const Difference d = difference_between(p, integrals, &node, &next, value, next_value);
        const realv per_extinction = reciprocal(d.extinction == 0.0f ? (realv)(1.0f) : d.extinction);
        const realv whole = d.extinction * (dt * reciprocal(d.distance));
        const realv opacity = (whole > OPAQUE_PART ? (realv)(1.0f) : absorbed(whole * (next_t - t))) * inside;
        Lighting lighting;
        if (p->shading)
            lighting = mix_lighting(p, lit_front, lit_back, 0.5f * (t + next_t));
        composite(p, d.r * per_extinction, d.g * per_extinction, d.b * per_extinction, opacity, &lighting, light);
        t = next_t, value = next_value, node = next;
    }
}
#endif

// Composites one stretch, of length `dt` times the table's unit, in parts where it must. `inside` is 0 where the ray is beside the
// field's support, else 1.
ALWAYS_INLINE void composite_way(__global const VOXEL *voxels, const VolumeView *view, const SampleParams *p,
                                 __global const int4 *integrals, const Stretch *s, const Way *way, realv dt, realv inside,
                                 const Lighting *lit_front, const Lighting *lit_back, Light *light, intv *active) {
#ifdef DIMMED
    const Light before = *light;
#endif
    composite_stretch(p, s, opacity_of_depth(p, s->depth) * inside, lit_front, lit_back, light, active);
#ifdef DIMMED
    const intv deep = s->depth > DEEP;
    if (ANY(deep)) {
        Light in_parts = before;
        composite_parts(voxels, view, p, integrals, way, deep, s->depth, dt, inside, lit_front, lit_back, &in_parts);
        light->r = deep ? in_parts.r : light->r;
        light->g = deep ? in_parts.g : light->g;
        light->b = deep ? in_parts.b : light->b;
        light->t = deep ? in_parts.t : light->t;
    }
#endif
}
