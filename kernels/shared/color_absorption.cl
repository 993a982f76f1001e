// Absorption of colours: of the extinction per unit distance or, with linear extinction, of the opacity of a unit distance.

#include "shared/shading.cl"

static inline realv color_absorption(const SampleParams *p, realv extinction) {
    return p->classification.linear ? absorbed(extinction) : extinction;
}
