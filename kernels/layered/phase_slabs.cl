// Sub-slabs of a layer in all patches of a tile: as accumulate_slabs() for the samples of one vector (sample.cl). Each step is done for all
// patches before the next one: short loops overlap better.

#include "layered/phase_tile.cl"

// Correction::MAX_SUB_LAYERS in src/host/layers/sub_slabs.rs.
#define MAX_SLABS 16

// A layer: its splat sums, those of the previous and the next one along the rays, its slabs, and the patches in which each can be visible.
typedef struct {
    const SplatLayer *before, *own, *after;
    int first_slab, slab_count;
    int shown[MAX_SLABS];
} LayerSums;

static inline realv slab_value(const LayerSums *layer, float4 slab, int patch) {
    return slab.x * layer->before->sums[patch] + slab.y * layer->own->sums[patch] + slab.z * layer->after->sums[patch];
}

#ifdef CLIPPED
// Where a slab begins, in layers from the plane of its layer. The slabs of the front layer begin in its middle.
static inline float first_start(const SampleParams *p, const LayerSums *layer) {
    return layer->first_slab == p->segments.inner_slabs ? 0.0f : -0.5f;
}

// Fraction of a slab inside the clip interval of a patch, in the n-th layer along the rays.
static inline realv share_inside(const Interval *interval, int n, float start, float end) {
    const realv inside = MIN(interval->to - n, (realv)(end)) - MAX(interval->from - n, (realv)(start));
    return MAX(inside, (realv)(0.0f)) / (end - start);
}
#endif

#if GATHERS_VALUES

static inline void gather_layer(const SampleParams *p, __global const float4 *slabs, const LayerSums *layer, const Interval *intervals,
                                int n, int patches, Accumulator *gathered, intv *counts) {
    const float length = 1.0f / p->segments.inner_slabs;
#ifdef CLIPPED
    float start = first_start(p, layer);
#endif
    for (int i = layer->first_slab; i < layer->first_slab + layer->slab_count; i++) {
        const float4 slab = slabs[i];
#ifdef CLIPPED
        const float end = start + slab.w * length;
#endif
        for (int left = patches; left; left &= left - 1) {
            const int m = LOWEST_BIT(left);
            const realv value = slab_value(layer, slab, m);
            realv share = slab.w;
#ifdef CLIPPED
            share *= share_inside(&intervals[m], n, start, end);
#endif
#if BLEND == MAXIMUM || BLEND == MINIMUM
            share = share > MIN_SHARE ? share : (realv)(0.0f);
#endif
            accumulate_values(value, value, length * share, &gathered[m], &counts[m]);
        }
#ifdef CLIPPED
        start = end;
#endif
    }
}

#else

// The table's entries that are visible, compared without conversion to integers.
static inline float2 visible_entries(const SampleParams *p) {
    const ClassificationParams *c = &p->classification;
    return (float2)(c->first_visible > 0 ? (float)c->first_visible : -INFINITY,
                    c->last_visible < c->table_last ? (float)(c->last_visible + 1) : INFINITY);
}

// Finds the subset of patches in which each slab can be visible. Returns their union.
static inline int find_visible_slabs(const SampleParams *p, __global const float4 *slabs, LayerSums *layer, int patches) {
    const float2 entries = visible_entries(p);
    int any = 0;
    for (int i = 0; i < layer->slab_count; i++) {
        const float4 slab = slabs[layer->first_slab + i];
        int shown = 0;
        for (int left = patches; left; left &= left - 1) {
            const int n = LOWEST_BIT(left);
            const realv entry = table_position(p, slab_value(layer, slab, n));
            shown |= (ANY(entry >= entries.x && entry < entries.y) ? 1 : 0) << n;
        }
        layer->shown[i] = shown;
        any |= shown;
    }
    return any;
}

// Lights the samples of some patches in layer k.
static inline void light_layer(__global const VOXEL *voxels, const VolumeView *view, const ShadingSource *shading,
                               const SplatLatticeParams *p, const SampleParams *sample, const PhaseTile *tile, const LayerSums *layer,
                               int patches, int k, Lighting *lighting) {
    SplatSlopes slopes;
#if SPLATS_GRADIENTS
    splat_slopes(voxels, view, p, tile, patches, k, &slopes);
#endif
    for (int left = patches; left; left &= left - 1) {
        const int n = LOWEST_BIT(left);
        const struct SampleSource source = {&slopes, n, patch_points(p, tile, n, k), {shading, &sample->field}};
        lighting[n] = shade(sample, shading->light, source.point, layer->own->sums[n], sample_gradient(&source));
    }
}

// Composites the slabs of the n-th layer along the rays.
static inline void composite_layer(const SampleParams *p, __global const float4 *slabs, const LayerSums *layer,
                                   __global const float4 *table, realv dt, const Interval *intervals, int n, const Lighting *lighting,
                                   Accumulator *gathered, intv *counts) {
#ifdef CLIPPED
    float start = first_start(p, layer);
#endif
    for (int i = 0; i < layer->slab_count; i++) {
        const float4 slab = slabs[layer->first_slab + i];
#ifdef CLIPPED
        const float end = start + slab.w / p->segments.inner_slabs;
#endif
        realv r[TILE_ROWS], g[TILE_ROWS], b[TILE_ROWS], w[TILE_ROWS];
        for (int left = layer->shown[i]; left; left &= left - 1) {
            const int m = LOWEST_BIT(left);
            table_entries(table, table_index(p, slab_value(layer, slab, m)), &r[m], &g[m], &b[m], &w[m]);
        }
        for (int left = layer->shown[i]; left; left &= left - 1) {
            const int m = LOWEST_BIT(left);
            Share share = slab.w;
#ifdef CLIPPED
            share *= share_inside(&intervals[m], n, start, end);
#endif
            const realv opacity = sample_opacity(p, w[m], share, dt);
            counts[m] += COUNT_IF(opacity > 0.0f);
            accumulate_lit(p, r[m], g[m], b[m], opacity, &lighting[m], &gathered[m]);
        }
#ifdef CLIPPED
        start = end;
#endif
    }
}

#endif
