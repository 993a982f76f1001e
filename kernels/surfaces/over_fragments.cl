// Composites what rays have gathered before their next fragments, and these fragments, and cuts the rays at the next ones.
//
// One work-item per row of pixels. A ray's volume is drawn interval by interval: `drawn` is the picture of the last one, and
// `picture` that of all in front of it. cuts: the next interval of each ray, empty for those that wait or are finished. pending[row]: DRAW where an interval of the row is
// to be drawn, FIND where further fragments are wanted.

#include "shared/elementary.cl"
#include "shared/clipping.cl"
#include "surfaces/cells.cl"
#include "surfaces/fragment_states.cl"
#include "shared/first_hit.cl"

#define DRAW 1
#define FIND 2
// Instead of the number of the next fragment: nothing follows.
#define FINISHED 255

// Premultiplied colour and transmittance; or, DEPTHS, the depth of the first hit, the mean weighted by opacity, unused, and transmittance.
typedef float4 Gathered;
#ifdef DEPTHS
#define NOTHING_GATHERED ((float4)(INFINITY, 0.0f, 0.0f, 1.0f))
#else
#define NOTHING_GATHERED ((float4)(0.0f, 0.0f, 0.0f, 1.0f))
#endif

// Adds what is behind: premultiplied colours and opacity.
static inline Gathered behind(Gathered front, float4 back) {
#ifdef DEPTHS
    const float left = front.w * (1.0f - back.w);
    const bool is_first = front.w > FIRST_HIT_TRANSMITTANCE && left <= FIRST_HIT_TRANSMITTANCE;
    // What alone is too faint for a hit has its mean depth.
    front.x = is_first ? (isfinite(back.x) ? back.x : back.y / back.w) : front.x;
    front.y += front.w * back.y;
    front.w = left;
#else
    front.xyz += front.w * back.xyz;
    front.w *= 1.0f - back.w;
#endif
    return front;
}

// A fragment as a picture of its own.
static inline float4 fragment_picture(__global const float *depths, __global const ushort4 *colors, size_t at) {
    const float4 color = vload_half4(at, (__global const half *)colors);
#ifdef DEPTHS
    return (float4)(depths[at], depths[at] * color.w, 0.0f, color.w);
#else
    return (float4)(color.xyz * color.w, color.w);
#endif
}

__kernel void over_fragments(SurfaceView view, RayEnds volume_ends, float opaque, int over_all, int first, __global const float4 *drawn,
                             __global const float *depths, __global const ushort4 *colors, __global uchar *states, __global uchar *next,
                             __global float4 *picture, __global float2 *cuts, __global uint *pending, ulong first_item) {
    const int y = first_item + get_global_id(0);
    if (y >= view.height)
        return;
    const size_t pixels = (size_t)view.width * view.height;
    uint todo = 0;
    for (int x = 0; x < view.width; x++) {
        const size_t at = (size_t)y * view.width + x;
        int n = first ? 0 : next[at];
        const float2 before = first ? (float2)(-INFINITY, -INFINITY) : cuts[at];
        cuts[at] = (float2)(INFINITY, -INFINITY);
        if (n == FINISHED)
            continue;
        Gathered gathered = first ? NOTHING_GATHERED : picture[at];
        gathered.w = first ? 1.0f : 1.0f - gathered.w;
        const int count = states[at] & FRAGMENT_COUNT;
        float from = before.y;
        if (before.x < before.y) {
            gathered = behind(gathered, drawn[at]);
            if (from < INFINITY)
                gathered = behind(gathered, fragment_picture(depths, colors, n++ * pixels + at));
        }
        // Where the ray is in the volume.
        const SurfaceRay ray = surface_ray(&view, x, y);
        const float origin[3] = {ray.origin.x, ray.origin.y, ray.origin.z}, along[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
        const Interval inside = clip_rays(&volume_ends, origin, along);
        float2 cut = {from, from};
        for (; from < INFINITY && gathered.w > opaque; n++) {
            if (n == count && states[at] & FOLLOWED) {
                states[at] |= WANTED;
                todo |= FIND, n = 0;
                break;
            }
            const float to = n < count ? depths[n * pixels + at] : INFINITY;
            const bool is_drawn = over_all ? to == INFINITY : max(from, inside.from) < min(to, inside.to);
            if (is_drawn) {
                cut = (float2)(over_all ? -INFINITY : from, to);
                todo |= DRAW;
                break;
            }
            from = to;
            cut = (float2)(from, from);
            if (to < INFINITY)
                gathered = behind(gathered, fragment_picture(depths, colors, n * pixels + at));
        }
        picture[at] = (float4)(gathered.xyz, 1.0f - gathered.w);
        const bool waits = cut.x < cut.y || states[at] & WANTED;
        next[at] = waits ? n : FINISHED;
        cuts[at] = cut;
    }
    pending[y] = todo;
}
