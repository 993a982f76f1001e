// Layered rendering with point-sampled layers of several fields, on a lattice for any view (channels.cl). What is said about tiles, segments
// and clipping in point_lattice.cl applies to each field. One field alone is drawn by point_lattice.cl: to the same picture but for rounding,
// in 5 to 13 % less time.
//
// The layers are those of the frame. A field whose voxels lie in them, or are shifted by whole voxels, is resampled row by row; another one
// is reconstructed at each sample.

#include "layered/channel_apart.cl"
#include "layered/channels.cl"

// Sub-layer l of the frame in the lattice of a channel.
static inline int own_sub_layer(const Channel *c, int s, int l) {
    return c->field.place->placed == SHIFTED ? l - c->field.place->shift_a * s : l;
}

// Sub-layer l of the frame of a channel, with samples in all patches over which it can be visible.
static inline Layer *sampled_layer(Channel *c, int s, int l) {
    const int own = own_sub_layer(c, s, l);
    Layer *layer = &c->layers[l & 1];
    if (layer->index == own && !(c->over & ~layer->sampled))
        return layer;
    if (c->field.place->placed == APART)
        sample_apart(c, s, own, c->over, layer);
    else
        sample_layer(c->field.voxels, &c->field.view, c->lattice.centre_layer, s, own, &c->tile, c->over, layer);
    return layer;
}

static inline void light_shown(Channel *c, int s, Layer *layer) {
    if (c->field.place->placed == APART)
        light_apart(c, s, c->shown, layer);
    else
        light_layer(&c->shading, &c->lattice, &c->field.sample, &c->tile, s, c->shown, layer);
}

// The span of a patch's rays that starts in plane k of the frame, in a channel's own voxels.
static inline RaySpan own_span(const Channel *c, const RaySpan *span) {
    if (c->field.place->placed == ON_FRAME)
        return *span;
    RaySpan own = *span;
    to_own_voxels(c->field.place, span->origin, 1.0f, own.origin);
    to_own_voxels(c->field.place, span->step, 0.0f, own.step);
    return own;
}

// Patches in `open` where a segment between two sub-layers of a channel can be visible.
static inline int shown_patches(const Channel *c, int open, const Layer *front, const Layer *behind) {
    int shown = open & c->over;
#if !GATHERS_VALUES
    for (int left = shown; left; left &= left - 1) {
        const int n = LOWEST_BIT(left);
        if (!ANY(is_visible_between(&c->field.sample, front->at.field[n], behind->at.field[n])))
            shown &= ~(1 << n);
    }
#endif
    return shown;
}

// Slabs of the frame, from q on along the rays, in which a channel is known to be invisible; 0 if it can be visible in slab q, in the
// patches `over`.
static inline int hidden_slabs(Channel *c, int q, int enters) {
    const RayLatticeParams *p = &c->lattice;
    c->over = 0;
    if (c->lowest > c->highest || (enters ? q < c->lowest : q > c->highest))
        return INT_MAX;
    if (enters ? q > c->highest : q < c->lowest)
        return enters ? q - c->highest : c->lowest - q;
    if (!p->culling) {
        c->over = LOW_BITS(c->tile.bands * PATCH_ROWS);
        return 0;
    }
    const int last = enters ? c->lowest : c->highest;
    if (c->field.place->placed == APART)
        return hidden_apart(c, q, last, enters);
    const int shift = c->field.place->placed == SHIFTED ? c->field.place->shift_a : 0;
    const int hidden =
        slabs_to_skip(c->visible, p, c->field.view.first_a, &c->tile, q - shift, last - shift, enters, &c->chunk, &c->over);
    if (hidden)
        c->over = 0;
    return hidden;
}

