// What a sample needs to know of its frame, its place in the table, and how it is lit.

// Mirrors `SampleParams` in src/device/launch/params.rs.
typedef struct {
    float table_first, table_per_value; // value of table entry 0, entries per unit of value
    int table_last;                     // index of the last entry
    int first_visible, last_visible;    // entries outside have no opacity
    int linear;                         // extinction: 1 = min(1, alpha dt), 0 = 1 - exp(-tau dt)
    int inner_slabs, front_slabs, back_slabs; // samples per layer: all inner ones, and of splatted layers the outer two
    int background_visible;             // the background has opacity: mask what lies beside the field's support
    float opaque;                       // transmittance below which a tile is finished; 0: never
    int shading;
    float gradient_u, gradient_v, gradient_a; // voxel differences -> gradient in value ranges per voxel, world axes
    float light_u, light_v, light_a;    // direction to the light, unit length
    float half_u, half_v, half_a;       // between light and eye, unit length
    float ambient, diffuse, specular, power;
    float step_u, step_v, step_a;       // world size of a voxel step / (unit distance x samples per layer)
    float table_unit;                   // extinction of one unit in the table of integrals
    float ends[8][2];                   // weights of the lower and the upper end of the stretches from a layer to the next
    float curve;                        // share of f that lighting follows between the ends of a stretch, else even
} SampleParams;
CHECK_SIZE(SampleParams, SAMPLE_PARAMS_BYTES);

// The table entry nearest to a value.
inline intv table_index(const SampleParams *p, realv value) {
    const realv x = (value - p->table_first) * p->table_per_value + 0.5f;
    return CONVERT_INTV(CLAMP(x, (realv)(0.0f), (realv)(p->table_last)));
}

// What a ray has gathered: premultiplied colour and the transmittance left.
typedef struct {
    realv r, g, b, t;
} Light;

// What a colour is multiplied by, and what highlight is added to it; and what it counts where it is mixed with another.
typedef struct {
    realv factor, highlight, weight;
} Lighting;

// Blinn-Phong, two-sided, one white light. Where the gradient is below 1e-3 of the value range per voxel the colour
// stays as it is, with a smooth fade up to 2e-3: rounding must not flip it.
inline Lighting light_gradient(const SampleParams *p, realv u, realv v, realv a) {
    u *= p->gradient_u;
    v *= p->gradient_v;
    a *= p->gradient_a;
    const realv squared = u * u + v * v + a * a;
    const realv inverse = inverse_sqrt(MAX(squared, (realv)(1e-20f)));
    const realv faded = CLAMP((squared * inverse - 1e-3f) * 1e3f, (realv)(0.0f), (realv)(1.0f));
    const realv lit = RISE(faded);
    const realv facing = fabs(u * p->light_u + v * p->light_v + a * p->light_a) * inverse;
    // A light at the camera has one direction for both.
    const bool headlight = p->half_u == p->light_u && p->half_v == p->light_v && p->half_a == p->light_a;
    const realv mirror = headlight ? facing : fabs(u * p->half_u + v * p->half_v + a * p->half_a) * inverse;
    Lighting lighting;
    // The root of the gradient's length: a weak one's direction is mostly noise, but a surface has weak ones too.
    lighting.weight = inverse_sqrt(inverse);
    lighting.factor = 1.0f + lit * (p->ambient + p->diffuse * facing - 1.0f);
    lighting.highlight = lit * p->specular * power(mirror, p->power);
    return lighting;
}

// Opacity of an optical depth, or of alpha times length.
inline realv opacity_of_depth(const SampleParams *p, realv depth) {
    return p->linear ? MIN(depth, (realv)(1.0f)) : absorbed(depth);
}

// Lights a colour and composites it behind what a ray has gathered.
ALWAYS_INLINE void composite(const SampleParams *p, realv r, realv g, realv b, realv opacity, const Lighting *lighting,
                             Light *light) {
    if (p->shading) {
        r = MIN(r * lighting->factor + lighting->highlight, (realv)(1.0f));
        g = MIN(g * lighting->factor + lighting->highlight, (realv)(1.0f));
        b = MIN(b * lighting->factor + lighting->highlight, (realv)(1.0f));
    }
    const realv weight = light->t * opacity;
    light->r += weight * r;
    light->g += weight * g;
    light->b += weight * b;
    light->t -= weight;
}
