// The finished 8-bit picture: over a background colour, or with straight alpha.
//
// One work-item per pixel. background.w is 1 for an opaque background; 0 keeps the picture transparent.

__kernel void present(__global const float4 *frame, float4 background, int pixels, __global uchar4 *rgba) {
    const int i = get_global_id(0);
    if (i >= pixels)
        return;
    const float4 color = frame[i];
    const float4 over = (float4)(color.xyz + (1.0f - color.w) * background.xyz, 1.0f);
    const float4 straight = color.w > 0.0f ? (float4)(color.xyz / color.w, color.w) : (float4)(0.0f);
    rgba[i] = convert_uchar4_sat_rte((background.w > 0.0f ? over : straight) * 255.0f);
}
