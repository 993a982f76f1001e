// Transmittance of half a layer for each table entry, along one direction of light.
//
// One work-item per entry. `half_layer`: length of half a layer, in unit distances. With linear extinction entries hold alpha, else tau.

__kernel void light_table(__global const float4 *table, int count, float half_layer, int linear, __global float *transmittance) {
    const int id = get_global_id(0);
    if (id >= count)
        return;
    const float depth = table[id].w * half_layer;
    transmittance[id] = linear ? fmax(1.0f - depth, 0.0f) : exp(-depth);
}
