// Layered rendering with point-sampled layers, on a lattice for any view: point_lattice.cl for GPUs.
//
// One work-item per sample of the lattice: VW is 1. A work-group is a tile of SAMPLE_COLUMNS x SAMPLE_ROWS samples. Its rays cross the
// slabs that any of them needs side by side, so that neighbouring work-items read neighbouring voxels. Field and lighting at the end of a
// segment are reused at the beginning of the next one; the state of a ray fits in registers. All else, including active_samples[tile], is
// as in point_lattice.cl.

// True of all layouts that lattices are rendered from.
#define ROWS_ALONG_U
#include "layered/point_sample.cl"
#include "layered/visible_group.cl"
#include "shared/segment.cl"

// end_weights() of all segments of a layer, in local memory: indexing kernel arguments by a variable would copy them to the private
// memory of every work-item.
#define END_FLOATS ((int)(sizeof((SampleParams *)0)->segments.ends / sizeof(float)))
ALWAYS_INLINE void share_end_weights(const SampleParams *sample, __local float *ends) {
#ifdef CURVED
    if (!get_local_id(0)) {
#pragma unroll
        for (int n = 0; n < END_FLOATS; n++)
            ends[n] = sample->segments.ends[n];
    }
    barrier(CLK_LOCAL_MEM_FENCE);
#endif
}
static inline float2 shared_end_weights(__local const float *ends, uint samples_per_layer, int l0, int l1) {
#ifdef CURVED
    const float2 weights = vload2((uint)min(l0, l1) % samples_per_layer, ends);
    return l0 < l1 ? weights : weights.yx;
#else
    return 0.0f;
#endif
}

// Sample at the end of a segment, which is reused where the next one begins.
typedef struct {
    bool is_lit;
    float field;
    LitSample lit;
} SegmentEnd;

static inline bool is_visible_to_beam(__global const uchar *visible, const RayLatticeParams *p, const VolumeView *view, const Beam *beam,
                                      int slab) {
    const float to_plane = slab + (p->layer_step > 0 ? 0 : 1) - RADIUS - p->centre_layer;
    const Window crossed = cells_crossed(beam, to_plane, to_plane + p->layer_step, 0.0f);
    return is_slab_visible(visible, p->blocks_u, p->blocks_v, slab - view->first_a, crossed);
}

// State of a ray between layers.
typedef struct {
    LatticeRay ray;
    float dt; // length per layer, in the table's units
    Interval interval;
    Accumulator gathered;
    SegmentEnd end;
    int last_slab; // slab at the end of which `end` lies
    int active; // segments with opacity
    bool open;
} RayState;

static inline RayState start_ray(const RayLatticeParams *p, const SampleParams *sample, const RayEnds *ends, int column, int row,
                                 __global const float4 *out) {
    const SampleRays rays = sample_rays(p, column, row);
    RayState state;
    state.ray.u = (float2)(rays.centre_u, rays.shear_u), state.ray.v = (float2)(rays.centre_v, rays.shear_v);
#if BLEND == COMPOSITE
    state.dt = length_per_layer(sample, &rays) * sample->classification.table_unit;
#endif
#ifdef CLIPPED
    state.interval = clip_sample_rays(p, ends, &rays);
#endif
    state.gathered = p->continues ? load_raw(sample, out, 1, 1) : empty_accumulator(sample);
    state.last_slab = INT_MIN, state.active = 0; // all else in `end` is set later, and takes no registers before
    state.open = !p->continues || any_open(sample, &state.gathered);
    return state;
}

