// Vectors of VW lanes, and definitions that all kernels share.

#ifndef VW
#error "VW: lanes of realv: 16, 8, 4 or 1"
#endif

#define CAT_(a, b) a##b
#define CAT(a, b) CAT_(a, b)

#if VW == 1
typedef float realv;
typedef int intv;
typedef uint uintv;
typedef float realv_unaligned;
#define ANY(mask) ((mask) != 0)
#define CONVERT_INTV(x) convert_int(x)
#define CONVERT_REALV(x) convert_float(x)
#define LOAD_VOXELS(p) convert_float(*(p))
#define AS_INTV(x) as_int(x)
#define AS_UINTV(x) as_uint(x)
#define AS_REALV(x) as_float(x)
#define GATHER_AS(type, p, i) ((type)((p)[i]))
#define LANES 0
#define COUNT_IF(mask) ((mask) ? 1 : 0)
#else
typedef CAT(float, VW) realv;
typedef CAT(int, VW) intv;
typedef CAT(uint, VW) uintv;
// Unaligned access through a typedef: vload16 on private memory is slower on PoCL.
typedef CAT(float, VW) __attribute__((aligned(4))) realv_unaligned;
#define ANY(mask) (any_lane(mask))
#define CONVERT_INTV(x) CAT(convert_int, VW)(x)
#define CONVERT_REALV(x) CAT(convert_float, VW)(x)
#define LOAD_VOXELS(p) CONVERT_REALV(CAT(vload, VW)(0, p))
#define AS_INTV(x) CAT(as_int, VW)(x)
#define AS_UINTV(x) CAT(as_uint, VW)(x)
#define AS_REALV(x) CAT(as_float, VW)(x)
#define COUNT_IF(mask) (-(mask))
#if VW == 16
#define LANES (intv)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)
#define GATHER_AS(type, p, i) \
    (type)((p)[(i).s0], (p)[(i).s1], (p)[(i).s2], (p)[(i).s3], (p)[(i).s4], (p)[(i).s5], (p)[(i).s6], (p)[(i).s7], \
           (p)[(i).s8], (p)[(i).s9], (p)[(i).sa], (p)[(i).sb], (p)[(i).sc], (p)[(i).sd], (p)[(i).se], (p)[(i).sf])
#elif VW == 8
#define LANES (intv)(0, 1, 2, 3, 4, 5, 6, 7)
#define GATHER_AS(type, p, i) \
    (type)((p)[(i).s0], (p)[(i).s1], (p)[(i).s2], (p)[(i).s3], (p)[(i).s4], (p)[(i).s5], (p)[(i).s6], (p)[(i).s7])
#elif VW == 4
#define LANES (intv)(0, 1, 2, 3)
#define GATHER_AS(type, p, i) (type)((p)[(i).s0], (p)[(i).s1], (p)[(i).s2], (p)[(i).s3])
#endif
#endif

// Clamp of integers. Vector bounds, since Oclgrind reads lanes even of scalar ones.
#define CLAMP_INTV(x, lowest, highest) clamp(x, (intv)(lowest), (intv)(highest))
#define GATHER(p, i) GATHER_AS(realv, p, i)
#define LOADV(p) (*(const realv_unaligned *)(p))
#define STOREV(p, x) (*(realv_unaligned *)(p) = (x))

#if VW > 1
// any() is a chain of branches on PoCL; this is one reduction, or one instruction if the compiler has a builtin. SPIR programs are for
// other consumers, and Oclgrind has no reductions.
#if defined(__has_builtin) && !defined(__SPIR__)
#if __has_builtin(__builtin_reduce_or)
#define REDUCE_OR(mask) __builtin_reduce_or(mask)
#endif
#endif
static inline bool any_lane(intv mask) {
#ifdef REDUCE_OR
    return REDUCE_OR(mask) != 0;
#else
#if VW == 16
    const int8 m8 = mask.lo | mask.hi;
    const int4 m4 = m8.lo | m8.hi;
#elif VW == 8
    const int4 m4 = mask.lo | mask.hi;
#else
    const int4 m4 = mask;
#endif
    const int2 m2 = m4.lo | m4.hi;
    return (m2.x | m2.y) != 0;
#endif
}
#endif

