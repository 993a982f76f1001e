// Words of 32 bits at any byte, for look-ups in volumes of bytes.

#include "shared/vector.cl"

#if defined(LIGHT_VOLUME) || defined(TINTED)
// A 32-bit word at any byte offset, in each lane.
#if defined(GATHER_WORDS)
#define WORDS_AT(p, bytes) GATHER_WORDS(p, bytes)
#elif VW == 1
#define WORDS_AT(p, bytes) as_int(vload4(0, (p) + (bytes)))
#else
#define WORD_AT(n) as_int(vload4(0, volume + at[n]))
static inline intv words_at(__global const uchar *volume, intv bytes) {
    const int *at = (const int *)&bytes;
    intv words;
    int *word = (int *)&words;
    for (int n = 0; n < VW; n++)
        word[n] = WORD_AT(n);
    return words;
}
#define WORDS_AT(p, bytes) words_at(p, bytes)
#endif
#endif

#ifdef STUDIO
// Four words from a byte offset on, in each lane. CPUs load them at once and sort them in registers, which takes less time than four gathers.
#if defined(__has_builtin) && (VW == 16 || VW == 8)
#if __has_builtin(__builtin_shufflevector)
#define QUAD(n) as_int4(vload16(0, volume + at[n]))
#if VW == 16
#define QUADS(n) (intv)(QUAD(n), QUAD((n) + 4), QUAD((n) + 8), QUAD((n) + 12))
#define LOW_PAIRS(a, b) __builtin_shufflevector(a, b, 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29)
#define HIGH_PAIRS(a, b) __builtin_shufflevector(a, b, 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31)
#else
#define QUADS(n) (intv)(QUAD(n), QUAD((n) + 4))
#define LOW_PAIRS(a, b) __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13)
#define HIGH_PAIRS(a, b) __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15)
#endif
#endif
#endif
static inline void four_words_at(__global const uchar *volume, intv bytes, intv *words) {
#ifdef QUADS
    const int *at = (const int *)&bytes;
    const intv first = QUADS(0), second = QUADS(1), third = QUADS(2), fourth = QUADS(3);
    const intv even_low = LOW_PAIRS(first, third), odd_low = LOW_PAIRS(second, fourth);
    const intv even_high = HIGH_PAIRS(first, third), odd_high = HIGH_PAIRS(second, fourth);
    words[0] = LOW_PAIRS(even_low, odd_low), words[1] = HIGH_PAIRS(even_low, odd_low);
    words[2] = LOW_PAIRS(even_high, odd_high), words[3] = HIGH_PAIRS(even_high, odd_high);
#else
    for (int n = 0; n < 4; n++)
        words[n] = WORDS_AT(volume, bytes + 4 * n);
#endif
}
#endif
