// One sample: classify, shade, composite.
//
// `composite_sample` is the only place where a sample's value becomes colour and opacity; the lattices and the direct
// method all end here. Clip planes, cropping and other blend modes belong here.

// Mirrors `SampleParams` in src/device/launch/params.rs.
typedef struct {
    float table_first, table_per_value; // value of table entry 0, entries per unit of value
    int table_last;                     // index of the last entry
    int first_visible, last_visible;    // entries outside have no opacity
    int linear;                         // extinction: 1 = min(1, alpha dt), 0 = 1 - exp(-tau dt)
    int inner_slabs, front_slabs, back_slabs; // samples per layer: layers 0..n-1, first and last outer layer
    int background_visible;             // the background has opacity: mask what lies beside the field's support
    float opaque;                       // transmittance below which a tile is finished; 0: never
    int shading;
    float gradient_u, gradient_v, gradient_a; // voxel differences -> gradient in value ranges per voxel, world axes
    float light_u, light_v, light_a;    // direction to the light, unit length
    float half_u, half_v, half_a;       // between light and eye, unit length
    float ambient, diffuse, specular, power;
    float step_u, step_v, step_a;       // world size of a voxel step / (unit distance x samples per layer)
} SampleParams;
CHECK_SIZE(SampleParams, SAMPLE_PARAMS_BYTES);

// What a ray has gathered: premultiplied colour and the transmittance left.
typedef struct {
    realv r, g, b, t;
} Light;

// How the gradient of a layer's samples is found differs by kernel, which defines both.
struct GradientSource;
inline void layer_gradient(const struct GradientSource *source, realv *u, realv *v, realv *a);

// What a colour is multiplied by, and what highlight is added to it.
typedef struct {
    realv factor, highlight;
} Lighting;

// x^exponent for x in 0 ... 1 and exponent > 0, through log2 (right to 1.2e-6 of itself) and exp2 (to 4e-6), polynomials
// fitted at Chebyshev nodes. PoCL's own cost 20 % of the lattice stage on engine.
inline realv power(realv x, float exponent) {
    const intv bits = AS_INTV(fmax(x, (realv)(1e-6f)));
    const intv e = (bits - 0x3f400000) >> 23;
    const realv t = AS_REALV(bits - (e << 23)) - 1.0f; // -0.25 ... 0.5: exact where x is 1
    realv log2 = 0.1199838635f;
    log2 = log2 * t - 0.2427637451f;
    log2 = log2 * t + 0.2982907009f;
    log2 = log2 * t - 0.3615473215f;
    log2 = log2 * t + 0.4806241063f;
    log2 = log2 * t - 0.7213282648f;
    log2 = log2 * t + 1.4426963325f;
    log2 = log2 * t + CONVERT_REALV(e);
    const realv y = fmax(exponent * log2, (realv)(-126.0f));
    const realv whole = floor(y), f = y - whole;
    realv exp2 = 0.0136839829f;
    exp2 = exp2 * f + 0.0517177355f;
    exp2 = exp2 * f + 0.2416213227f;
    exp2 = exp2 * f + 0.6929695509f;
    exp2 = exp2 * f + 1.0000035971f;
    return exp2 * AS_REALV((CONVERT_INTV(whole) + 127) << 23);
}

// Blinn-Phong, two-sided, one white light. Where the gradient is below 1e-3 of the value range per voxel the colour
// stays as it is, with a smooth fade up to 2e-3: rounding must not flip it.
inline Lighting light_gradient(const SampleParams *p, realv u, realv v, realv a) {
    u *= p->gradient_u;
    v *= p->gradient_v;
    a *= p->gradient_a;
    const realv squared = u * u + v * v + a * a;
    const realv inverse = rsqrt(fmax(squared, (realv)(1e-20f)));
    const realv faded = clamp((squared * inverse - 1e-3f) * 1e3f, (realv)(0.0f), (realv)(1.0f));
    const realv lit = RISE(faded);
    const realv facing = fabs(u * p->light_u + v * p->light_v + a * p->light_a) * inverse;
    const realv mirror = fabs(u * p->half_u + v * p->half_v + a * p->half_a) * inverse;
    Lighting lighting;
    lighting.factor = 1.0f + lit * (p->ambient + p->diffuse * facing - 1.0f);
    lighting.highlight = lit * p->specular * power(mirror, p->power);
    return lighting;
}

