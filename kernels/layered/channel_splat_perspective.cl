// Layered splatting of several fields on the lattice of a perspective view: splat_perspective.cl, whose work-items these are, with the sum of
// extinctions. Each field is splatted into layers of its own, and all are classified together in each sub-slab. Blend modes that gather values
// gather those of each field.

#include "layered/resampled_rows.cl"
#include "layered/channel_slabs.cl"

// One field of a scene, under a tile.
typedef struct {
    ChannelField field;
    ShadingSource shading;
    __global const uchar *visible;
    __global const float4 *table;
    LayerChunk layer_chunk;
    int last_slab, splats_gradients;
    bool shown; // whether the current layer can be visible
    Sums sums[3], across;
    int sums_layer[3];
#if GATHERS_VALUES
    Accumulator gathered[TILE_ROWS];
#endif
} Channel;

__kernel void channel_splat_perspective(PER_CHANNEL(__global const VOXEL *, voxels),
                                        PER_CHANNEL(__global const GRADIENT_VOXEL *, gradient_voxels),
                                        PER_CHANNEL(__global const uchar *, visible), PER_CHANNEL(__global const float4 *, tables),
                                        __global const ChannelParams *channel_params, int count, __global const uchar *light,
                                        __global const uchar *sky, __global const float2 *nodes, __global const float4 *slabs,
                                        RayLatticeParams p, Clipping clip, __global float4 *lattice, __global uint *active_samples,
                                        ulong first_item) {
    const int tile = first_item + get_global_id(0);
    if (tile >= p.tiles_u * p.tiles_v)
        return;
    __global const VOXEL *const all_voxels[MAX_CHANNELS] = EACH(voxels);
    __global const GRADIENT_VOXEL *const all_gradient_voxels[MAX_CHANNELS] = EACH(gradient_voxels);
    __global const uchar *const all_visible[MAX_CHANNELS] = EACH(visible);
    __global const float4 *const all_tables[MAX_CHANNELS] = EACH(tables);
    const int column = tile % p.tiles_u * VW, row = tile / p.tiles_u * TILE_ROWS;
    const int tile_rows = min(TILE_ROWS, p.height - row), columns = min(VW, p.width - column);
    const Beam beam = make_beam(&p, column, row, columns, tile_rows);
    const float2 reach = max(splat_reach(beam.shear.lo), splat_reach(beam.shear.hi));
    realv centre_u, shear_u;
    axis_crossings(&p, 0, LANES + column, &centre_u, &shear_u);

    Channel channels[CHANNELS];
    for (int c = 0; c < count; c++) {
        Channel *channel = &channels[c];
        set_field(channel_params + c, all_voxels[c], all_gradient_voxels[c], light, sky, &channel->field);
        channel->shading = shading_of(&channel->field);
        channel->visible = all_visible[c], channel->table = all_tables[c];
        channel->layer_chunk = (LayerChunk){-1, 0};
        channel->last_slab = min(p.last_layer + 1, channel->field.view.dims_a) - channel->field.view.first_a;
        channel->splats_gradients = GATHERS_VALUES ? 0 : SPLATS_GRADIENTS ? channel->field.sample.light.shading : 0;
        for (int i = 0; i < 3; i++)
            channel->sums_layer[i] = INT_MIN;
#if GATHERS_VALUES
        for (int r = 0; r < TILE_ROWS; r++)
            channel->gathered[r] = empty_accumulator(&channel->field.sample);
#endif
    }
    const SampleParams *sample = &channels[0].field.sample;
    const VolumeView *view = &channels[0].field.view;
    Rows ring;
#if !GATHERS_VALUES
    Accumulator gathered[TILE_ROWS];
#endif
    Interval intervals[TILE_ROWS];
    for (int r = 0; r < TILE_ROWS; r++) {
#if !GATHERS_VALUES
        gathered[r] = empty_accumulator(sample);
#endif
#ifdef CLIPPED
        const SampleRays rays = sample_rays(&p, LANES + column, (intv)(row + r));
        intervals[r] = clip_sample_rays(&p, &clip, &rays);
#endif
    }
    intv active = 0;
    const int layers = view->dims_a + 2;
    bool finished = false;
    for (int n = 0; n < layers && !finished; n++) {
        const int k = p.layer_step > 0 ? n - 1 : view->dims_a - n;
        if (k < p.first_layer || k > p.last_layer)
            continue;
        const float depth = k - p.centre_layer;
        bool any = false;
        for (int c = 0; c < count; c++) {
            Channel *channel = &channels[c];
            const ChannelField *field = &channel->field;
            int2 over = {0, tile_rows - 1};
            if (p.culling)
                over = visible_rows(channel->visible, p.blocks_u, p.blocks_v, channel->last_slab, &beam, tile_rows, reach,
                                    field->view.first_a - p.centre_layer, k - field->view.first_a, &channel->layer_chunk);
            channel->shown = over.x <= over.y;
            any |= channel->shown;
            if (!channel->shown)
                continue;
            for (int j = k - 1; j <= k + 1; j++) {
                if (channel->sums_layer[slot(j)] == j)
                    continue;
                channel->sums_layer[slot(j)] = j;
                splat_layer(field->voxels, &field->view, &p, nodes, centre_u, shear_u, row, tile_rows, j, false,
                            channel->splats_gradients, &ring, &channel->sums[slot(j)]);
            }
            if (channel->splats_gradients)
                splat_layer(field->voxels, &field->view, &p, nodes, centre_u, shear_u, row, tile_rows, k, true, 0, &ring,
                            &channel->across);
        }
        if (!any)
            continue;
        int first, slab_count;
        layer_slabs(sample, n, layers, &first, &slab_count);
        finished = true;
        for (int r = 0; r < tile_rows; r++) {
            const SampleRays rays = sample_rays(&p, LANES + column, (intv)(row + r));
            LayerSpan layer_span;
            layer_span.dt = length_per_layer(sample, &rays);
#ifdef CLIPPED
            layer_span.interval.from = intervals[r].from - depth * p.layer_step;
            layer_span.interval.to = intervals[r].to - depth * p.layer_step;
#endif
            const Point point = {rays.centre_u + depth * rays.shear_u, rays.centre_v + depth * rays.shear_v, (realv)(k)};
            LayerOfField fields[CHANNELS];
            int field_count = 0;
            for (int c = 0; c < count; c++) {
                Channel *channel = &channels[c];
                if (!channel->shown)
                    continue;
                const Sums *own = &channel->sums[slot(k)];
                const realv before = channel->sums[slot(k - p.layer_step)].sum[r], after = channel->sums[slot(k + p.layer_step)].sum[r];
                if (!layer_may_contribute(&channel->field.sample, before, own->sum[r], after))
                    continue;
                const struct SampleSource source = {point,
                                                    {own->u[r], own->v[r], 0.5f * channel->across.sum[r]},
                                                    {&channel->shading, &channel->field.sample.field}};
                LayerOfField *f = &fields[field_count++];
                f->params = &channel->field.sample, f->table = channel->table;
                f->before = before, f->own = own->sum[r], f->after = after;
                f->source = source;
#if GATHERS_VALUES
                f->gathered = &channel->gathered[r];
            }
            accumulate_channel_slabs(fields, field_count, slabs, first, slab_count, &layer_span, &active);
            for (int c = 0; c < count; c++)
                finished = finished && !any_open_lanes(&channels[c].field.sample, &channels[c].gathered[r], columns);
#else
                f->lit = false;
            }
            if (field_count)
                accumulate_channel_slabs(fields, field_count, slabs, first, slab_count, &layer_span, &gathered[r], &active);
            finished = finished && !any_open_lanes(sample, &gathered[r], columns);
#endif
        }
    }

    uint total = sum_lanes(active, columns);
    for (int r = 0; r < tile_rows; r++) {
#if GATHERS_VALUES
        realv color[4] = {(realv)(0.0f), (realv)(0.0f), (realv)(0.0f), (realv)(0.0f)};
        for (int c = 0; c < count; c++)
            add_resolved(&channels[c].field.sample, channels[c].table, &channels[c].gathered[r], &intervals[r], color);
        total += count_visible(color, columns);
#else
        realv color[4];
        resolve(sample, channels[0].table, &gathered[r], &intervals[r], color);
#endif
        store_colors(color, columns, 1, lattice + (size_t)(row + r) * p.width + column);
    }
    active_samples[tile] = total;
}
