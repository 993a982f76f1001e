// Ray casting, front to back: the field is sampled at equal steps along each ray and classified after interpolation.
//
// Sample n is in the middle of step n. `table`: (r, g, b, tau) per value.

#define TABLE float4
#include "rays/steps.cl"
#include "shared/field.cl"
#include "shared/sample.cl"

struct Marched {
    __global const VOXEL *voxels;
    const VolumeView *view;
    const ShadingSource *shading;
    __global const uchar *visible;
    __global const TABLE *table;
    const SampleParams *sample;
};

ALWAYS_INLINE bool box_shows(struct Marched *m, const MarchParams *p, const realv *one, const realv *other) {
    return box_visible(m->visible, p->blocks_u, p->blocks_v, m->view, one, other);
}

ALWAYS_INLINE intv points_show(const struct Marched *m, const MarchParams *p, const realv *point, intv needed) {
    return cells_visible(m->visible, p->blocks_u, p->blocks_v, m->view, point[0], point[1], point[2]);
}

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

ALWAYS_INLINE void accumulate_step(const struct Marched *m, const MarchParams *p, int n, const realv *point, intv needed, realv share,
                                   realv step, Accumulator *gathered, intv *active) {
    const realv value = value_at(m->voxels, m->view, point[0], point[1], point[2], needed);
    const struct SampleSource source = {m->shading, &m->sample->field, point, needed};
    bool lit = false;
    Lighting lighting;
    accumulate_sample(m->sample, m->table, value, needed ? share : (realv)(0.0f), (realv)(p->length), step, &source, &lit, &lighting,
                      gathered, active);
}

// Marches one row of rays.
ALWAYS_INLINE void march_row(__global const VOXEL *voxels, const VolumeView *view, const ShadingSource *shading,
                             __global const uchar *visible, __global const TABLE *table, const MarchParams *p,
                             const SampleParams *sample, const RowRays *rays, const Interval *interval, Accumulator *gathered,
                             intv *active) {
    struct Marched marched = {voxels, view, shading, visible, table, sample};
    march_steps(&marched, sample, p, rays, interval, gathered, active);
}

#include "rays/march.cl"
