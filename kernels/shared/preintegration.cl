// Pre-integrated classification: colour and opacity of the segment between two samples of a ray.
//
// The value is assumed to change linearly between the samples (Engel et al. 2001). CURVED: except for a share of the segment that it
// spends at its end values, since between layers the field follows 3t^2 - 2t^3 and stays near them longer (segment_ends() in src/host/layers).
//
// integrals[i] = (R, G, B, T): extinction times colour, and extinction, integrated from the first value to node i, as integers of one
// unit. Differences of two nodes are exact, so dividing by their distance gives the mean over the segment. The table_last + 1 nodes are
// followed by the same four quantities at each node, as floats, and preceded by the extinction cells.
//
// Absorption inside a segment dims its lighting, and its colour where DIMMED is set (dimmed_segment.cl). Samples along a ray alternate
// between even and odd nodes: no segment is empty, so there is no division by 0, and each sample is looked up once for both of its
// segments.

#include "shared/accumulator.cl"
#include "shared/integral_nodes.cl"
#include "shared/reconstruction.cl"
#include "shared/span_lighting.cl"

// WHOLE_LAYERS: segments extend from layer to layer. segment_ends() gives weights to the ends of shorter ones, of the cubic only.
#if BLEND == COMPOSITE && KERNEL == CUBIC && !defined(WHOLE_LAYERS)
#define CURVED
#endif

// Table entries of a sample.
typedef struct {
    intv index, r, g, b, extinction; // integrals
    realv at_extinction;
#ifdef CURVED
    realv at_r, at_g, at_b;
#endif
} Node;

// The extinction at the value of a node.
static inline realv extinction_at(__global const int4 *integrals, intv index) {
#ifdef GATHER_WORDS
    const intv bits = GATHER_WORDS(NODES(integrals), index * 16 + 12);
#else
    const intv at = index * 4 + 3;
    const intv bits = GATHER_AS(intv, (__global const int *)NODES(integrals), at);
#endif
    return AS_REALV(bits);
}

// The extinction near a value, linear within each cell. The cells fit in registers: gathering extinctions from the table costs Zen 4 a
// tenth of a frame.
static inline realv extinction_near(const SampleParams *p, __global const int4 *integrals, realv value) {
    // Cells per unit of value, and the cell coordinate of value 0.
    const float2 scale = as_float4(integrals[2 * EXTINCTION_CELLS / 4]).xy;
    const realv place = CLAMP(value * scale.x + scale.y, (realv)(0.0f), (realv)(EXTINCTION_CELLS - 1e-3f));
    const intv cell = CONVERT_INTV(place);
#ifdef PERMUTE
    const float *at = (const float *)(ulong)integrals;
    const realv first = PERMUTE(LOADV(at), LOADV(at + VW), cell);
    const realv to_next = PERMUTE(LOADV(at + EXTINCTION_CELLS), LOADV(at + EXTINCTION_CELLS + VW), cell);
#else
    __global const float *at = (__global const float *)integrals;
    const realv first = GATHER(at, cell), to_next = GATHER(at + EXTINCTION_CELLS, cell);
#endif
    return first + (place - CONVERT_REALV(cell)) * to_next;
}

// Whether any value between two contributes: it is visible and not in a gap of the table. An even and an odd node always differ.
static inline intv contributes_between(const SampleParams *p, __global const int4 *integrals, realv from, realv to) {
    intv contributes = is_visible_between(p, from, to);
#if BLEND == COMPOSITE
    const intv front = AS_INTV(extinction_at(integrals, node_index(p, from, 0)));
    intv any = front != AS_INTV(extinction_at(integrals, node_index(p, to, 1)));
    if (p->classification.cut) {
        const float first = p->classification.table_first, last = first + p->classification.table_last / p->classification.table_per_value;
        any |= MIN(from, to) < first && NODES(integrals)[p->classification.table_last + 1].w != 0;
        any |= MAX(from, to) > last && NODES(integrals)[2 * p->classification.table_last + 1].w != 0;
    }
    contributes = contributes && any;
#endif
    return contributes;
}

