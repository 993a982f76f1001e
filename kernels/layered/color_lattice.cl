// Layered rendering with point-sampled layers of a volume of colours, on a lattice for any view. What is said about tiles, segments and
// clipping in point_lattice.cl applies here.
//
// Four fields are interpolated, by kernels without negative weights: extinction times colour (red, green, blue), and extinction. Their ratio
// is the colour, so that transparent voxels do not bleed theirs. All four are linear between two samples. Lighting follows the gradient of
// the extinction.

#include "layered/point_tile.cl"
#include "shared/color_absorption.cl"

#if BLEND != COMPOSITE
#error "BLEND: volumes of colours are composited"
#endif

// The fields, and their samples in a tile: extinction last.
typedef struct {
    __global const VOXEL *voxels[4];
    Layer layers[2][4];
} Fields;

// Sub-layer l of a field, with samples in some patches.
static inline Layer *sampled_layer(Fields *fields, int field, const VolumeView *view, const RayLatticeParams *p, const Tile *tile, int s,
                                   int l, int patches) {
    Layer *layer = &fields->layers[l & 1][field];
    if (layer->index != l || patches & ~layer->sampled)
        sample_layer(fields->voxels[field], view, p->centre_layer, s, l, tile, patches, layer);
    return layer;
}

// Values of the four fields in a patch, `t` of the way from one sample to the next.
static inline void colors_between(const Layer *front, const Layer *back, int n, realv t, realv *color) {
    for (int i = 0; i < 4; i++)
        color[i] = lerp(front[i].at.field[n], back[i].at.field[n], t);
}

// With linear extinction, absorption is of the opacity: scales the four values to it.
static inline void scale_to_absorption(const SampleParams *p, realv *color) {
    if (!p->classification.linear)
        return;
    const realv scale = color_absorption(p, color[3]) * reciprocal(color[3] > 0.0f ? color[3] : (realv)(1.0f));
    for (int i = 0; i < 4; i++)
        color[i] *= scale;
}

// The segment between two of these. `ends`: weights of the front and back values; `length` in unit distances.
static inline Segment color_segment(const realv *front, const realv *back, float2 ends, realv length) {
    const float even = 0.5f * (1.0f - ends.x - ends.y), weight_front = even + ends.x, weight_back = even + ends.y;
    const realv extinction = weight_front * front[3] + weight_back * back[3];
    const realv per_extinction = reciprocal(extinction > 0.0f ? extinction : (realv)(1.0f));
    Segment s;
    s.r = (weight_front * front[0] + weight_back * back[0]) * per_extinction;
    s.g = (weight_front * front[1] + weight_back * back[1]) * per_extinction;
    s.b = (weight_front * front[2] + weight_back * back[2]) * per_extinction;
    s.depth = extinction * length;
    const realv both = front[3] + back[3];
    s.centroid = both > 0.0f ? 0.3333333f * (1.0f + back[3] * reciprocal(both > 0.0f ? both : (realv)(1.0f))) : (realv)(0.5f);
    return s;
}

// Composites a segment, in parts that dim each other where it is deep.
static inline void composite_colors(const SampleParams *p, const Layer *front, const Layer *back, int n, const Part *part, float2 ends,
                                    realv length, Accumulator *a, intv *active) {
    const LitSample *lit_front = &front[3].at.lit[n], *lit_back = &back[3].at.lit[n];
    realv from[4], to[4];
    colors_between(front, back, n, SEGMENT_PARAMETER(part, (realv)(0.0f)), from);
    colors_between(front, back, n, SEGMENT_PARAMETER(part, (realv)(1.0f)), to);
    scale_to_absorption(p, from);
    scale_to_absorption(p, to);
    const Segment whole = color_segment(from, to, ends, length);
    const Accumulator before = *a;
    composite_segment(p, &whole, part, opacity_of_depth(p, whole.depth), lit_front, lit_back, a, active);
    const intv deep = whole.depth > SUBDIVISION_DEPTH && !p->classification.linear;
    if (!ANY(deep))
        return;
    Accumulator subdivided = before;
    const realv step = reciprocal(CLAMP(whole.depth * (1.0f / SUBSEGMENT_DEPTH), (realv)(2.0f), (realv)(MAX_SUBSEGMENTS)));
    // The curve of the cubic changes the depth of the whole, which its parts share.
    const realv mean = 0.5f * (from[3] + to[3]);
    const realv scale = whole.depth * reciprocal(mean > 0.0f ? mean : (realv)(1.0f));
    realv t = deep ? (realv)(0.0f) : (realv)(1.0f);
    for (int i = 1; i <= MAX_SUBSEGMENTS && ANY(t < 1.0f && subdivided.t > p->segments.opaque); i++) {
        const realv next_t = MIN(i * step, (realv)(1.0f)), middle = 0.5f * (t + next_t);
        realv color[4];
        colors_between(front, back, n, SEGMENT_PARAMETER(part, middle), color);
        const realv per_extinction = reciprocal(color[3] > 0.0f ? color[3] : (realv)(1.0f));
        Lighting lighting;
        if (p->light.shading)
            lighting = interpolate_lighting(p, lit_front, lit_back, SEGMENT_PARAMETER(part, middle));
        accumulate_lit(p, color[0] * per_extinction, color[1] * per_extinction, color[2] * per_extinction,
                       absorbed(color[3] * scale * (next_t - t)), &lighting, &subdivided);
        t = next_t;
    }
    a->r = deep ? subdivided.r : a->r;
    a->g = deep ? subdivided.g : a->g;
    a->b = deep ? subdivided.b : a->b;
    a->t = deep ? subdivided.t : a->t;
}

