// Ray casting of several fields, each in its own voxels: raycast.cl with the sum of extinctions (emission.cl).

#include "rays/steps.cl"
#include "shared/channel.cl"
#include "shared/emission.cl"

// One field of a scene.
typedef struct {
    ChannelField field;
    ShadingSource shading;
    __global const uchar *visible;
    __global const float4 *table;
    bool shown;        // in the current chunk of steps
    Interval interval; // in which the field is seen, in steps
} Channel;

// Points of the frame among the voxels of a channel.
ALWAYS_INLINE void own_points(const Channel *c, const realv *point, realv *own) {
    if (c->field.place->placed != ON_FRAME) {
        to_own_voxels(c->field.place, point, 1.0f, own);
        return;
    }
    for (int i = 0; i < 3; i++)
        own[i] = point[i];
}

struct Marched {
    Channel channels[CHANNELS];
    int count;
};

ALWAYS_INLINE bool box_shows(struct Marched *m, const MarchParams *p, const realv *one, const realv *other) {
    bool any = false;
    for (int c = 0; c < m->count; c++) {
        Channel *channel = &m->channels[c];
        realv own_one[3], own_other[3];
        own_points(channel, one, own_one);
        own_points(channel, other, own_other);
        channel->shown = box_visible(channel->visible, channel->field.place->blocks_u, channel->field.place->blocks_v,
                                     &channel->field.view, own_one, own_other);
        any |= channel->shown;
    }
    return any;
}

// Each channel has its own visibility: see accumulate_step().
ALWAYS_INLINE intv points_show(const struct Marched *m, const MarchParams *p, const realv *point, intv needed) { return needed; }

// Adds what a channel emits at a point where it is `needed`. `own`: the point among its voxels; `length`: of a step inside its ends.
ALWAYS_INLINE void add_sample(const Channel *c, const realv *point, const realv *own, intv needed, realv length, realv *sum,
                              realv *depth) {
    const SampleParams *sample = &c->field.sample;
    const realv value = value_at_own(&c->field, own, needed);
    const intv index = table_index(sample, value);
    needed &= index >= sample->classification.first_visible && index <= sample->classification.last_visible;
    if (!ANY(needed))
        return;
    realv r, g, b, extinction;
    table_entries(c->table, index, &r, &g, &b, &extinction);
#ifdef TINTED
    const Point colored = {own[0], own[1], own[2]};
    mix_color(&c->shading.tint, colored, &r, &g, &b);
#endif
    Emission e;
    e.depth = needed ? extinction * (length * sample->classification.table_unit) : (realv)(0.0f);
    if (sample->light.shading) {
        const Point at = {point[0], point[1], point[2]};
        const Gradient gradient = gradient_at(&c->shading, &sample->field, own[0], own[1], own[2], needed);
        e.lighting = shade(sample, c->shading.light, at, value, along_frame(c->field.place, gradient));
#ifdef THINNED
        e.depth *= e.lighting.extinction_scale;
#endif
    }
    add_emission(sample, r, g, b, &e, sum);
    *depth += e.depth;
}

ALWAYS_INLINE void accumulate_step(const struct Marched *m, const MarchParams *p, int n, const realv *point, intv needed, realv share,
                                   realv step, Accumulator *gathered, intv *active) {
    realv sum[3] = {(realv)(0.0f), (realv)(0.0f), (realv)(0.0f)}, depth = 0.0f;
    for (int c = 0; c < m->count; c++) {
        const Channel *channel = &m->channels[c];
        if (!channel->shown)
            continue;
        realv own[3], length = p->length;
        own_points(channel, point, own);
        intv shows = needed;
        if (p->culling)
            shows &= cells_visible(channel->visible, channel->field.place->blocks_u, channel->field.place->blocks_v, &channel->field.view,
                                   own[0], own[1], own[2]);
#ifdef CLIPPED
        if (channel->field.place->has_ends) {
            const realv inside = MIN(channel->interval.to, (realv)(n + 1.0f)) - MAX(channel->interval.from, (realv)(n));
            shows &= inside > 0.0f;
            // Of the share of the step that counts.
            length *= inside * reciprocal(shows ? share : (realv)(1.0f));
        }
#endif
        if (ANY(shows))
            add_sample(channel, point, own, shows, length, sum, &depth);
    }
    if (!ANY(depth > 0.0f))
        return;
    const bool linear = m->channels[0].field.sample.classification.linear;
    const realv opacity = linear ? MIN(depth, (realv)(1.0f)) * share : absorbed(depth * share);
    *active += COUNT_IF(opacity > 0.0f);
    accumulate_emission(sum, depth, opacity, gathered);
}

__kernel void channel_raycast(SHADED_CHANNELS, ScreenParams s, MarchParams p, CHANNEL_COLORS ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= s.tiles_u * s.tiles_v)
        return;
    struct Marched marched;
    marched.count = count;
    SET_CHANNELS(marched.channels, count);
    SET_COLORS(marched.channels, count);
    for (int c = 0; c < count; c++)
        marched.channels[c].shown = true;
    const SampleParams *first = &marched.channels[0].field.sample;
    const int column = id % s.tiles_u * VW, row = id / s.tiles_u * TILE_ROWS;
    intv active = 0;
    for (int r = row; r < min(row + TILE_ROWS, s.height); r++) {
        const RowRays rays = row_rays(&s, column, r);
        const Interval interval = SCREEN_INTERVAL(&s, &ray_ends, &rays, column, r);
        Accumulator gathered = empty_accumulator(first);
        const realv per_step = rays.length * (1.0f / p.length);
        for (int c = 0; c < count; c++) {
            Interval *own = &marched.channels[c].interval;
            *own = interval_within(marched.channels[c].field.place, &interval, rays.o, rays.d);
            own->from *= per_step, own->to *= per_step;
        }
        if (ANY(interval.from < interval.to))
            march_steps(&marched, first, &p, &rays, &interval, &gathered, &active);
        store_pixels(&s, first, marched.channels[0].table, column, r, &gathered, &interval, target);
    }
    active_samples[id] = sum_lanes(active, columns_on_screen(&s, column));
}
