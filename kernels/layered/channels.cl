// The fields that a scene composites together, and one segment of a ray through all of them.
//
// Extinctions add: tau = sum of tau_c. Emission is sum(tau_c C_c) / tau, so that the order of the fields does not matter.

#include "shared/channel.cl"
#include "layered/point_tile.cl"
#include "shared/emission.cl"

// Rays among the voxels of a field: where they cross the layer of the frame's centre, and their steps from layer to layer.
typedef struct {
    realv origin[3], step[3];
} OwnRays;

// Smallest and largest of such numbers.
typedef struct {
    float origin[2][3], step[2][3];
} OwnBeam;

// Of a field with voxels anywhere: the rays of patches, between which they lie, and between which all do; the steps in which its cells are
// tested from plane to plane, two planes, and the patches that can be visible there.
typedef struct {
    OwnRays rays[TILE_ROWS];
    OwnBeam beams[TILE_ROWS], whole;
    int steps_per_slab, plane[2], shown_at[2];
} Apart;

// One field of a scene, under a tile.
typedef struct {
    ChannelField field;
    ShadingSource shading;
    __global const uchar *visible;
    __global const float4 *table;
    __global const int4 *integrals;
    // The lattice in the field's own voxels if these are shifted, otherwise in the frame's; the rays of the tile there.
    RayLatticeParams lattice;
    Tile tile;
    // First and last slab with anything visible; the chunk of slabs that the tile is in; patches over which a slab can be visible, and
    // those in which a segment is.
    int lowest, highest;
    Chunk chunk;
    int over, shown;
    Apart apart;
    Layer layers[2];
#if ANALYTIC_GRADIENTS && LIT_AT_ENDS
    Samples middle;
#endif
    // Samples at the ends of the current span, and the part of it inside the clip interval and the field's ends.
    const Samples *front, *back;
    Part parts[TILE_ROWS];
#ifdef CLIPPED
    Interval intervals[TILE_ROWS];
#endif
#if BLEND == COMPOSITE
    // Table nodes of the samples at even and at odd positions, and these positions.
    Node nodes[2][TILE_ROWS];
    int nodes_at[2][TILE_ROWS];
    Segment segments[TILE_ROWS];
#else
    Accumulator gathered[TILE_ROWS];
#endif
#if BLEND == ISO
    // Where the surface is, in spans along the ray.
    realv surface[TILE_ROWS];
#endif
} Channel;

#if BLEND == COMPOSITE

// Optical depth of a channel's segment in patch n.
static inline realv depth_in(const Channel *c, int n) {
#ifdef THINNED
    const Segment *s = &c->segments[n];
    if (c->field.sample.light.shading)
        return s->depth * extinction_scale_on_span(&c->front->lit[n], &c->back->lit[n], SEGMENT_PARAMETER(&c->parts[n], s->centroid));
#endif
    return c->segments[n].depth;
}

#ifdef DIMMED
// Share of the span from one of its parameters to another that lies in the part of a channel.
static inline realv share_in(const Channel *c, int n, realv from, realv to) {
#ifdef CLIPPED
    const Part *part = &c->parts[n];
    return MAX(MIN(part->to, to) - MAX(part->from, from), (realv)(0.0f)) * reciprocal(MAX(to - from, (realv)(1e-6f)));
#else
    return 1.0f;
#endif
}

