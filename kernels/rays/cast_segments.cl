// Ray casting with pre-integrated segments: the classification of point-sampled layers (preintegration.cl) between two planes (slabs.cl),
// for views in which no layer axis suits all rays. `table` holds integrals.

#define TABLE int4
#include "rays/slabs.cl"
#include "shared/dimmed_segment.cl"

ALWAYS_INLINE void march_slab(__global const VOXEL *voxels, const VolumeView *view, const ShadingSource *shading,
                              __global const TABLE *integrals, const MarchParams *p, const SampleParams *sample, const SlabRays *rays,
                              realv from, realv to, Plane *front, Plane *back, Accumulator *gathered, intv *active) {
    const realv dt = rays->length * sample->classification.table_unit;
    const Node one = look_up_node(sample, integrals, from, 0), other = look_up_node(sample, integrals, to, 1);
    const Segment segment = segment_between(sample, integrals, &one, &other, from, to, (float2)(0.0f, 0.0f), dt);
    LitSample lit_front, lit_back;
    if (sample->light.shading) {
        find_gradient(shading, &sample->field, rays->hits, front);
        find_gradient(shading, &sample->field, rays->hits, back);
        lit_front = light_sample(sample, shading->light, point_on_plane(front), front->value, front->gradient);
        lit_back = light_sample(sample, shading->light, point_on_plane(back), back->value, back->gradient);
    }
    const RaySpan span = span_between(front, back);
    composite_span(voxels, view, sample, shading, integrals, &segment, &rays->part, &span, dt, &lit_front, &lit_back, gathered, active);
}

#include "rays/march.cl"
