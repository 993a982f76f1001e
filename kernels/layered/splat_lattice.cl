// Layered splatting on the sheared lattice of a parallel view: splat, correct, classify, shade, composite.
//
// One work-item per tile of VW x TILE_ROWS consecutive samples, from the first layer to the last, in patches (patches.cl). It keeps the
// splat sums of three layers of each field, in patches that can be visible, and computes gradients in visible patches only. One field is
// classified step by step in all patches (phase_slabs.cl), several together in each sub-slab of a patch (channel_slabs.cl).
//
// Work-item id: tile_v*tiles_u + tile_u. target[J*width + I] = RGBA.

#include "layered/phase_slabs.cl"
#include "layered/channel_slabs.cl"

// One field of a scene, under a tile.
typedef struct {
    ChannelField field;
    ShadingSource shading;
    __global const uchar *visible;
    __global const float4 *table;
    LayerChunk layer_chunk;
    int last_slab;
    int shown; // patches in which the current layer can be visible
    SplatLayer ring[3];
#if CHANNELS > 1
    SplatSlopes slopes;
#endif
} Channel;

// Finds the patches in `open` in which layer k of a field can be visible, and its splat sums there. Returns the number of further layers of
// which nothing can be visible.
static inline int splat_channel(Channel *c, const SplatLatticeParams *p, const PhaseTile *tile, const Beam *beam, float2 reach, int open,
                                int k) {
    const VolumeView *view = &c->field.view;
    int2 over = {0, tile->rows - 1};
    // Offsets begin with layer -1.
    if (p->culling)
        over = visible_rows(c->visible, p->blocks_u, p->blocks_v, c->last_slab, beam, tile->rows, reach, 1.0f + view->first_a,
                            k - view->first_a, &c->layer_chunk);
    c->shown = open & patches_in_rows(over);
    if (!c->shown)
        return p->culling && !c->layer_chunk.slabs ? layers_left_in_chunk(k - view->first_a, p->layer_step) : 0;
    for (int j = k - 1; j <= k + 1; j++)
        ensure_sums(c->field.voxels, view, p, tile, c->shown, j, &c->ring[slot(j)]);
    return 0;
}

#if CHANNELS == 1
// Composites the n-th layer along the rays, layer k, of the only field.
static inline void composite_channel(const Channel *c, const SplatLatticeParams *p, const PhaseTile *tile, __global const float4 *slabs,
                                     realv sample_length, const Interval *intervals, int n, int layers, int k, Accumulator *gathered,
                                     intv *counts) {
    const SampleParams *sample = &c->field.sample;
    LayerSums layer = {&c->ring[slot(k - p->layer_step)], &c->ring[slot(k)], &c->ring[slot(k + p->layer_step)]};
    layer_slabs(sample, n, layers, &layer.first_slab, &layer.slab_count);
#if GATHERS_VALUES
    gather_layer(sample, slabs, &layer, intervals, n, c->shown, gathered, counts);
#else
    const int visible_patches = find_visible_slabs(sample, slabs, &layer, c->shown);
    if (!visible_patches)
        return;
    Lighting lighting[TILE_ROWS];
    if (sample->light.shading)
        light_layer(c->field.voxels, &c->field.view, &c->shading, p, sample, tile, &layer, visible_patches, k, lighting);
    composite_layer(sample, slabs, &layer, c->table, sample_length, intervals, n, lighting, gathered, counts);
#endif
}
#else
// Finds the patches of those shown in which the splat sums of layer k contribute, and their slopes.
static inline void narrow_channel(Channel *c, const SplatLatticeParams *p, const PhaseTile *tile, int k) {
    c->shown = contributing_patches(&c->field.sample, &c->ring[slot(k - p->layer_step)], &c->ring[slot(k)],
                                    &c->ring[slot(k + p->layer_step)], c->shown);
#if SPLATS_GRADIENTS && !GATHERS_VALUES
    if (c->shown && c->field.sample.light.shading)
        splat_slopes(c->field.voxels, &c->field.view, p, tile, c->shown, k, &c->slopes);
#endif
}

// Composites the n-th layer along the rays, layer k, in the patches in which fields show it.
static inline void composite_channels(Channel *channels, int count, const SplatLatticeParams *p, const PhaseTile *tile,
                                      __global const float4 *slabs, realv sample_length, const Interval *intervals, int n, int layers,
                                      int k, int shown, Accumulator (*gathered)[TILE_ROWS], intv *counts) {
    int first, slab_count;
    layer_slabs(&channels[0].field.sample, n, layers, &first, &slab_count);
    for (int left = shown; left; left &= left - 1) {
        const int m = LOWEST_BIT(left);
        LayerSpan layer_span;
        layer_span.dt = sample_length;
#ifdef CLIPPED
        layer_span.interval.from = intervals[m].from - n;
        layer_span.interval.to = intervals[m].to - n;
#endif
        const Point point = patch_points(p, tile, m, k);
#if SUMS_EXTINCTIONS
        LayerOfField fields[CHANNELS];
        int field_count = 0;
#endif
        for (int c = 0; c < count; c++) {
            const Channel *channel = &channels[c];
            if (!(channel->shown >> m & 1))
                continue;
            const struct SampleSource source = {&channel->slopes, m, point, {&channel->shading, &channel->field.sample.field}};
            const realv before = channel->ring[slot(k - p->layer_step)].sums[m], own = channel->ring[slot(k)].sums[m];
            const realv after = channel->ring[slot(k + p->layer_step)].sums[m];
#if SUMS_EXTINCTIONS
            add_field(&channel->field.sample, channel->table, before, own, after, &source, fields, &field_count);
#else
            accumulate_layer(&channel->field.sample, slabs, first, slab_count, channel->table, before, own, after, &layer_span, &source,
                             &gathered[c][m], &counts[m]);
#endif
        }
#if SUMS_EXTINCTIONS
        accumulate_fields(fields, field_count, slabs, first, slab_count, &layer_span, &gathered[0][m], &counts[m]);
#endif
    }
}
#endif