// Smallest and largest lane. Narrower vectors are repeated to 16 lanes.
#if VW == 16
#define SIXTEEN(x) (x)
#elif VW == 8
#define SIXTEEN(x) (float16)(x, x)
#elif VW == 4
#define SIXTEEN(x) (float16)(x, x, x, x)
#else
#define SIXTEEN(x) (float16)(x)
#endif
static inline float smallest_lane(realv x) {
    const float16 x16 = SIXTEEN(x);
    const float8 x8 = x16.lo < x16.hi ? x16.lo : x16.hi;
    const float4 x4 = x8.lo < x8.hi ? x8.lo : x8.hi;
    const float2 x2 = x4.lo < x4.hi ? x4.lo : x4.hi;
    return x2.x < x2.y ? x2.x : x2.y;
}
static inline float largest_lane(realv x) { return -smallest_lane(-x); }

// AVX-512 selects any of 32 floats for each lane in one instruction; no OpenCL function compiles to it.
#if VW == 16 && defined(__AVX512F__)
#define PERMUTE(a, b, index) __builtin_ia32_vpermi2varps512(a, index, b)
#endif

// AVX-512 gathers 32-bit words from unaligned byte offsets.
#if VW == 16 && defined(__AVX512F__)
#define GATHER_WORDS(p, bytes) \
    __builtin_ia32_gathersiv16si((intv)(0), (const void *)(ulong)(p), bytes, (ushort)0xffff, 1)
#endif

// 1 / x (any sign) and 1 / sqrt(x) for normal x > 0, to 1e-7 and 5e-6. AVX-512 estimates both to 14 bits; a Newton step more takes a
// quarter of a division's time. The rough versions, for weights of similar quantities, are accurate to at least 1e-4 and save four
// dependent operations.
#if VW == 16 && defined(__AVX512F__)
static inline realv rough_reciprocal(realv x) { return __builtin_ia32_rcp14ps512_mask(x, (realv)(0.0f), (ushort)0xffff); }
static inline realv rough_inverse_sqrt(realv x) { return __builtin_ia32_rsqrt14ps512_mask(x, (realv)(0.0f), (ushort)0xffff); }
static inline realv reciprocal(realv x) {
    const realv guess = rough_reciprocal(x);
    return guess * (2.0f - x * guess);
}
static inline realv inverse_sqrt(realv x) {
    const realv guess = rough_inverse_sqrt(x);
    return guess * (1.5f - 0.5f * x * guess * guess);
}
#else
#define rough_reciprocal reciprocal
#define rough_inverse_sqrt inverse_sqrt
static inline realv reciprocal(realv x) { return 1.0f / x; }
// An initial estimate from the exponent, and two Newton steps.
static inline realv inverse_sqrt(realv x) {
    realv y = AS_REALV(0x5f3759df - (AS_INTV(x) >> 1));
    y = y * (1.5f - 0.5f * x * y * y);
    return y * (1.5f - 0.5f * x * y * y);
}
#endif

// Element index[i] of a row of `vectors` (1 or 2; more without PERMUTE) x VW floats, in lane i.
#ifdef PERMUTE
#define PICK(row, vectors, index) PERMUTE(LOADV(row), LOADV((row) + ((vectors) - 1) * VW), index)
#elif VW == 8 && defined(__AVX2__)
// AVX2 selects any of eight floats for each lane in one instruction.
#define PICK(row, vectors, index) (pick_lanes(row, vectors, index))
static inline realv pick_lanes(const float *row, int vectors, intv index) {
    const realv low = __builtin_ia32_permvarsf256(LOADV(row), index);
    if (vectors == 1)
        return low;
    const realv middle = index < VW ? low : __builtin_ia32_permvarsf256(LOADV(row + VW), index);
    return vectors == 2 ? middle : index < 2 * VW ? middle : __builtin_ia32_permvarsf256(LOADV(row + 2 * VW), index);
}
#else
#define PICK(row, vectors, index) GATHER(row, index)
#endif

// PoCL does not inline larger functions, and passes vectors through memory.
#define ALWAYS_INLINE static inline __attribute__((always_inline))

// Prefetch into the cache. OpenCL's own prefetch() does nothing on PoCL.
#ifdef __x86_64__
#define PREFETCH(p) __builtin_prefetch((const void *)(ulong)(p))
#else
#define PREFETCH(p)
#endif

// The interpolation kernel of the paper (Eq. 2) on [0, 1], reversed: 3t^2 - 2t^3, so that f(t) = 1 - smoothstep(t).
#define SMOOTHSTEP(t) ((t) * (t) * (3.0f - 2.0f * (t)))
