// Projects splats to the screen and sorts them by the sheet in which they begin; splats outside the screen are discarded.
//
// One work-item per chunk of `count` splats. Counts its splats per sheet, counts[chunk*buckets + bucket], or with `fill` writes them to
// the positions given by the scanned counts, which keeps their order within a sheet. PRECLASSIFIED, for axis-aligned sheets: uses one
// bucket, since the list is in the order of layers already; classifies and shades the voxels.

#include "shared/shading.cl"
#include "paper/splat.cl"

// Limit for the kernel of an opaque voxel: with more, its rim would be as opaque as its middle.
#define OPAQUE_EXTINCTION 16.0f

__kernel void sorted_splats(__global const ushort4 *places, __global const float4 *contents, int count, SplatParams p,
                            __global const float4 *table, SampleParams sample, int width, int height, int chunks, int buckets, int fill,
                            __global uint *counts, __global Splat *sorted, ulong first_item) {
    const int chunk = first_item + get_global_id(0);
    if (chunk >= chunks)
        return;
    __global uint *own = counts + (size_t)chunk * buckets;
    if (!fill)
        for (int b = 0; b < buckets; b++)
            own[b] = 0;
    const int begin = (long)count * chunk / chunks, end = (long)count * (chunk + 1) / chunks;
    for (int n = begin; n < end; n++) {
        const int i = p.backwards ? count - 1 - n : n;
        const float3 at = convert_float3(places[i].xyz);
        const float depth = p.along[0] * at.x + p.along[1] * at.y + p.along[2] * at.z + p.along[3];
        if (depth < p.nearest)
            continue;
        float h[3];
        for (int r = 0; r < 3; r++)
            h[r] = p.to_screen[4 * r] * at.x + p.to_screen[4 * r + 1] * at.y + p.to_screen[4 * r + 2] * at.z + p.to_screen[4 * r + 3];
        if (h[2] <= p.least_w)
            continue;
        const float x = h[0] / h[2], y = h[1] / h[2];
        const int4 pixels = pixels_under(&p, x, y, h[2], width, height);
        if (pixels.x > pixels.y || pixels.z > pixels.w)
            continue;
#ifdef PRECLASSIFIED
        const int bucket = 0;
#else
        const float reach = sheet_position(&p, depth);
        const int bucket = clamp(first_sheet(reach), 0, buckets - 1);
#endif
        if (!fill) {
            own[bucket]++;
            continue;
        }
        const float4 content = contents[i];
        __global Splat *splat = sorted + own[bucket]++;
        splat->x = x, splat->y = y, splat->w = h[2];
#ifdef PRECLASSIFIED
        splat->reach = at.z;
        float4 entry = table[table_index(&sample, content.x)];
        float4 color = (float4)(entry.xyz, 1.0f);
        if (sample.light.shading) {
            const Point point = {at.x, at.y, at.z};
            const Gradient gradient = {content.y, content.z, content.w};
            const LightVolume none = NO_LIGHT_VOLUME;
            const Lighting lighting = shade(&sample, none, point, content.x, gradient);
            color.x = lit_red(&sample, color.x, &lighting);
            color.y = lit_green(&sample, color.y, &lighting);
            color.z = lit_blue(&sample, color.z, &lighting);
            entry.w *= lighting.extinction_scale;
        }
        splat->content = color * MIN(entry.w, OPAQUE_EXTINCTION);
#else
        splat->reach = reach;
        splat->content = (float4)(content.x - p.background, content.yzw);
#endif
    }
}
