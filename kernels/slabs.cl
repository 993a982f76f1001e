// Marching from plane to plane at right angles to the view: the field where rays cross them, and what lies between two, in a
// way of its own (slicing.cl, cast_stretches.cl).
//
// Plane n crosses rays at the parameter n slice_step, plane 0 the volume's centre.

// What is known of the rays on one plane.
typedef struct {
    realv point[3], value;
    realv u, v, a; // gradient
    bool sampled, differentiated;
} Plane;

// The rays between two planes.
typedef struct {
    intv hits;     // those that meet the volume
    realv length;  // in unit distances
    realv inside;  // 0 where nothing is to be composited, else 1
} SlabRays;

ALWAYS_INLINE void differentiate(__global const VOXEL *voxels, const VolumeView *view, intv needed, Plane *plane) {
    if (!plane->differentiated)
        differences_at(voxels, view, plane->point[0], plane->point[1], plane->point[2], needed, &plane->u, &plane->v, &plane->a);
    plane->differentiated = true;
}

// Composites what lies between two planes.
ALWAYS_INLINE void composite_slab(__global const VOXEL *voxels, const VolumeView *view, __global const float4 *table,
                                  const MarchParams *p, const SampleParams *sample, const SlabRays *rays, Plane *front,
                                  Plane *back, Light *light, intv *active);

// Marches one row of rays from plane to plane.
ALWAYS_INLINE Light march_row(__global const VOXEL *voxels, const VolumeView *view, __global const uchar *visible,
                              __global const float4 *table, const ScreenParams *s, const MarchParams *p,
                              const SampleParams *sample, const RowRays *rays, intv *active) {
    Light light = {0.0f, 0.0f, 0.0f, 1.0f};
    const Extent extent = support_of(view, s, rays);
    const intv hits = extent.from < extent.to;
    if (!ANY(hits))
        return light;
    const float step = p->slice_step;
    const int begin = (int)floor(smallest_lane(hits ? extent.from : (realv)(INFINITY)) / step);
    const int end = (int)ceil(largest_lane(hits ? extent.to : (realv)(-INFINITY)) / step);
    Plane front, back;
    front.sampled = false;
    back.sampled = false;
    intv visible_front = 0;
    bool known = false; // whether visible_front is that of plane n
    for (int n = begin; n < end; n++) {
        // Only what lies in front of the eye counts: a slab around it is cut.
        const float from = MAX(n * step, s->start), to = (n + 1) * step;
        points_at(rays, (realv)(to), back.point);
        if (!known || n * step < s->start)
            points_at(rays, (realv)(from), front.point);
        if (p->culling && (n - begin) % CHUNK == 0) {
            realv far[3];
            points_at(rays, (realv)((n + CHUNK) * step), far);
            if (!box_visible(visible, p, view, front.point, far)) {
                n += CHUNK - 1;
                known = false, front.sampled = false;
                continue;
            }
        }
        intv needed = hits;
        if (p->culling && p->thin) {
            if (!known)
                visible_front = cells_visible(visible, p, view, front.point[0], front.point[1], front.point[2]);
            const intv visible_back = cells_visible(visible, p, view, back.point[0], back.point[1], back.point[2]);
            needed &= visible_front | visible_back;
            visible_front = visible_back;
        }
        if (sample->opaque > 0.0f)
            needed &= light.t > sample->opaque;
        back.sampled = back.differentiated = false;
        if (ANY(needed)) {
            if (!front.sampled) {
                front.value = value_at(voxels, view, front.point[0], front.point[1], front.point[2], hits);
                front.differentiated = false;
            }
            back.value = value_at(voxels, view, back.point[0], back.point[1], back.point[2], hits);
            back.sampled = true;
            needed &= MAX(front.value, back.value) >= p->visible_from && MIN(front.value, back.value) <= p->visible_to;
            if (ANY(needed)) {
                SlabRays slab = {hits, (to - from) * rays->length, CONVERT_REALV(COUNT_IF(needed))};
                if (sample->background_visible) {
                    const realv middle = (realv)(0.5f * (from + to));
                    slab.inside *= CONVERT_REALV(COUNT_IF(middle >= extent.from && middle <= extent.to));
                }
                composite_slab(voxels, view, table, p, sample, &slab, &front, &back, &light, active);
                if (sample->opaque > 0.0f && !ANY(hits && light.t > sample->opaque))
                    break;
            }
        }
        front = back;
        known = true;
    }
    return light;
}
