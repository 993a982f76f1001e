// One sample: classify, shade, composite.
//
// `composite_sample` is the only place where one sample's value becomes colour and opacity: splatted layers, image-aligned sheets
// and cast rays end here, stretches between two samples in preintegration.cl and slicing.cl, and axis-aligned sheets are classified
// in sorted_splats.cl. Clip planes, cropping and other blend modes belong here.

// How the gradient of a layer's samples is found differs by kernel, which defines both.
struct GradientSource;
inline void layer_gradient(const struct GradientSource *source, realv *u, realv *v, realv *a);

// Opacity of a sample of `share` sub-slab thicknesses. PER_RAY_STEP: the table holds tau (or alpha), and dt, the
// length of a sub-slab along each ray, comes with the sample. Otherwise dt is one number per frame, and in the table.
inline realv opacity_of(const SampleParams *p, realv w, float share, realv dt) {
#ifdef PER_RAY_STEP
    return p->linear ? MIN(w * dt, (realv)(1.0f)) * share : absorbed(w * (dt * share));
#else
    if (share == 1.0f)
        return w;
    // The outer layers' half sub-slabs; no other share occurs.
    return p->linear ? w * share : 1.0f - sqrt(1.0f - w);
#endif
}

// Classifies, shades and composites one sample (of VW rays) front to back. `inside` is 0 where the ray is beside the
// field's support, else 1. The lighting of the layer is found when its first visible sample needs it.
ALWAYS_INLINE void composite_sample(const SampleParams *p, __global const float4 *table, realv value, float share, realv dt,
                             realv inside, const struct GradientSource *source, bool *lit, Lighting *lighting,
                             Light *light, intv *active) {
    const intv index = table_index(p, value);
    if (!ANY(index >= p->first_visible && index <= p->last_visible))
        return;
    realv r, g, b, w;
    table_entries(table, index, &r, &g, &b, &w);
    const realv opacity = opacity_of(p, w, share, dt) * inside;
    *active += COUNT_IF(opacity > 0.0f);
    if (p->shading && !*lit) {
        realv gu, gv, ga;
        layer_gradient(source, &gu, &gv, &ga);
        *lighting = light_gradient(p, gu, gv, ga);
        *lit = true;
    }
    composite(p, r, g, b, opacity, lighting, light);
}

// All samples of one layer, from the splat sums of the layer met before, the layer itself and the one met next. Slabs
// are (weight before, own, after, share), front to back: inner, front and back ones after each other. `from_eye` is the
// distance of the layer from the eye, in layers, or INFINITY: what lies behind the eye is cut off.
ALWAYS_INLINE void composite_layer(const SampleParams *p, __global const float4 *slabs, int first, int count,
                            __global const float4 *table, realv before, realv own, realv after, realv dt, float from_eye,
                            realv inside, const struct GradientSource *source, Light *light, intv *active) {
    // Every sample lies between the three sums: one test for all.
    const intv largest = table_index(p, MAX(MAX(before, after), own));
    const intv smallest = table_index(p, MIN(MIN(before, after), own));
    if (!ANY(largest >= p->first_visible && smallest <= p->last_visible))
        return;
    // The front layer's slabs begin in its middle.
    float start = from_eye - (first == p->inner_slabs ? 0.0f : 0.5f);
    bool lit = false;
    Lighting lighting;
    for (int i = first; i < first + count; i++) {
        const float4 slab = slabs[i];
        const float end = start + slab.w / p->inner_slabs;
        const float share = start >= 0.0f ? slab.w : slab.w * end / (end - start);
        start = end;
        if (end <= 0.0f)
            continue;
        const realv value = slab.x * before + slab.y * own + slab.z * after;
        composite_sample(p, table, value, share, dt, inside, source, &lit, &lighting, light, active);
    }
}

// First slab and number of slabs of the n-th layer (0 ... layers-1) along the ray.
inline void layer_slabs(const SampleParams *p, int n, int layers, int *first, int *count) {
    const bool front = n == 0, back = n == layers - 1;
    *first = front ? p->inner_slabs : back ? p->inner_slabs + p->front_slabs : 0;
    *count = front ? p->front_slabs : back ? p->back_slabs : p->inner_slabs;
}
