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
