// Rays from a light in the layers that they cross, for both schedules of the sweep (light_sweep.cl, light_rays.cl). COLUMNS, SWEEP_ROWS:
// rays of a tile.

#include "layered/beam.cl"
#include "shared/blend_modes.cl"
#include "shared/channel.cl"
#include "shared/clipping.cl"
#include "shared/field.cl"
#include "shared/integral_nodes.cl"
#include "shared/shading.cl"

// Columns and rows of rays that neighbouring tiles have in common: a voxel is interpolated from 4 x 4 rays of one tile.
#define COMMON_RAYS 3

// Values of LightSweepParams.sum.
#define STORE 1
#define ADD 2

// Rays of a tile in one layer.
typedef struct {
    int k;
    int first_u, first_v;        // voxel below the first ray
    float between_u, between_v;  // distance of the rays from it
} RayLayer;

// The rays of a tile whose first is ray (column, row), in layer k.
static inline RayLayer ray_layer(const LightSweepParams *p, __global const LayerOffset *offsets, int column, int row, int k) {
    const LayerOffset u = offsets[k + 1], v = offsets[p->layers + 2 + k + 1];
    const RayLayer layer = {k, column + u.base, row + v.base, u.fraction, v.fraction};
    return layer;
}

// Whether anything can be visible to the rays of a tile between two neighbouring layers.
static inline bool is_slab_visible_between(__global const uchar *visible, const LightSweepParams *p, int first_held,
                                           const RayLayer *one, const RayLayer *other) {
    const int4 window = {min(one->first_u, other->first_u), min(one->first_v, other->first_v),
                         max(one->first_u, other->first_u) + COLUMNS, max(one->first_v, other->first_v) + SWEEP_ROWS};
    const int slab = max(one->k, other->k) - first_held;
    return slabs_in_window(visible, p->blocks_u, p->blocks_v, slab >> 3, window) >> (slab & 7) & 1;
}

static inline bool is_beside_volume(const LightSweepParams *p, const RayLayer *layer) {
    return layer->first_u > p->dims_u || layer->first_u + COLUMNS < -1 || layer->first_v > p->dims_v ||
           layer->first_v + SWEEP_ROWS < -1;
}

// Whether something can be visible between a layer and the one before, and between it and the next, among the layers that a sweep visits.
// n: number of the layer, as rays meet it; first_held: the first layer of the voxels. Layers before that in which the first segment begins
// are sampled even if nothing is visible.
typedef struct {
    bool before, behind;
} Crossing;

static inline Crossing crossing_of(__global const uchar *visible, const LightSweepParams *p, int first_held,
                                   __global const LayerOffset *offsets, int column, int row, int n, const RayLayer *layer) {
    Crossing c = {n > 0 && n >= p->from, n < p->to - 1};
    if (p->culling && c.before) {
        const RayLayer last = ray_layer(p, offsets, column, row, layer->k - p->layer_step);
        c.before = is_slab_visible_between(visible, p, first_held, &last, layer);
    }
    if (p->culling && c.behind && n + 1 >= p->from) {
        const RayLayer next = ray_layer(p, offsets, column, row, layer->k + p->layer_step);
        c.behind = is_slab_visible_between(visible, p, first_held, layer, &next);
    }
    return c;
}

// The sample of a ray in a layer: its node in the table of integrals, the integral of the extinction up to there, and its distance from the
// table, in nodes; the transmittance of half a layer (COARSE); or its value (ISO).
typedef struct {
#if BLEND == ISO
    realv value;
#elif defined(COARSE)
    realv half_layer;
#else
    intv node, integral;
    realv outside;
#endif
#ifdef THINNED
    realv extinction_scale;
#endif
} RaySample;

#if BLEND == COMPOSITE && !defined(COARSE)
static inline RaySample classified_sample(const SampleParams *p, __global const int4 *integrals, realv value, int odd) {
    RaySample s;
    s.node = node_index(p, value, odd);
    const realv place = (value - p->classification.table_first) * p->classification.table_per_value;
    s.outside = place - CLAMP(place, (realv)(0.0f), (realv)(p->classification.table_last));
    s.integral = 0;
    // Values below all visible ones need no look-up.
    if (ANY(value >= p->classification.shown_from)) {
        const intv at = s.node * 4 + 3;
        s.integral = GATHER_AS(intv, (__global const int *)NODES(integrals), at);
    }
    return s;
}

