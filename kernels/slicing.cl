// Pre-integrated slicing: the field on planes at right angles to the view, and between two of them a table over the
// values in front and behind (preintegrated_table.cl).
//
// Slice n crosses rays at the parameter n slice_step, slice 0 the volume's centre. A slab is lit by the mean of the gradients on its two slices. TABLE_CUT: values can
// lie beyond the table.

// What is known of the rays on one slice.
typedef struct {
    realv point[3], value;
    realv u, v, a; // gradient
    bool sampled, differentiated;
} Slice;

ALWAYS_INLINE void differentiate(__global const VOXEL *voxels, const VolumeView *view, intv needed, Slice *slice) {
    if (!slice->differentiated)
        differences_at(voxels, view, slice->point[0], slice->point[1], slice->point[2], needed, &slice->u, &slice->v, &slice->a);
    slice->differentiated = true;
}

ALWAYS_INLINE intv entry_of(const MarchParams *p, realv value) {
    const realv x = (value - p->table_first) * p->table_per_value + 0.5f;
    return CONVERT_INTV(CLAMP(x, (realv)(0.0f), (realv)(p->table_size - 1)));
}

// What lies between the values on two slices.
typedef struct {
    realv r, g, b, extinction;
} Slab;

#ifdef TABLE_CUT
// Beyond the table its first and last entry go on: each part of the values has its share.
inline void extend_slab(__global const float4 *table, const MarchParams *p, realv front, realv back, Slab *slab) {
    const realv last = p->table_size - 1.0f;
    const realv x0 = (front - p->table_first) * p->table_per_value, x1 = (back - p->table_first) * p->table_per_value;
    const realv below = fabs(MIN(x1, (realv)(0.0f)) - MIN(x0, (realv)(0.0f)));
    const realv above = fabs(MAX(x1 - last, (realv)(0.0f)) - MAX(x0 - last, (realv)(0.0f)));
    const realv all = MAX(fabs(x1 - x0), (realv)(1e-3f)), within = MAX(all - below - above, (realv)(0.0f));
    const float4 first_entry = table[0], last_entry = table[p->table_size * p->table_size - 1];
    const realv of_slab = within / all * slab->extinction, of_first = below / all * first_entry.w;
    const realv of_last = above / all * last_entry.w, sum = of_slab + of_first + of_last;
    const realv inverse = 1.0f / MAX(sum, (realv)(1e-30f));
    const intv cut = below + above > 0.0f;
    slab->r = cut ? (of_slab * slab->r + of_first * first_entry.x + of_last * last_entry.x) * inverse : slab->r;
    slab->g = cut ? (of_slab * slab->g + of_first * first_entry.y + of_last * last_entry.y) * inverse : slab->g;
    slab->b = cut ? (of_slab * slab->b + of_first * first_entry.z + of_last * last_entry.z) * inverse : slab->b;
    slab->extinction = cut ? sum : slab->extinction;
}
#endif

ALWAYS_INLINE Slab slab_between(__global const float4 *table, const MarchParams *p, realv front, realv back) {
    Slab slab;
    table_entries(table, entry_of(p, front) * p->table_size + entry_of(p, back), &slab.r, &slab.g, &slab.b,
                  &slab.extinction);
#ifdef TABLE_CUT
    extend_slab(table, p, front, back, &slab);
#endif
    return slab;
}

// Slices one row of rays.
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
    Slice front, back;
    front.sampled = false;
    back.sampled = false;
    intv visible_front = 0;
    bool known = false; // whether visible_front is that of slice n
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
                const Slab slab = slab_between(table, p, front.value, back.value);
                Lighting lighting;
                if (sample->shading) {
                    differentiate(voxels, view, hits, &front);
                    differentiate(voxels, view, hits, &back);
                    lighting = light_gradient(sample, 0.5f * (front.u + back.u), 0.5f * (front.v + back.v),
                                              0.5f * (front.a + back.a));
                }
                const realv depth = slab.extinction * ((to - from) * rays->length);
                realv opacity = opacity_of_depth(sample, depth);
                opacity *= CONVERT_REALV(COUNT_IF(needed));
                if (sample->background_visible) {
                    const realv middle = (realv)(0.5f * (from + to));
                    opacity *= CONVERT_REALV(COUNT_IF(middle >= extent.from && middle <= extent.to));
                }
                *active += COUNT_IF(opacity > 0.0f);
                composite(sample, slab.r, slab.g, slab.b, opacity, &lighting, &light);
                if (sample->opaque > 0.0f && !ANY(hits && light.t > sample->opaque))
                    break;
            }
        }
        front = back;
        known = true;
    }
    return light;
}