// As composite_subsegments() does for one field. `part`: of all channels; `length`: of it, in the unit of lengths.
static inline void composite_channel_subsegments(Channel *channels, int count, int n, const RaySpan *spans, const Part *part, intv lanes,
                                                 realv depth, realv length, Accumulator *a) {
    const realv step = reciprocal(CLAMP(depth * (1.0f / SUBSEGMENT_DEPTH), (realv)(2.0f), (realv)(MAX_SUBSEGMENTS)));
    realv t = lanes ? (realv)(0.0f) : (realv)(1.0f);
    realv values[CHANNELS];
    Node nodes[CHANNELS];
    for (int c = 0; c < count; c++) {
        Channel *channel = &channels[c];
        if (!(channel->shown >> n & 1))
            continue;
        values[c] = value_on_span(channel->field.voxels, &channel->field.view, &spans[c], SEGMENT_PARAMETER(part, (realv)(0.0f)), lanes);
        nodes[c] = look_up_node(&channel->field.sample, channel->integrals, values[c], 0);
    }
    for (int i = 1; i <= MAX_SUBSEGMENTS && ANY(t < 1.0f && a->t > channels[0].field.sample.segments.opaque); i++) {
        const realv next_t = MIN(i * step, (realv)(1.0f));
        realv sum[3] = {(realv)(0.0f), (realv)(0.0f), (realv)(0.0f)}, whole_depth = 0.0f;
        for (int c = 0; c < count; c++) {
            Channel *channel = &channels[c];
            if (!(channel->shown >> n & 1))
                continue;
            const SampleParams *p = &channel->field.sample;
            const LitSample *front = &channel->front->lit[n], *back = &channel->back->lit[n];
            const realv next_value =
                value_on_span(channel->field.voxels, &channel->field.view, &spans[c], SEGMENT_PARAMETER(part, next_t), lanes);
            const Node next = look_up_node(p, channel->integrals, next_value, i & 1);
            const Difference d = difference_between(p, channel->integrals, &nodes[c], &next, values[c], next_value);
            const realv per_extinction = reciprocal(d.extinction == 0.0f ? (realv)(1.0f) : d.extinction);
            Emission e;
            e.depth = d.extinction * (length * p->classification.table_unit * reciprocal(d.distance));
            if (channel->field.place->has_ends)
                e.depth *= share_in(channel, n, SEGMENT_PARAMETER(part, t), SEGMENT_PARAMETER(part, next_t));
            if (p->light.shading)
                e.lighting = interpolate_lighting(p, front, back, SEGMENT_PARAMETER(part, 0.5f * (t + next_t)));
#ifdef THINNED
            if (p->light.shading)
                e.depth *= e.lighting.extinction_scale;
#endif
            realv r = d.r * per_extinction, g = d.g * per_extinction, b = d.b * per_extinction;
#ifdef TINTED
            mix_color(&channel->shading.tint, point_on_span(&spans[c], SEGMENT_PARAMETER(part, 0.5f * (t + next_t))), &r, &g, &b);
#endif
            add_emission(p, r, g, b, &e, sum);
            whole_depth += e.depth;
            values[c] = next_value, nodes[c] = next;
        }
        const realv opacity = whole_depth > OPAQUE_DEPTH ? (realv)(1.0f) : absorbed(whole_depth * (next_t - t));
        accumulate_emission(sum, whole_depth, opacity, a);
        t = next_t;
    }
}
#endif

// Composites the segments of all channels that are shown in patch n. `part`: of the span, for all; `length`: of it, in the unit of lengths.
static inline void composite_channels(Channel *channels, int count, int n, const RaySpan *spans, const Part *part, realv length,
                                      Accumulator *a, intv *active) {
    realv depth = 0.0f;
    Emission emissions[CHANNELS];
    for (int c = 0; c < count; c++) {
        if (!(channels[c].shown >> n & 1))
            continue;
        emissions[c].depth = depth_in(&channels[c], n);
        depth += emissions[c].depth;
    }
    const realv opacity = opacity_of_depth(&channels[0].field.sample, depth);
    *active += COUNT_IF(opacity > 0.0f);
    realv sum[3] = {(realv)(0.0f), (realv)(0.0f), (realv)(0.0f)};
    for (int c = 0; c < count; c++) {
        Channel *channel = &channels[c];
        if (!(channel->shown >> n & 1))
            continue;
        const Segment *s = &channel->segments[n];
        const LitSample *front = &channel->front->lit[n], *back = &channel->back->lit[n];
        const realv origin = SEGMENT_PARAMETER(&channel->parts[n], visible_origin(s, depth));
        if (channel->field.sample.light.shading)
            emissions[c].lighting = interpolate_lighting(&channel->field.sample, front, back, origin);
        realv r = s->r, g = s->g, b = s->b;
#ifdef TINTED
        if (ANY(s->depth > 0.0f))
            mix_color(&channel->shading.tint, point_on_span(&spans[c], origin), &r, &g, &b);
#endif
        add_emission(&channel->field.sample, r, g, b, &emissions[c], sum);
    }
#ifdef DIMMED
    const Accumulator before = *a;
#endif
    accumulate_emission(sum, depth, opacity, a);
#ifdef DIMMED
    const intv deep = depth > SUBDIVISION_DEPTH;
    if (ANY(deep)) {
        Accumulator subdivided = before;
        composite_channel_subsegments(channels, count, n, spans, part, deep, depth, length, &subdivided);
        a->r = deep ? subdivided.r : a->r;
        a->g = deep ? subdivided.g : a->g;
        a->b = deep ? subdivided.b : a->b;
        a->t = deep ? subdivided.t : a->t;
    }
#endif
}

#else

// Colour of a ray: the colours of all channels, added and clamped to 1; of surfaces, that of the nearest one.
static inline void resolve_channels(const Channel *channels, int count, int r, realv *color) {
    realv nearest = INFINITY;
    for (int i = 0; i < 4; i++)
        color[i] = 0.0f;
    for (int c = 0; c < count; c++) {
#if BLEND == ISO
        realv own[4];
        resolve(&channels[c].field.sample, channels[c].table, &channels[c].gathered[r], &channels[c].intervals[r], own);
        const realv at = channels[c].surface[r];
        const intv is_nearer = at < nearest;
        nearest = is_nearer ? at : nearest;
        for (int i = 0; i < 4; i++)
            color[i] = is_nearer ? own[i] : color[i];
#else
        add_resolved(&channels[c].field.sample, channels[c].table, &channels[c].gathered[r], &channels[c].intervals[r], color);
#endif
    }
}

#endif