// Difference of the integrals between two samples. Outside the table its first and last extinction apply.
static inline realv extinction_between(const SampleParams *p, __global const int4 *integrals, const RaySample *from, const RaySample *to) {
    __global const int4 *at_nodes = NODES(integrals) + p->classification.table_last + 1;
    const float first = as_float(at_nodes[0].w), last = as_float(at_nodes[p->classification.table_last].w);
    const realv above = MAX(to->outside, (realv)(0.0f)) - MAX(from->outside, (realv)(0.0f));
    const realv below = MIN(to->outside, (realv)(0.0f)) - MIN(from->outside, (realv)(0.0f));
    return CONVERT_REALV(to->integral - from->integral) + (last * above + first * below);
}
#endif

#ifdef COARSE
// The transmittance of a multiple of a length, from that of the length.
static inline realv to_power(const SampleParams *p, realv transmittance, float exponent) {
    const realv scaled =
        p->classification.linear ? 1.0f - (1.0f - transmittance) * exponent : general_power(transmittance, (realv)(exponent));
    return transmittance < 1.0f ? scaled : (realv)(1.0f);
}

// Transmittance of two halves of a layer. With linear extinction opacities add up.
static inline realv of_two_halves(const SampleParams *p, realv one, realv other) {
    return p->classification.linear ? MAX(one + other - 1.0f, (realv)(0.0f)) : one * other;
}
#endif

// A field that absorbs light. Coarse transmittances are those of all fields.
typedef struct {
    ChannelField field;
    __global const uchar *visible;
    __global const int4 *integrals;
    Crossing crossing;
    int sampled_last;    // number of the layer that its sample before belongs to
} Absorber;

// Sets the fields of a scene from the arguments of a kernel.
#define SET_ABSORBERS(absorbers, count)                                                                                    \
    __global const VOXEL *const all_voxels[MAX_CHANNELS] = EACH(voxels);                                                   \
    __global const GRADIENT_VOXEL *const all_gradient_voxels[MAX_CHANNELS] = EACH(gradient_voxels);                        \
    __global const uchar *const all_visible[MAX_CHANNELS] = EACH(visible);                                                 \
    __global const int4 *const all_integrals[MAX_CHANNELS] = EACH(integrals);                                              \
    for (int i = 0; i < (count); i++) {                                                                                    \
        set_field(channel_params + i, all_voxels[i], all_gradient_voxels[i], 0, 0, &(absorbers)[i].field);                 \
        (absorbers)[i].visible = all_visible[i], (absorbers)[i].integrals = all_integrals[i];                              \
        (absorbers)[i].sampled_last = -2;                                                                                  \
    }

// Whether a field is sampled in the current layer.
static inline bool is_sampled(const Absorber *absorber) { return absorber->crossing.before || absorber->crossing.behind; }

// What fields absorb between two layers: 1 where they end a ray (ISO), what they let through (COARSE), or the optical depth, or alpha times
// length. Depths add.
static inline realv absorbed_by_both(const SampleParams *p, realv one, realv other) {
#if BLEND == ISO
    return MAX(one, other);
#elif defined(COARSE)
    return of_two_halves(p, one, other);
#else
    return one + other;
#endif
}

// The light that is left.
static inline realv let_through(const SampleParams *p, realv absorbs) {
#if BLEND == ISO
    return 1.0f - absorbs;
#elif defined(COARSE)
    return absorbs;
#else
    return 1.0f - opacity_of_depth(p, absorbs);
#endif
}

// The sample of rays before their first layer: background.
static inline RaySample sample_beside(const SampleParams *p, const VolumeView *view, __global const int4 *integrals, int odd) {
#if BLEND == ISO
    RaySample s = {(realv)(view->background)};
#elif defined(COARSE)
    RaySample s = {(realv)(1.0f)};
#else
    RaySample s = classified_sample(p, integrals, (realv)(view->background), odd);
#endif
#ifdef THINNED
    s.extinction_scale = 1.0f;
#endif
    return s;
}

