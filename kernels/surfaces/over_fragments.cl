// Composites what rays have gathered before their next fragments, and these fragments, and cuts the rays at the next ones.
//
// One work-item per row of pixels. The volume along a ray is drawn interval by interval: `drawn` is the picture of the last one, and `picture`
// that of all in front of it. cuts: the next interval of each ray, empty for rays that wait or are finished. sample_cuts: the same for the
// samples of a lattice that are pixels. pending: per row, 1 where further fragments are wanted, and between which positions in the layers of the
// lattice the next intervals lie, within the volume; of rows without any, from infinity to minus infinity.

#include "shared/elementary.cl"
#include "shared/clipping.cl"
#include "picture/own_samples.cl"
#include "surfaces/cells.cl"
#include "surfaces/fragment_states.cl"
#include "shared/first_hit.cl"

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

// A cut in the layers of a lattice.
static inline float in_layers(const SurfaceView *view, int x, int y, float cut) {
    const float *offset = view->to_layers, *scale = view->to_layers + 3;
    const float u = x + 0.5f, v = y + 0.5f;
    return isinf(cut) ? cut : offset[0] + u * offset[1] + v * offset[2] + cut * (scale[0] + u * scale[1] + v * scale[2]);
}

// Cuts the ray of a pixel and, where samples of a lattice are pixels, that of its sample.
#define NO_CUT ((float2)(INFINITY, -INFINITY))
static inline void cut_ray(const SurfaceView *view, const WarpParams *lattice, int x, int y, float2 cut, __global float2 *cuts,
                           __global float2 *sample_cuts) {
    cuts[(size_t)y * view->width + x] = cut;
    if (lattice->for_each_pixel) {
        FIND_SAMPLES(float, int, uint, lattice, x + 0.5f, y + 0.5f, at, beyond)
        if (!beyond)
            sample_cuts[at] = cut.x < cut.y ? (float2)(in_layers(view, x, y, cut.x), in_layers(view, x, y, cut.y)) : NO_CUT;
    }
}

__kernel void over_fragments(SurfaceView view, WarpParams lattice, RayEnds volume_ends, float opaque, int over_all, int first, __global const float4 *drawn,
                             __global const float *depths, __global const ushort4 *colors, __global uchar *states, __global uchar *next,
                             __global float4 *picture, __global float2 *cuts,
                             __global float2 *sample_cuts, __global float4 *pending, ulong first_item) {
    const int y = first_item + get_global_id(0);
    if (y >= view.height)
        return;
    const size_t pixels = (size_t)view.width * view.height;
    float4 todo = {0.0f, INFINITY, -INFINITY, 0.0f};
    for (int x = 0; x < view.width; x++) {
        const size_t at = (size_t)y * view.width + x;
        int n = first ? 0 : next[at];
        const float2 before = first ? (float2)(-INFINITY, -INFINITY) : cuts[at];
        if (n == FINISHED) {
            cut_ray(&view, &lattice, x, y, NO_CUT, cuts, sample_cuts);
            continue;
        }
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
                todo.x = 1.0f, n = 0;
                break;
            }
            const float to = n < count ? depths[n * pixels + at] : INFINITY;
            const bool is_drawn = over_all ? to == INFINITY : max(from, inside.from) < min(to, inside.to);
            if (is_drawn) {
                cut = (float2)(over_all ? -INFINITY : from, to);
                todo.y = min(todo.y, in_layers(&view, x, y, over_all ? -INFINITY : max(from, inside.from)));
                todo.z = max(todo.z, in_layers(&view, x, y, over_all ? INFINITY : min(to, inside.to)));
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
        cut_ray(&view, &lattice, x, y, cut, cuts, sample_cuts);
    }
    pending[y] = todo;
}
