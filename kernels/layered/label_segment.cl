// Segments of a volume of labels, whose moments are linear between two samples. Where labels meet, segments are composited in parts, since
// the opacity is not linear.

// Parts of a segment in which labels meet, as long as a layer; and of a deep one in which they do not.
#define PARTS_OF_LAYER 5.0f
#define PARTS_OF_DEEP 4.0f
// Optical depth above which a segment is deep.
#define DEEP 0.3f
// Part of the larger opacity by which both ends differ where labels meet.
#define SAME_OPACITY 1e-3f

// Interpolated values: moments of the opacity, and the first times colour.
typedef struct {
    realv first, second, third, red, green, blue;
} LabelSample;

// `t` of the way from one sample to the next.
static inline LabelSample labels_between(const LabelParams *labels, const Layer *front, const Layer *back, int n, realv t) {
#define BETWEEN(number) lerp(front[number].at.field[n], back[number].at.field[n], t)
    LabelSample s;
    s.red = BETWEEN(0), s.green = BETWEEN(1), s.blue = BETWEEN(2), s.first = BETWEEN(SHADED);
#ifdef VARIED_OPACITIES
    s.second = BETWEEN(SECOND), s.third = BETWEEN(THIRD);
#else
    s.second = labels->most * s.first, s.third = labels->most * s.second;
#endif
#undef BETWEEN
    return s;
}

static inline LabelOpacity opacity_of_sample(const LabelParams *labels, const LabelSample *s) {
    return label_opacity(labels, s->first, s->second, s->third);
}

// Composites a segment of this length in unit distances.
static inline void composite_labels(const SampleParams *p, const LabelParams *labels, const Layer *front, const Layer *back, int n,
                                    const Part *part, float2 ends, realv length, Accumulator *a, intv *active) {
    const LitSample *lit_front = &front[SHADED].at.lit[n], *lit_back = &back[SHADED].at.lit[n];
    const LabelSample from = labels_between(labels, front, back, n, SEGMENT_PARAMETER(part, (realv)(0.0f)));
    const LabelSample to = labels_between(labels, front, back, n, SEGMENT_PARAMETER(part, (realv)(1.0f)));
    const realv one = opacity_of_sample(labels, &from).at_point, other = opacity_of_sample(labels, &to).at_point, most = MAX(one, other);
    const intv meet = fabs(one - other) > SAME_OPACITY * most, deep = most * length > DEEP;
    const float parts = MAX(PARTS_OF_LAYER / SAMPLES_PER_LAYER(p), 2.0f);
    const realv step = meet ? (realv)(1.0f / parts) : deep ? (realv)(1.0f / PARTS_OF_DEEP) : (realv)(1.0f);
    realv t = most > 0.0f ? (realv)(0.0f) : (realv)(1.0f), spent = 0.0f;
    intv counts = 0;
    for (int i = 1; ANY(t < 1.0f && a->t > p->segments.opaque); i++) {
        const realv next_t = MIN(i * step, (realv)(1.0f)), middle = SEGMENT_PARAMETER(part, 0.5f * (t + next_t));
        const LabelSample s = labels_between(labels, front, back, n, middle);
        const LabelOpacity of_unit = opacity_of_sample(labels, &s);
        realv opacity;
        const realv of_part = t < 1.0f ? length * (next_t - t) : (realv)(0.0f);
        if (p->classification.linear) {
            // Opacities of parts add up to that of the segment.
            const realv share = of_unit.at_point * of_part;
            opacity = MIN(share * reciprocal(MAX(1.0f - spent, (realv)(1e-6f))), (realv)(1.0f));
            spent += share;
        } else {
            opacity = of_unit.at_point > 0.0f ? 1.0f - general_power(1.0f - of_unit.at_point, of_part) : (realv)(0.0f);
        }
        t = next_t;
        if (!ANY(opacity > 0.0f))
            continue;
        const realv per_opacity = reciprocal(s.first > 0.0f ? s.first : (realv)(1.0f));
        Lighting lighting;
        if (p->light.shading) {
            lighting = interpolate_lighting(p, lit_front, lit_back, middle);
            light_label(of_unit, lerp(front[SMOOTHED_OPACITY].at.field[n], back[SMOOTHED_OPACITY].at.field[n], middle), &lighting);
        }
        accumulate_lit(p, LIT_COLOR(s.red * per_opacity), LIT_COLOR(s.green * per_opacity), LIT_COLOR(s.blue * per_opacity), opacity,
                       &lighting, a);
        counts |= COUNT_IF(opacity > 0.0f);
    }
    *active += counts;
}
