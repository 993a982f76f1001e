// Where rays begin and end: each in its interval of the ray parameter, inside a box, and on the positive side of planes. All of these are
// convex, so the result is one interval. CLIPPED: segments and samples are cut to it. Without it, everything visible is known to lie
// inside.

#include "shared/elementary.cl"

// Ray parameters; empty where from >= to.
typedef struct {
    realv from, to;
} Interval;

// Clip interval of the rays origin + t direction, along the axes of `ends`.
static inline Interval clip_rays(const RayEnds *ends, const realv *origin, const realv *direction) {
    Interval interval = {(realv)(ends->start), (realv)(ends->end)};
    for (int i = 0; i < 3; i++) {
        // A ray parallel to a face is inside along its whole length or not at all; a ray in the face is inside.
        const intv along = fabs(direction[i]) < 1e-30f;
        const realv inverse = 1.0f / (along ? (realv)(1.0f) : direction[i]);
        const realv above = ends->lowest[i] - origin[i], below = ends->highest[i] - origin[i];
        const realv a = along ? (above <= 0.0f ? (realv)(-INFINITY) : (realv)(INFINITY)) : above * inverse;
        const realv b = along ? (below >= 0.0f ? (realv)(INFINITY) : (realv)(-INFINITY)) : below * inverse;
        interval.from = MAX(interval.from, MIN(a, b));
        interval.to = MIN(interval.to, MAX(a, b));
    }
    // Unrolled: GPUs would keep planes indexed by a variable in memory.
#pragma unroll
    for (int n = 0; n < (int)(sizeof ends->planes / sizeof(float)) / 4; n++) {
        if (n >= ends->plane_count)
            break;
        const float *plane = ends->planes + 4 * n;
        const realv at = plane[0] * origin[0] + plane[1] * origin[1] + plane[2] * origin[2] + plane[3];
        const realv along = plane[0] * direction[0] + plane[1] * direction[1] + plane[2] * direction[2];
        const realv crossing = -at / (fabs(along) < 1e-30f ? (realv)(1e-30f) : along);
        interval.from = along > 0.0f ? MAX(interval.from, crossing) : interval.from;
        interval.to = along < 0.0f ? MIN(interval.to, crossing) : interval.to;
        interval.to = along == 0.0f && at < 0.0f ? (realv)(-INFINITY) : interval.to;
    }
    return interval;
}

// Part of a segment inside the clip interval, as fractions of the segment: 0 at its front, 1 at its back. Empty where from >= to.
typedef Interval Part;

// The part of the segment between two ray parameters.
static inline Part part_of(const Interval *interval, realv front, realv back) {
    const realv inverse = 1.0f / (back - front);
    const Part part = {CLAMP((interval->from - front) * inverse, (realv)(0.0f), (realv)(1.0f)),
                       CLAMP((interval->to - front) * inverse, (realv)(0.0f), (realv)(1.0f))};
    return part;
}

// Length of a part, as a fraction of the segment.
static inline realv part_length(const Part *part) { return MAX(part->to - part->from, (realv)(0.0f)); }

// Whether any non-empty part is shorter than its segment.
static inline bool any_clipped(const Part *part) {
    return ANY(part->from < part->to && (part->from > 0.0f || part->to < 1.0f));
}

// Linear interpolation, exact at both ends.
static inline realv lerp(realv front, realv back, realv t) { return t < 1.0f ? front + t * (back - front) : back; }

// Converts a parameter of the part, 0 ... 1, to one of the whole segment.
#ifdef CLIPPED
#define SEGMENT_PARAMETER(part, t) lerp((part)->from, (part)->to, t)
#else
#define SEGMENT_PARAMETER(part, t) (t)
#endif

// The length inside the part.
#ifdef CLIPPED
#define CLIPPED_LENGTH(length, part) ((length) * part_length(part))
#else
#define CLIPPED_LENGTH(length, part) (length)
#endif