inline intv table_index(const SampleParams *p, realv value) {
    const realv x = (value - p->table_first) * p->table_per_value + 0.5f;
    return CONVERT_INTV(clamp(x, (realv)(0.0f), (realv)(p->table_last)));
}

// Sixteen whole entries instead of four gathers of sixteen floats: 229 -> 186 CPU ms in the prototype.
inline void table_entries(__global const float4 *table, intv i, realv *r, realv *g, realv *b, realv *w) {
#if VW == 1
    const float4 e = table[i];
    *r = e.x, *g = e.y, *b = e.z, *w = e.w;
#elif VW == 4
    const float4 e0 = table[i.s0], e1 = table[i.s1], e2 = table[i.s2], e3 = table[i.s3];
    *r = (realv)(e0.x, e1.x, e2.x, e3.x);
    *g = (realv)(e0.y, e1.y, e2.y, e3.y);
    *b = (realv)(e0.z, e1.z, e2.z, e3.z);
    *w = (realv)(e0.w, e1.w, e2.w, e3.w);
#else
    const float4 e0 = table[i.s0], e1 = table[i.s1], e2 = table[i.s2], e3 = table[i.s3];
    const float4 e4 = table[i.s4], e5 = table[i.s5], e6 = table[i.s6], e7 = table[i.s7];
#if VW == 8
#define LANES_OF(c) (realv)(e0.c, e1.c, e2.c, e3.c, e4.c, e5.c, e6.c, e7.c)
#else
    const float4 e8 = table[i.s8], e9 = table[i.s9], ea = table[i.sa], eb = table[i.sb];
    const float4 ec = table[i.sc], ed = table[i.sd], ee = table[i.se], ef = table[i.sf];
#define LANES_OF(c) \
    (realv)(e0.c, e1.c, e2.c, e3.c, e4.c, e5.c, e6.c, e7.c, e8.c, e9.c, ea.c, eb.c, ec.c, ed.c, ee.c, ef.c)
#endif
    *r = LANES_OF(x);
    *g = LANES_OF(y);
    *b = LANES_OF(z);
    *w = LANES_OF(w);
#endif
}

// Opacity of a sample of `share` sub-slab thicknesses. PER_RAY_STEP: the table holds tau (or alpha), and dt, the
// length of a sub-slab along each ray, comes with the sample. Otherwise dt is one number per frame, and in the table.
inline realv opacity_of(const SampleParams *p, realv w, float share, realv dt) {
#ifdef PER_RAY_STEP
    return p->linear ? fmin(w * dt, (realv)(1.0f)) * share : 1.0f - exp(-w * (dt * share));
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
    if (p->shading) {
        if (!*lit) {
            realv gu, gv, ga;
            layer_gradient(source, &gu, &gv, &ga);
            *lighting = light_gradient(p, gu, gv, ga);
            *lit = true;
        }
        r = fmin(r * lighting->factor + lighting->highlight, (realv)(1.0f));
        g = fmin(g * lighting->factor + lighting->highlight, (realv)(1.0f));
        b = fmin(b * lighting->factor + lighting->highlight, (realv)(1.0f));
    }
    const realv weight = light->t * opacity;
    light->r += weight * r;
    light->g += weight * g;
    light->b += weight * b;
    light->t -= weight;
}

// All samples of one layer, from the splat sums of the layer met before, the layer itself and the one met next. Slabs
// are (weight before, own, after, share), front to back: inner, front and back ones after each other. `from_eye` is the
// distance of the layer from the eye, in layers, or INFINITY: what lies behind the eye is cut off.
ALWAYS_INLINE void composite_layer(const SampleParams *p, __global const float4 *slabs, int first, int count,
                            __global const float4 *table, realv before, realv own, realv after, realv dt, float from_eye,
                            realv inside, const struct GradientSource *source, Light *light, intv *active) {
    // Every sample lies between the three sums: one test for all.
    const intv largest = table_index(p, fmax(fmax(before, after), own));
    const intv smallest = table_index(p, fmin(fmin(before, after), own));
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
