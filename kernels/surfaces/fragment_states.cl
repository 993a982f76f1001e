// Fragments that are kept per pixel, and what is known of them: their number, and whether more can follow, or are wanted.
#define SLOTS 4
#define FRAGMENT_COUNT 7
#define FOLLOWED 8
#define WANTED 16
