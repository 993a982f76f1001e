// Ray casting, front to back: the field is sampled at equal steps along each ray and classified after interpolation.
//
// Sample n is in the middle of step n, counted from the plane of the volume's centre. `table`: (r, g, b, tau) per value.

#define TABLE float4
#include "rays/marching.cl"
#include "shared/field.cl"
#include "shared/sample.cl"

struct SampleSource {
    const ShadingSource *shading;
    const FieldParams *field;
    const realv *point;
    intv needed;
};

static inline Point sample_point(const struct SampleSource *s) {
    const Point point = {s->point[0], s->point[1], s->point[2]};
    return point;
}

static inline LightVolume sample_light(const struct SampleSource *s) { return s->shading->light; }

#ifdef TINTED
static inline const Tint *sample_tint(const struct SampleSource *s) { return &s->shading->tint; }
#endif

static inline Gradient sample_gradient(const struct SampleSource *s) {
    return gradient_at(s->shading, s->field, s->point[0], s->point[1], s->point[2], s->needed);
}

// Marches one row of rays.
ALWAYS_INLINE void march_row(__global const VOXEL *voxels, const VolumeView *view, const ShadingSource *shading,
                             __global const uchar *visible, __global const TABLE *table, const MarchParams *p,
                             const SampleParams *sample, const RowRays *rays, const Interval *interval, Accumulator *gathered,
                             intv *active) {
    const realv step = p->length / rays->length;
    const realv first = interval->from / step, last = interval->to / step;
    const intv hits = first < last;
    const int begin = (int)floor(smallest_lane(hits ? first : (realv)(INFINITY)));
    const int end = (int)ceil(largest_lane(hits ? last : (realv)(-INFINITY)));
    for (int n = begin; n < end; n++) {
        realv point[3];
        if (p->culling && (n - begin) % CHUNK == 0) {
            realv other[3];
            points_at(rays, (realv)(n) * step, point);
            points_at(rays, (realv)(n + CHUNK) * step, other);
            if (!box_visible(visible, p, view, point, other)) {
                n += CHUNK - 1;
                continue;
            }
        }
        const float middle = n + 0.5f;
        points_at(rays, middle * step, point);
#ifdef CLIPPED
        const realv share = MAX(MIN(last, (realv)(n + 1.0f)) - MAX(first, (realv)(n)), (realv)(0.0f));
        intv needed = share > 0.0f;
#else
        const realv share = 1.0f;
        intv needed = middle >= first && middle < last;
#endif
        needed &= open_rays(sample, gathered);
        if (p->culling)
            needed &= cells_visible(visible, p, view, point[0], point[1], point[2]);
        if (!ANY(needed))
            continue;
        const realv value = value_at(voxels, view, point[0], point[1], point[2], needed);
        const struct SampleSource source = {shading, &sample->field, point, needed};
#ifdef DEPTHS
        set_depth_range(MAX(first, (realv)(n)) * step, MIN(last, (realv)(n + 1.0f)) * step, gathered);
#endif
        bool lit = false;
        Lighting lighting;
        accumulate_sample(sample, table, value, needed ? share : (realv)(0.0f), (realv)(p->length), step, &source, &lit, &lighting,
                          gathered, active);
        if (!ANY(hits && open_rays(sample, gathered)))
            break;
    }
}

#include "rays/march.cl"
