// Sets of few things, as rows or patches of a tile, or some of its slabs: a bit each.

#define LOWEST_OF(set) (31 - clz((set) & -(set)))
#define HIGHEST_OF(set) (31 - clz(set))
#define FIRST_FEW(count) ((1 << (count)) - 1)