__kernel void splat_lattice(SHADED_CHANNELS, __global const LayerOffset *offsets_u, __global const LayerOffset *offsets_v,
                            __global const float *weights, __global const float4 *slabs, SplatLatticeParams p, ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= p.tiles_u * p.tiles_v)
        return;
    const PhaseTile tile = make_phase_tile(&p, id, offsets_u, offsets_v, weights);
    const int patches = tile.bands * PATCH_ROWS, width = p.columns_u * p.per_voxel_u;
    target += (size_t)tile.row * width + tile.column;

    Channel channels[CHANNELS];
    SET_CHANNELS(channels, FIELDS(count));
    const SampleParams *sample = &channels[0].field.sample;
    const VolumeView *view = &channels[0].field.view;
    Accumulator gathered[ACCUMULATED(CHANNELS)][TILE_ROWS];
    Interval intervals[TILE_ROWS];
    intv counts[TILE_ROWS]; // of samples with opacity, in each patch
    for (int c = 0; c < FIELDS(count); c++) {
        Channel *channel = &channels[c];
        channel->layer_chunk = (LayerChunk){-1, 0};
        // A part of a volume may lack further slabs.
        channel->last_slab = min(p.last_layer + 1, channel->field.view.dims_a) - channel->field.view.first_a;
        for (int i = 0; i < 3; i++)
            channel->ring[i].index = INT_MIN;
        for (int n = 0; n < patches; n++)
            gathered[ACCUMULATOR(c)][n] = empty_accumulator(&channel->field.sample);
    }
    if (p.continues) {
        for (int r = 0; r < tile.rows; r++)
            gathered[0][r] = load_raw(sample, target + (size_t)r * width, tile.columns, 1);
        regroup_all((realv *)gathered[0], RAW_FLOATS, tile.bands);
    }
    for (int n = 0; n < patches; n++) {
        counts[n] = 0;
#ifdef CLIPPED
        intervals[n] = clip_patch(view, &p, &ray_ends, &tile, n);
#endif
    }

#ifdef PER_RAY_STEP
    const realv sample_length = length(
        (float3)(p.shear_u * sample->segments.step_u, p.shear_v * sample->segments.step_v, sample->segments.step_a));
#else
    const realv sample_length = 0.0f; // included in the table
#endif
    const int layers = view->dims_a + 2;
    const Beam beam = phase_beam(&p, &tile);
    const float2 reach = splat_reach((float2)(p.shear_u, p.shear_v));
    int open = 0; // patches that further samples can change
    for (int c = 0; c < ACCUMULATED(FIELDS(count)); c++)
        open |= open_patches(&channels[c].field.sample, &tile, gathered[c], LOW_BITS(patches));
    for (int n = 0; n < layers && open; n++) {
        const int k = p.layer_step > 0 ? n - 1 : view->dims_a - n;
        if (k < p.first_layer || k > p.last_layer)
            continue;
        int shown = 0, hidden = layers;
        for (int c = 0; c < FIELDS(count); c++) {
            hidden = min(hidden, splat_channel(&channels[c], &p, &tile, &beam, reach, open, k));
            shown |= channels[c].shown;
        }
        n += hidden;
        if (!shown)
            continue;
#if CHANNELS == 1
        composite_channel(&channels[0], &p, &tile, slabs, sample_length, intervals, n, layers, k, gathered[0], counts);
#else
        shown = 0;
        for (int c = 0; c < count; c++) {
            if (channels[c].shown)
                narrow_channel(&channels[c], &p, &tile, k);
            shown |= channels[c].shown;
        }
        if (!shown)
            continue;
        composite_channels(channels, count, &p, &tile, slabs, sample_length, intervals, n, layers, k, shown, gathered, counts);
#endif
        int left_open = 0;
        for (int c = 0; c < ACCUMULATED(FIELDS(count)); c++)
            left_open |= open_patches(&channels[c].field.sample, &tile, gathered[c], shown);
        open &= ~shown | left_open;
    }

    for (int c = 0; c < ACCUMULATED(FIELDS(count)); c++)
        regroup_all((realv *)gathered[c], RAW_FLOATS, tile.bands);
#ifdef CLIPPED
    regroup_all((realv *)intervals, sizeof(Interval) / sizeof(realv), tile.bands);
#endif
    intv active = 0;
    for (int n = 0; n < patches; n++)
        active += lanes_with_rays(&tile, n) ? counts[n] : (intv)(0);
    uint total = sum_lanes(active, VW);
    for (int r = 0; r < tile.rows; r++)
        STORE_CHANNELS(p, channels, FIELDS(count), gathered, r, &intervals[r], tile.columns, target + (size_t)r * width, total)
    active_samples[id] = total;
}
