// The table of pre-integrated slicing: colour and extinction of a slab, by the values at its front and back.
//
// One work-item per entry, out[front*size + back] = (r, g, b, mean extinction). The value changes linearly within the slab. The slab is
// divided into up to PARTS parts, each with the mean over its range of values, composited front to back. `integrals`: `nodes` of them
// starting with `first`, as in preintegration.cl; entries are `nodes_per_entry` nodes apart. `thickness` is in unit distances.

#include "shared/elementary.cl"

#define PARTS 32

__kernel void preintegrated_table(__global const int4 *integrals, int first, int nodes, float nodes_per_entry, float unit, float thickness,
                                  int linear, int size, __global float4 *out, ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= size * size)
        return;
    const float front = (id / size) * nodes_per_entry, back = (id % size) * nodes_per_entry;
    const int parts = linear ? 1 : clamp((int)(fabs(back - front) * 0.5f), 1, PARTS);
    float4 color = 0.0f;
    float through = 1.0f, depth = 0.0f;
    for (int i = 0; i < parts; i++) {
        const float from = front + (back - front) * i / parts, to = front + (back - front) * (i + 1) / parts;
        // At least the segment between two nodes, so never empty.
        const int lo = clamp((int)(fmin(from, to) + 0.5f), 0, nodes - 2);
        const int hi = clamp((int)(fmax(from, to) + 0.5f), lo + 1, nodes - 1);
        const float4 sum = convert_float4(integrals[first + hi] - integrals[first + lo]);
        const float mean = sum.w * unit / (hi - lo);
        const float part = mean * thickness / parts;
        // A selection instead of a branch: if a branch sets two values and only the next branch reads one of them, PoCL 6 aborts
        // (docs/dev/portability.md).
        const float dimmed = absorbed(part), opacity = linear ? part : dimmed;
        if (sum.w > 0.0f)
            color += through * opacity * (float4)(sum.xyz / sum.w, 1.0f);
        through *= 1.0f - (linear ? 0.0f : dimmed);
        depth += mean / parts;
    }
    out[id] = color.w > 0.0f ? (float4)(color.xyz / color.w, depth) : (float4)(0.0f);
}
