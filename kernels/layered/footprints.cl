// Weights of the parallel lattice: footprints of all voxels that reach a sample, for each phase of each layer.
//
// One work-item per (phase u, phase v, layer -1 ... n), phase u fastest; `layers` is n + 2, and offsets_* are per layer and phase, along u
// repeated up to `columns`. weights[(((layer+1)*per_voxel_v + q)*16 + a + 4*b)*columns + i] is the weight of tap (a, b) in column i of
// phase row q, taps counted from first_tap: vectors of the weights of consecutive samples begin with any phase.

#include "layered/footprint.cl"

__kernel void footprints(__global const LayerOffset *offsets_u, __global const LayerOffset *offsets_v, float shear_u, float shear_v,
                         int per_voxel_u, int per_voxel_v, int columns, int layers, __global float *weights, ulong first_item) {
    const size_t id = first_item + get_global_id(0);
    if (id >= (size_t)per_voxel_u * per_voxel_v * layers)
        return;
    const int p = id % per_voxel_u, q = id / per_voxel_u % per_voxel_v, layer = id / (per_voxel_u * per_voxel_v);
    const float fraction_u = offsets_u[layer * columns + p].fraction, fraction_v = offsets_v[layer * per_voxel_v + q].fraction;
    const int first_u = first_tap(fraction_u, shear_u), first_v = first_tap(fraction_v, shear_v);
    const int taps_u = tap_count(fraction_u, shear_u), taps_v = tap_count(fraction_v, shear_v);
    __global float *out = weights + ((size_t)layer * per_voxel_v + q) * 16 * columns;
    for (int b = 0; b < 4; b++)
        for (int a = 0; a < 4; a++, out += columns) {
            const float weight = a < taps_u && b < taps_v
                                     ? footprint(fraction_u - (first_u + a), fraction_v - (first_v + b), shear_u, shear_v)
                                     : 0.0f;
            for (int i = p; i < columns; i += per_voxel_u)
                out[i] = weight;
        }
}
