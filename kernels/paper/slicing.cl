// Pre-integrated slicing: between two planes perpendicular to the view (slabs.cl), a table look-up by the values in front and behind
// (preintegrated_table.cl).
//
// A slab is lit by the mean of the gradients on its two planes.

#define TABLE float4
#include "rays/slabs.cl"

ALWAYS_INLINE intv slice_entry(const MarchParams *p, realv value) {
    const realv x = (value - p->table_first) * p->table_per_value + 0.5f;
    return CONVERT_INTV(CLAMP(x, (realv)(0.0f), (realv)(p->table_size - 1)));
}

// Colour and extinction of a slab, from the values on its two planes.
typedef struct {
    realv r, g, b, extinction;
} Slab;

// Beyond the table its first and last entries apply, weighted by their shares of the range of values.
static inline void extend_slab(__global const float4 *table, const MarchParams *p, realv front, realv back, Slab *slab) {
    const realv last = p->table_size - 1.0f;
    const realv x0 = (front - p->table_first) * p->table_per_value, x1 = (back - p->table_first) * p->table_per_value;
    const realv below = fabs(MIN(x1, (realv)(0.0f)) - MIN(x0, (realv)(0.0f)));
    const realv above = fabs(MAX(x1 - last, (realv)(0.0f)) - MAX(x0 - last, (realv)(0.0f)));
    const realv all = MAX(fabs(x1 - x0), (realv)(1e-3f)), within = MAX(all - below - above, (realv)(0.0f));
    const float4 first_entry = table[0], last_entry = table[p->table_size * p->table_size - 1];
    const realv inner_extinction = within / all * slab->extinction, first_extinction = below / all * first_entry.w;
    const realv last_extinction = above / all * last_entry.w, sum = inner_extinction + first_extinction + last_extinction;
    const realv inverse = 1.0f / MAX(sum, (realv)(1e-30f));
    const intv cut = below + above > 0.0f;
    slab->r = cut ? (inner_extinction * slab->r + first_extinction * first_entry.x + last_extinction * last_entry.x) * inverse : slab->r;
    slab->g = cut ? (inner_extinction * slab->g + first_extinction * first_entry.y + last_extinction * last_entry.y) * inverse : slab->g;
    slab->b = cut ? (inner_extinction * slab->b + first_extinction * first_entry.z + last_extinction * last_entry.z) * inverse : slab->b;
    slab->extinction = cut ? sum : slab->extinction;
}

ALWAYS_INLINE Slab slab_between(__global const float4 *table, const MarchParams *p, realv front, realv back) {
    Slab slab;
    table_entries(table, slice_entry(p, front) * p->table_size + slice_entry(p, back), &slab.r, &slab.g, &slab.b,
                  &slab.extinction);
    if (p->cut)
        extend_slab(table, p, front, back, &slab);
    return slab;
}

ALWAYS_INLINE void march_slab(__global const VOXEL *voxels, const VolumeView *view, const ShadingSource *shading,
                              __global const TABLE *table, const MarchParams *p, const SampleParams *sample, const SlabRays *rays,
                              realv from, realv to, Plane *front, Plane *back, Accumulator *gathered, intv *active) {
    const Slab slab = slab_between(table, p, from, to);
    Lighting lighting;
    if (sample->light.shading) {
        find_gradient(shading, &sample->field, rays->hits, front);
        find_gradient(shading, &sample->field, rays->hits, back);
        const Gradient one = front->gradient, other = back->gradient;
        const Gradient mean = {0.5f * (one.u + other.u), 0.5f * (one.v + other.v), 0.5f * (one.a + other.a)};
        const RaySpan span = span_between(front, back);
        lighting = shade(sample, shading->light, point_on_span(&span, (realv)(0.5f)), 0.5f * (from + to), mean);
    }
    const realv opacity = opacity_of_depth(sample, slab.extinction * rays->length);
    *active += COUNT_IF(opacity > 0.0f);
    accumulate_lit(sample, slab.r, slab.g, slab.b, opacity, &lighting, gathered);
}

#include "rays/march.cl"