ALWAYS_INLINE Node look_up_node(const SampleParams *p, __global const int4 *integrals, realv value, int odd) {
    Node node;
    node.index = node_index(p, value, odd);
    realv r, g, b, extinction;
    table_entries((__global const float4 *)NODES(integrals), node.index, &r, &g, &b, &extinction);
    node.r = AS_INTV(r), node.g = AS_INTV(g), node.b = AS_INTV(b), node.extinction = AS_INTV(extinction);
#ifdef CURVED
    table_entries((__global const float4 *)NODES(integrals) + p->classification.table_last + 1, node.index, &node.at_r, &node.at_g,
                  &node.at_b, &node.at_extinction);
#elif defined(TINTED)
    // Colours of labels are looked up where the light of a segment originates, also without shading.
    node.at_extinction = extinction_near(p, integrals, value);
#else
    if (p->light.shading)
        node.at_extinction = extinction_near(p, integrals, value);
#endif
    return node;
}

// Differences of the integrals between two samples, and the distance of their nodes.
typedef struct {
    realv r, g, b, extinction, distance;
} Difference;

// Distance from the table, in nodes, at which samples count as far: a steep ramp beside a wide range of values would overflow otherwise.
#define FAR_FROM_TABLE 1e12f

// Beyond the table its first and last entries apply. If one sample is outside and the other inside or beyond the other end, the entry's
// share is added. If both are beyond the same end, the differences are right already.
static inline void extend_difference(const SampleParams *p, __global const int4 *integrals, realv from, realv to, Difference *d) {
    const realv last = p->classification.table_last;
    const float first = p->classification.table_first, per_value = p->classification.table_per_value;
    const realv x0 = CLAMP((from - first) * per_value, (realv)(-FAR_FROM_TABLE), (realv)(FAR_FROM_TABLE));
    const realv x1 = CLAMP((to - first) * per_value, (realv)(-FAR_FROM_TABLE), (realv)(FAR_FROM_TABLE));
#if VW == 1
    // Both inside the table, and neither is NaN.
    if (x0 >= 0.0f && x0 <= last && x1 >= 0.0f && x1 <= last)
        return;
#endif
    const realv below = MIN(x1, (realv)(0.0f)) - MIN(x0, (realv)(0.0f));
    const realv above = MAX(x1 - last, (realv)(0.0f)) - MAX(x0 - last, (realv)(0.0f));
    const realv distance = d->distance + below + above;
    const realv inner = MAX(x0, x1) <= 0.0f || MIN(x0, x1) >= last || fabs(distance) < 0.5f ? (realv)(0.0f) : (realv)(1.0f);
    const float4 first_entry = as_float4(NODES(integrals)[p->classification.table_last + 1]);
    const float4 last_entry = as_float4(NODES(integrals)[2 * p->classification.table_last + 1]);
    d->r += inner * (below * first_entry.x + above * last_entry.x);
    d->g += inner * (below * first_entry.y + above * last_entry.y);
    d->b += inner * (below * first_entry.z + above * last_entry.z);
    d->extinction += inner * (below * first_entry.w + above * last_entry.w);
    d->distance += inner * (below + above);
}

ALWAYS_INLINE Difference difference_between(const SampleParams *p, __global const int4 *integrals, const Node *front,
                                            const Node *back, realv from, realv to) {
    Difference d;
    d.r = CONVERT_REALV(back->r - front->r);
    d.g = CONVERT_REALV(back->g - front->g);
    d.b = CONVERT_REALV(back->b - front->b);
    d.extinction = CONVERT_REALV(back->extinction - front->extinction);
    d.distance = CONVERT_REALV(back->index - front->index);
    if (p->classification.cut)
        extend_difference(p, integrals, from, to, &d);
    return d;
}

// Integrated segment: mean colour, optical depth, and the mean position of the extinction along the segment, 0 ... 1.
typedef struct {
    realv r, g, b, depth, centroid;
} Segment;

