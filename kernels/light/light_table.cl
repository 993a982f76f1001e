// Transmittance of a thickness for each table entry.
//
// One work-item per entry. `thickness`: in unit distances. With linear extinction entries hold alpha, else tau.

__kernel void light_table(__global const float4 *table, int count, float thickness, int linear, __global float *transmittance,
                          ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= count)
        return;
    const float depth = table[id].w * thickness;
    transmittance[id] = linear ? fmax(1.0f - depth, 0.0f) : exp(-depth);
}
