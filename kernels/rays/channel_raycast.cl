// Ray casting of several fields on one grid: raycast.cl with the sum of extinctions (emission.cl).

#include "rays/marching.cl"
#include "shared/channel.cl"
#include "shared/emission.cl"
#include "shared/field.cl"

// One field of a scene.
typedef struct {
    __global const VOXEL *voxels;
    __global const uchar *visible;
    __global const float4 *table;
    ShadingSource shading;
    VolumeView view, gradient_view;
    SampleParams sample;
    bool shown; // in the current chunk of steps
} Channel;

// Adds what a channel emits at a point where it is `needed`. `length`: of a whole step.
ALWAYS_INLINE void add_sample(const Channel *c, const realv *point, intv needed, float length, realv *sum, realv *depth) {
    const SampleParams *sample = &c->sample;
    const realv value = value_at(c->voxels, &c->view, point[0], point[1], point[2], needed);
    const intv index = table_index(sample, value);
    needed &= index >= sample->classification.first_visible && index <= sample->classification.last_visible;
    if (!ANY(needed))
        return;
    realv r, g, b, extinction;
    table_entries(c->table, index, &r, &g, &b, &extinction);
    Emission e;
    e.depth = needed ? extinction * (length * sample->classification.table_unit) : (realv)(0.0f);
    if (sample->light.shading) {
        const Point at = {point[0], point[1], point[2]};
        const Gradient gradient = gradient_at(&c->shading, &sample->field, point[0], point[1], point[2], needed);
        e.lighting = shade(sample, c->shading.light, at, value, gradient);
#ifdef THINNED
        e.depth *= e.lighting.extinction_scale;
#endif
    }
    add_emission(sample, r, g, b, &e, sum);
    *depth += e.depth;
}

// Marches one row of rays.
ALWAYS_INLINE void march_channels(Channel *channels, int count, const MarchParams *p, const RowRays *rays, const Interval *interval,
                                  Accumulator *gathered, intv *active) {
    const SampleParams *first_sample = &channels[0].sample;
    const realv step = p->length / rays->length;
    const realv first = interval->from / step, last = interval->to / step;
    const intv hits = first < last;
    const int begin = (int)floor(smallest_lane(hits ? first : (realv)(INFINITY)));
    const int end = (int)ceil(largest_lane(hits ? last : (realv)(-INFINITY)));
    for (int n = begin; n < end; n++) {
        realv point[3];
        if ((n - begin) % CHUNK == 0) {
            realv other[3];
            points_at(rays, (realv)(n) * step, point);
            points_at(rays, (realv)(n + CHUNK) * step, other);
            bool any = false;
            for (int c = 0; c < count; c++) {
                Channel *channel = &channels[c];
                channel->shown = !p->culling || box_visible(channel->visible, p, &channel->view, point, other);
                any |= channel->shown;
            }
            if (!any) {
                n += CHUNK - 1;
                continue;
            }
        }
        const float middle = n + 0.5f;
        points_at(rays, middle * step, point);
#ifdef CLIPPED
        const realv share = MAX(MIN(last, (realv)(n + 1.0f)) - MAX(first, (realv)(n)), (realv)(0.0f));
        const intv inside = share > 0.0f;
#else
        const realv share = 1.0f;
        const intv inside = middle >= first && middle < last;
#endif
        const intv open = inside && open_rays(first_sample, gathered);
        realv sum[3] = {(realv)(0.0f), (realv)(0.0f), (realv)(0.0f)}, depth = 0.0f;
        for (int c = 0; c < count; c++) {
            const Channel *channel = &channels[c];
            if (!channel->shown)
                continue;
            intv needed = open;
            if (p->culling)
                needed &= cells_visible(channel->visible, p, &channel->view, point[0], point[1], point[2]);
            if (ANY(needed))
                add_sample(channel, point, needed, p->length, sum, &depth);
        }
        if (!ANY(depth > 0.0f))
            continue;
        const realv opacity = first_sample->classification.linear ? MIN(depth, (realv)(1.0f)) * share : absorbed(depth * share);
        *active += COUNT_IF(opacity > 0.0f);
#ifdef DEPTHS
        set_depth_range(MAX(first, (realv)(n)) * step, MIN(last, (realv)(n + 1.0f)) * step, gathered);
#endif
        accumulate_emission(sum, depth, opacity, gathered);
        if (!ANY(hits && open_rays(first_sample, gathered)))
            break;
    }
}

__kernel void channel_raycast(SHADED_CHANNELS, ScreenParams s, MarchParams p, ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= s.tiles_u * s.tiles_v)
        return;
    __global const VOXEL *const all_voxels[MAX_CHANNELS] = EACH(voxels);
    __global const GRADIENT_VOXEL *const all_gradient_voxels[MAX_CHANNELS] = EACH(gradient_voxels);
    __global const uchar *const all_visible[MAX_CHANNELS] = EACH(visible);
    __global const float4 *const all_tables[MAX_CHANNELS] = EACH(tables);
    Channel channels[CHANNELS];
    for (int c = 0; c < count; c++) {
        Channel *channel = &channels[c];
        channel->view = channel_params[c].view, channel->gradient_view = channel_params[c].gradient_view;
        channel->sample = channel_params[c].sample;
        channel->voxels = all_voxels[c] + channel->view.first;
        channel->visible = all_visible[c], channel->table = all_tables[c];
#ifdef SEPARATE_GRADIENTS
        channel->shading.voxels = all_gradient_voxels[c] + channel->gradient_view.first, channel->shading.view = &channel->gradient_view;
#else
        channel->shading.voxels = channel->voxels, channel->shading.view = &channel->view;
#endif
        channel->shading.light.lights = light, channel->shading.light.sky = sky;
    }
    const SampleParams *first = &channels[0].sample;
    const int column = id % s.tiles_u * VW, row = id / s.tiles_u * TILE_ROWS;
    intv active = 0;
    for (int r = row; r < min(row + TILE_ROWS, s.height); r++) {
        const RowRays rays = row_rays(&s, column, r);
        const Interval interval = clip_rays(&ray_ends, rays.o, rays.d);
        Accumulator gathered = empty_accumulator(first);
        if (ANY(interval.from < interval.to))
            march_channels(channels, count, &p, &rays, &interval, &gathered, &active);
        store_pixels(&s, first, all_tables[0], column, r, &gathered, &interval, target);
    }
    active_samples[id] = sum_lanes(active, columns_on_screen(&s, column));
}
