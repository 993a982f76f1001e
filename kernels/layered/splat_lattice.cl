// Layered splatting on the sheared lattice of a parallel view: splat, correct, classify, shade, composite.
//
// One work-item per tile: TILE_COLUMNS x TILE_ROWS lattice samples of one phase (p, q), one sample per voxel column and row, from the
// first layer to the last (splat_stencil.cl). It keeps the splat sums of three layers, in rows that can be visible, and computes
// gradients in visible rows only.
//
// Work-item id: ((tile_v*tiles_u + tile_u)*per_voxel_v + q)*per_voxel_u + p. The phases of a tile are consecutive and share its voxels in
// the cache. lattice[(j*per_voxel_v + q)*width + i*per_voxel_u + p] = RGBA.

#include "layered/phase_tile.cl"

__kernel void splat_lattice(__global const VOXEL *voxels, VolumeView view, __global const GRADIENT_VOXEL *gradient_voxels,
                            VolumeView gradient_view, __global const uchar *light, __global const uchar *sky,
                            __global const LayerOffset *offsets_u, __global const LayerOffset *offsets_v, __global const float *weights,
                            __global const uchar *visible, __global const float4 *table, __global const float4 *slabs, SplatLatticeParams p,
                            SampleParams sample, Clipping clip, __global float4 *lattice, __global uint *active_samples, ulong first_item) {
    int id = first_item + get_global_id(0);
    if (id >= p.per_voxel_u * p.per_voxel_v * p.tiles_u * p.tiles_v)
        return;
    voxels += view.first;
    const ShadingSource shading = SHADING_SOURCE;
    const int tile = id;
    const int phase_u = id % p.per_voxel_u;
    id /= p.per_voxel_u;
    const int phase_v = id % p.per_voxel_v;
    id /= p.per_voxel_v;
    const int column = id % p.tiles_u * TILE_COLUMNS, row = id / p.tiles_u * TILE_ROWS;
    const int rows = min(TILE_ROWS, p.columns_v - row), columns = min(TILE_COLUMNS, p.columns_u - column);
    const PhaseTile place = {offsets_u, offsets_v, weights, phase_u, phase_v, column, row};

    SplatLayer ring[3];
    for (int i = 0; i < 3; i++)
        ring[i].index = INT_MIN;
    float along_u[TILE_ROWS * TILE_COLUMNS], across[TILE_ROWS * TILE_COLUMNS];
    Accumulator gathered[TILE_ROWS * TILE_VECTORS];
    Interval intervals[TILE_ROWS * TILE_VECTORS];
    intv active[TILE_VECTORS];
    for (int i = 0; i < TILE_ROWS * TILE_VECTORS; i++) {
        const int c = i % TILE_VECTORS * VW, r = i / TILE_VECTORS;
        gathered[i] = p.continues && r < rows && c < columns
                          ? load_raw(&sample, lattice + lattice_index(&p, phase_u, phase_v, column + c, row + r), min(VW, columns - c),
                                     p.per_voxel_u)
                          : empty_accumulator(&sample);
#ifdef CLIPPED
        intervals[i] = clip_phase_samples(&view, &p, &clip, offsets_u[phase_u], offsets_v[phase_v], column + i % TILE_VECTORS * VW,
                                          row + i / TILE_VECTORS);
#endif
    }
    for (int c = 0; c < TILE_VECTORS; c++)
        active[c] = 0;

#ifdef PER_RAY_STEP
    const realv sample_length = length(
        (float3)(p.shear_u * sample.segments.step_u, p.shear_v * sample.segments.step_v, sample.segments.step_a));
#else
    const realv sample_length = 0.0f; // included in the table
#endif
    const int border = GATHERS_VALUES ? 0 : SPLATS_GRADIENTS ? sample.light.shading : 0, layers = view.dims_a + 2;
    // Offsets begin with layer -1.
    const float2 crossing = (float2)(offsets_u[phase_u].base + column, offsets_v[phase_v].base + row) +
                            (float2)(offsets_u[phase_u].fraction, offsets_v[phase_v].fraction);
    const float2 shear = {p.shear_u, p.shear_v}, reach = splat_reach(shear);
    const Beam beam = {(float4)(crossing, crossing + (float2)(columns - 1, rows - 1)), (float4)(shear, shear)};
    const int last_slab = min(p.last_layer + 1, view.dims_a) - view.first_a; // a part of a volume may lack further slabs
    LayerChunk layer_chunk = {-1, 0};
    int open = LOW_BITS(rows); // rows that further samples can change
    if (p.continues)
        open = open_rows(&sample, gathered, open, columns);
    for (int n = 0; n < layers && open; n++) {
        const int k = p.layer_step > 0 ? n - 1 : view.dims_a - n;
        if (k < p.first_layer || k > p.last_layer)
            continue;
        int2 over = {0, rows - 1};
        if (p.culling)
            over = visible_rows(visible, p.blocks_u, p.blocks_v, last_slab, &beam, rows, reach, 1.0f + view.first_a, k - view.first_a,
                                &layer_chunk);
        int shown = open & LOW_BITS(over.y + 1) & ~LOW_BITS(over.x);
        if (!shown)
            continue;
        for (int j = k - 1; j <= k + 1; j++)
            ensure_rows(voxels, &view, &p, &place, LOWEST_BIT(shown) - border, HIGHEST_BIT(shown) + border, j, &ring[slot(j)]);
        const SplatLayer *before = &ring[slot(k - p.layer_step)], *own = &ring[slot(k)], *after = &ring[slot(k + p.layer_step)];
        for (int left = shown; left; left &= left - 1) {
            const int r = LOWEST_BIT(left);
            bool any = false;
            for (int c = 0; c < TILE_COLUMNS; c += VW)
                any = any || layer_may_contribute(&sample, LOADV(SUM_ROW(before, r) + c), LOADV(SUM_ROW(own, r) + c),
                                                  LOADV(SUM_ROW(after, r) + c));
            if (!any)
                shown &= ~(1 << r);
        }
        if (!shown)
            continue;
        if (border) {
            const int first = LOWEST_BIT(shown), lit = HIGHEST_BIT(shown) - first + 1;
            splat_tile(voxels, &view, &p, &place, first, lit, k, (Step){1, 0}, along_u + first * TILE_COLUMNS);
            splat_tile(voxels, &view, &p, &place, first, lit, k, (Step){0, 1}, across + first * TILE_COLUMNS);
        }
        int first, count;
        layer_slabs(&sample, n, layers, &first, &count);
        for (int left = shown; left; left &= left - 1) {
            const int r = LOWEST_BIT(left);
            for (int c = 0; c < TILE_VECTORS; c++) {
                LayerSpan layer_span;
                layer_span.dt = sample_length;
#ifdef CLIPPED
                layer_span.interval.from = intervals[r * TILE_VECTORS + c].from - n;
                layer_span.interval.to = intervals[r * TILE_VECTORS + c].to - n;
#endif
                const int at = r * TILE_COLUMNS + c * VW;
                const Point point = phase_points(&view, &p, &place, c * VW, r, k);
                const struct SampleSource source = {SUM_ROW(own, r) + c * VW, along_u + at, across + at, point,
                                                    {&shading, &sample.field}};
                accumulate_slabs(&sample, slabs, first, count, table, LOADV(SUM_ROW(before, r) + c * VW), LOADV(source.own),
                                 LOADV(SUM_ROW(after, r) + c * VW), &layer_span, &source, &gathered[r * TILE_VECTORS + c], &active[c]);
            }
        }
        open = open_rows(&sample, gathered, open, columns);
    }

    uint total = 0;
    for (int c = 0; c < TILE_VECTORS; c++)
        total += sum_lanes(active[c], clamp(columns - c * VW, 0, VW));
    for (int r = 0; r < rows; r++)
        for (int c = 0; c < TILE_VECTORS && c * VW < columns; c++)
            STORE_RAYS(p, sample, table, &gathered[r * TILE_VECTORS + c], &intervals[r * TILE_VECTORS + c], min(VW, columns - c * VW),
                       p.per_voxel_u, lattice + lattice_index(&p, phase_u, phase_v, column + c * VW, row + r), total)
    active_samples[tile] = total;
}
