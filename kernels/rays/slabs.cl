// Marching between planes perpendicular to the view: the field is sampled where rays cross the planes, and each including file defines
// how the slab between two planes is accumulated (slicing.cl, cast_segments.cl, cast_values.cl).
//
// Plane n crosses rays at the parameter n slice_step; plane 0 contains the volume's centre.

#include "rays/marching.cl"
#include "shared/ray_span.cl"

// Samples of the rays on one plane.
typedef struct {
    realv point[3], value;
    Gradient gradient;
    bool has_value, has_gradient;
} Plane;

// The rays between two planes.
typedef struct {
    intv hits;          // rays that intersect the volume
    realv length;       // length of the part, in unit distances; 0 for rays that are skipped
    realv parameters;   // the same in ray parameters
    float from, to;     // positions of the planes, in ray parameters
    Part part;
} SlabRays;

ALWAYS_INLINE void find_gradient(const ShadingSource *shading, const FieldParams *field, intv needed, Plane *plane) {
    if (!plane->has_gradient)
        plane->gradient = gradient_at(shading, field, plane->point[0], plane->point[1], plane->point[2], needed);
    plane->has_gradient = true;
}

static inline Point point_on_plane(const Plane *plane) {
    const Point point = {plane->point[0], plane->point[1], plane->point[2]};
    return point;
}

// The span from a plane to the next.
static inline RaySpan span_between(const Plane *front, const Plane *back) {
    RaySpan span;
    for (int i = 0; i < 3; i++)
        span.origin[i] = front->point[i], span.step[i] = back->point[i] - front->point[i];
    span.from = front->value, span.to = back->value;
    return span;
}

// Accumulates the slab between two planes; `from` and `to` are the values at the ends of the part.
ALWAYS_INLINE void march_slab(__global const VOXEL *voxels, const VolumeView *view, const ShadingSource *shading,
                              __global const TABLE *table, const MarchParams *p, const SampleParams *sample, const SlabRays *rays,
                              realv from, realv to, Plane *front, Plane *back, Accumulator *gathered, intv *active);

// Marches one row of rays from plane to plane.
ALWAYS_INLINE void march_row(__global const VOXEL *voxels, const VolumeView *view, const ShadingSource *shading,
                             __global const uchar *visible, __global const TABLE *table, const MarchParams *p,
                             const SampleParams *sample, const RowRays *rays, const Interval *interval, Accumulator *gathered,
                             intv *active) {
    const intv hits = interval->from < interval->to;
    const float step = p->slice_step;
    const int begin = (int)floor(smallest_lane(hits ? interval->from : (realv)(INFINITY)) / step);
    const int end = (int)ceil(largest_lane(hits ? interval->to : (realv)(-INFINITY)) / step);
    Plane front, back;
    front.has_value = false;
    back.has_value = false;
    intv visible_front = 0;
    bool front_known = false; // whether front.point and visible_front are those of plane n
    for (int n = begin; n < end; n++) {
        points_at(rays, (realv)((n + 1) * step), back.point);
        if (!front_known)
            points_at(rays, (realv)(n * step), front.point);
        if (p->culling && (n - begin) % CHUNK == 0) {
            realv far[3];
            points_at(rays, (realv)((n + CHUNK) * step), far);
            if (!box_visible(visible, p->blocks_u, p->blocks_v, view, front.point, far)) {
                n += CHUNK - 1;
                front_known = false, front.has_value = false;
                continue;
            }
        }
        intv needed = hits;
        if (p->culling && p->thin) {
            if (!front_known)
                visible_front = cells_visible(visible, p->blocks_u, p->blocks_v, view, front.point[0], front.point[1], front.point[2]);
            const intv visible_back = cells_visible(visible, p->blocks_u, p->blocks_v, view, back.point[0], back.point[1], back.point[2]);
            needed &= visible_front | visible_back;
            visible_front = visible_back;
        }
        needed &= open_rays(sample, gathered);
        back.has_value = back.has_gradient = false;
        if (ANY(needed)) {
            if (!front.has_value) {
                front.value = value_at(voxels, view, front.point[0], front.point[1], front.point[2], hits);
                front.has_gradient = false;
            }
            back.value = value_at(voxels, view, back.point[0], back.point[1], back.point[2], hits);
            back.has_value = true;
#if !GATHERS_VALUES
            needed &= MAX(front.value, back.value) >= p->visible_from && MIN(front.value, back.value) <= p->visible_to;
#endif
            SlabRays slab;
            slab.hits = hits;
            slab.from = n * step, slab.to = (n + 1) * step;
            slab.parameters = (n + 1) * step - n * step;
            realv from = front.value, to = back.value;
#ifdef CLIPPED
            slab.part = part_of(interval, (realv)(n * step), (realv)((n + 1) * step));
            slab.parameters *= part_length(&slab.part);
            from = lerp(front.value, back.value, slab.part.from), to = lerp(front.value, back.value, slab.part.to);
            needed &= slab.part.from < slab.part.to;
#endif
            if (ANY(needed)) {
                slab.parameters = needed ? slab.parameters : (realv)(0.0f);
                slab.length = slab.parameters * rays->length;
                march_slab(voxels, view, shading, table, p, sample, &slab, from, to, &front, &back, gathered, active);
                if (!ANY(hits && open_rays(sample, gathered)))
                    break;
            }
        }
        front = back;
        front_known = true;
    }
}
