// Transmittance of a ray at its first hit, which depth pictures show: one step of an 8-bit picture has been absorbed.
#define FIRST_HIT_TRANSMITTANCE (1.0f - 1.0f / 256.0f)