#if BLEND == COMPOSITE
// Classifies the current span of a channel. `places`: of its ends, in spans; `length`: of the span, per patch.
static inline void classify_span(Channel *c, const int places[2], float2 weights, float length, const realv *lengths) {
    const SampleParams *sample = &c->field.sample;
    const Part *parts = c->parts;
    for (int end = 0; end < 2; end++) {
        const int place = places[end], odd = place & 1;
        const Samples *here = end ? c->back : c->front;
        for (int left = c->shown; left; left &= left - 1) {
            const int n = LOWEST_BIT(left);
            if (c->nodes_at[odd][n] == place)
                continue;
            c->nodes[odd][n] = look_up_node(sample, c->integrals, here->field[n], odd);
            c->nodes_at[odd][n] = place;
        }
    }
    const Node *at_front = c->nodes[places[0] & 1], *at_back = c->nodes[places[1] & 1];
    for (int left = c->shown; left; left &= left - 1) {
        const int n = LOWEST_BIT(left);
        const realv from = c->front->field[n], to = c->back->field[n];
        const realv unit = length * (lengths[n] * sample->classification.table_unit);
#ifdef CLIPPED
        if (any_clipped(&parts[n])) {
            const realv cut_from = lerp(from, to, parts[n].from), cut_to = lerp(from, to, parts[n].to);
            const Node at_cut = look_up_node(sample, c->integrals, cut_from, places[0] & 1);
            const Node behind_cut = look_up_node(sample, c->integrals, cut_to, places[1] & 1);
            c->segments[n] = segment_between(sample, c->integrals, &at_cut, &behind_cut, cut_from, cut_to, weights,
                                             unit * part_length(&parts[n]));
            continue;
        }
#endif
        c->segments[n] = segment_between(sample, c->integrals, &at_front[n], &at_back[n], from, to, weights, CLIPPED_LENGTH(unit, &parts[n]));
    }
}
#else
// Accumulates the current span of a channel in a patch. `place`: number of the span along the rays.
static inline void accumulate_channel(Channel *c, int n, const RaySpan *frame_span, float length, int place, intv *active) {
    Accumulator *a = &c->gathered[n];
    const Part *part = &c->parts[n];
    const RaySpan own = own_span(c, frame_span), *span = &own;
#if BLEND == ISO
    const intv was_open = a->t > 0.5f;
    realv crossing = 0.0f;
    const RaySpan *lit = c->field.place->placed == APART ? frame_span : span;
    accumulate_crossing(c->field.voxels, &c->field.view, &c->shading, &c->field.sample, part, span, lit, &c->front->lit[n],
                        &c->back->lit[n], &crossing, a, active);
    c->surface[n] = was_open && !(a->t > 0.5f) ? place + crossing : c->surface[n];
#else
    accumulate_span(c->field.voxels, &c->field.view, part, span, part_length(part) * length, a, active);
#endif
}
#endif

// Rays that further samples can change: of surfaces, those that no channel has hit yet.
static inline bool is_open(const Channel *channels, int count, int n, intv has_ray, const Accumulator *gathered) {
#if BLEND == COMPOSITE
    return ANY(has_ray && open_rays(&channels[0].field.sample, &gathered[n]));
#else
    intv open = BLEND == ISO ? has_ray : (intv)(0);
    for (int c = 0; c < count; c++) {
        const intv own = has_ray && open_rays(&channels[c].field.sample, &channels[c].gathered[n]);
        open = BLEND == ISO ? open & own : open | own;
    }
    return ANY(open);
#endif
}

