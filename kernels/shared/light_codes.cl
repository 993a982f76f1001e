// Codes of the light that a light volume keeps: 1 for all light, 0 for 1/510 of it or less, and between them 1 - sqrt(tau / DARKEST) for e^-tau.
//
// Light decreases exponentially into matter, within a voxel if it is dense. Between voxels, linear interpolation of the light would be too
// bright, by an amount that depends on where the surface lies between them: stripes on surfaces. That of the codes is nearer to the truth than
// that of tau, which would make the edges of shadows too dark and has too few steps where there is much light (docs/dev/light.md).

#include "shared/elementary.cl"

#define DARKEST_LOG2 8.9943534f
#define DARKEST (DARKEST_LOG2 * 0.6931472f)

// The code of a light of 0 ... 1, and the light of a code of 0 ... 1.
static inline realv code_of_light(realv light) { return 1.0f - sqrt(MIN(-fast_log2(light) * (1.0f / DARKEST_LOG2), (realv)(1.0f))); }
static inline realv light_of_code(realv code) { return fast_exp2((1.0f - code) * (1.0f - code) * -DARKEST_LOG2); }
