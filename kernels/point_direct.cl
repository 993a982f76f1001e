// Layered rendering with point-sampled layers, per screen pixel: point_lattice.cl without a lattice. Used where none
// reaches, and as its oracle.
//
// One work-item per pixel, row by row; VW is 1. `visible_*` are bits per slab, for rays of any lean.

__kernel void point_direct(__global const VOXEL *voxels, __global const uchar *visible_x,
                           __global const uchar *visible_y, __global const uchar *visible_z,
                           __global const int4 *integrals, DirectParams p, SampleParams sample, int width, int height,
                           __global float4 *frame, __global uint *active_samples) {
    const size_t pixel = get_global_id(0);
    if (pixel >= (size_t)width * height)
        return;
    const PixelRay ray = ray_of_pixel(&p, pixel % width + 0.5f, pixel / width + 0.5f, &sample);
    const VolumeView view = ray.view;
    __global const uchar *visible = ray.axis == 0 ? visible_x : ray.axis == 1 ? visible_y : visible_z;
    const int blocks_u = p.blocks[ray.axis][0], blocks_v = p.blocks[ray.axis][1];
    const int s = sample.inner_slabs, slabs = view.dims_a + 1, back = ray.layer_step > 0 ? 0 : 1;

    Light light = {0.0f, 0.0f, 0.0f, 1.0f};
    int active = 0;
    for (int n = 0; n < slabs; n++) {
        const int q = back ? slabs - 1 - n : n;
        const float enters = q - 1 + back;
        // Only what lies in front of the eye counts.
        if (eye_distance(&p, &ray, enters) <= -1.0f)
            continue;
        const float u = ray.o_u + (enters - ray.o_a) * ray.s_u, v = ray.o_v + (enters - ray.o_a) * ray.s_v;
        const float to_u = u + ray.layer_step * ray.s_u, to_v = v + ray.layer_step * ray.s_v;
        if (fmax(u, to_u) < -1.0f || fmin(u, to_u) > view.dims_u || fmax(v, to_v) < -1.0f || fmin(v, to_v) > view.dims_v)
            continue;
        const int b = clamp(block_of(whole_below(u), BLOCK), 0, blocks_u - 1);
        const int c = clamp(block_of(whole_below(v), POINT_BLOCK_ROWS), 0, blocks_v - 1);
        if (p.culling && !(visible[((size_t)(q >> 3) * blocks_v + c) * blocks_u + b] >> (q & 7) & 1))
            continue;
        for (int i = 0; i < s; i++) {
            const int l[2] = {back ? (q + 1) * s - i : q * s + i, back ? (q + 1) * s - i - 1 : q * s + i + 1};
            float at_u[2], at_v[2], at_k[2], field[2];
            for (int e = 0; e < 2; e++) {
                at_k[e] = (float)l[e] / s - 1.0f;
                at_u[e] = ray.o_u + (at_k[e] - ray.o_a) * ray.s_u, at_v[e] = ray.o_v + (at_k[e] - ray.o_a) * ray.s_v;
                field[e] = value_at(voxels, &view, at_u[e], at_v[e], at_k[e], 1);
            }
            const float start = eye_distance(&p, &ray, at_k[0]);
            const float cut = start < 0.0f ? fmin(-start * s, 1.0f) : 0.0f; // of the stretch, behind the eye
            if (cut == 1.0f)
                continue;
            Lighting lit[2];
            for (int e = 0; e < (sample.shading ? 2 : 0); e++) {
                float along_u, along_v, along_a;
                differences_at(voxels, &view, at_u[e], at_v[e], at_k[e], 1, &along_u, &along_v, &along_a);
                lit[e] = light_gradient(&sample, along_u, along_v, along_a);
            }
            const float middle_u = 0.5f * (at_u[0] + at_u[1]), middle_v = 0.5f * (at_v[0] + at_v[1]);
            const bool beside = middle_u < -1.0f || middle_u > view.dims_u || middle_v < -1.0f || middle_v > view.dims_v;
            const float at_eye = field[0] + cut * (field[1] - field[0]), dt = ray.dt * (1.0f - cut) * sample.table_unit;
            const Node from = node_of(&sample, integrals, at_eye, l[0] & 1);
            const Node to = node_of(&sample, integrals, field[1], l[1] & 1);
            const Stretch stretch =
                stretch_between(&sample, integrals, &from, &to, at_eye, field[1], ends_of(&sample, l[0], l[1]), dt);
            const Way way = {{mix(at_u[0], at_u[1], cut), mix(at_v[0], at_v[1], cut), mix(at_k[0], at_k[1], cut)},
                             {(1.0f - cut) * (at_u[1] - at_u[0]), (1.0f - cut) * (at_v[1] - at_v[0]),
                              (1.0f - cut) * (at_k[1] - at_k[0])}};
            composite_way(voxels, &view, &sample, integrals, &stretch, &way, dt, sample.background_visible && beside ? 0.0f : 1.0f,
                          &lit[0], &lit[1], &light, &active);
        }
        if (light.t <= sample.opaque)
            break;
    }
    frame[pixel] = (float4)(light.r, light.g, light.b, 1.0f - light.t);
    active_samples[pixel] = active;
}
