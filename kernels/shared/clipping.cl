// Where rays count: the part of each ray that lies in a box, before planes, in front of the eye. All of these are convex, so it is one
// interval. CLIPPED: segments and samples are cut to it; without, all that shows anything is known to lie inside.

#include "shared/elementary.cl"

// Ray parameters; empty where from >= to.
typedef struct {
    realv from, to;
} Interval;

// The interval of rays origin + t direction, t >= start, in the axes of `c`.
static inline Interval interval_of(const Clipping *c, const realv *origin, const realv *direction, float start) {
    Interval e = {(realv)(start), (realv)(INFINITY)};
    for (int i = 0; i < 3; i++) {
        // Rays along a face lie in the box from end to end or not at all; in a face they do.
        const intv along = fabs(direction[i]) < 1e-30f;
        const realv inverse = 1.0f / (along ? (realv)(1.0f) : direction[i]);
        const realv above = c->lowest[i] - origin[i], below = c->highest[i] - origin[i];
        const realv a = along ? (above <= 0.0f ? (realv)(-INFINITY) : (realv)(INFINITY)) : above * inverse;
        const realv b = along ? (below >= 0.0f ? (realv)(INFINITY) : (realv)(-INFINITY)) : below * inverse;
        e.from = MAX(e.from, MIN(a, b));
        e.to = MIN(e.to, MAX(a, b));
    }
    // Unrolled: graphics processors would keep planes that are looked up by a number in memory.
#pragma unroll
    for (int n = 0; n < (int)(sizeof c->planes / sizeof(float)) / 4; n++) {
        if (n >= c->plane_count)
            break;
        const float *plane = c->planes + 4 * n;
        const realv at = plane[0] * origin[0] + plane[1] * origin[1] + plane[2] * origin[2] + plane[3];
        const realv along = plane[0] * direction[0] + plane[1] * direction[1] + plane[2] * direction[2];
        const realv crossing = -at / (fabs(along) < 1e-30f ? (realv)(1e-30f) : along);
        e.from = along > 0.0f ? MAX(e.from, crossing) : e.from;
        e.to = along < 0.0f ? MIN(e.to, crossing) : e.to;
        e.to = along == 0.0f && at < 0.0f ? (realv)(-INFINITY) : e.to;
    }
    return e;
}

// The part of a segment that counts, as shares of it: from 0, its front, to 1. Empty where from >= to.
typedef Interval Part;

// Of the segment between two ray parameters.
static inline Part part_of(const Interval *e, realv front, realv back) {
    const realv inverse = 1.0f / (back - front);
    const Part part = {CLAMP((e->from - front) * inverse, (realv)(0.0f), (realv)(1.0f)),
                       CLAMP((e->to - front) * inverse, (realv)(0.0f), (realv)(1.0f))};
    return part;
}

// Length of a part.
static inline realv share_of(const Part *part) { return MAX(part->to - part->from, (realv)(0.0f)); }

// Whether a part is less than the whole for any ray that has one.
static inline bool any_cut(const Part *part) {
    return ANY(part->from < part->to && (part->from > 0.0f || part->to < 1.0f));
}

// Between two numbers at the ends of a segment; exact at both.
static inline realv between(realv front, realv back, realv t) { return t < 1.0f ? front + t * (back - front) : back; }

// A place in a part, 0 ... 1, as one in the whole segment.
#ifdef CLIPPED
#define IN_PART(part, t) between((part)->from, (part)->to, t)
#else
#define IN_PART(part, t) (t)
#endif

// What of a length lies in a part.
#ifdef CLIPPED
#define PART_OF(length, part) ((length) * share_of(part))
#else
#define PART_OF(length, part) (length)
#endif
