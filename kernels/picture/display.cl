// A finished pixel in 8 bits: over a background colour, or with straight alpha.

#include "shared/elementary.cl"

// background.w is 1 for an opaque background; 0 keeps the picture transparent.
inline uchar4 displayed(float4 color, float4 background) {
    float4 shown = 0.0f;
    if (background.w > 0.0f)
        shown = (float4)(color.xyz + (1.0f - color.w) * background.xyz, 1.0f);
    else if (color.w > 0.0f)
        shown = (float4)(color.xyz / color.w, color.w);
    return convert_uchar4(CLAMP(shown * 255.0f + 0.5f, (float4)(0.0f), (float4)(255.0f)));
}
