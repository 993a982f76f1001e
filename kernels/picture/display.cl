// Conversion of a finished pixel to 8 bits: over a background colour, or with straight alpha.
//
// Bit-identical to src/host/image/display.rs: fma() is explicit where the compiler could choose, and quotients of denormals are avoided, which
// a device may flush to 0.

// Pixels of less opacity are empty.
#define MIN_OPACITY 0x1p-100f

#include "shared/elementary.cl"

#ifdef CURVE
// Applies the curve of a picture to the straight colour of a premultiplied one: src/host/color.rs. `curve`: factor, beginning of the
// shoulder, exponent, and 1 for linear colours.
static inline float4 curved(float4 color, float4 curve) {
    if (!(color.w >= MIN_OPACITY))
        return color;
    float3 shown = MAX(color.xyz / color.w, (float3)(0.0f)) * curve.x;
    const float largest = MAX(MAX(shown.x, shown.y), shown.z), knee = curve.y;
    if (largest > knee) {
        const float above = (largest - knee) / (1.0f - knee);
        shown *= (knee + (1.0f - knee) * (above / (1.0f + above))) / largest;
    }
    if (curve.w > 0.0f) {
        const float3 coded = 1.055f * pow(shown, (float3)(1.0f / 2.4f)) - 0.055f;
        shown = shown <= 0.0031308f ? shown * 12.92f : coded;
    }
    if (curve.z != 1.0f)
        shown = pow(shown, (float3)(curve.z));
    return (float4)(shown * color.w, color.w);
}
#define FOUR_AT_ONCE(background) false
#else
#define FOUR_AT_ONCE(background) ((background).w > 0.0f)
#endif

// background.w is 1 for an opaque background; 0 keeps the picture transparent. `curve`: see curved(); not used without CURVE.
static inline uchar4 displayed(float4 color, float4 background, float4 curve) {
    float4 shown = 0.0f;
#ifdef CURVE
    color = curved(color, curve);
#endif
    if (background.w > 0.0f)
        shown = (float4)(fma((float3)(1.0f - color.w), background.xyz, color.xyz), 1.0f);
    else if (color.w >= MIN_OPACITY)
        shown = (float4)(color.xyz / color.w, color.w);
    const float4 rounded = fma(shown, (float4)(255.0f), (float4)(0.5f));
    return convert_uchar4(CLAMP(rounded, (float4)(0.0f), (float4)(255.0f)));
}

// The opacities of four colours, each repeated for all components of its colour.
#ifdef PERMUTE
#define OPACITIES(colors) PERMUTE(colors, colors, (int16)(3, 3, 3, 3, 7, 7, 7, 7, 11, 11, 11, 11, 15, 15, 15, 15))
#else
#define OPACITIES(colors) (float16)((colors).s3333, (colors).s7777, (colors).sbbbb, (colors).sffff)
#endif

// Four pixels at once.
static inline uchar16 displayed_four(float16 colors, float4 background, float4 curve) {
    if (!FOUR_AT_ONCE(background))
        return (uchar16)(displayed(colors.s0123, background, curve), displayed(colors.s4567, background, curve), displayed(colors.s89ab, background, curve),
                         displayed(colors.scdef, background, curve));
    const float4 behind = (float4)(background.xyz, 0.0f);
    float16 shown = fma(1.0f - OPACITIES(colors), (float16)(behind, behind, behind, behind), colors);
    shown.s37bf = 1.0f;
    const float16 rounded = fma(shown, (float16)(255.0f), (float16)(0.5f));
    return convert_uchar16(CLAMP(rounded, (float16)(0.0f), (float16)(255.0f)));
}
