// Bytes of a light volume, roots of the light, from the sums of several sweeps.
//
// One work-item per value of volume number `volume`. `gain`: factor of the light, of which a sum holds `whole`.

__kernel void finish_light(__global const ushort *sums, int values, float whole, float gain, int volume, __global uchar *light) {
    const int id = get_global_id(0);
    if (id < values)
        light[(size_t)volume * values + id] = convert_uchar(sqrt(fmin(sums[id] / whole * gain, 1.0f)) * 255.0f + 0.5f);
}
