// The opacity table of a parallel view: extinction converted to opacity for its constant step length.
//
// One work-item per entry: (r, g, b, tau) -> (r, g, b, 1 - exp(-tau dt)), or (r, g, b, alpha) -> min(1, alpha dt).

__kernel void table(__global const float4 *base, float dt, int linear, int count, __global float4 *entries, ulong first_item) {
    const int i = first_item + get_global_id(0);
    if (i >= count)
        return;
    float4 entry = base[i];
    entry.w = linear ? fmin(entry.w * dt, 1.0f) : -expm1(-entry.w * dt);
    entries[i] = entry;
}
