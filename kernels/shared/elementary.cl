// Elementary functions with just the accuracy that rendering needs. PoCL's own cost 20 % of the lattice stage and more.

#include "shared/vector.cl"

// fmax and fmin treat NaN, which takes four instructions more. Here the result is b if a is NaN.
#define MAX(a, b) ((a) > (b) ? (a) : (b))
#define MIN(a, b) ((a) < (b) ? (a) : (b))
#define CLAMP(x, lo, hi) MIN(MAX(x, lo), hi)

// Largest integer not above x, for x in the range of int; scalar and vector.
static inline int floor_int(float x) {
    const int i = (int)x;
    return i - (x < i);
}
static inline intv floor_ints(realv x) {
    const intv i = CONVERT_INTV(x);
    return i - COUNT_IF(x < CONVERT_REALV(i));
}

// 2^y for y in -126 ... 0, to 1.1e-7, exact for integral y: adding 1.5 x 2^23 rounds y to an integer in the low bits.
static inline realv fast_exp2(realv y) {
    const realv shifted = y + 12582912.0f;
    const realv f = y - (shifted - 12582912.0f);
    // Evaluated in pairs: a chain of five dependent operations has a longer latency.
    const realv f2 = f * f;
    const realv low = f * 0.6931469776f + 1.0f, middle = f * 0.0555073372f + 0.2402224208f;
    const realv high = f * 0.0013264732f + 0.0096715131f;
    const realv p = low + f2 * (middle + f2 * high);
    return AS_REALV(AS_INTV(p) + (AS_INTV(shifted) << 23));
}

// 1 - e^-x for x >= 0.
static inline realv absorbed(realv x) { return 1.0f - fast_exp2(MAX(x * -1.4426950409f, (realv)(-126.0f))); }

// log2(x) for x in 1e-6 ... 1 (relative error 1.2e-6), a polynomial fitted at Chebyshev nodes. Smaller x have the value of 1e-6.
static inline realv fast_log2(realv x) {
    const intv bits = AS_INTV(MAX(x, (realv)(1e-6f)));
    const intv e = (bits - 0x3f400000) >> 23;
    const realv t = AS_REALV(bits - (e << 23)) - 1.0f; // -0.25 ... 0.5; 0 where x is 1
    const realv t2 = t * t, t4 = t2 * t2;
    const realv p01 = t * 1.4426963325f + CONVERT_REALV(e), p23 = t * 0.4806241063f - 0.7213282648f;
    const realv p45 = t * 0.2982907009f - 0.3615473215f, p67 = t * 0.1199838635f - 0.2427637451f;
    return p01 + t2 * p23 + t4 * (p45 + t2 * p67);
}

// x^exponent for x in 0 ... 1 and exponent >= 0.
static inline realv general_power(realv x, realv exponent) {
    return fast_exp2(CLAMP(exponent * fast_log2(x), (realv)(-126.0f), (realv)(0.0f)));
}

// x^exponent for x in 0 ... 1 and exponent > 0. Integral exponents below 256 by squaring.
static inline realv power(realv x, float exponent) {
    int whole = (int)exponent;
    if (whole == exponent && whole < 256) {
        realv result = whole & 1 ? x : (realv)(1.0f);
        while (whole >>= 1) {
            x *= x;
            result = whole & 1 ? result * x : result;
        }
        return result;
    }
    return general_power(x, (realv)(exponent));
}
