// Composites what rays have gathered before their next fragments, and these fragments, and cuts the rays at the next ones.
//
// One work-item per row of pixels. The volume along a ray is drawn interval by interval: `drawn` is the picture of the last one, and `picture`
// that of all in front of it. next: the number of the next fragment, and what the ray waits for. cuts: the next interval of each ray; sample_cuts:
// the same for the samples of a lattice that are pixels, instead. Rays that wait for nothing have an empty one. pending: per row, 1
// where further fragments are wanted, and between which positions in the layers of the lattice the next intervals lie, within the volume; of rows
// without any, from infinity to minus infinity.

#include "shared/elementary.cl"
#include "shared/clipping.cl"
#include "picture/own_samples.cl"
#include "surfaces/cells.cl"
#include "surfaces/fragment_states.cl"
#include "shared/first_hit.cl"

// What a ray waits for: an interval that ends at the next fragment, or further fragments behind the beginning of its interval.
#define NEXT_COUNT 7
#define WAITS_TO_DRAW 8
#define WAITS_TO_FIND 16

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

#define NO_CUT ((float2)(INFINITY, -INFINITY))

// Where rays of VW pixels are in the volume.
static inline Interval within(const SurfaceView *view, const RayEnds *ends, int x, int y) {
    const realv u = CONVERT_REALV(LANES + x) + 0.5f;
    const float v = y + 0.5f;
    realv origin[3], along[3];
    for (int i = 0; i < 3; i++) {
        origin[i] = view->origin[i] + u * view->origin[4 + i] + v * view->origin[8 + i];
        along[i] = view->direction[i] + u * view->direction[4 + i] + v * view->direction[8 + i];
    }
    return clip_rays(ends, origin, along);
}

// Names of the types of VW lanes end so.
#if VW == 1
#define WIDTH
#else
#define WIDTH VW
#endif

// The samples of VW pixels, negative beyond the lattice.
static inline intv samples_of_pixels(const WarpParams *lattice, int x, int y) {
    const realv columns = CONVERT_REALV(LANES + x) + 0.5f;
    FIND_SAMPLES(CAT(float, WIDTH), CAT(int, WIDTH), CAT(uint, WIDTH), lattice, columns, y + 0.5f, at, beyond)
    return beyond ? (intv)(-1) : at;
}

__kernel void over_fragments(SurfaceView view, WarpParams lattice, RayEnds volume_ends, float opaque, int over_all, int first,
                             __global const float4 *drawn, __global const float *depths, __global const ushort4 *colors,
                             __global uchar *states, __global uchar *next, __global float4 *picture, __global float2 *cuts,
                             __global float2 *sample_cuts, __global float4 *pending, ulong first_item) {
    const int y = first_item + get_global_id(0);
    if (y >= view.height || (!first && pending[y].x == 0.0f && pending[y].y > pending[y].z))
        return;
    const size_t pixels = (size_t)view.width * view.height;
    float4 todo = {0.0f, INFINITY, -INFINITY, 0.0f};
    for (int column = 0; column < view.width; column += VW) {
        const int lanes = min(VW, view.width - column);
        const size_t begin = (size_t)y * view.width + column;
        bool any_waits = first;
        for (int lane = 0; lane < lanes; lane++)
            any_waits |= !first && next[begin + lane];
        if (!any_waits)
            continue;
        const Interval inside = within(&view, &volume_ends, column, y);
        intv samples = -1;
        if (lattice.for_each_pixel)
            samples = samples_of_pixels(&lattice, column, y);
        for (int lane = 0; lane < lanes; lane++) {
            const size_t at = begin + lane;
            const int waits = first ? 0 : next[at], count = states[at] & FRAGMENT_COUNT;
            if (!first && !waits)
                continue;
            int n = waits & NEXT_COUNT;
            Gathered gathered = NOTHING_GATHERED;
            if (!first) {
                gathered = picture[at];
                gathered.w = 1.0f - gathered.w;
            }
            // Where the next interval begins.
            float from = waits & WAITS_TO_FIND ? cuts[at].x : -INFINITY;
            if (waits & WAITS_TO_DRAW) {
                gathered = behind(gathered, drawn[at]);
                from = n < count ? depths[n * pixels + at] : INFINITY;
                if (n < count)
                    gathered = behind(gathered, fragment_picture(depths, colors, n++ * pixels + at));
            }
            float2 cut = NO_CUT;
            int waits_for = 0;
            for (; from < INFINITY && gathered.w > opaque; n++) {
                if (n == count && states[at] & FOLLOWED) {
                    states[at] |= WANTED;
                    waits_for = WAITS_TO_FIND, todo.x = 1.0f;
                    break;
                }
                const float to = n < count ? depths[n * pixels + at] : INFINITY;
                const float enters = max(from, ((const float *)&inside.from)[lane]), leaves = min(to, ((const float *)&inside.to)[lane]);
                if (over_all ? to == INFINITY : enters < leaves) {
                    cut = (float2)(over_all ? -INFINITY : from, to);
                    waits_for = WAITS_TO_DRAW | n;
                    todo.y = min(todo.y, in_layers(&view, column + lane, y, over_all ? -INFINITY : enters));
                    todo.z = max(todo.z, in_layers(&view, column + lane, y, over_all ? INFINITY : leaves));
                    break;
                }
                if (to < INFINITY)
                    gathered = behind(gathered, fragment_picture(depths, colors, n * pixels + at));
                from = to;
            }
            picture[at] = (float4)(gathered.xyz, 1.0f - gathered.w);
            next[at] = waits_for;
            // Where a ray that waits for fragments goes on.
            if (!lattice.for_each_pixel || waits_for == WAITS_TO_FIND)
                cuts[at] = waits_for == WAITS_TO_FIND ? (float2)(from, from) : cut;
            const int sample = ((const int *)&samples)[lane];
            if (sample >= 0)
                sample_cuts[sample] = waits_for & WAITS_TO_DRAW ? (float2)(in_layers(&view, column + lane, y, cut.x),
                                                                           in_layers(&view, column + lane, y, cut.y))
                                                                : NO_CUT;
        }
    }
    pending[y] = todo;
}
