// Layered rendering with point-sampled layers, per screen pixel: point_lattice.cl without a lattice. Used where none
// reaches, and as its oracle.
//
// One work-item per pixel, row by row; VW is 1. `visible_*` are bits per slab, for rays of any lean.

#include "layered/pixel_ray.cl"
#include "layered/visible_slab.cl"
#include "shared/segment.cl"

__kernel void point_direct(__global const VOXEL *voxels, __global const uchar *visible_x,
                           __global const uchar *visible_y, __global const uchar *visible_z,
                           __global const int4 *integrals, __global const float4 *table, DirectParams p, SampleParams sample_of_z,
                           Clipping clip, int width, int height, __global float4 *frame, __global uint *active_samples) {
    const size_t pixel = get_global_id(0);
    if (pixel >= (size_t)width * height)
        return;
    SampleParams sample;
    const PixelRay ray = ray_of_pixel(&p, pixel % width + 0.5f, pixel / width + 0.5f, &sample_of_z, &sample);
    const VolumeView view = ray.view;
    voxels += view.first;
    __global const uchar *visible = ray.axis == 0 ? visible_x : ray.axis == 1 ? visible_y : visible_z;
    const int blocks_u = p.blocks[2 * ray.axis], blocks_v = p.blocks[2 * ray.axis + 1];
    const int s = sample.inner_slabs, slabs = view.dims_a + 2 * RADIUS - 1, back = ray.layer_step > 0 ? 0 : 1;

    Accumulator gathered = empty_accumulator(&sample);
    Interval interval;
#ifdef CLIPPED
    interval = interval_in_layers(&p, &clip, &ray);
#endif
    int active = 0;
    for (int n = 0; n < slabs; n++) {
        const int q = back ? slabs - 1 - n : n;
        const float enters = q - RADIUS + back;
#ifdef CLIPPED
        const float entry = ray.layer_step * (enters - ray.o_a);
        if (entry >= interval.to || entry + 1.0f <= interval.from)
            continue;
#endif
        const float u = ray.o_u + (enters - ray.o_a) * ray.s_u, v = ray.o_v + (enters - ray.o_a) * ray.s_v;
        const float to_u = u + ray.layer_step * ray.s_u, to_v = v + ray.layer_step * ray.s_v;
        if (fmax(u, to_u) < -RADIUS || fmin(u, to_u) > view.dims_u + (RADIUS - 1) || fmax(v, to_v) < -RADIUS ||
            fmin(v, to_v) > view.dims_v + (RADIUS - 1))
            continue;
        if (p.culling && !slab_shows(visible, blocks_u, blocks_v, q, u, v))
            continue;
        for (int i = 0; i < s; i++) {
            const int l[2] = {back ? (q + 1) * s - i : q * s + i, back ? (q + 1) * s - i - 1 : q * s + i + 1};
            float at_u[2], at_v[2], at_k[2], field[2];
            for (int e = 0; e < 2; e++) {
                at_k[e] = (float)l[e] / s - RADIUS;
                at_u[e] = ray.o_u + (at_k[e] - ray.o_a) * ray.s_u, at_v[e] = ray.o_v + (at_k[e] - ray.o_a) * ray.s_v;
                field[e] = value_at(voxels, &view, at_u[e], at_v[e], at_k[e], 1);
            }
            Lit lit[3];
            float values[3] = {field[0], field[1], field[1]};
            const Way whole = {{at_u[0], at_v[0], at_k[0]}, {at_u[1] - at_u[0], at_v[1] - at_v[0], at_k[1] - at_k[0]}, field[0], field[1]};
            int ways = 1;
#if LIT_AT_ENDS
            if (sample.shading) {
                for (int e = 0; e < 2; e++) {
                    float along_u, along_v, along_a;
                    gradient_at(voxels, &view, at_u[e], at_v[e], at_k[e], 1, &along_u, &along_v, &along_a);
                    lit[e] = lit_by(&sample, along_u, along_v, along_a);
                }
#if HAS_SLOPES
                lit[2] = lit[1], ways = 2;
                const int counts = counts_between(&sample, integrals, field[0], field[1]);
                lit[1] = lit_in_the_middle(&sample, &whole, counts, &lit[0], &lit[2], &values[1]);
#endif
            }
#endif
            for (int w = 0; w < ways; w++) {
                Way way = {{0}, {0}, values[w], values[w + 1]};
                for (int axis = 0; axis < 3; axis++) {
                    way.step[axis] = whole.step[axis] / ways;
                    way.place[axis] = whole.place[axis] + w * way.step[axis];
                }
                Part part = {0.0f, 1.0f};
#ifdef CLIPPED
                const float enters_at = ray.layer_step * (way.place[2] - ray.o_a);
                part = part_of(&interval, enters_at, enters_at + 1.0f / (s * ways));
                if (part.from >= part.to)
                    continue;
#endif
#if BLEND == COMPOSITE
                const float value_from = between(way.from, way.to, part.from), value_to = between(way.from, way.to, part.to);
                const float dt = ray.dt / ways * share_of(&part) * sample.table_unit;
                // Samples alternate between even and odd nodes.
                const int place = ways * l[0] + w;
                const Node from = node_of(&sample, integrals, value_from, place & 1);
                const Node to = node_of(&sample, integrals, value_to, place + 1 & 1);
                const Segment segment =
                    segment_between(&sample, integrals, &from, &to, value_from, value_to, ends_of(&sample, l[0], l[1]), dt);
                composite_way(voxels, &view, &sample, integrals, &segment, &part, &way, dt, &lit[w], &lit[w + 1], &gathered, &active);
#elif BLEND == ISO
                take_crossing(voxels, &view, &sample, &part, &way, &lit[w], &lit[w + 1], &gathered, &active);
#else
                take_values(voxels, &view, &part, &way, share_of(&part) / s, &gathered, &active);
#endif
            }
        }
        if (!any_open(&sample, &gathered))
            break;
    }
    float color[4];
    resolve(&sample, table, &gathered, &interval, color);
    store_colors(color, 1, 1, frame + pixel);
    active_samples[pixel] = active;
}