__kernel void channel_lattice(SHADED_CHANNELS, PER_CHANNEL(__global const int4 *, integrals),
                              PER_CHANNEL(__global const int *, shown_slabs), RayLatticeParams p, CHANNEL_COLORS ulong first_item) {
    const int order = first_item + get_global_id(0);
    if (order >= p.tiles_u * p.tiles_v)
        return;
    __global const int *const all_shown_slabs[MAX_CHANNELS] = EACH(shown_slabs);
    __global const int4 *const all_integrals[MAX_CHANNELS] = EACH(integrals);

    const int id = scheduled_tile(&p, order);
    const Tile tile = make_tile(&p, id);
    const int patches = tile.bands * PATCH_ROWS;
    Channel channels[CHANNELS];
    SET_CHANNELS(channels, count);
    SET_COLORS(channels, count);
    int lowest = INT_MAX, highest = INT_MIN;
    for (int c = 0; c < count; c++) {
        Channel *channel = &channels[c];
        __global const FieldPlacement *place = channel->field.place;
        channel->integrals = all_integrals[c];
        channel->layers[0].index = channel->layers[1].index = INT_MIN;
        channel->chunk.index = INT_MIN, channel->chunk.bits = 0;
        channel->lowest = max(p.first_layer, place->first_slab), channel->highest = min(p.last_layer, place->last_slab);
        channel->lattice = p, channel->tile = tile;
        if (place->placed == APART) {
            channel->apart.steps_per_slab = steps_per_slab(place, &tile);
            set_own_rays(channel);
        }
        channel->lattice.blocks_u = place->blocks_u, channel->lattice.blocks_v = place->blocks_v;
        int first_layer = channel->field.view.first_a;
        if (place->placed == SHIFTED) {
            channel->lattice.rays[0] -= place->shift_u, channel->lattice.rays[4] -= place->shift_v;
            channel->lattice.centre_layer -= place->shift_a;
            channel->tile = make_tile(&channel->lattice, id);
            first_layer += place->shift_a;
        }
        if (p.culling && place->placed != APART) {
            channel->lowest = max(channel->lowest, all_shown_slabs[c][0] + first_layer);
            channel->highest = min(channel->highest, all_shown_slabs[c][1] + first_layer);
        }
        if (channel->lowest <= channel->highest)
            lowest = min(lowest, channel->lowest), highest = max(highest, channel->highest);
        for (int n = 0; n < patches; n++) {
#if BLEND == COMPOSITE
            channel->nodes_at[0][n] = channel->nodes_at[1][n] = INT_MIN;
#else
            channel->gathered[n] = empty_accumulator(&channel->field.sample);
#endif
#if BLEND == ISO
            channel->surface[n] = INFINITY;
#endif
        }
    }
    const SampleParams *first = &channels[0].field.sample;
    Accumulator gathered[TILE_ROWS];
    Interval intervals[TILE_ROWS];
    intv has_ray[TILE_ROWS];
    realv lengths[TILE_ROWS];
    intv active = 0;
    int open = 0; // patches that further samples can change
    for (int n = 0; n < patches; n++) {
        const SampleRays rays = patch_rays(&p, &tile, n);
        gathered[n] = empty_accumulator(first);
        has_ray[n] = lanes_with_rays(&p, &tile, n);
        lengths[n] = length_per_layer(first, &rays);
#ifdef CLIPPED
        intervals[n] = clip_sample_rays(&p, &ray_ends, &rays);
#endif
        open |= (is_open(channels, count, n, has_ray[n], gathered) ? 1 : 0) << n;
    }
#ifdef CUT_RAYS
    cut_intervals(&p, &tile, cuts, intervals);
#endif
#ifdef CLIPPED
    for (int n = 0; n < patches; n++) {
        const SampleRays rays = patch_rays(&p, &tile, n);
        const realv origin[3] = {rays.centre_u, rays.centre_v, (realv)(p.centre_layer)};
        const realv direction[3] = {rays.shear_u * p.layer_step, rays.shear_v * p.layer_step, (realv)(p.layer_step)};
        for (int c = 0; c < count; c++)
            channels[c].intervals[n] = interval_within(channels[c].field.place, &intervals[n], origin, direction);
    }
    const TileBounds bounds = tile_bounds(intervals, patches);
#ifdef CUT_RAYS
    // Nothing reads these samples.
    if (bounds.from >= bounds.to) {
        active_samples[id] = 0;
        return;
    }
#endif
#endif

    const int s = SAMPLES_PER_LAYER(first), enters = p.layer_step > 0 ? 0 : 1;
    // No sum of these is larger than an int: both are unchanged only if nothing is visible.
    const int slabs = lowest > highest ? 0 : highest - lowest + 1;
    for (int passed = 0; passed < slabs && open; passed++) {
        const int q = enters ? highest - passed : lowest + passed;
#ifdef CLIPPED
        const int within = patches_in_slab(&bounds, patches, p.layer_step * (q - RADIUS + enters - p.centre_layer));
        if (!within)
            continue;
#endif
        int hidden = INT_MAX;
        for (int c = 0; c < count; c++)
            hidden = min(hidden, hidden_slabs(&channels[c], q, enters));
        if (hidden) {
            passed += min(hidden, slabs) - 1;
            continue;
        }
#ifdef CUT_RAYS
        int over = 0;
        for (int c = 0; c < count; c++)
            over |= channels[c].over &= within;
        if (!(open & over))
            continue;
#endif
        const int ahead = q - RADIUS + 1 - enters + (RADIUS + 1) * p.layer_step;
        for (int c = 0; c < count; c++)
            if (channels[c].over && channels[c].field.place->placed != APART)
                fetch_ahead(channels[c].field.voxels, &channels[c].field.view, &p, &tile, ahead);
        for (int i = 0; i < s; i++) {
            const int l0 = enters ? (q + 1) * s - i : q * s + i, l1 = l0 + p.layer_step;
            // The plane where rays enter, and the distance to the one where they leave.
            const float k = (float)l0 / s - RADIUS, step = (float)p.layer_step / s;
            int spans = 1, shown = 0;
            for (int c = 0; c < count; c++) {
                Channel *channel = &channels[c];
                channel->shown = 0;
                if (!channel->over)
                    continue;
                Layer *front = sampled_layer(channel, s, l0);
                Layer *behind = sampled_layer(channel, s, l1);
                channel->shown = shown_patches(channel, open, front, behind);
                shown |= channel->shown;
                if (!channel->shown)
                    continue;
                if (channel->field.sample.light.shading && LIT_AT_ENDS) {
                    light_shown(channel, s, front);
                    light_shown(channel, s, behind);
                }
                channel->front = &front->at, channel->back = &behind->at;
            }
            if (!shown)
                continue;
#if ANALYTIC_GRADIENTS && LIT_AT_ENDS
            if (first->light.shading) {
                spans = 2;
                for (int c = 0; c < count; c++) {
                    Channel *channel = &channels[c];
                    const Samples *ends[2] = {channel->front, channel->back};
                    const float own_k = channel->field.place->placed == SHIFTED ? k - channel->field.place->shift_a : k;
                    if (channel->shown)
                        find_middle(&channel->lattice, &channel->field.sample, channel->shading.light, channel->integrals, &channel->tile,
                                    own_k, step, channel->shown, ends, &channel->middle);
                }
            }
#endif
            for (int w = 0; w < spans; w++) {
                const float length = 1.0f / spans, from_k = k + w * length * step;
                const int places[2] = {spans * l0 + w * p.layer_step, spans * l0 + (w + 1) * p.layer_step};
                Part parts[TILE_ROWS];
#ifdef CLIPPED
                const float enters_at = p.layer_step * (from_k - p.centre_layer);
                for (int n = 0; n < patches; n++)
                    parts[n] = part_of(&intervals[n], (realv)(enters_at), (realv)(enters_at + length / s));
                for (int c = 0; c < count; c++)
                    for (int left = channels[c].shown; left; left &= left - 1) {
                        const int n = LOWEST_BIT(left);
                        channels[c].parts[n] = part_of(&channels[c].intervals[n], (realv)(enters_at), (realv)(enters_at + length / s));
                    }
#endif
                for (int c = 0; c < count; c++) {
                    Channel *channel = &channels[c];
                    if (!channel->shown)
                        continue;
#if ANALYTIC_GRADIENTS && LIT_AT_ENDS
                    if (spans == 2) {
                        channel->front = w ? &channel->middle : &channel->layers[l0 & 1].at;
                        channel->back = w ? &channel->layers[l1 & 1].at : &channel->middle;
                    }
#endif
#if BLEND == COMPOSITE
                    classify_span(channel, places, end_weights(&channel->field.sample, l0, l1), length, lengths);
#endif
                }
                for (int left = shown; left; left &= left - 1) {
                    const int n = LOWEST_BIT(left);
                    intv counts = 0;
                    RaySpan ray_spans[CHANNELS];
                    for (int c = 0; c < count; c++) {
                        Channel *channel = &channels[c];
                        if (!(channel->shown >> n & 1))
                            continue;
                        const RaySpan span =
                            patch_span(&p, &tile, n, from_k, length * step, channel->front->field[n], channel->back->field[n]);
#if BLEND != COMPOSITE
                        accumulate_channel(channel, n, &span, 1.0f / s, places[0] * p.layer_step, &counts);
#else
                        ray_spans[c] = own_span(channel, &span);
#endif
                    }
#if BLEND == COMPOSITE
                    composite_channels(channels, count, n, ray_spans, &parts[n], CLIPPED_LENGTH(length * lengths[n], &parts[n]),
                                       &gathered[n], &counts);
#endif
                    active += COUNT_IF(counts > 0) & has_ray[n];
                    if (!is_open(channels, count, n, has_ray[n], gathered))
                        open &= ~(1 << n);
                }
            }
        }
    }

#ifdef CLIPPED
    regroup_all((realv *)intervals, sizeof(Interval) / sizeof(realv), tile.bands);
#endif
#if BLEND == COMPOSITE
    regroup_all((realv *)gathered, RAW_FLOATS, tile.bands);
#else
    for (int c = 0; c < count; c++) {
        regroup_all((realv *)channels[c].gathered, RAW_FLOATS, tile.bands);
#ifdef CLIPPED
        regroup_all((realv *)channels[c].intervals, sizeof(Interval) / sizeof(realv), tile.bands);
#endif
    }
#if BLEND == ISO
    for (int c = 0; c < count; c++)
        regroup_all(channels[c].surface, 1, tile.bands);
#endif
#endif
    uint total = sum_lanes(active, VW);
    for (int r = 0; r < tile.rows; r++) {
        realv color[4];
#if BLEND == COMPOSITE
        resolve(first, channels[0].table, &gathered[r], &intervals[r], color);
#else
        resolve_channels(channels, count, r, color);
#endif
        STORE_ROW_COLORS(&p, color, target, &tile, r);
        if (GATHERS_VALUES)
            total += COUNT_VISIBLE_IN_ROW(&p, color, &tile, r);
    }
    active_samples[id] = total;
}
