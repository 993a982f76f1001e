// The kernels that scatter light between cells, in one program: most of the compile time is a fixed cost per program, however small.

#include "light/scatter_cells.cl"
#include "light/scatter_source.cl"
#include "light/scatter_sweep.cl"
#include "light/scatter_layers.cl"
