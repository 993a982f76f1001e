// A field of a scene, and the kernel arguments of several.
//
// The buffers of up to MAX_CHANNELS fields are arguments of their own, since kernels cannot read pointers from memory. Those beyond the
// fields of a scene are not read. CHANNELS: fields for which a program has room.

#include "shared/clipping.cl"
#include "shared/field.cl"

#ifndef CHANNELS
#error "CHANNELS: most fields of a scene"
#endif

#define MAX_CHANNELS 8
#define PER_CHANNEL(type, name) \
    type name##_0, type name##_1, type name##_2, type name##_3, type name##_4, type name##_5, type name##_6, type name##_7
#define CHANNEL_FIELDS                                                                                        \
    PER_CHANNEL(__global const VOXEL *, voxels), PER_CHANNEL(__global const GRADIENT_VOXEL *, gradient_voxels), \
        __global const ChannelParams *channel_params, int count
#define SHADED_CHANNELS                                                                                       \
    CHANNEL_FIELDS, LIGHT_BUFFERS, PER_CHANNEL(__global const uchar *, visible), PER_CHANNEL(__global const float4 *, tables), \
        RayEnds ray_ends, OUTPUT
// Colours of the fields' voxels, in programs with TINTED (voxel_colors.cl).
#ifdef TINTED
#define CHANNEL_COLORS PER_CHANNEL(__global const uchar *, colors),
#else
#define CHANNEL_COLORS
#endif
#define EACH(name) {name##_0, name##_1, name##_2, name##_3, name##_4, name##_5, name##_6, name##_7}

// Number of fields, which is known of one.
#if CHANNELS == 1
#define FIELDS(count) 1
#else
#define FIELDS(count) (count)
#endif

typedef struct {
    __global const VOXEL *voxels;
    __global const GRADIENT_VOXEL *gradient_voxels;
    __global const FieldPlacement *place;
    LightVolume light;
    VolumeView view, gradient_view;
    SampleParams sample;
} ChannelField;

ALWAYS_INLINE void set_field(__global const ChannelParams *params, __global const VOXEL *voxels,
                             __global const GRADIENT_VOXEL *gradient_voxels, __global const uchar *light, __global const uchar *sky,
                             ChannelField *field) {
    field->place = &params->place;
    field->view = params->view, field->gradient_view = params->gradient_view;
    field->sample = params->sample;
    field->voxels = voxels + field->view.first, field->gradient_voxels = gradient_voxels + field->gradient_view.first;
    field->light.lights = light, field->light.sky = sky;
}

ALWAYS_INLINE ShadingSource shading_of(const ChannelField *field) {
#ifdef SEPARATE_GRADIENTS
    const ShadingSource source = {field->gradient_voxels, &field->gradient_view, field->light, field->place};
#else
    const ShadingSource source = {field->voxels, &field->view, field->light, field->place};
#endif
    return source;
}

#ifdef TINTED
// The colours of a field's voxels.
ALWAYS_INLINE Tint tint_of(__global const ChannelParams *params, __global const uchar *colors) {
    const Tint tint = {colors,
                       {params->color_stride_u, params->color_stride_v, params->color_stride_a},
                       {params->color_dims_u, params->color_dims_v, params->color_dims_a}};
    return tint;
}

// Gives them to all fields of a kernel with the arguments CHANNEL_COLORS.
#define SET_COLORS(channels, count)                                                                       \
    __global const uchar *const all_colors[MAX_CHANNELS] = EACH(colors);                                  \
    for (int c = 0; c < (count); c++)                                                                     \
        (channels)[c].shading.tint = tint_of(channel_params + c, all_colors[c]);
#else
#define SET_COLORS(channels, count)
#endif

// Points of the frame, or directions in it, as positions among the voxels of a field. `one`: 1 for points, 0 for directions.
ALWAYS_INLINE void to_own_voxels(__global const FieldPlacement *c, const realv *frame, float one, realv *own) {
    for (int i = 0; i < 3; i++) {
        __global const float *row = c->to_own + 4 * i;
        own[i] = row[0] * frame[0] + (row[1] * frame[1] + (row[2] * frame[2] + one * row[3]));
    }
}

// The clip interval of rays in a field: the part of `all` inside the field's ends. `origin` and `direction` are
// in voxels of the frame.
ALWAYS_INLINE Interval interval_within(__global const FieldPlacement *c, const Interval *all, const realv *origin, const realv *direction) {
    if (!c->has_ends)
        return *all;
    RayEnds ends;
    ends.start = -INFINITY, ends.end = INFINITY, ends.plane_count = 0;
    for (int i = 0; i < 3; i++)
        ends.lowest[i] = c->lowest[i], ends.highest[i] = c->highest[i];
    realv from[3], along[3];
    to_own_voxels(c, origin, 1.0f, from);
    to_own_voxels(c, direction, 0.0f, along);
    const Interval own = clip_rays(&ends, from, along);
    const Interval within = {MAX(all->from, own.from), MIN(all->to, own.to)};
    return within;
}

// The value of a field at points among its voxels. Beyond its support lies the background.
ALWAYS_INLINE realv value_at_own(const ChannelField *field, const realv *own, intv needed) {
    const VolumeView *view = &field->view;
    needed &= own[0] > -RADIUS && own[0] < view->dims_u - 1 + RADIUS && own[1] > -RADIUS && own[1] < view->dims_v - 1 + RADIUS &&
              own[2] > -RADIUS && own[2] < view->dims_a - 1 + RADIUS;
    if (!ANY(needed))
        return (realv)(view->background);
    const realv value = value_at(field->voxels, view, own[0], own[1], own[2], needed);
    return needed ? value : (realv)(view->background);
}

// The gradient at points among a field's voxels, along the axes of the frame.
ALWAYS_INLINE Gradient along_frame(__global const FieldPlacement *c, Gradient own) {
    if (c->placed != APART)
        return own;
    __global const float *m = c->to_own;
    const Gradient gradient = {m[0] * own.u + m[4] * own.v + m[8] * own.a, m[1] * own.u + m[5] * own.v + m[9] * own.a,
                               m[2] * own.u + m[6] * own.v + m[10] * own.a};
    return gradient;
}

// What a kernel with the arguments SHADED_CHANNELS knows of each field from the beginning.
#define SET_CHANNELS(channels, count)                                                                                  \
    __global const VOXEL *const all_voxels[MAX_CHANNELS] = EACH(voxels);                                               \
    __global const GRADIENT_VOXEL *const all_gradient_voxels[MAX_CHANNELS] = EACH(gradient_voxels);                    \
    __global const uchar *const all_visible[MAX_CHANNELS] = EACH(visible);                                             \
    __global const float4 *const all_tables[MAX_CHANNELS] = EACH(tables);                                              \
    for (int c = 0; c < (count); c++) {                                                                                \
        set_field(channel_params + c, all_voxels[c], all_gradient_voxels[c], light, sky, &(channels)[c].field);        \
        (channels)[c].shading = shading_of(&(channels)[c].field);                                                      \
        (channels)[c].visible = all_visible[c], (channels)[c].table = all_tables[c];                                   \
    }
