// Layered splatting of several fields on the sheared lattice of a parallel view: splat_lattice.cl, whose work-items these are, with the sum
// of extinctions. Each field is splatted into layers of its own, and all are classified together in each sub-slab. Blend modes that gather
// values gather those of each field.

#include "layered/phase_tile.cl"
#include "layered/channel_slabs.cl"

// One field of a scene, under a tile.
typedef struct {
    ChannelField field;
    ShadingSource shading;
    __global const uchar *visible;
    __global const float4 *table;
    LayerChunk layer_chunk;
    int last_slab;
    bool splats_gradients;
    int shown; // patches in which the current layer can be visible
    SplatLayer ring[3];
    SplatSlopes slopes;
#if GATHERS_VALUES
    Accumulator gathered[TILE_ROWS];
#endif
} Channel;

// The patches in `open` in which layer k of a field can be visible, with its splat sums there.
static inline int splat_channel(Channel *c, const SplatLatticeParams *p, const PhaseTile *tile, const Beam *beam, float2 reach, int open,
                                int k) {
    const VolumeView *view = &c->field.view;
    int2 over = {0, tile->rows - 1};
    if (p->culling)
        over = visible_rows(c->visible, p->blocks_u, p->blocks_v, c->last_slab, beam, tile->rows, reach, 1.0f + view->first_a,
                            k - view->first_a, &c->layer_chunk);
    int shown = open & patches_in_rows(over);
    if (!shown)
        return 0;
    for (int j = k - 1; j <= k + 1; j++)
        ensure_sums(c->field.voxels, view, p, tile, shown, j, &c->ring[slot(j)]);
    shown = contributing_patches(&c->field.sample, &c->ring[slot(k - p->layer_step)], &c->ring[slot(k)],
                                 &c->ring[slot(k + p->layer_step)], shown);
    if (shown && c->splats_gradients)
        splat_slopes(c->field.voxels, view, p, tile, shown, k, &c->slopes);
    return shown;
}

__kernel void channel_splat_lattice(PER_CHANNEL(__global const VOXEL *, voxels),
                                    PER_CHANNEL(__global const GRADIENT_VOXEL *, gradient_voxels),
                                    PER_CHANNEL(__global const uchar *, visible), PER_CHANNEL(__global const float4 *, tables),
                                    __global const ChannelParams *channel_params, int count, __global const uchar *light,
                                    __global const uchar *sky, __global const LayerOffset *offsets_u,
                                    __global const LayerOffset *offsets_v, __global const float *weights, __global const float4 *slabs,
                                    SplatLatticeParams p, Clipping clip, __global float4 *lattice, __global uint *active_samples,
                                    ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= p.tiles_u * p.tiles_v)
        return;
    __global const VOXEL *const all_voxels[MAX_CHANNELS] = EACH(voxels);
    __global const GRADIENT_VOXEL *const all_gradient_voxels[MAX_CHANNELS] = EACH(gradient_voxels);
    __global const uchar *const all_visible[MAX_CHANNELS] = EACH(visible);
    __global const float4 *const all_tables[MAX_CHANNELS] = EACH(tables);
    const PhaseTile tile = make_phase_tile(&p, id, offsets_u, offsets_v, weights);
    const int patches = tile.bands * PATCH_ROWS, width = p.columns_u * p.per_voxel_u;
    lattice += (size_t)tile.row * width + tile.column;

    Channel channels[CHANNELS];
    for (int c = 0; c < count; c++) {
        Channel *channel = &channels[c];
        set_field(channel_params + c, all_voxels[c], all_gradient_voxels[c], light, sky, &channel->field);
        channel->shading = shading_of(&channel->field);
        channel->visible = all_visible[c], channel->table = all_tables[c];
        channel->layer_chunk = (LayerChunk){-1, 0};
        channel->last_slab = min(p.last_layer + 1, channel->field.view.dims_a) - channel->field.view.first_a;
        channel->splats_gradients = !GATHERS_VALUES && SPLATS_GRADIENTS && channel->field.sample.light.shading;
        for (int i = 0; i < 3; i++)
            channel->ring[i].index = INT_MIN;
#if GATHERS_VALUES
        for (int n = 0; n < patches; n++)
            channel->gathered[n] = empty_accumulator(&channel->field.sample);
#endif
    }
    const SampleParams *sample = &channels[0].field.sample;
    const VolumeView *view = &channels[0].field.view;
