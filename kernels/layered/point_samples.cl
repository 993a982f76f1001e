// Layered rendering with point-sampled layers, on the lattice of any view: point_lattice.cl as graphics processors like it.
//
// One work-item per sample of the lattice: VW is 1. A group takes a tile of SAMPLE_COLUMNS x SAMPLE_ROWS of them, whose rays
// go through the slabs that any of them needs side by side, as their voxels lie. What a ray knows of a sample, its field and its light, goes from
// the end of one segment to the beginning of the next: all of it fits into registers.
// Everything else is as in point_lattice.cl; active_samples[tile] too.

// All layouts that lattices are drawn from are.
#define ROWS_ALONG_U
#include "layered/point_sample.cl"
#include "layered/visible_group.cl"
#include "shared/segment.cl"

// ends_of() of all segments of a layer, for a group: looked up by a number, arguments would be copied to every work-item's memory.
#define ENDS ((int)(sizeof((SampleParams *)0)->segments.ends / sizeof(float)))
ALWAYS_INLINE void share_ends(const SampleParams *sample, __local float *ends) {
#ifdef CURVED
    if (!get_local_id(0)) {
#pragma unroll
        for (int n = 0; n < ENDS; n++)
            ends[n] = sample->segments.ends[n];
    }
    barrier(CLK_LOCAL_MEM_FENCE);
#endif
}
static inline float2 ends_in(__local const float *ends, uint samples_per_layer, int l0, int l1) {
#ifdef CURVED
    const float2 of_segment = vload2((uint)min(l0, l1) % samples_per_layer, ends);
    return l0 < l1 ? of_segment : of_segment.yx;
#else
    return 0.0f;
#endif
}

// What is known of the end of a segment, where the next one begins.
typedef struct {
    bool is_lit;
    float field;
    Lit lit;
} End;

static inline bool beam_sees(__global const uchar *visible, const RayLatticeParams *p, const VolumeView *view, const Beam *beam, int slab) {
    const float to_plane = slab + (p->layer_step > 0 ? 0 : 1) - RADIUS - p->centre_layer;
    const Window crossed = cells_crossed(beam, to_plane, to_plane + p->layer_step, 0.0f);
    return slab_shows(visible, p->blocks_u, p->blocks_v, slab - view->first_a, crossed);
}

// A ray on its way through the layers.
typedef struct {
    LatticeRay ray;
    float dt; // from layer to layer, in the table's units
    Interval interval;
    Accumulator gathered;
    End end;
    int passed; // the slab that it ends
    int active; // segments with opacity
    bool open;
} Traveller;

static inline Traveller traveller_of(const RayLatticeParams *p, const SampleParams *sample, const Clipping *clip, int column, int row,
                                     __global const float4 *out) {
    const SampleRays rays = rays_of_samples(p, column, row);
    Traveller t;
    t.ray.u = (float2)(rays.centre_u, rays.shear_u), t.ray.v = (float2)(rays.centre_v, rays.shear_v);
#if BLEND == COMPOSITE
    t.dt = length_of_rays(sample, &rays) * sample->classification.table_unit;
#endif
#ifdef CLIPPED
    t.interval = interval_of_rays(p, clip, &rays);
#endif
    t.gathered = p->continues ? load_raw(sample, out, 1, 1) : empty_accumulator(sample);
    t.passed = INT_MIN, t.active = 0; // of the end all else follows, and is not in registers before
    t.open = !p->continues || any_open(sample, &t.gathered);
    return t;
}

