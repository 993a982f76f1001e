// Layered rendering with point-sampled layers, per screen pixel: point_lattice.cl without a lattice. Draws views with evaluation per pixel,
// and those of a forced layer axis that no lattice covers. Other views without a lattice are cast (cast_segments.cl). Tests compare lattices
// with it.
//
// One work-item per pixel, row by row; VW is 1.

#include "layered/pixel_ray.cl"
#include "layered/visible_cells.cl"
#include "shared/segment.cl"

// Where a ray crosses the plane k, which can lie between layers.
static inline float3 point_on_ray(const PixelRay *ray, float k) {
    return (float3)(ray->o_u + (k - ray->o_a) * ray->s_u, ray->o_v + (k - ray->o_a) * ray->s_v, k);
}

__kernel void point_direct(PIXEL_FIELD, __global const int4 *integrals, __global const float4 *table, ulong first_item) {
    const size_t pixel = first_item + get_global_id(0);
    if (pixel >= (size_t)p.width * p.height)
        return;
    SampleParams sample;
    const PixelRay ray = make_pixel_ray(&p, pixel % p.width + 0.5f, pixel / p.width + 0.5f, &view_of_z, &sample_of_z, &sample);
    const VolumeView view = ray.view;
    voxels += view.first;
    const VolumeView gradient_view = permuted_view(&gradient_view_of_z, ray.axis);
    const ShadingSource shading = SHADING_SOURCE;
    __global const uchar *visible = ray.axis == 0 ? visible_x : ray.axis == 1 ? visible_y : visible_z;
    const int s = SAMPLES_PER_LAYER(&sample), slabs = view.dims_a + 2 * RADIUS - 1, back = ray.layer_step > 0 ? 0 : 1;

    Accumulator gathered = empty_accumulator(&sample);
    Interval interval;
#ifdef CLIPPED
    interval = interval_in_layers(&p, &ray_ends, &ray);
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
        const float2 at = {u, v}, to = {to_u, to_v};
        const Window crossed = cells_between(MIN(at, to), MAX(at, to));
        if (p.culling && !is_slab_visible(visible, ray.blocks_u, ray.blocks_v, q, crossed))
            continue;
        for (int i = 0; i < s; i++) {
            const int l0 = back ? (q + 1) * s - i : q * s + i, l1 = l0 + ray.layer_step;
            // Both ends in a loop: arrays indexed by a variable would be in memory.
            float from = 0.0f, field = 0.0f;
            for (int l = l0;; l = l1) {
                const float3 place = point_on_ray(&ray, (float)l / s - RADIUS);
                from = field;
                field = value_at(voxels, &view, place.x, place.y, place.z, 1);
                if (l == l1)
                    break;
            }
            LitSample lit = {0}, lit_behind = {0};
#if LIT_AT_ENDS
            for (int l = l0; sample.light.shading; l = l1) {
                const float3 place = point_on_ray(&ray, (float)l / s - RADIUS);
                const Point point = {place.x, place.y, place.z};
                const Gradient gradient = gradient_at(&shading, &sample.field, place.x, place.y, place.z, 1);
                lit = lit_behind;
                lit_behind = light_sample(&sample, shading.light, point, l == l0 ? from : field, gradient);
                if (l == l1)
                    break;
            }
#endif
            const float k = (float)l0 / s - RADIUS, step = (float)ray.layer_step / s;
            int spans = 1;
            float to = field;
            LitSample lit_to = lit_behind;
#if ANALYTIC_GRADIENTS && LIT_AT_ENDS
            if (sample.light.shading) {
                const RaySpan whole = span_at_plane(ray.o_u, ray.s_u, ray.o_v, ray.s_v, ray.o_a, k, step, from, field);
                const int contributes = contributes_between(&sample, integrals, from, field);
                lit_to = light_midpoint(&sample, shading.light, &whole, contributes, &lit, &lit_behind, &to);
                spans = 2;
            }
#endif
#pragma unroll 1
            for (int w = 0; w < spans; w++) {
                const float length = 1.0f / spans, from_k = k + w * length * step;
                const RaySpan span = span_at_plane(ray.o_u, ray.s_u, ray.o_v, ray.s_v, ray.o_a, from_k, length * step, from, to);
                Part part = {0.0f, 1.0f};
#ifdef CLIPPED
                const float enters_at = ray.layer_step * (from_k - ray.o_a);
                part = part_of(&interval, enters_at, enters_at + length / s);
#endif
#if BLEND == COMPOSITE
                const float value_from = lerp(from, to, part.from), value_to = lerp(from, to, part.to);
                const float dt = ray.dt * length * part_length(&part) * sample.classification.table_unit;
                // Samples alternate between even and odd nodes.
                const int place = spans * l0 + w * ray.layer_step;
                const Node front = look_up_node(&sample, integrals, value_from, place & 1);
                const Node behind = look_up_node(&sample, integrals, value_to, (place + 1) & 1);
                const Segment segment =
                    segment_between(&sample, integrals, &front, &behind, value_from, value_to, end_weights(&sample, l0, l1), dt);
                composite_span(voxels, &view, &sample, &shading, integrals, &segment, &part, &span, dt, &lit, &lit_to, &gathered, &active);
#elif BLEND == ISO
                accumulate_surface(voxels, &view, &shading, &sample, &part, &span, &lit, &lit_to, &gathered, &active);
#else
                accumulate_span(voxels, &view, &part, &span, part_length(&part) / s, &gathered, &active);
#endif
                from = to, lit = lit_to;
                to = field, lit_to = lit_behind;
            }
        }
        if (!any_open(&sample, &gathered))
            break;
    }
    float color[4];
    resolve(&sample, table, &gathered, &interval, color);
    store_colors(color, 1, 1, target + pixel);
    active_samples[pixel] = active;
}