// Advances a ray through slab q.
ALWAYS_INLINE void cross_slab(__global const VOXEL *voxels, const VolumeView *view, const ShadingSource *shading,
                              __global const int4 *integrals, const RayLatticeParams *p, const SampleParams *sample,
                              __local const float *ends, int q, RayState *state) {
    const int s = SAMPLES_PER_LAYER(sample), plane = q + (p->layer_step > 0 ? 0 : 1);
#ifdef CLIPPED
    const float entry = p->layer_step * (plane - RADIUS - p->centre_layer);
    if (entry >= state->interval.to || entry + 1.0f <= state->interval.from)
        return;
#endif
    bool front_known = state->last_slab == q - p->layer_step;
    state->last_slab = q;
    int l0 = plane * s;
    for (int i = 0; i < s && state->open; i++, l0 += p->layer_step) {
        const int l1 = l0 + p->layer_step;
        // Samples both ends, or only the back if the front is known; the same for lighting.
        float from;
        state->end.is_lit = front_known && state->end.is_lit;
        for (int l = front_known ? l1 : l0;; l = l1) {
            const Cells c = cells_in(view, &state->ray, p->centre_layer, s, l);
            from = state->end.field;
            state->end.field = value_in_cell(voxels, view, &c);
            if (l == l1)
                break;
        }
        front_known = true;
#if !GATHERS_VALUES
        if (!is_visible_between(sample, from, state->end.field)) {
            state->end.is_lit = false;
            continue;
        }
#endif
        LitSample lit;
        if (sample->light.shading && LIT_AT_ENDS) {
            for (int l = state->end.is_lit ? l1 : l0;; l = l1) {
                const Cells c = cells_in(view, &state->ray, p->centre_layer, s, l);
                lit = state->end.lit;
                state->end.lit = light_in_cell(voxels, view, shading, sample, &c);
                if (l == l1)
                    break;
            }
            state->end.is_lit = true;
        }
        const float k = (float)l0 / s - RADIUS, step = (float)p->layer_step / s;
        int spans = 1;
        float to = state->end.field;
        LitSample lit_to = state->end.lit;
#if ANALYTIC_GRADIENTS && LIT_AT_ENDS
        if (sample->light.shading) {
            const RaySpan whole = span_at_plane(state->ray.u.x, state->ray.u.y, state->ray.v.x, state->ray.v.y, p->centre_layer, k, step,
                                                from, to);
            lit_to = light_midpoint(sample, shading->light, &whole, contributes_between(sample, integrals, from, state->end.field), &lit,
                                    &state->end.lit, &to);
            spans = 2;
        }
#endif
#pragma unroll 1
        for (int w = 0; w < spans; w++) {
            const float length = 1.0f / spans, from_k = k + w * length * step;
            const RaySpan span = span_at_plane(state->ray.u.x, state->ray.u.y, state->ray.v.x, state->ray.v.y, p->centre_layer, from_k,
                                               length * step, from, to);
            Part part = {0.0f, 1.0f};
#ifdef CLIPPED
            const float enters_at = p->layer_step * (from_k - p->centre_layer);
            part = part_of(&state->interval, enters_at, enters_at + length / s);
#endif
#if BLEND == COMPOSITE
            // Nodes are looked up once for each segment: keeping them would take six registers.
            const float value_from = lerp(from, to, part.from), value_to = lerp(from, to, part.to);
            const float part_dt = CLIPPED_LENGTH(length * state->dt, &part);
            const int place = spans * l0 + w * p->layer_step;
            const Node front = look_up_node(sample, integrals, value_from, place & 1);
            const Node back = look_up_node(sample, integrals, value_to, (place + 1) & 1);
            const Segment segment =
                segment_between(sample, integrals, &front, &back, value_from, value_to, shared_end_weights(ends, s, l0, l1), part_dt);
            composite_span(voxels, view, sample, shading, integrals, &segment, &part, &span, part_dt, &lit, &lit_to, &state->gathered,
                           &state->active);
#elif BLEND == ISO
            accumulate_surface(voxels, view, shading, sample, &part, &span, &lit, &lit_to, &state->gathered, &state->active);
#else
            accumulate_span(voxels, view, &part, &span, part_length(&part) / s, &state->gathered, &state->active);
#endif
            from = to, lit = lit_to;
            to = state->end.field, lit_to = state->end.lit;
        }
        state->open = any_open(sample, &state->gathered);
    }
}

__attribute__((reqd_work_group_size(SAMPLE_COLUMNS * SAMPLE_ROWS, 1, 1)))
__kernel void point_samples(SHADED_FIELD, __global const uchar *visible, __global const int *shown_slabs, __global const int4 *integrals,
                            __global const float4 *table, RayLatticeParams p, SampleParams sample, RayEnds ray_ends, OUTPUT, TINT_ARGUMENTS
                            ulong first_item) {
    __local uint active, slabs[WORDS_LOOKED_UP];
    __local float ends[END_FLOATS];
    const int tile = FIRST_GROUP + get_group_id(0);
    if (tile >= p.tiles_u * p.tiles_v)
        return;
    share_end_weights(&sample, ends);
    int lowest = p.first_layer, highest = p.last_layer;
    if (p.culling)
        lowest = max(lowest, shown_slabs[0] + view.first_a), highest = min(highest, shown_slabs[1] + view.first_a);
    const int first = p.layer_step > 0 ? lowest : highest, count = highest - lowest + 1;
    find_visible(visible, &p, &view, tile, first, count, slabs);

    voxels += view.first;
    const ShadingSource shading = SHADING_SOURCE;
    const int2 place = work_item_sample(tile, p.tiles_u);
    uint own = 0;
    if (place.x < p.width && place.y < p.height) {
        __global float4 *out = target + (size_t)place.y * p.width + place.x;
        RayState state = start_ray(&p, &sample, &ray_ends, place.x, place.y, out);
#ifdef CUT_RAYS
        const float2 cut = cuts[out - target];
        state.interval.from = MAX(state.interval.from, cut.x), state.interval.to = MIN(state.interval.to, cut.y);
#endif
        for (int word = 0; 32 * word < count && state.open; word++)
            for (uint left = visible_word(slabs, word, count); left && state.open; left &= left - 1)
                cross_slab(voxels, &view, &shading, integrals, &p, &sample, ends, first + lowest_in_word(word, left) * p.layer_step,
                           &state);
        own = state.active;
        STORE_RAYS(p, sample, table, &state.gathered, &state.interval, 1, 1, out, own)
    }
    count_tile(own, &active, active_samples + tile);
}