// Takes a ray through slab q.
ALWAYS_INLINE void pass_slab(__global const VOXEL *voxels, const VolumeView *view, __global const int4 *integrals,
                             const RayLatticeParams *p, const SampleParams *sample, __local const float *ends, int q, Traveller *t) {
    const int s = SAMPLES_PER_LAYER(sample), plane = q + (p->layer_step > 0 ? 0 : 1);
#ifdef CLIPPED
    const float entry = p->layer_step * (plane - RADIUS - p->centre_layer);
    if (entry >= t->interval.to || entry + 1.0f <= t->interval.from)
        return;
#endif
    bool goes_on = t->passed == q - p->layer_step;
    t->passed = q;
    int l0 = plane * s;
    for (int i = 0; i < s && t->open; i++, l0 += p->layer_step) {
        const int l1 = l0 + p->layer_step;
        // Both ends, or the other alone; and so with light.
        float from;
        t->end.is_lit = goes_on && t->end.is_lit;
        for (int l = goes_on ? l1 : l0;; l = l1) {
            const Cells c = cells_in(view, &t->ray, p->centre_layer, s, l);
            from = t->end.field;
            t->end.field = value_in(voxels, view, &c);
            if (l == l1)
                break;
        }
        goes_on = true;
#if !GATHERS_VALUES
        if (!shows(sample, from, t->end.field)) {
            t->end.is_lit = false;
            continue;
        }
#endif
        Lit lit;
        if (sample->light.shading && LIT_AT_ENDS) {
            for (int l = t->end.is_lit ? l1 : l0;; l = l1) {
                const Cells c = cells_in(view, &t->ray, p->centre_layer, s, l);
                lit = t->end.lit;
                t->end.lit = lit_in(voxels, view, sample, &c);
                if (l == l1)
                    break;
            }
            t->end.is_lit = true;
        }
        const float k = (float)l0 / s - RADIUS, step = (float)p->layer_step / s;
        int ways = 1;
        float to = t->end.field;
        Lit lit_to = t->end.lit;
#if HAS_SLOPES && LIT_AT_ENDS
        if (sample->light.shading) {
            const Way whole = way_on(t->ray.u.x, t->ray.u.y, t->ray.v.x, t->ray.v.y, p->centre_layer, k, step, from, to);
            lit_to = lit_in_the_middle(sample, &whole, counts_between(sample, integrals, from, t->end.field), &lit, &t->end.lit, &to);
            ways = 2;
        }
#endif
#pragma unroll 1
        for (int w = 0; w < ways; w++) {
            const float length = 1.0f / ways, from_k = k + w * length * step;
            const Way way = way_on(t->ray.u.x, t->ray.u.y, t->ray.v.x, t->ray.v.y, p->centre_layer, from_k, length * step, from, to);
            Part part = {0.0f, 1.0f};
#ifdef CLIPPED
            const float enters_at = p->layer_step * (from_k - p->centre_layer);
            part = part_of(&t->interval, enters_at, enters_at + length / s);
#endif
#if BLEND == COMPOSITE
            // Nodes are looked up for both segments that a sample ends: kept, they would take six registers.
            const float value_from = between(from, to, part.from), value_to = between(from, to, part.to);
            const float part_dt = PART_OF(length * t->dt, &part);
            const int place = ways * l0 + w * p->layer_step;
            const Node front = node_of(sample, integrals, value_from, place & 1);
            const Node back = node_of(sample, integrals, value_to, (place + 1) & 1);
            const Segment segment =
                segment_between(sample, integrals, &front, &back, value_from, value_to, ends_in(ends, s, l0, l1), part_dt);
            composite_way(voxels, view, sample, integrals, &segment, &part, &way, part_dt, &lit, &lit_to, &t->gathered, &t->active);
#elif BLEND == ISO
            take_crossing(voxels, view, sample, &part, &way, &lit, &lit_to, &t->gathered, &t->active);
#else
            take_values(voxels, view, &part, &way, share_of(&part) / s, &t->gathered, &t->active);
#endif
            from = to, lit = lit_to;
            to = t->end.field, lit_to = t->end.lit;
        }
        t->open = any_open(sample, &t->gathered);
    }
}

__attribute__((reqd_work_group_size(SAMPLE_COLUMNS * SAMPLE_ROWS, 1, 1)))
__kernel void point_samples(__global const VOXEL *voxels, VolumeView view, __global const uchar *visible,
                            __global const int *shown_slabs, __global const int4 *integrals, __global const float4 *table, RayLatticeParams p,
                            SampleParams sample, Clipping clip, __global float4 *lattice, __global uint *active_samples) {
    __local uint active, slabs[WORDS_LOOKED_UP];
    __local float ends[ENDS];
    if (get_group_id(0) >= p.tiles_u * p.tiles_v)
        return;
    share_ends(&sample, ends);
    int lowest = p.first_layer, highest = p.last_layer;
    if (p.culling)
        lowest = max(lowest, shown_slabs[0] + view.first_a), highest = min(highest, shown_slabs[1] + view.first_a);
    const int tile = get_group_id(0), first = p.layer_step > 0 ? lowest : highest, count = highest - lowest + 1;
    look_up(visible, &p, &view, tile, first, count, slabs);

    const int2 place = sample_of_tile(tile, p.tiles_u);
    uint own = 0;
    if (place.x < p.width && place.y < p.height) {
        __global float4 *out = lattice + (size_t)place.y * p.width + place.x;
        Traveller t = traveller_of(&p, &sample, &clip, place.x, place.y, out);
        for (int word = 0; 32 * word < count && t.open; word++)
            for (uint left = word_of(slabs, word, count); left && t.open; left &= left - 1)
                pass_slab(voxels + view.first, &view, integrals, &p, &sample, ends, first + lowest_of_word(word, left) * p.layer_step, &t);
        own = t.active;
        END_RAYS(p, sample, table, &t.gathered, &t.interval, 1, 1, out, own)
    }
    count_tile(own, &active, active_samples + tile);
}
