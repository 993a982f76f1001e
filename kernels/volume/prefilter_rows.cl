// Filter along x: from voxels, less the offset, to filtered ones. One work-item per row, with `rows_per_layer` rows per layer.

#include "shared/volume.cl"
#include "volume/prefilter.cl"

__kernel void prefilter_rows(__global const VOXEL *voxels, VolumeView view, __global const float *taps, int first, int held, int whole,
                             int rows_per_layer, int rows, __global float *filtered, ulong first_item) {
    const float background = view.background;
    const size_t id = first_item + get_global_id(0);
    if (id >= rows)
        return;
    __global const VOXEL *row = voxels + view.first + id % rows_per_layer * view.stride_v + id / rows_per_layer * view.stride_a;
    __global float *out = filtered + id * held;
    for (int i = 0; i < held; i += VW) {
        // The voxels for VW sums.
        float span[VW + 2 * PREFILTER_RADIUS];
        const bool inside = i >= PREFILTER_RADIUS && i + VW + PREFILTER_RADIUS <= held;
#pragma unroll
        for (int n = 0; n < VW + 2 * PREFILTER_RADIUS; n++) {
            const int at = i + n - PREFILTER_RADIUS;
            const float number = VOXEL_VALUE(&view, convert_float(row[inside ? at : resident(at, first, held, whole)]));
            span[n] = inside ? number : OR_BACKGROUND(float, at, number);
        }
        realv sum = taps[0] * LOADV(span + PREFILTER_RADIUS);
#pragma unroll
        for (int k = 1; k <= PREFILTER_RADIUS; k++)
            sum += taps[k] * (LOADV(span + PREFILTER_RADIUS - k) + LOADV(span + PREFILTER_RADIUS + k));
        for (int n = 0; n < min(VW, held - i); n++)
            out[i + n] = ((const float *)&sum)[n];
    }
}
