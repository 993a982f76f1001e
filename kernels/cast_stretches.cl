// Ray casting with pre-integrated stretches: between two planes (slabs.cl) the classification of point-sampled layers
// (preintegration.cl), where no layer axis serves all rays. `table` holds integrals.

ALWAYS_INLINE void composite_slab(__global const VOXEL *voxels, const VolumeView *view, __global const float4 *table,
                                  const MarchParams *p, const SampleParams *sample, const SlabRays *rays, Plane *front,
                                  Plane *back, Light *light, intv *active) {
    __global const int4 *integrals = (__global const int4 *)table;
    const realv dt = rays->length * sample->table_unit;
    const Node from = node_of(sample, integrals, front->value, 0), to = node_of(sample, integrals, back->value, 1);
    const Stretch stretch =
        stretch_between(sample, integrals, &from, &to, front->value, back->value, (float2)(0.0f, 0.0f), dt);
    Lighting lit_front, lit_back;
    if (sample->shading) {
        differentiate(voxels, view, rays->hits, front);
        differentiate(voxels, view, rays->hits, back);
        lit_front = light_gradient(sample, front->u, front->v, front->a);
        lit_back = light_gradient(sample, back->u, back->v, back->a);
    }
    Way way;
    for (int i = 0; i < 3; i++)
        way.place[i] = front->point[i], way.step[i] = back->point[i] - front->point[i];
    composite_way(voxels, view, sample, integrals, &stretch, &way, dt, rays->inside, &lit_front, &lit_back, light, active);
}
