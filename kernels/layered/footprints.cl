// Weights of the parallel lattice: footprints of all voxels that reach a sample, for each phase of each layer.
//
// One work-item per (phase u, phase v, layer -1 ... n), phase u fastest; `layers` is n + 2, and offsets_* are per layer and phase, along u
// repeated up to `columns`. weights[(((layer+1)*per_voxel_v + q)*16 + a + 4*b)*columns + i] is the weight of tap (a, b) in column i of
// phase row q, taps counted from first_tap: vectors of the weights of consecutive samples begin with any phase.
//
// Taps are whole voxels apart, so that they have all knots in common: those where the ray crosses from cell to cell.

#include "layered/footprint.cl"

static inline float4 kernel_functions(float4 x) {
    x = fmin(fabs(x), 1.0f);
    return 1.0f - SMOOTHSTEP(x);
}

__kernel void footprints(__global const LayerOffset *offsets_u, __global const LayerOffset *offsets_v, float shear_u, float shear_v,
                         int per_voxel_u, int per_voxel_v, int columns, int layers, __global float *weights, ulong first_item) {
    const size_t id = first_item + get_global_id(0);
    if (id >= (size_t)per_voxel_u * per_voxel_v * layers)
        return;
    const int p = id % per_voxel_u, q = id / per_voxel_u % per_voxel_v, layer = id / (per_voxel_u * per_voxel_v);
    const float fraction_u = offsets_u[layer * columns + p].fraction, fraction_v = offsets_v[layer * per_voxel_v + q].fraction;
    const int first_u = first_tap(fraction_u, shear_u), first_v = first_tap(fraction_v, shear_v);
    const int taps_u = tap_count(fraction_u, shear_u), taps_v = tap_count(fraction_v, shear_v);
    const float4 taps = {0.0f, 1.0f, 2.0f, 3.0f};
    const float4 x = fraction_u - first_u - taps, y = fraction_v - first_v - taps;
    float4 sums[4] = {(float4)(0.0f), (float4)(0.0f), (float4)(0.0f), (float4)(0.0f)};
    for (float z = -1.0f; z < 1.0f;) {
        const float end = end_of_piece(fraction_u, fraction_v, shear_u, shear_v, z);
        const float centre = 0.5f * (z + end), half_length = 0.5f * (end - z);
        for (int i = 0; i < 5; i++) {
            const float node = centre + half_length * GAUSS_NODE[i];
            const float4 along_u = kernel_functions(x + shear_u * node) * (half_length * GAUSS_WEIGHT[i] * kernel_function(node));
            const float4 along_v = kernel_functions(y + shear_v * node);
            sums[0] += along_v.x * along_u, sums[1] += along_v.y * along_u;
            sums[2] += along_v.z * along_u, sums[3] += along_v.w * along_u;
        }
        z = end;
    }
    __global float *out = weights + ((size_t)layer * per_voxel_v + q) * 16 * columns;
    for (int b = 0; b < 4; b++)
        for (int a = 0; a < 4; a++, out += columns)
            for (int i = p; i < columns; i += per_voxel_u)
                out[i] = a < taps_u && b < taps_v ? ((const float *)&sums[b])[a] : 0.0f;
}