// `from`, `to`: values at the two nodes. `ends`: weights of the front and back values. `dt`: length times the table's unit.
ALWAYS_INLINE Segment segment_between(const SampleParams *p, __global const int4 *integrals, const Node *front,
                                      const Node *back, realv from, realv to, float2 ends, realv dt) {
    Difference d = difference_between(p, integrals, front, back, from, to);
    // Centroid of the parabola with the same extinction at both ends and the same mean.
    realv moment = 0.5f * d.extinction + 0.0833333f * d.distance * (back->at_extinction - front->at_extinction);
#ifdef CURVED
    const float even = 1.0f - ends.x - ends.y;
    const realv weight_front = ends.x * d.distance, weight_back = ends.y * d.distance;
    moment = even * moment + weight_back * back->at_extinction;
    d.r = even * d.r + (weight_front * front->at_r + weight_back * back->at_r);
    d.g = even * d.g + (weight_front * front->at_g + weight_back * back->at_g);
    d.b = even * d.b + (weight_front * front->at_b + weight_back * back->at_b);
    d.extinction = even * d.extinction + (weight_front * front->at_extinction + weight_back * back->at_extinction);
#endif
    // One division instead of two. Where the extinction is 0 the colour is too, and any divisor will do.
    const realv divisor = d.extinction == 0.0f ? (realv)(1.0f) : d.extinction;
    const realv inverse = reciprocal(d.distance * divisor), per_extinction = d.distance * inverse;
    Segment s;
    s.r = d.r * per_extinction, s.g = d.g * per_extinction, s.b = d.b * per_extinction;
    s.depth = d.extinction * (divisor * inverse * dt);
    s.centroid = CLAMP(moment * per_extinction, (realv)(0.0f), (realv)(1.0f));
    return s;
}

// Weights of the front and back values of the segment from sub-layer l0 to l1.
static inline float2 end_weights(const SampleParams *p, int l0, int l1) {
    const float *ends = p->segments.ends + 2 * (min(l0, l1) % p->segments.inner_slabs);
    return l0 < l1 ? (float2)(ends[0], ends[1]) : (float2)(ends[1], ends[0]);
}

// How far the visible light of a homogeneous segment originates in front of its middle, as a fraction of its length: 1/2 - 1/d + 1/(e^d -
// 1) for optical depth d; within 0.05, and 0.003 up to a depth of 2.
static inline realv shift_to_front(realv depth) {
    return depth * (1.0f + 0.1f * depth) * rough_reciprocal(12.0f + depth * (1.41f + 0.2f * depth));
}

// Where along a segment its visible light originates, 0 ... 1, if its whole optical depth is `depth`. The nearer the extinction is to one
// end, the less of it is dimmed by the rest.
static inline realv visible_origin(const Segment *s, realv depth) {
    const realv spread = 4.0f * s->centroid * (1.0f - s->centroid);
    const realv unclamped = s->centroid - spread * shift_to_front(depth);
    // Clamped to the front, beyond which no lighting is known; this happens in deep segments with most extinction near the front.
    return MAX(unclamped, (realv)(0.0f));
}

#if BLEND == COMPOSITE
// Composites one segment, of which `part` is inside the clip interval.
ALWAYS_INLINE void composite_segment(const SampleParams *p, const Segment *s, const Part *part, realv opacity, const LitSample *front,
                                     const LitSample *back, Accumulator *a, intv *active) {
    *active += COUNT_IF(opacity > 0.0f);
    Lighting lighting;
    if (p->light.shading) {
        lighting = interpolate_lighting(p, front, back, SEGMENT_PARAMETER(part, visible_origin(s, s->depth)));
#ifdef THINNED
        lighting.extinction_scale = extinction_scale_on_span(front, back, SEGMENT_PARAMETER(part, s->centroid));
#endif
    }
    accumulate_lit(p, s->r, s->g, s->b, opacity, &lighting, a);
}
#endif
