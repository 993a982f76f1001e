// Pre-integrated classification: colour and opacity of the stretch between two samples of a ray.
//
// Between the samples the value is taken to change evenly (Engel et al. 2001); or, CURVED, but for the share of a stretch that
// it spends at its ends: between layers the field rises as 3t^2 - 2t^3 and stays longer near them (stretch_ends() in
// src/layers). integrals[i] = (R, G, B, T): extinction times colour, and extinction, integrated from the first value to node i,
// in whole numbers of one unit: a difference of two nodes is exact, so its quotient by the distance is the mean over
// the stretch. Behind all nodes, table_last + 1 of them, stand the same four at each node, as floats. Light lost inside a
// stretch does not dim its colour. Nodes of samples alternate between even and odd ones along the ray: no stretch is
// empty, so nothing is divided by 0, and each sample is looked up once for both stretches it ends.

// A sample's place in the table.
typedef struct {
    intv index, r, g, b, extinction; // integrals
#ifdef CURVED
    realv at_r, at_g, at_b, at_extinction;
#endif
} Node;

// The nearest even or odd node, one of the two that the value lies between.
inline intv node_index(const SampleParams *p, realv value, int odd) {
    const realv x = (value - p->table_first) * (0.5f * p->table_per_value) + (odd ? 0.0f : 0.5f);
    return 2 * CONVERT_INTV(CLAMP(x, (realv)(0.0f), (realv)((p->table_last - odd) / 2))) + odd;
}

ALWAYS_INLINE Node node_of(const SampleParams *p, __global const int4 *integrals, realv value, int odd) {
    Node node;
    node.index = node_index(p, value, odd);
    realv r, g, b, extinction;
    table_entries((__global const float4 *)integrals, node.index, &r, &g, &b, &extinction);
    node.r = AS_INTV(r), node.g = AS_INTV(g), node.b = AS_INTV(b), node.extinction = AS_INTV(extinction);
#ifdef CURVED
    table_entries((__global const float4 *)integrals + p->table_last + 1, node.index, &node.at_r, &node.at_g, &node.at_b,
                  &node.at_extinction);
#endif
    return node;
}

// What lies between two samples: differences of the table's columns, in nodes, and their distance in nodes.
typedef struct {
    realv r, g, b, extinction, distance;
} Stretch;

// Beyond the table its first and last entry go on. One sample beyond it and one in it or beyond the other end: the
// entry's share is added. Both beyond one end: the nodes are right as they are.
inline void extend_stretch(const SampleParams *p, __global const int4 *integrals, realv from, realv to, Stretch *stretch) {
    const realv last = p->table_last;
    const realv x0 = (from - p->table_first) * p->table_per_value, x1 = (to - p->table_first) * p->table_per_value;
    const realv below = MIN(x1, (realv)(0.0f)) - MIN(x0, (realv)(0.0f));
    const realv above = MAX(x1 - last, (realv)(0.0f)) - MAX(x0 - last, (realv)(0.0f));
    const realv distance = stretch->distance + below + above;
    const realv inner = MAX(x0, x1) <= 0.0f || MIN(x0, x1) >= last || fabs(distance) < 0.5f ? (realv)(0.0f) : (realv)(1.0f);
    const float4 first_entry = as_float4(integrals[p->table_last + 1]);
    const float4 last_entry = as_float4(integrals[2 * p->table_last + 1]);
    stretch->r += inner * (below * first_entry.x + above * last_entry.x);
    stretch->g += inner * (below * first_entry.y + above * last_entry.y);
    stretch->b += inner * (below * first_entry.z + above * last_entry.z);
    stretch->extinction += inner * (below * first_entry.w + above * last_entry.w);
    stretch->distance += inner * (below + above);
}

// `from` and `to`: the values at the two nodes; `ends`: weights of front and back. TABLE_CUT: values can lie beyond the table.
// (As a variable it costs all tables 5 %.)
ALWAYS_INLINE Stretch stretch_between(const SampleParams *p, __global const int4 *integrals, const Node *front,
                                      const Node *back, realv from, realv to, float2 ends) {
    Stretch stretch;
    stretch.r = CONVERT_REALV(back->r - front->r);
    stretch.g = CONVERT_REALV(back->g - front->g);
    stretch.b = CONVERT_REALV(back->b - front->b);
    stretch.extinction = CONVERT_REALV(back->extinction - front->extinction);
    stretch.distance = CONVERT_REALV(back->index - front->index);
#ifdef TABLE_CUT
    extend_stretch(p, integrals, from, to, &stretch);
#endif
#ifdef CURVED
    const float even = 1.0f - ends.x - ends.y;
    const realv of_front = ends.x * stretch.distance, of_back = ends.y * stretch.distance;
    stretch.r = even * stretch.r + (of_front * front->at_r + of_back * back->at_r);
    stretch.g = even * stretch.g + (of_front * front->at_g + of_back * back->at_g);
    stretch.b = even * stretch.b + (of_front * front->at_b + of_back * back->at_b);
    stretch.extinction = even * stretch.extinction + (of_front * front->at_extinction + of_back * back->at_extinction);
#endif
    return stretch;
}

// Weights of front and back of the stretch from sub-layer l0 to l1.
inline float2 ends_of(const SampleParams *p, int l0, int l1) {
    const float *ends = p->ends[min(l0, l1) % p->inner_slabs];
    return l0 < l1 ? (float2)(ends[0], ends[1]) : (float2)(ends[1], ends[0]);
}

// Composites one stretch. `dt` is its length times the table's unit. `inside` is 0 where the ray is beside the field's
// support, else 1.
ALWAYS_INLINE void composite_stretch(const SampleParams *p, const Stretch *s, realv dt, realv inside,
                                     const Lighting *lighting, Light *light, intv *active) {
    // One division for two. Where there is no extinction there is no colour either: any divisor does.
    const realv divisor = s->extinction == 0.0f ? (realv)(1.0f) : s->extinction;
    const realv inverse = 1.0f / (s->distance * divisor);
    const realv depth = s->extinction * (divisor * inverse * dt), share = s->distance * inverse;
    const realv opacity = opacity_of_depth(p, depth) * inside;
    *active += COUNT_IF(opacity > 0.0f);
    composite(p, s->r * share, s->g * share, s->b * share, opacity, lighting, light);
}
