// Small sets as bit masks: rows or patches of a tile, or slabs.

#define LOWEST_BIT(set) (31 - clz((set) & -(set)))
#define HIGHEST_BIT(set) (31 - clz(set))
#define LOW_BITS(count) ((1 << (count)) - 1)
