// Layered splatting on the sheared lattice of a parallel view: splat, correct, classify, shade, composite.
//
// One work-item per tile of VW x TILE_ROWS consecutive samples, from the first layer to the last, in patches (patches.cl). It keeps the
// splat sums of three layers, in patches that can be visible, and computes gradients in visible patches only.
//
// Work-item id: tile_v*tiles_u + tile_u. lattice[J*width + I] = RGBA.

#include "layered/phase_slabs.cl"

__kernel void splat_lattice(__global const VOXEL *voxels, VolumeView view, __global const GRADIENT_VOXEL *gradient_voxels,
                            VolumeView gradient_view, __global const uchar *light, __global const uchar *sky,
                            __global const LayerOffset *offsets_u, __global const LayerOffset *offsets_v, __global const float *weights,
                            __global const uchar *visible, __global const float4 *table, __global const float4 *slabs, SplatLatticeParams p,
                            SampleParams sample, Clipping clip, __global float4 *lattice, __global uint *active_samples, ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= p.tiles_u * p.tiles_v)
        return;
    voxels += view.first;
    const ShadingSource shading = SHADING_SOURCE;
    const PhaseTile tile = make_phase_tile(&p, id, offsets_u, offsets_v, weights);
    const int patches = tile.bands * PATCH_ROWS, width = p.columns_u * p.per_voxel_u;
    lattice += (size_t)tile.row * width + tile.column;

    SplatLayer ring[3];
    for (int i = 0; i < 3; i++)
        ring[i].index = INT_MIN;
    Accumulator gathered[TILE_ROWS];
    Interval intervals[TILE_ROWS];
    intv counts[TILE_ROWS]; // of samples with opacity, in each patch
    for (int n = 0; n < patches; n++)
        counts[n] = 0, gathered[n] = empty_accumulator(&sample);
    if (p.continues) {
        for (int r = 0; r < tile.rows; r++)
            gathered[r] = load_raw(&sample, lattice + (size_t)r * width, tile.columns, 1);
        regroup_all((realv *)gathered, RAW_FLOATS, tile.bands);
    }
#ifdef CLIPPED
    for (int n = 0; n < patches; n++)
        intervals[n] = clip_patch(&view, &p, &clip, &tile, n);
#endif

#ifdef PER_RAY_STEP
    const realv sample_length = length(
        (float3)(p.shear_u * sample.segments.step_u, p.shear_v * sample.segments.step_v, sample.segments.step_a));
#else
    const realv sample_length = 0.0f; // included in the table
#endif
    const int layers = view.dims_a + 2;
    const Beam beam = phase_beam(&p, &tile);
    const float2 reach = splat_reach((float2)(p.shear_u, p.shear_v));
    const int last_slab = min(p.last_layer + 1, view.dims_a) - view.first_a; // a part of a volume may lack further slabs
    LayerChunk layer_chunk = {-1, 0};
    int open = open_patches(&sample, &tile, gathered, LOW_BITS(patches));
    for (int n = 0; n < layers && open; n++) {
        const int k = p.layer_step > 0 ? n - 1 : view.dims_a - n;
        if (k < p.first_layer || k > p.last_layer)
            continue;
        int2 over = {0, tile.rows - 1};
        // Offsets begin with layer -1.
        if (p.culling)
            over = visible_rows(visible, p.blocks_u, p.blocks_v, last_slab, &beam, tile.rows, reach, 1.0f + view.first_a,
                                k - view.first_a, &layer_chunk);
        if (p.culling && !layer_chunk.slabs)
            n += layers_left_in_chunk(k - view.first_a, p.layer_step);
        const int shown = open & patches_in_rows(over);
        if (!shown)
            continue;
        for (int j = k - 1; j <= k + 1; j++)
            ensure_sums(voxels, &view, &p, &tile, shown, j, &ring[slot(j)]);
        LayerSums layer = {&ring[slot(k - p.layer_step)], &ring[slot(k)], &ring[slot(k + p.layer_step)]};
        layer_slabs(&sample, n, layers, &layer.first_slab, &layer.slab_count);
#if GATHERS_VALUES
        gather_layer(&sample, slabs, &layer, intervals, n, shown, gathered, counts);
#else
        const int visible_patches = find_visible_slabs(&sample, slabs, &layer, shown);
        if (!visible_patches)
            continue;
        Lighting lighting[TILE_ROWS];
        if (sample.light.shading)
            light_layer(voxels, &view, &shading, &p, &sample, &tile, &layer, visible_patches, k, lighting);
        composite_layer(&sample, slabs, &layer, table, sample_length, intervals, n, lighting, gathered, counts);
#endif
        open &= ~shown | open_patches(&sample, &tile, gathered, shown);
    }

    regroup_all((realv *)gathered, RAW_FLOATS, tile.bands);
#ifdef CLIPPED
    regroup_all((realv *)intervals, sizeof(Interval) / sizeof(realv), tile.bands);
#endif
    intv active = 0;
    for (int n = 0; n < patches; n++)
        active += lanes_with_rays(&tile, n) ? counts[n] : (intv)(0);
    uint total = sum_lanes(active, VW);
    for (int r = 0; r < tile.rows; r++)
        STORE_RAYS(p, sample, table, &gathered[r], &intervals[r], tile.columns, 1, lattice + (size_t)r * width, total)
    active_samples[id] = total;
}
