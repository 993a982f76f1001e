// Ray casting of what is not composited: between two planes (slabs.cl) values are gathered, or an iso-surface is found. `table`:
// (r, g, b, tau) per value.

#define TABLE float4
#include "rays/slabs.cl"
#include "shared/segment.cl"

ALWAYS_INLINE void take_slab(__global const VOXEL *voxels, const VolumeView *view, __global const TABLE *table, const MarchParams *p,
                             const SampleParams *sample, const SlabRays *rays, realv from, realv to, Plane *front, Plane *back,
                             Accumulator *gathered, intv *active) {
#if BLEND == ISO
    Lit lit_front, lit_back;
#ifndef REFINED
    if (sample->light.shading) {
        differentiate(voxels, view, rays->hits, front);
        differentiate(voxels, view, rays->hits, back);
        lit_front = lit_at(sample, point_on_plane(front), front->value, front->gradient);
        lit_back = lit_at(sample, point_on_plane(back), back->value, back->gradient);
    }
#endif
#ifdef DEPTHS
    is_between((realv)(rays->from), (realv)(rays->to), gathered);
#endif
    const Way way = way_between(front, back);
    const Part part = {rays->part.from, rays->length > 0.0f ? rays->part.to : rays->part.from};
    take_crossing(voxels, view, sample, &part, &way, &lit_front, &lit_back, gathered, active);
#else
    const Way way = way_between(front, back);
    take_values(voxels, view, &rays->part, &way, rays->parameters, gathered, active);
#endif
}

#include "rays/march.cl"
