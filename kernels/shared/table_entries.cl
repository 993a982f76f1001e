// Look-up in tables of four-component entries.

#include "shared/vector.cl"

#if VW > 1
// (a0 b0 a1 b1, a4 b4 a5 b5, ...) and (a2 b2 a3 b3, a6 b6 a7 b7, ...): within groups of four lanes, like the unpack instructions of
// vector units.
#if VW == 4
#define INTERLEAVE_LOW(a, b) (realv)((a).s0, (b).s0, (a).s1, (b).s1)
#define INTERLEAVE_HIGH(a, b) (realv)((a).s2, (b).s2, (a).s3, (b).s3)
#elif VW == 8
#define INTERLEAVE_LOW(a, b) (realv)((a).s0, (b).s0, (a).s1, (b).s1, (a).s4, (b).s4, (a).s5, (b).s5)
#define INTERLEAVE_HIGH(a, b) (realv)((a).s2, (b).s2, (a).s3, (b).s3, (a).s6, (b).s6, (a).s7, (b).s7)
#elif defined(PERMUTE)
// Spelled out, LLVM generates a chain of eight dependent permutations for each result.
#define INTERLEAVE_LOW(a, b) \
    PERMUTE(a, b, (intv)(0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29))
#define INTERLEAVE_HIGH(a, b) \
    PERMUTE(a, b, (intv)(2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31))
#else
#define INTERLEAVE_LOW(a, b) \
    (realv)((a).s0, (b).s0, (a).s1, (b).s1, (a).s4, (b).s4, (a).s5, (b).s5, \
            (a).s8, (b).s8, (a).s9, (b).s9, (a).sc, (b).sc, (a).sd, (b).sd)
#define INTERLEAVE_HIGH(a, b) \
    (realv)((a).s2, (b).s2, (a).s3, (b).s3, (a).s6, (b).s6, (a).s7, (b).s7, \
            (a).sa, (b).sa, (a).sb, (b).sb, (a).se, (b).se, (a).sf, (b).sf)
#endif

// Transposes 4 x 4 matrices, one in each group of four lanes: rows (a, b, c, d) to columns.
static inline void transpose_fours(realv a, realv b, realv c, realv d, realv *x, realv *y, realv *z, realv *w) {
    const realv ac_low = INTERLEAVE_LOW(a, c), ac_high = INTERLEAVE_HIGH(a, c);
    const realv bd_low = INTERLEAVE_LOW(b, d), bd_high = INTERLEAVE_HIGH(b, d);
    *x = INTERLEAVE_LOW(ac_low, bd_low);
    *y = INTERLEAVE_HIGH(ac_low, bd_low);
    *z = INTERLEAVE_LOW(ac_high, bd_high);
    *w = INTERLEAVE_HIGH(ac_high, bd_high);
}
#endif

#ifdef PERMUTE
// Halves of two vectors, and every second quarter.
#define LOW_HALVES(a, b) PERMUTE(a, b, (intv)(0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23))
#define HIGH_HALVES(a, b) PERMUTE(a, b, (intv)(8, 9, 10, 11, 12, 13, 14, 15, 24, 25, 26, 27, 28, 29, 30, 31))
#define EVEN_QUARTERS(a, b) PERMUTE(a, b, (intv)(0, 1, 2, 3, 8, 9, 10, 11, 16, 17, 18, 19, 24, 25, 26, 27))
#define ODD_QUARTERS(a, b) PERMUTE(a, b, (intv)(4, 5, 6, 7, 12, 13, 14, 15, 20, 21, 22, 23, 28, 29, 30, 31))
// Transposes rows of four quarters to columns.
static inline void transpose_quarters(const realv *rows, realv *columns) {
    const realv left = LOW_HALVES(rows[0], rows[1]), right = HIGH_HALVES(rows[0], rows[1]);
    const realv left_below = LOW_HALVES(rows[2], rows[3]), right_below = HIGH_HALVES(rows[2], rows[3]);
    columns[0] = EVEN_QUARTERS(left, left_below), columns[1] = ODD_QUARTERS(left, left_below);
    columns[2] = EVEN_QUARTERS(right, right_below), columns[3] = ODD_QUARTERS(right, right_below);
}
#endif

// Components of VW four-component entries ENTRY(0), ENTRY(1) ..., each loaded into its place for the transposition.
#if VW == 4
#define COMPONENTS(ENTRY, x, y, z, w) transpose_fours(ENTRY(0), ENTRY(1), ENTRY(2), ENTRY(3), x, y, z, w)
#elif VW == 8
#define COMPONENTS(ENTRY, x, y, z, w) \
    transpose_fours((realv)(ENTRY(0), ENTRY(4)), (realv)(ENTRY(1), ENTRY(5)), (realv)(ENTRY(2), ENTRY(6)), \
                    (realv)(ENTRY(3), ENTRY(7)), x, y, z, w)
#elif VW == 16
#define FOUR_ENTRIES(ENTRY, n) (realv)(ENTRY(n), ENTRY(n + 4), ENTRY(n + 8), ENTRY(n + 12))
#define COMPONENTS(ENTRY, x, y, z, w) \
    transpose_fours(FOUR_ENTRIES(ENTRY, 0), FOUR_ENTRIES(ENTRY, 1), FOUR_ENTRIES(ENTRY, 2), FOUR_ENTRIES(ENTRY, 3), x, y, \
                    z, w)
#endif

// Loads VW whole entries instead of four gathers of VW floats: 229 -> 186 CPU ms in the prototype.
static inline void table_entries(__global const float4 *table, intv index, realv *r, realv *g, realv *b, realv *w) {
#if VW == 1
    const float4 e = table[index];
    *r = e.x, *g = e.y, *b = e.z, *w = e.w;
#else
    // Indices of half entries: x86 addressing scales by up to 8 bytes.
    const intv halves = index * 2;
    const int *i = (const int *)&halves;
#define TABLE_ENTRY(n) (*(__global const float4 *)((__global const float2 *)table + i[n]))
    COMPONENTS(TABLE_ENTRY, r, g, b, w);
#endif
}
