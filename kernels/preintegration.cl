// Pre-integrated classification: colour and opacity of the stretch between two samples of a ray.
//
// Between the samples the value is taken to change evenly (Engel et al. 2001). integrals[i] = (R, G, B, T): extinction times
// colour, and extinction, integrated from the first value to node i, in whole numbers of one unit: a difference of two
// nodes is exact, so its quotient by the distance is the mean over the stretch. Light lost inside a stretch
// does not dim its colour. Nodes of samples alternate between even and odd ones along the ray: no stretch is
// empty, so nothing is divided by 0, and each sample is looked up once for both stretches it ends.

// A sample's place in the table.
typedef struct {
    intv index, r, g, b, extinction;
} Node;

// The nearest even or odd node, one of the two that the value lies between.
inline intv node_index(const SampleParams *p, realv value, int odd) {
    const realv x = (value - p->table_first) * (0.5f * p->table_per_value) + (odd ? 0.0f : 0.5f);
    return 2 * CONVERT_INTV(CLAMP(x, (realv)(0.0f), (realv)((p->table_last - odd) / 2))) + odd;
}

ALWAYS_INLINE Node node_of(const SampleParams *p, __global const int4 *integrals, realv value, int odd) {
    Node node;
    node.index = node_index(p, value, odd);
    realv r, g, b, extinction;
    table_entries((__global const float4 *)integrals, node.index, &r, &g, &b, &extinction);
    node.r = AS_INTV(r), node.g = AS_INTV(g), node.b = AS_INTV(b), node.extinction = AS_INTV(extinction);
    return node;
}

// Composites one stretch. `dt` is its length times the table's unit. `inside` is 0 where the ray is beside the field's
// support, else 1.
ALWAYS_INLINE void composite_stretch(const SampleParams *p, const Node *front, const Node *back, realv dt, realv inside,
                                     const Lighting *lighting, Light *light, intv *active) {
    const realv extinction = CONVERT_REALV(back->extinction - front->extinction);
    // One division for two. Where there is no extinction there is no colour either: any divisor does.
    const realv distance = CONVERT_REALV(back->index - front->index);
    const realv divisor = extinction == 0.0f ? (realv)(1.0f) : extinction;
    const realv inverse = 1.0f / (distance * divisor);
    const realv depth = extinction * (divisor * inverse * dt), share = distance * inverse;
    const realv opacity = (p->linear ? MIN(depth, (realv)(1.0f)) : absorbed(depth)) * inside;
    *active += COUNT_IF(opacity > 0.0f);
    realv r = CONVERT_REALV(back->r - front->r) * share;
    realv g = CONVERT_REALV(back->g - front->g) * share;
    realv b = CONVERT_REALV(back->b - front->b) * share;
    if (p->shading) {
        r = MIN(r * lighting->factor + lighting->highlight, (realv)(1.0f));
        g = MIN(g * lighting->factor + lighting->highlight, (realv)(1.0f));
        b = MIN(b * lighting->factor + lighting->highlight, (realv)(1.0f));
    }
    const realv weight = light->t * opacity;
    light->r += weight * r;
    light->g += weight * g;
    light->b += weight * b;
    light->t -= weight;
}