#if !GATHERS_VALUES
    Accumulator gathered[TILE_ROWS];
#endif
    Interval intervals[TILE_ROWS];
    for (int n = 0; n < patches; n++) {
#if !GATHERS_VALUES
        gathered[n] = empty_accumulator(sample);
#endif
#ifdef CLIPPED
        intervals[n] = clip_patch(view, &p, &clip, &tile, n);
#endif
    }
    intv active = 0;

    const realv sample_length = length(
        (float3)(p.shear_u * sample->segments.step_u, p.shear_v * sample->segments.step_v, sample->segments.step_a));
    const int layers = view->dims_a + 2;
    const Beam beam = phase_beam(&p, &tile);
    const float2 reach = splat_reach((float2)(p.shear_u, p.shear_v));
    int open = LOW_BITS(patches); // patches that further samples can change
    for (int n = 0; n < layers && open; n++) {
        const int k = p.layer_step > 0 ? n - 1 : view->dims_a - n;
        if (k < p.first_layer || k > p.last_layer)
            continue;
        int shown = 0;
        for (int c = 0; c < count; c++) {
            channels[c].shown = splat_channel(&channels[c], &p, &tile, &beam, reach, open, k);
            shown |= channels[c].shown;
        }
        if (!shown)
            continue;
        int first, slab_count;
        layer_slabs(sample, n, layers, &first, &slab_count);
        for (int left = shown; left; left &= left - 1) {
            const int m = LOWEST_BIT(left);
            LayerSpan layer_span;
            layer_span.dt = sample_length;
#ifdef CLIPPED
            layer_span.interval.from = intervals[m].from - n;
            layer_span.interval.to = intervals[m].to - n;
#endif
            const Point point = patch_points(&p, &tile, m, k);
            LayerOfField fields[CHANNELS];
            int field_count = 0;
            intv counts = 0;
            for (int c = 0; c < count; c++) {
                Channel *channel = &channels[c];
                if (!(channel->shown >> m & 1))
                    continue;
                const struct SampleSource source = {&channel->slopes, m, point, {&channel->shading, &channel->field.sample.field}};
                LayerOfField *f = &fields[field_count++];
                f->params = &channel->field.sample, f->table = channel->table;
                f->before = channel->ring[slot(k - p.layer_step)].sums[m];
                f->own = channel->ring[slot(k)].sums[m];
                f->after = channel->ring[slot(k + p.layer_step)].sums[m];
                f->source = source;
#if GATHERS_VALUES
                f->gathered = &channel->gathered[m];
            }
            accumulate_channel_slabs(fields, field_count, slabs, first, slab_count, &layer_span, &counts);
#else
                f->lit = false;
            }
            accumulate_channel_slabs(fields, field_count, slabs, first, slab_count, &layer_span, &gathered[m], &counts);
#endif
            active += lanes_with_rays(&tile, m) ? counts : (intv)(0);
        }
#if GATHERS_VALUES
        int open_of_any = 0;
        for (int c = 0; c < count; c++)
            open_of_any |= open_patches(&channels[c].field.sample, &tile, channels[c].gathered, open);
        open = open_of_any;
#else
        open &= ~shown | open_patches(sample, &tile, gathered, shown);
#endif
    }

#if GATHERS_VALUES
    for (int c = 0; c < count; c++)
        regroup_all((realv *)channels[c].gathered, RAW_FLOATS, tile.bands);
#else
    regroup_all((realv *)gathered, RAW_FLOATS, tile.bands);
#endif
#ifdef CLIPPED
    regroup_all((realv *)intervals, sizeof(Interval) / sizeof(realv), tile.bands);
#endif
    uint total = sum_lanes(active, VW);
    for (int r = 0; r < tile.rows; r++) {
#if GATHERS_VALUES
        realv color[4] = {(realv)(0.0f), (realv)(0.0f), (realv)(0.0f), (realv)(0.0f)};
        for (int n = 0; n < count; n++)
            add_resolved(&channels[n].field.sample, channels[n].table, &channels[n].gathered[r], &intervals[r], color);
        total += count_visible(color, tile.columns);
#else
        realv color[4];
        resolve(sample, channels[0].table, &gathered[r], &intervals[r], color);
#endif
        store_colors(color, tile.columns, 1, lattice + (size_t)r * width);
    }
    active_samples[id] = total;
}
