// Layered splatting on the lattice of a perspective view: a ray has the same (I, J) in all layers, and crosses layer k at u = c_u + (k -
// k_c) s_u(I), v = c_v + (k - k_c) s_v(J).
//
// The integrated footprint is a sum of products over NODES quadrature nodes z: F = sum w f(x + s_u z) f(y + s_v z). Each voxel row is
// first interpolated along u at all columns of a tile, for each node (a resampled row); for each lattice row, the v factors then combine
// two of these. Each field is splatted into layers of its own, and all are classified together in each sub-slab (channel_slabs.cl). One
// work-item per tile of VW x TILE_ROWS samples, id = tile_v*tiles_u + tile_u. target[J*width + I] = RGBA.

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
} Channel;

// Splats layer k of a field, and its neighbours, unless nothing of it can be visible.
ALWAYS_INLINE void splat_channel(Channel *channel, const RayLatticeParams *p, __global const float2 *nodes, const Beam *beam,
                                 float2 reach, realv centre_u, realv shear_u, int row, int tile_rows, int k, Rows *ring) {
    const ChannelField *field = &channel->field;
    int2 over = {0, tile_rows - 1};
    if (p->culling)
        over = visible_rows(channel->visible, p->blocks_u, p->blocks_v, channel->last_slab, beam, tile_rows, reach,
                            field->view.first_a - p->centre_layer, k - field->view.first_a, &channel->layer_chunk);
    channel->shown = over.x <= over.y;
    if (!channel->shown)
        return;
    for (int j = k - 1; j <= k + 1; j++) {
        if (channel->sums_layer[slot(j)] == j)
            continue;
        channel->sums_layer[slot(j)] = j;
        splat_layer(field->voxels, &field->view, p, nodes, centre_u, shear_u, row, tile_rows, j, false, channel->splats_gradients, ring,
                    &channel->sums[slot(j)]);
    }
    if (channel->splats_gradients)
        splat_layer(field->voxels, &field->view, p, nodes, centre_u, shear_u, row, tile_rows, k, true, 0, ring, &channel->across);
}

__kernel void splat_perspective(SHADED_CHANNELS, __global const float2 *nodes, __global const float4 *slabs, RayLatticeParams p,
                                ulong first_item) {
    const int tile = first_item + get_global_id(0);
    if (tile >= p.tiles_u * p.tiles_v)
        return;
    const int column = tile % p.tiles_u * VW, row = tile / p.tiles_u * TILE_ROWS;
    const int tile_rows = min(TILE_ROWS, p.height - row), columns = min(VW, p.width - column);
    target += (size_t)row * p.width + column;
    const Beam beam = make_beam(&p, column, row, columns, tile_rows);
    const float2 reach = max(splat_reach(beam.shear.lo), splat_reach(beam.shear.hi));
    realv centre_u, shear_u;
    axis_crossings(&p, 0, LANES + column, &centre_u, &shear_u);

    Channel channels[CHANNELS];
    SET_CHANNELS(channels, FIELDS(count));
    for (int c = 0; c < FIELDS(count); c++) {
        Channel *channel = &channels[c];
        channel->layer_chunk = (LayerChunk){-1, 0};
        // A part of a volume may lack further slabs.
        channel->last_slab = min(p.last_layer + 1, channel->field.view.dims_a) - channel->field.view.first_a;
        channel->splats_gradients = GATHERS_VALUES ? 0 : SPLATS_GRADIENTS ? channel->field.sample.light.shading : 0;
        for (int i = 0; i < 3; i++)
            channel->sums_layer[i] = INT_MIN;
    }
    const SampleParams *sample = &channels[0].field.sample;
    const VolumeView *view = &channels[0].field.view;
    Rows ring;
    Accumulator gathered[ACCUMULATED(CHANNELS)][TILE_ROWS];
    Interval intervals[TILE_ROWS];
    for (int r = 0; r < TILE_ROWS; r++) {
        for (int c = 0; c < ACCUMULATED(FIELDS(count)); c++)
            gathered[c][r] = p.continues && r < tile_rows ? load_raw(sample, target + (size_t)r * p.width, columns, 1)
                                                          : empty_accumulator(&channels[c].field.sample);
#ifdef CLIPPED
        const SampleRays rays = sample_rays(&p, LANES + column, (intv)(row + r));
        intervals[r] = clip_sample_rays(&p, &ray_ends, &rays);
#endif
    }
    intv active = 0;
    const int layers = view->dims_a + 2;
    bool finished = p.continues;
    for (int r = 0; r < tile_rows && finished; r++)
        finished = !any_open_lanes(sample, &gathered[0][r], columns);
    for (int n = 0; n < layers && !finished; n++) {
        const int k = p.layer_step > 0 ? n - 1 : view->dims_a - n;
        if (k < p.first_layer || k > p.last_layer)
            continue;
        bool any = false;
        for (int c = 0; c < FIELDS(count); c++) {
            splat_channel(&channels[c], &p, nodes, &beam, reach, centre_u, shear_u, row, tile_rows, k, &ring);
            any |= channels[c].shown;
        }
        if (!any)
            continue;
        const float depth = k - p.centre_layer;
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
#if SUMS_EXTINCTIONS
            LayerOfField fields[CHANNELS];
            int field_count = 0;
#endif
            for (int c = 0; c < FIELDS(count); c++) {
                const Channel *channel = &channels[c];
                if (!channel->shown)
                    continue;
                const Sums *own = &channel->sums[slot(k)];
                const realv before = channel->sums[slot(k - p.layer_step)].sum[r], after = channel->sums[slot(k + p.layer_step)].sum[r];
                const struct SampleSource source = {point,
                                                    {own->u[r], own->v[r], 0.5f * channel->across.sum[r]},
                                                    {&channel->shading, &channel->field.sample.field}};
#if SUMS_EXTINCTIONS
                add_field(&channel->field.sample, channel->table, before, own->sum[r], after, &source, fields, &field_count);
#else
                accumulate_layer(&channel->field.sample, slabs, first, slab_count, channel->table, before, own->sum[r], after, &layer_span,
                                 &source, &gathered[c][r], &active);
#endif
            }
#if SUMS_EXTINCTIONS
            accumulate_fields(fields, field_count, slabs, first, slab_count, &layer_span, &gathered[0][r], &active);
#endif
            for (int c = 0; c < ACCUMULATED(FIELDS(count)); c++)
                finished = finished && !any_open_lanes(&channels[c].field.sample, &gathered[c][r], columns);
        }
    }

    uint total = sum_lanes(active, columns);
    for (int r = 0; r < tile_rows; r++)
        STORE_CHANNELS(p, channels, FIELDS(count), gathered, r, &intervals[r], columns, target + (size_t)r * p.width, total)
    active_samples[tile] = total;
}
