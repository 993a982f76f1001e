// Colours in linear light: src/host/color.rs.

#include "shared/elementary.cl"

// The reflectance of white.
#define WHITEST 0.9f

// The reflectance of a component of an sRGB colour.
static inline realv reflectance(realv coded) {
    const realv high = general_power((coded + 0.055f) * (1.0f / 1.055f), (realv)(2.4f));
    return WHITEST * (coded <= 0.04045f ? coded * (1.0f / 12.92f) : high);
}

// The albedo of matter with a reflectance.
static inline realv albedo(realv reflectance) {
    const realv b = 1.139f + 1.17f * reflectance;
    const realv s = (b - sqrt(MAX(b * b - 0.556f * (1.0f - reflectance), (realv)(0.0f)))) * (1.0f / 0.278f);
    return 1.0f - s * s;
}

// A component of an sRGB colour as programs light it. Colours of voxels are interpolated as they are coded, like those between the points of
// a transfer function.
#ifdef STUDIO
#define LIT_COLOR(coded) reflectance(coded)
#else
#define LIT_COLOR(coded) (coded)
#endif
