// Marching in equal steps: step n of a ray is between n and n + 1 steps from the plane of the volume's centre, and is accumulated
// as a whole where its middle is seen.
//
// The including file says what rays are marched through: `struct Marched` and the functions below.

#include "rays/marching.cl"

struct Marched;
// Whether anything can be visible in the box of two sets of ray points.
ALWAYS_INLINE bool box_shows(struct Marched *m, const MarchParams *p, const realv *one, const realv *other);
// Whether anything can be visible around points where it is `needed`.
ALWAYS_INLINE intv points_show(const struct Marched *m, const MarchParams *p, const realv *point, intv needed);
// Accumulates step n, or a `share` of it, where it is `needed`. `step`: its length in ray parameters.
ALWAYS_INLINE void accumulate_step(const struct Marched *m, const MarchParams *p, int n, const realv *point, intv needed, realv share,
                                   realv step, Accumulator *gathered, intv *active);

// Marches one row of rays.
ALWAYS_INLINE void march_steps(struct Marched *m, const SampleParams *sample, const MarchParams *p, const RowRays *rays,
                               const Interval *interval, Accumulator *gathered, intv *active) {
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
            if (!box_shows(m, p, point, other)) {
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
            needed &= points_show(m, p, point, needed);
        if (!ANY(needed))
            continue;
#ifdef DEPTHS
        set_depth_range(MAX(first, (realv)(n)) * step, MIN(last, (realv)(n + 1.0f)) * step, gathered);
#endif
        accumulate_step(m, p, n, point, needed, share, step, gathered, active);
        if (!ANY(hits && open_rays(sample, gathered)))
            break;
    }
}
