// A field of a scene, and the kernel arguments of several.
//
// The buffers of up to MAX_CHANNELS fields are arguments of their own, since kernels cannot read pointers from memory. Those beyond the
// fields of a scene are not read. CHANNELS: fields for which a program has room.

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
    LightVolume light;
    VolumeView view, gradient_view;
    SampleParams sample;
} ChannelField;

ALWAYS_INLINE void set_field(__global const ChannelParams *params, __global const VOXEL *voxels,
                             __global const GRADIENT_VOXEL *gradient_voxels, __global const uchar *light, __global const uchar *sky,
                             ChannelField *field) {
    field->view = params->view, field->gradient_view = params->gradient_view;
    field->sample = params->sample;
    field->voxels = voxels + field->view.first, field->gradient_voxels = gradient_voxels + field->gradient_view.first;
    field->light.lights = light, field->light.sky = sky;
}

ALWAYS_INLINE ShadingSource shading_of(const ChannelField *field) {
#ifdef SEPARATE_GRADIENTS
    const ShadingSource source = {field->gradient_voxels, &field->gradient_view, field->light};
#else
    const ShadingSource source = {field->voxels, &field->view, field->light};
#endif
    return source;
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