// Replaces the sample of rays in the layer before by that of this layer, with a value at (u, v). Returns whether the field absorbs light
// between the two, and what (let_through). `odd`: parity of this layer's nodes.
ALWAYS_INLINE bool cross_to_layer(const LightSweepParams *p, const Absorber *absorber, const RayEnds *ends, int k, int odd, realv value,
                                  realv u, realv v, RaySample *before, realv *absorbs) {
    const SampleParams *sample = &absorber->field.sample;
    const bool crossed = absorber->crossing.before;
#ifdef CLIPPED
    // Depths: layers from that of the centre, in the direction of the light.
    const float depth = p->layer_step * (k - p->centre_layer);
    const realv origin[3] = {u - depth * p->along_u, v - depth * p->along_v, (realv)(p->centre_layer)};
    const realv direction[3] = {(realv)(p->along_u), (realv)(p->along_v), (realv)(p->layer_step)};
    const Interval hit = clip_rays(ends, origin, direction);
#endif
#if BLEND == ISO
    const realv last = before->value - sample->classification.iso, own = value - sample->classification.iso;
    before->value = value;
    intv blocks = (last < 0.0f) != (own < 0.0f);
#ifdef CLIPPED
    const realv surface = depth - own / (blocks ? own - last : (realv)(1.0f));
    blocks &= surface >= hit.from && surface <= hit.to;
#endif
    *absorbs = blocks ? (realv)(1.0f) : (realv)(0.0f);
    return crossed && ANY(blocks);
#elif defined(COARSE)
    const realv own = to_power(sample, value, p->half_layer), last = before->half_layer;
    before->half_layer = own;
    if (!crossed || !ANY(own < 1.0f || last < 1.0f))
        return false;
    *absorbs = of_two_halves(sample, last, own);
    return true;
#else
    RaySample own = classified_sample(sample, absorber->integrals, value, odd);
    const RaySample last = *before;
    const realv extinction = extinction_between(sample, absorber->integrals, &last, &own);
    const intv dims = extinction != 0.0f;
#ifdef THINNED
    own.extinction_scale = 1.0f;
    const intv shown = value >= sample->classification.shown_from && value <= sample->classification.shown_to;
    if (sample->light.thinned && ANY(dims || shown)) {
        const ShadingSource source = shading_of(&absorber->field);
        const Gradient gradient = gradient_at(&source, &sample->field, u, v, (realv)(k), dims || shown);
        own.extinction_scale = gradient_extinction_scale(sample, gradient_length(sample, gradient));
    }
#endif
    *before = own;
    if (!crossed || !ANY(dims))
        return false;
    // Nodes of neighbouring layers are even and odd: never equal.
    const realv mean = extinction * reciprocal(CONVERT_REALV(own.node - last.node) + (own.outside - last.outside));
    realv length = (realv)(p->layer_length * sample->classification.table_unit);
#ifdef CLIPPED
    const Part part = part_of(&hit, (realv)(depth - 1.0f), (realv)(depth));
    length *= part_length(&part);
#endif
#ifdef THINNED
    length *= 0.5f * (own.extinction_scale + last.extinction_scale);
#endif
    *absorbs = mean * length;
    return true;
#endif
}

// With a limited reach, light comes back with the distance from what absorbed it: half of a step before, half behind its absorption.
static inline realv recovered(const LightSweepParams *p, realv light) {
    return p->recovered < 1.0f ? 1.0f - p->recovered * (1.0f - light) : light;
}

// Weights of four rays in a row for the voxel between the second and the third, which lies `behind` voxels before the third: Catmull-Rom.
// Linear weights would blur shadows by an amount that depends on where the rays of a layer lie between its voxels: stripes, from layer to
// layer. Light of an iso-surface is 0 or 1 along a ray, and a surface must not dim what lies more than a voxel off it: linear.
static inline float4 ray_weights(float behind) {
    const float t = 1.0f - behind;
#if BLEND == ISO
    return (float4)(0.0f, behind, t, 0.0f);
#else
    return (float4)(t * (t * (1.0f - 0.5f * t) - 0.5f), 1.0f + t * t * (1.5f * t - 2.5f), t * (t * (2.0f - 1.5f * t) + 0.5f),
                    t * t * (0.5f * t - 0.5f));
#endif
}

// Weighted sum of four rays. The weights sum to one: sums of differences keep equal values exact to the bit.
static inline realv mixed_rays(float4 w, realv one, realv two, realv three, realv four) {
    return two + w.s0 * (one - two) + (w.s2 * (three - two) + w.s3 * (four - two));
}

// What is interpolated between rays of a transmittance: it, where several sweeps are added, or the code of the light.
static inline realv value_of_ray(const LightSweepParams *p, realv transmittance) {
    return p->sum ? transmittance : code_of_light(MIN(transmittance * p->gain, (realv)(1.0f)));
}

// An interpolated value in steps.
static inline intv light_steps(const LightSweepParams *p, realv value) {
    return CONVERT_INTV(CLAMP(value, (realv)(0.0f), (realv)(1.0f)) * p->steps + 0.5f);
}

// Stores the light of a voxel.
static inline void store_light(const LightSweepParams *p, size_t voxel, int steps, __global uchar *light, __global ushort *sums) {
    if (p->sum == ADD)
        sums[voxel] += steps;
    else if (p->sum == STORE)
        sums[voxel] = steps;
    else
        light[voxel] = steps;
}
