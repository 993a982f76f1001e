// The kernels that prepare a volume, in one program: most of the compile time is a fixed cost per program, however small.

#include "volume/min_max_blocks.cl"
#include "volume/slab_visibility.cl"
#include "volume/shown_slabs.cl"
#include "volume/transpose.cl"
