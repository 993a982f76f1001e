// Segments of a volume of colours, whose fields are linear between two samples.

// Values of the four fields in a patch, `t` of the way from one sample to the next.
static inline void colors_between(const Layer *front, const Layer *back, int n, realv t, realv *color) {
    for (int i = 0; i < 4; i++)
        color[i] = lerp(front[i].at.field[n], back[i].at.field[n], t);
}

// With linear extinction, absorption is of the opacity: scales the four values to it.
static inline void scale_to_absorption(const SampleParams *p, realv *color) {
    if (!p->classification.linear)
        return;
    const realv scale = color_absorption(p, color[3]) * reciprocal(color[3] > 0.0f ? color[3] : (realv)(1.0f));
    for (int i = 0; i < 4; i++)
        color[i] *= scale;
}

// The segment between two of these. `ends`: weights of the front and back values; `length` in unit distances.
static inline Segment color_segment(const realv *front, const realv *back, float2 ends, realv length) {
    const float even = 0.5f * (1.0f - ends.x - ends.y), weight_front = even + ends.x, weight_back = even + ends.y;
    const realv extinction = weight_front * front[3] + weight_back * back[3];
    const realv per_extinction = reciprocal(extinction > 0.0f ? extinction : (realv)(1.0f));
    Segment s;
    s.r = LIT_COLOR((weight_front * front[0] + weight_back * back[0]) * per_extinction);
    s.g = LIT_COLOR((weight_front * front[1] + weight_back * back[1]) * per_extinction);
    s.b = LIT_COLOR((weight_front * front[2] + weight_back * back[2]) * per_extinction);
    s.depth = extinction * length;
    const realv both = front[3] + back[3];
    s.centroid = both > 0.0f ? 0.3333333f * (1.0f + back[3] * reciprocal(both > 0.0f ? both : (realv)(1.0f))) : (realv)(0.5f);
    return s;
}

// Composites a segment, in parts that dim each other where it is deep.
static inline void composite_colors(const SampleParams *p, const LabelParams *labels, const Layer *front, const Layer *back, int n, const Part *part, float2 ends,
                                    realv length, Accumulator *a, intv *active) {
    const LitSample *lit_front = &front[3].at.lit[n], *lit_back = &back[3].at.lit[n];
    realv from[4], to[4];
    colors_between(front, back, n, SEGMENT_PARAMETER(part, (realv)(0.0f)), from);
    colors_between(front, back, n, SEGMENT_PARAMETER(part, (realv)(1.0f)), to);
    scale_to_absorption(p, from);
    scale_to_absorption(p, to);
    const Segment whole = color_segment(from, to, ends, length);
    const Accumulator before = *a;
    composite_segment(p, &whole, part, opacity_of_depth(p, whole.depth), lit_front, lit_back, a, active);
    const intv deep = whole.depth > SUBDIVISION_DEPTH && !p->classification.linear;
    if (!ANY(deep))
        return;
    Accumulator subdivided = before;
    const realv step = reciprocal(CLAMP(whole.depth * (1.0f / SUBSEGMENT_DEPTH), (realv)(2.0f), (realv)(MAX_SUBSEGMENTS)));
    // The curve of the cubic changes the depth of the whole, which its parts share.
    const realv mean = 0.5f * (from[3] + to[3]);
    const realv scale = whole.depth * reciprocal(mean > 0.0f ? mean : (realv)(1.0f));
    realv t = deep ? (realv)(0.0f) : (realv)(1.0f);
    for (int i = 1; i <= MAX_SUBSEGMENTS && ANY(t < 1.0f && subdivided.t > p->segments.opaque); i++) {
        const realv next_t = MIN(i * step, (realv)(1.0f)), middle = 0.5f * (t + next_t);
        realv color[4];
        colors_between(front, back, n, SEGMENT_PARAMETER(part, middle), color);
        const realv per_extinction = reciprocal(color[3] > 0.0f ? color[3] : (realv)(1.0f));
        Lighting lighting;
        if (p->light.shading)
            lighting = interpolate_lighting(p, lit_front, lit_back, SEGMENT_PARAMETER(part, middle));
        accumulate_lit(p, LIT_COLOR(color[0] * per_extinction), LIT_COLOR(color[1] * per_extinction), LIT_COLOR(color[2] * per_extinction),
                       absorbed(color[3] * scale * (next_t - t)), &lighting, &subdivided);
        t = next_t;
    }
    a->r = deep ? subdivided.r : a->r;
    a->g = deep ? subdivided.g : a->g;
    a->b = deep ? subdivided.b : a->b;
    a->t = deep ? subdivided.t : a->t;
}
