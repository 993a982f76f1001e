// Ray casting of several fields on one grid: raycast.cl with the sum of extinctions (emission.cl).

#include "rays/steps.cl"
#include "shared/channel.cl"
#include "shared/emission.cl"

// One field of a scene.
typedef struct {
    ChannelField field;
    ShadingSource shading;
    __global const uchar *visible;
    __global const float4 *table;
    bool shown; // in the current chunk of steps
} Channel;

struct Marched {
    Channel channels[CHANNELS];
    int count;
};

ALWAYS_INLINE bool box_shows(struct Marched *m, const MarchParams *p, const realv *one, const realv *other) {
    bool any = false;
    for (int c = 0; c < m->count; c++) {
        Channel *channel = &m->channels[c];
        channel->shown = box_visible(channel->visible, p, &channel->field.view, one, other);
        any |= channel->shown;
    }
    return any;
}

// All channels lie on one grid, but each has its own visibility: see add_sample().
ALWAYS_INLINE intv points_show(const struct Marched *m, const MarchParams *p, const realv *point, intv needed) { return needed; }

// Adds what a channel emits at a point where it is `needed`. `length`: of a whole step.
ALWAYS_INLINE void add_sample(const Channel *c, const realv *point, intv needed, float length, realv *sum, realv *depth) {
    const SampleParams *sample = &c->field.sample;
    const realv value = value_at(c->field.voxels, &c->field.view, point[0], point[1], point[2], needed);
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

ALWAYS_INLINE void accumulate_step(const struct Marched *m, const MarchParams *p, const realv *point, intv needed, realv share, realv step,
                                   Accumulator *gathered, intv *active) {
    realv sum[3] = {(realv)(0.0f), (realv)(0.0f), (realv)(0.0f)}, depth = 0.0f;
    for (int c = 0; c < m->count; c++) {
        const Channel *channel = &m->channels[c];
        if (!channel->shown)
            continue;
        intv own = needed;
        if (p->culling)
            own &= cells_visible(channel->visible, p, &channel->field.view, point[0], point[1], point[2]);
        if (ANY(own))
            add_sample(channel, point, own, p->length, sum, &depth);
    }
    if (!ANY(depth > 0.0f))
        return;
    const bool linear = m->channels[0].field.sample.classification.linear;
    const realv opacity = linear ? MIN(depth, (realv)(1.0f)) * share : absorbed(depth * share);
    *active += COUNT_IF(opacity > 0.0f);
    accumulate_emission(sum, depth, opacity, gathered);
}

__kernel void channel_raycast(SHADED_CHANNELS, ScreenParams s, MarchParams p, ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= s.tiles_u * s.tiles_v)
        return;
    struct Marched marched;
    marched.count = count;
    SET_CHANNELS(marched.channels, count);
    for (int c = 0; c < count; c++)
        marched.channels[c].shown = true;
    const SampleParams *first = &marched.channels[0].field.sample;
    const int column = id % s.tiles_u * VW, row = id / s.tiles_u * TILE_ROWS;
    intv active = 0;
    for (int r = row; r < min(row + TILE_ROWS, s.height); r++) {
        const RowRays rays = row_rays(&s, column, r);
        const Interval interval = clip_rays(&ray_ends, rays.o, rays.d);
        Accumulator gathered = empty_accumulator(first);
        if (ANY(interval.from < interval.to))
            march_steps(&marched, first, &p, &rays, &interval, &gathered, &active);
        store_pixels(&s, first, marched.channels[0].table, column, r, &gathered, &interval, target);
    }
    active_samples[id] = sum_lanes(active, columns_on_screen(&s, column));
}
