// The nodes of a table of integrals (preintegration.cl).

#include "shared/elementary.cl"

// The nearest even or odd node, one of the two around the value.
static inline intv node_index(const SampleParams *p, realv value, int odd) {
    const realv x = (value - p->classification.table_first) * (0.5f * p->classification.table_per_value) + (odd ? 0.0f : 0.5f);
    return 2 * CONVERT_INTV(CLAMP(x, (realv)(0.0f), (realv)((p->classification.table_last - odd) / 2))) + odd;
}

// Layout of the cells of EXTINCTION_CELLS in src/host/transfer/integrals.rs: extinctions, differences to the next cell, scale and offset of
// cells. The nodes follow.
#define EXTINCTION_CELLS 32
#define NODES(integrals) ((integrals) + (2 * EXTINCTION_CELLS / 4 + 1))
