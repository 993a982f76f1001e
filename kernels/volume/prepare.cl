// What every volume is prepared with, in one program: most of what these kernels take to compile is the same for each program, however small.

#include "volume/min_max_blocks.cl"
#include "volume/slab_visibility.cl"
#include "volume/shown_slabs.cl"
#include "volume/transpose.cl"