__kernel void color_lattice(COLOR_FIELDS, __global const int *shown_slabs, RayLatticeParams p, ulong first_item) {
    const int order = first_item + get_global_id(0);
    if (order >= p.tiles_u * p.tiles_v)
        return;
    const int id = scheduled_tile(&p, order);
    voxels += view.first;
    const ShadingSource shading = SHADING_SOURCE;
    const Tile tile = make_tile(&p, id);
    Fields fields = {{red + view.first, green + view.first, blue + view.first, voxels}};
    for (int i = 0; i < 4; i++)
        fields.layers[0][i].index = fields.layers[1][i].index = INT_MIN;
    Accumulator gathered[TILE_ROWS];
    Interval intervals[TILE_ROWS];
    intv has_ray[TILE_ROWS];
    realv lengths[TILE_ROWS];
    intv active = 0;
    const int patches = tile.bands * PATCH_ROWS;
    int open = 0; // patches that further samples can change
    for (int n = 0; n < patches; n++) {
        const SampleRays rays = patch_rays(&p, &tile, n);
        gathered[n] = empty_accumulator(&sample);
        has_ray[n] = lanes_with_rays(&p, &tile, n);
        lengths[n] = length_per_layer(&sample, &rays);
#ifdef CLIPPED
        intervals[n] = clip_sample_rays(&p, &ray_ends, &rays);
#endif
        open |= (ANY(has_ray[n]) ? 1 : 0) << n;
    }
#ifdef CLIPPED
    float begin, end;
    tile_bounds(intervals, patches, &begin, &end);
#endif

    const int s = SAMPLES_PER_LAYER(&sample), enters = p.layer_step > 0 ? 0 : 1;
    int lowest = p.first_layer, highest = p.last_layer;
    if (p.culling)
        lowest = max(lowest, shown_slabs[0] + view.first_a), highest = min(highest, shown_slabs[1] + view.first_a);
    Chunk chunk = {-1, 0};
    for (int passed = 0; passed <= highest - lowest && open; passed++) {
        const int q = enters ? highest - passed : lowest + passed;
#ifdef CLIPPED
        const float entry = p.layer_step * (q - RADIUS + enters - p.centre_layer);
        if (entry >= end || entry + 1.0f <= begin)
            continue;
#endif
        int over = LOW_BITS(patches);
        const int skip =
            p.culling ? slabs_to_skip(visible, &p, view.first_a, &tile, q, enters ? lowest : highest, enters, &chunk, &over) : 0;
        if (skip) {
            passed += skip - 1;
            continue;
        }
        for (int i = 0; i < s; i++) {
            const int l0 = enters ? (q + 1) * s - i : q * s + i, l1 = l0 + p.layer_step;
            Layer *front = sampled_layer(&fields, 3, &view, &p, &tile, s, l0, over);
            Layer *behind = sampled_layer(&fields, 3, &view, &p, &tile, s, l1, over);
            int shown = open & over;
            for (int left = shown; left; left &= left - 1) {
                const int n = LOWEST_BIT(left);
                if (!ANY(is_visible_between(&sample, front->at.field[n], behind->at.field[n])))
                    shown &= ~(1 << n);
            }
            if (!shown)
                continue;
            for (int field = 0; field < 3; field++) {
                sampled_layer(&fields, field, &view, &p, &tile, s, l0, over);
                sampled_layer(&fields, field, &view, &p, &tile, s, l1, over);
            }
            if (sample.light.shading) {
                light_layer(&shading, &p, &sample, &tile, s, shown, front);
                light_layer(&shading, &p, &sample, &tile, s, shown, behind);
            }
            const float2 ends = end_weights(&sample, l0, l1);
            for (int left = shown; left; left &= left - 1) {
                const int n = LOWEST_BIT(left);
                Part part;
#ifdef CLIPPED
                const float enters_at = p.layer_step * ((float)l0 / s - RADIUS - p.centre_layer);
                part = part_of(&intervals[n], (realv)(enters_at), (realv)(enters_at + 1.0f / s));
#endif
                intv counts = 0;
                composite_colors(&sample, fields.layers[l0 & 1], fields.layers[l1 & 1], n, &part, ends, CLIPPED_LENGTH(lengths[n], &part),
                                 &gathered[n], &counts);
                active += counts & has_ray[n];
                if (!ANY(has_ray[n] && open_rays(&sample, &gathered[n])))
                    open &= ~(1 << n);
            }
        }
    }

    regroup_all((realv *)gathered, RAW_FLOATS, tile.bands);
    uint total = sum_lanes(active, VW);
    for (int r = 0; r < tile.rows; r++) {
        realv color[4];
        resolve(&sample, 0, &gathered[r], &intervals[r], color);
        STORE_ROW_COLORS(&p, color, target, &tile, r);
    }
    active_samples[id] = total;
}
