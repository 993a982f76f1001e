// The paper's set of 856 oriented footprint images of 64 x 64 bytes.
//
// One work-item per texel; `count` is 856*64*64. images[index*64*64 + row*64 + column] is F scaled to 0 ... 255 at the centre of the
// texel, over |x| < 1+|s_u|, |y| < 1+|s_v|, for the shear of the image, shears[index].

#include "layered/footprint.cl"

__kernel void footprint_set(__global const float2 *shears, int count, __global uchar *images, ulong first_item) {
    const int texel = first_item + get_global_id(0), column = texel % 64, row = texel / 64 % 64;
    if (texel >= count)
        return;
    const float2 s = shears[texel / (64 * 64)];
    const float x = ((column + 0.5f) / 32.0f - 1.0f) * (1.0f + fabs(s.x));
    const float y = ((row + 0.5f) / 32.0f - 1.0f) * (1.0f + fabs(s.y));
    images[texel] = convert_uchar_sat_rte(footprint(x, y, s.x, s.y) * 255.0f);
}
