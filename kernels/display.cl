// A finished pixel in 8 bits: over a background colour, or with straight alpha.

// background.w is 1 for an opaque background; 0 keeps the picture transparent.
inline uchar4 displayed(float4 color, float4 background) {
    const float4 over = (float4)(color.xyz + (1.0f - color.w) * background.xyz, 1.0f);
    const float4 straight = color.w > 0.0f ? (float4)(color.xyz / color.w, color.w) : (float4)(0.0f);
    const float4 shown = (background.w > 0.0f ? over : straight) * 255.0f + 0.5f;
    return convert_uchar4(CLAMP(shown, (float4)(0.0f), (float4)(255.0f)));
}
