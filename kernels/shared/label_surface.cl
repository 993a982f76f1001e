// The opacity where labels meet. Voxels hold means over their surroundings of the labels' opacity, its square and its cube, and of opacity
// times colour (label_moments.cl); without a label, the opacity is 0. Their interpolated values are such means, too.
//
// Two opacities and their shares are determined by these three means. A surface lies where both shares are one half, whatever the opacities
// are: there the opacity changes from one to the other. Of three opacities, the two are those of Gauss's quadrature, so they lie between
// the smallest and the largest.

#include "shared/shading.cl"

// Variance relative to the squared mean, below which there is one opacity: rounding makes as much.
#define LEAST_VARIANCE 1e-5f

// The opacity at a point, and that of the label that it is part of: within a surface, of the more opaque one.
typedef struct {
    realv at_point, of_label;
} LabelOpacity;

// Of the means of opacities, their squares and their cubes.
static inline LabelOpacity label_opacity(const LabelParams *labels, realv first, realv second, realv third) {
    const realv variance = second - first * first, least = LEAST_VARIANCE * first * first + 1e-30f;
    const realv skewed = third + first * (2.0f * first * first - 3.0f * second);
    // Twice the distance of the mean from the middle of both, and the distance of both.
    const realv to_middle = skewed / MAX(variance, least);
    const realv squared = MAX(to_middle * to_middle + 4.0f * variance, (realv)(1e-20f));
    const realv distance = squared * inverse_sqrt(squared);
    const realv past_cut = CLAMP(0.5f - 0.5f * labels->per_share * to_middle / distance, (realv)(0.0f), (realv)(1.0f));
    const realv smaller = first - 0.5f * (distance - to_middle), larger = smaller + distance;
    // Nothing is visible where culling says so.
    const intv meet = variance > least, shows = first > labels->least;
    const realv at_point = meet ? smaller + SMOOTHSTEP(past_cut) * distance : first;
    const realv of_label = meet ? (past_cut > 0.0f ? larger : smaller) : first;
    LabelOpacity opacity;
    opacity.at_point = shows ? CLAMP(at_point, (realv)(0.0f), (realv)(labels->most)) : (realv)(0.0f);
    opacity.of_label = of_label;
    return opacity;
}

// Part of the opacity that the smoothed opacity lacks where a label is lit fully.
#define LIT_LACK 0.2f

// Lights a label near its surface, where smoothing has lowered its opacity. Beside a label of larger opacity the gradient is not that of
// its own surface. It is lit there as by a mean normal in so far as it is seen by its surface: by the light of four unit distances.
// `smoothed`: what gradients are estimated from.
static inline void light_label(LabelOpacity opacity, realv smoothed, Lighting *lighting) {
    const realv least = opacity.of_label > 0.0f ? LIT_LACK * opacity.of_label : (realv)(1.0f);
    const realv lack = CLAMP((opacity.of_label - smoothed) * reciprocal(least), (realv)(0.0f), (realv)(1.0f));
    const realv lit = SMOOTHSTEP(lack), left = 1.0f - CLAMP(opacity.of_label, (realv)(0.0f), (realv)(1.0f));
    const realv by_surface = 1.0f - left * left * left * left;
    FOR_LIT_COMPONENTS(i) {
#ifdef STUDIO
        const realv otherwise = (1.0f - lit) * lighting->beside[i];
        lighting->factor[i] = by_surface * otherwise + lit * lighting->factor[i];
        lighting->unlit[i] = (1.0f - by_surface) * otherwise + lit * lighting->unlit[i];
#else
        const realv otherwise = lighting->unlit[i] + by_surface * (lighting->beside[i] - lighting->unlit[i]);
        lighting->factor[i] = otherwise + lit * (lighting->factor[i] - otherwise);
#endif
        lighting->highlight[i] *= lit;
    }
}
