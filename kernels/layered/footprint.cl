// The footprint of a voxel, F(x, y) = integral of f(x + s_u z) f(y + s_v z) f(z) dz over [-1, 1], in float.
//
// The integrand is a polynomial of degree 9 between the knots of its three factors, and five-point Gauss quadrature of each piece is
// exact.

#include "shared/vector.cl"

__constant float GAUSS_NODE[5] = {0.0f, -0.5384693101f, 0.5384693101f, -0.9061798459f, 0.9061798459f};
__constant float GAUSS_WEIGHT[5] = {0.5688888889f, 0.4786286705f, 0.4786286705f, 0.2369268851f, 0.2369268851f};

static inline float kernel_function(float x) {
    x = fmin(fabs(x), 1.0f);
    return 1.0f - SMOOTHSTEP(x);
}

// Next knot of f(p + s z) after z: where p + s z is -1, 0 or 1. Pieces shorter than 1e-6 are skipped.
static inline float next_knot(float p, float s, float z) {
    float next = 1.0f;
    for (int k = -1; k <= 1; k++) {
        const float knot = (k - p) / s;
        if (knot > z + 1e-6f && knot < next)
            next = knot;
    }
    return next;
}

// The next z at which p + s z is a whole number.
static inline float next_cell(float p, float s, float z) {
    const float at = p + s * z;
    float knot = ((s > 0.0f ? floor(at) + 1.0f : ceil(at) - 1.0f) - p) / s;
    if (knot < z + 1e-6f)
        knot += 1.0f / fabs(s);
    return knot;
}

// The end of the piece from z on of the ray (u + s_u z, v + s_v z): the next cell, or a knot of the kernel along the ray.
static inline float end_of_piece(float u, float v, float s_u, float s_v, float z) {
    float end = z < 0.0f ? 0.0f : 1.0f;
    if (s_u != 0.0f)
        end = fmin(end, next_cell(u, s_u, z));
    if (s_v != 0.0f)
        end = fmin(end, next_cell(v, s_v, z));
    return end;
}

static inline float footprint(float x, float y, float s_u, float s_v) {
    float sum = 0.0f;
    for (float z = -1.0f; z < 1.0f;) {
        float end = z < 0.0f ? 0.0f : 1.0f;
        if (s_u != 0.0f)
            end = fmin(end, next_knot(x, s_u, z));
        if (s_v != 0.0f)
            end = fmin(end, next_knot(y, s_v, z));
        const float centre = 0.5f * (z + end), half_length = 0.5f * (end - z);
        for (int i = 0; i < 5; i++) {
            const float node = centre + half_length * GAUSS_NODE[i];
            sum += half_length * GAUSS_WEIGHT[i] * kernel_function(x + s_u * node) * kernel_function(y + s_v * node) *
                   kernel_function(node);
        }
        z = end;
    }
    return sum;
}

// Voxels whose footprints reach a sample along one axis, counted from the one below it: |fraction - tap| < 1+|s|. 2 to 4 of -1 ... 2
// while |s| <= 1.
static inline int first_tap(float fraction, float s) { return fraction < fabs(s) ? -1 : 0; }
static inline int tap_count(float fraction, float s) { return (fraction > 1.0f - fabs(s) ? 3 : 2) - first_tap(fraction, s); }
