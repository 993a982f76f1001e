// Bytes of a light volume from the sums of several sweeps.
//
// One work-item per value of volume number `volume`. `gain`: factor of the light, of which a sum holds `whole`. `coded`: whether the volume has
// codes of light, or the light itself.

#include "shared/light_codes.cl"

__kernel void finish_light(__global const ushort *sums, int values, float whole, float gain, int coded, int volume, __global uchar *light,
                           ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= values)
        return;
    const float share = fmin(sums[id] / whole * gain, 1.0f);
    const float value = coded ? code_of_light(share) : share;
    light[(size_t)volume * values + id] = convert_uchar(value * 255.0f + 0.5f);
}
