// Ray casting for the blend modes that do not composite: between two planes (slabs.cl) values are accumulated, or an iso-surface is
// located. `table`: (r, g, b, tau) per value.

#define TABLE float4
#include "rays/slabs.cl"
#include "shared/segment.cl"

ALWAYS_INLINE void march_slab(__global const VOXEL *voxels, const VolumeView *view, const ShadingSource *shading,
                              __global const TABLE *table, const MarchParams *p, const SampleParams *sample, const SlabRays *rays,
                              realv from, realv to, Plane *front, Plane *back, Accumulator *gathered, intv *active) {
#if BLEND == ISO
    LitSample lit_front, lit_back;
#ifndef REFINED
    if (sample->light.shading) {
        find_gradient(shading, &sample->field, rays->hits, front);
        find_gradient(shading, &sample->field, rays->hits, back);
        lit_front = light_sample(sample, shading->light, point_on_plane(front), front->value, front->gradient);
        lit_back = light_sample(sample, shading->light, point_on_plane(back), back->value, back->gradient);
    }
#endif
#ifdef DEPTHS
    set_depth_range((realv)(rays->from), (realv)(rays->to), gathered);
#endif
    const RaySpan span = span_between(front, back);
    const Part part = {rays->part.from, rays->length > 0.0f ? rays->part.to : rays->part.from};
    accumulate_surface(voxels, view, shading, sample, &part, &span, &lit_front, &lit_back, gathered, active);
#else
    const RaySpan span = span_between(front, back);
    accumulate_span(voxels, view, &rays->part, &span, rays->parameters, gathered, active);
#endif
}

#include "rays/march.cl"
