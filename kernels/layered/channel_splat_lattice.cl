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
    int last_slab, border;
    int shown; // rows in which the current layer can be visible
    SplatLayer ring[3];
    float along_u[TILE_ROWS * TILE_COLUMNS], across[TILE_ROWS * TILE_COLUMNS];
#if GATHERS_VALUES
    Accumulator gathered[TILE_ROWS * TILE_VECTORS];
#endif
} Channel;

// The rows in `open` in which layer k of a field can be visible, with its splat sums there.
static inline int splat_channel(Channel *c, const SplatLatticeParams *p, const PhaseTile *place, const Beam *beam, float2 reach, int rows,
                                int open, int k) {
    const VolumeView *view = &c->field.view;
    int2 over = {0, rows - 1};
    if (p->culling)
        over = visible_rows(c->visible, p->blocks_u, p->blocks_v, c->last_slab, beam, rows, reach, 1.0f + view->first_a,
                            k - view->first_a, &c->layer_chunk);
    int shown = open & LOW_BITS(over.y + 1) & ~LOW_BITS(over.x);
    if (!shown)
        return 0;
    for (int j = k - 1; j <= k + 1; j++)
        ensure_rows(c->field.voxels, view, p, place, LOWEST_BIT(shown) - c->border, HIGHEST_BIT(shown) + c->border, j, &c->ring[slot(j)]);
    const SplatLayer *before = &c->ring[slot(k - p->layer_step)], *own = &c->ring[slot(k)], *after = &c->ring[slot(k + p->layer_step)];
    for (int left = shown; left; left &= left - 1) {
        const int r = LOWEST_BIT(left);
        bool any = false;
        for (int i = 0; i < TILE_COLUMNS; i += VW)
            any = any || layer_may_contribute(&c->field.sample, LOADV(SUM_ROW(before, r) + i), LOADV(SUM_ROW(own, r) + i),
                                              LOADV(SUM_ROW(after, r) + i));
        if (!any)
            shown &= ~(1 << r);
    }
    if (shown && c->border) {
        const int first = LOWEST_BIT(shown), lit = HIGHEST_BIT(shown) - first + 1;
        splat_tile(c->field.voxels, view, p, place, first, lit, k, (Step){1, 0}, c->along_u + first * TILE_COLUMNS);
        splat_tile(c->field.voxels, view, p, place, first, lit, k, (Step){0, 1}, c->across + first * TILE_COLUMNS);
    }
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
    int id = first_item + get_global_id(0);
    if (id >= p.per_voxel_u * p.per_voxel_v * p.tiles_u * p.tiles_v)
        return;
    __global const VOXEL *const all_voxels[MAX_CHANNELS] = EACH(voxels);
    __global const GRADIENT_VOXEL *const all_gradient_voxels[MAX_CHANNELS] = EACH(gradient_voxels);
    __global const uchar *const all_visible[MAX_CHANNELS] = EACH(visible);
    __global const float4 *const all_tables[MAX_CHANNELS] = EACH(tables);
    const int tile = id;
    const int phase_u = id % p.per_voxel_u;
    id /= p.per_voxel_u;
    const int phase_v = id % p.per_voxel_v;
    id /= p.per_voxel_v;
    const int column = id % p.tiles_u * TILE_COLUMNS, row = id / p.tiles_u * TILE_ROWS;
    const int rows = min(TILE_ROWS, p.columns_v - row), columns = min(TILE_COLUMNS, p.columns_u - column);
    const PhaseTile place = {offsets_u, offsets_v, weights, phase_u, phase_v, column, row};

    Channel channels[CHANNELS];
    for (int c = 0; c < count; c++) {
        Channel *channel = &channels[c];
        set_field(channel_params + c, all_voxels[c], all_gradient_voxels[c], light, sky, &channel->field);
        channel->shading = shading_of(&channel->field);
        channel->visible = all_visible[c], channel->table = all_tables[c];
        channel->layer_chunk = (LayerChunk){-1, 0};
        channel->last_slab = min(p.last_layer + 1, channel->field.view.dims_a) - channel->field.view.first_a;
        channel->border = GATHERS_VALUES ? 0 : SPLATS_GRADIENTS ? channel->field.sample.light.shading : 0;
        for (int i = 0; i < 3; i++)
            channel->ring[i].index = INT_MIN;
#if GATHERS_VALUES
        for (int i = 0; i < TILE_ROWS * TILE_VECTORS; i++)
            channel->gathered[i] = empty_accumulator(&channel->field.sample);
#endif
    }
    const SampleParams *sample = &channels[0].field.sample;
    const VolumeView *view = &channels[0].field.view;
#if !GATHERS_VALUES
    Accumulator gathered[TILE_ROWS * TILE_VECTORS];
#endif
    Interval intervals[TILE_ROWS * TILE_VECTORS];
    intv active[TILE_VECTORS];
    for (int i = 0; i < TILE_ROWS * TILE_VECTORS; i++) {
#if !GATHERS_VALUES
        gathered[i] = empty_accumulator(sample);
#endif
#ifdef CLIPPED
        intervals[i] = clip_phase_samples(view, &p, &clip, offsets_u[phase_u], offsets_v[phase_v], column + i % TILE_VECTORS * VW,
                                          row + i / TILE_VECTORS);
#endif
    }
    for (int c = 0; c < TILE_VECTORS; c++)
        active[c] = 0;

    const realv sample_length = length(
        (float3)(p.shear_u * sample->segments.step_u, p.shear_v * sample->segments.step_v, sample->segments.step_a));
    const int layers = view->dims_a + 2;
    // Offsets begin with layer -1.
    const float2 crossing = (float2)(offsets_u[phase_u].base + column, offsets_v[phase_v].base + row) +
                            (float2)(offsets_u[phase_u].fraction, offsets_v[phase_v].fraction);
    const float2 shear = {p.shear_u, p.shear_v}, reach = splat_reach(shear);
    const Beam beam = {(float4)(crossing, crossing + (float2)(columns - 1, rows - 1)), (float4)(shear, shear)};
    int open = LOW_BITS(rows); // rows that further samples can change
    for (int n = 0; n < layers && open; n++) {
        const int k = p.layer_step > 0 ? n - 1 : view->dims_a - n;
        if (k < p.first_layer || k > p.last_layer)
            continue;
        int shown = 0;
        for (int c = 0; c < count; c++) {
            channels[c].shown = splat_channel(&channels[c], &p, &place, &beam, reach, rows, open, k);
            shown |= channels[c].shown;
        }
        if (!shown)
            continue;
        int first, slab_count;
        layer_slabs(sample, n, layers, &first, &slab_count);
        for (int left = shown; left; left &= left - 1) {
            const int r = LOWEST_BIT(left);
            for (int v = 0; v < TILE_VECTORS; v++) {
                LayerSpan layer_span;
                layer_span.dt = sample_length;
#ifdef CLIPPED
                layer_span.interval.from = intervals[r * TILE_VECTORS + v].from - n;
                layer_span.interval.to = intervals[r * TILE_VECTORS + v].to - n;
#endif
                const int at = r * TILE_COLUMNS + v * VW;
                const Point point = phase_points(view, &p, &place, v * VW, r, k);
                LayerOfField fields[CHANNELS];
                int field_count = 0;
                for (int c = 0; c < count; c++) {
                    Channel *channel = &channels[c];
                    if (!(channel->shown >> r & 1))
                        continue;
                    const float *own = SUM_ROW(&channel->ring[slot(k)], r) + v * VW;
                    const struct SampleSource source = {own, channel->along_u + at, channel->across + at, point,
                                                        {&channel->shading, &channel->field.sample.field}};
                    LayerOfField *f = &fields[field_count++];
                    f->params = &channel->field.sample, f->table = channel->table;
                    f->before = LOADV(SUM_ROW(&channel->ring[slot(k - p.layer_step)], r) + v * VW);
                    f->own = LOADV(own);
                    f->after = LOADV(SUM_ROW(&channel->ring[slot(k + p.layer_step)], r) + v * VW);
                    f->source = source;
#if GATHERS_VALUES
                    f->gathered = &channel->gathered[r * TILE_VECTORS + v];
                }
                accumulate_channel_slabs(fields, field_count, slabs, first, slab_count, &layer_span, &active[v]);
#else
                    f->lit = false;
                }
                accumulate_channel_slabs(fields, field_count, slabs, first, slab_count, &layer_span, &gathered[r * TILE_VECTORS + v],
                                         &active[v]);
#endif
            }
        }
#if GATHERS_VALUES
        int open_of_any = 0;
        for (int c = 0; c < count; c++)
            open_of_any |= open_rows(&channels[c].field.sample, channels[c].gathered, open, columns);
        open = open_of_any;
#else
        open = open_rows(sample, gathered, open, columns);
#endif
    }

    uint total = 0;
    for (int c = 0; c < TILE_VECTORS; c++)
        total += sum_lanes(active[c], clamp(columns - c * VW, 0, VW));
    for (int r = 0; r < rows; r++)
        for (int c = 0; c < TILE_VECTORS && c * VW < columns; c++) {
            const int at = r * TILE_VECTORS + c, lanes = min(VW, columns - c * VW);
#if GATHERS_VALUES
            realv color[4] = {(realv)(0.0f), (realv)(0.0f), (realv)(0.0f), (realv)(0.0f)};
            for (int n = 0; n < count; n++)
                add_resolved(&channels[n].field.sample, channels[n].table, &channels[n].gathered[at], &intervals[at], color);
            total += count_visible(color, lanes);
#else
            realv color[4];
            resolve(sample, channels[0].table, &gathered[at], &intervals[at], color);
#endif
            store_colors(color, lanes, p.per_voxel_u, lattice + lattice_index(&p, phase_u, phase_v, column + c * VW, row + r));
        }
    active_samples[tile] = total;
}
