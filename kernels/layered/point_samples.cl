// Layered rendering with point-sampled layers, on the lattice of any view: point_lattice.cl as graphics processors like it.
//
// One work-item per sample of the lattice: VW is 1. A group takes a tile of SAMPLE_COLUMNS x SAMPLE_ROWS of them, whose rays
// go through the layers side by side, as their voxels lie. What a ray knows of a sample, its field and its light, goes from the end of one
// segment to the beginning of the next: all of it fits into registers.
// Everything else is as in point_lattice.cl; active_samples[tile] too.

// All layouts that lattices are drawn from are.
#define ROWS_ALONG_U
#include "layered/point_sample.cl"
#include "layered/ray_lattice.cl"
#include "layered/sample_tile.cl"
#include "shared/segment.cl"

// ends_of() of all segments of a layer, for a group: looked up by a number, arguments would be copied to every work-item's memory.
#define ENDS ((int)(sizeof((SampleParams *)0)->ends / sizeof(float)))
ALWAYS_INLINE void share_ends(const SampleParams *sample, __local float *ends) {
#ifdef CURVED
    if (!get_local_id(0)) {
#pragma unroll
        for (int n = 0; n < ENDS; n++)
            ends[n] = sample->ends[n];
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
    bool is_there, is_lit;
    float field;
    Lit lit;
} End;

// Draws the sample at a column and row; says how many of its segments have opacity.
ALWAYS_INLINE uint draw_sample(__global const VOXEL *voxels, const VolumeView *view, __global const uchar *visible,
                               __global const int *shown_slabs, __global const int4 *integrals, __global const float4 *table,
                               const RayLatticeParams *p, const SampleParams *sample, __local const float *ends,
                               const Clipping *clip, int column, int row, __global float4 *out) {
    const SampleRays rays = rays_of_samples(p, column, row);
    const LatticeRay ray = {(float2)(rays.centre_u, rays.shear_u), (float2)(rays.centre_v, rays.shear_v)};
    const float2 centre = {rays.centre_u, rays.centre_v}, shear = {rays.shear_u, rays.shear_v};
    Accumulator gathered = p->continues ? load_raw(sample, out, 1, 1) : empty_accumulator(sample);
    Interval interval;
#ifdef CLIPPED
    interval = interval_of_rays(p, clip, &rays);
#endif
#if BLEND == COMPOSITE
    const float dt = length_of_rays(sample, &rays) * sample->table_unit;
#endif
    const int s = SAMPLES_PER_LAYER(sample), enters = p->layer_step > 0 ? 0 : 1;
    int lowest = p->first_layer, highest = p->last_layer;
    if (p->culling)
        lowest = max(lowest, shown_slabs[0] + view->first_a), highest = min(highest, shown_slabs[1] + view->first_a);
    int left = highest - lowest, active = 0;
    int known = -1; // the chunk of slabs that the ray is in, and eight bits of those that can show anything
    End end; // all of it follows from this, and is not in registers before
    end.is_there = false;
    bool open = lowest <= highest && (!p->continues || any_open(sample, &gathered));
    for (int q = enters ? highest : lowest; open; open = open && left-- > 0, q += p->layer_step) {
        // One at a time: rays that are in one layer read voxels side by side.
        const int plane = q + enters, slab = q - view->first_a;
        const float to_plane = plane - RADIUS - p->centre_layer;
        if (p->culling && slab >> 3 != known >> 8) {
            const int on = enters ? -(slab & 7) - 1 : 8 - (slab & 7);
            const float2 at = centre + to_plane * shear, to = centre + (to_plane + on) * shear;
            known = (slab >> 3) << 8 |
                    slabs_over_few(visible, p->blocks_u, p->blocks_v, slab >> 3, cells_between(MIN(at, to), MAX(at, to)));
        }
        bool skips = p->culling && !(known >> (slab & 7) & 1);
#ifdef CLIPPED
        const float entry = p->layer_step * to_plane;
        skips = skips || entry >= interval.to || entry + 1.0f <= interval.from;
#endif
        if (skips) {
            end.is_there = false;
            continue;
        }
        int l0 = plane * s;
        for (int i = 0; i < s && open; i++, l0 += p->layer_step) {
            const int l1 = l0 + p->layer_step;
            // Both ends, or the other alone, by the same code; and so with light.
            float from;
            end.is_lit = end.is_there && end.is_lit;
            for (int l = end.is_there ? l1 : l0;; l = l1) {
                const Cells c = cells_in(view, &ray, p->centre_layer, s, l);
                from = end.field;
                end.field = value_in(voxels, view, &c);
                if (l == l1)
                    break;
            }
            end.is_there = true;
#if !GATHERS_VALUES
            if (!shows(sample, from, end.field)) {
                end.is_lit = false;
                continue;
            }
#endif
            Lit lit;
            if (sample->shading && LIT_AT_ENDS) {
                for (int l = end.is_lit ? l1 : l0;; l = l1) {
                    const Cells c = cells_in(view, &ray, p->centre_layer, s, l);
                    lit = end.lit;
                    end.lit = lit_in(voxels, view, sample, &c);
                    if (l == l1)
                        break;
                }
                end.is_lit = true;
            }
            const float k = (float)l0 / s - RADIUS, step = (float)p->layer_step / s;
            int ways = 1;
            float to = end.field;
            Lit lit_to = end.lit;
#if HAS_SLOPES && LIT_AT_ENDS
            if (sample->shading) {
                const Way whole = way_on(ray.u.x, ray.u.y, ray.v.x, ray.v.y, p->centre_layer, k, step, from, end.field);
                lit_to = lit_in_the_middle(sample, &whole, counts_between(sample, integrals, from, end.field), &lit, &end.lit, &to);
                ways = 2;
            }
#endif
#pragma unroll 1
            for (int w = 0; w < ways; w++) {
                const float length = 1.0f / ways, from_k = k + w * length * step;
                const Way way = way_on(ray.u.x, ray.u.y, ray.v.x, ray.v.y, p->centre_layer, from_k, length * step, from, to);
                Part part = {0.0f, 1.0f};
#ifdef CLIPPED
                const float enters_at = p->layer_step * (from_k - p->centre_layer);
                part = part_of(&interval, enters_at, enters_at + length / s);
#endif
#if BLEND == COMPOSITE
                // Nodes are looked up for both segments that a sample ends: kept, they would take six registers.
                const float value_from = between(from, to, part.from), value_to = between(from, to, part.to);
                const float part_dt = PART_OF(length * dt, &part);
                const int place = ways * l0 + w * p->layer_step;
                const Node front = node_of(sample, integrals, value_from, place & 1);
                const Node back = node_of(sample, integrals, value_to, (place + 1) & 1);
                const Segment segment =
                    segment_between(sample, integrals, &front, &back, value_from, value_to, ends_in(ends, s, l0, l1), part_dt);
                composite_way(voxels, view, sample, integrals, &segment, &part, &way, part_dt, &lit, &lit_to, &gathered, &active);
#elif BLEND == ISO
                take_crossing(voxels, view, sample, &part, &way, &lit, &lit_to, &gathered, &active);
#else
                take_values(voxels, view, &part, &way, share_of(&part) / s, &gathered, &active);
#endif
                from = to, lit = lit_to;
                to = end.field, lit_to = end.lit;
            }
            open = any_open(sample, &gathered);
        }
    }
    uint total = active;
    END_RAYS(*p, *sample, table, &gathered, &interval, 1, 1, out, total)
    return total;
}

__attribute__((reqd_work_group_size(SAMPLE_COLUMNS * SAMPLE_ROWS, 1, 1)))
__kernel void point_samples(__global const VOXEL *voxels, VolumeView view, __global const uchar *visible,
                            __global const int *shown_slabs, __global const int4 *integrals, __global const float4 *table, RayLatticeParams p,
                            SampleParams sample, Clipping clip, __global float4 *lattice, __global uint *active_samples) {
    __local uint active;
    __local float ends[ENDS];
    share_ends(&sample, ends);
    const int tile = get_group_id(0);
    const int2 place = sample_of_tile(tile, p.tiles_u);
    uint own = 0;
    if (place.x < p.width && place.y < p.height)
        own = draw_sample(voxels + view.first, &view, visible, shown_slabs, integrals, table, &p, &sample, ends, &clip, place.x, place.y,
                          lattice + (size_t)place.y * p.width + place.x);
    count_tile(own, &active, active_samples + tile);
}
