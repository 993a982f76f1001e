// Layered rendering with point-sampled layers, on a lattice for any view.
//
// Samples are the reconstructed field where rays cross the layers. On the plane of a layer that needs this layer alone, with all kernels
// but the B-spline (point_layer.cl). Classification is pre-integrated between two samples.
//
// One work-item per tile of VW x TILE_ROWS samples. lattice[J*width + I] = RGBA; visible: a bit per block and slab, from
// slab_visibility.cl; shown_slabs: the first and the last slab with any bit set, counted from the first resident layer, from
// shown_slabs.cl.

#include "layered/point_tile.cl"

// The two sub-layers at the ends of a segment. SAMPLE_SUB_LAYER computes the samples that are missing in the visible patches.
#define SUB_LAYER(l) (&layers[(l) & 1])
#define SAMPLE_SUB_LAYER(l)                                          \
    if (SUB_LAYER(l)->index != (l) || over & ~SUB_LAYER(l)->sampled) \
    sample_layer(voxels, &view, p.centre_layer, s, l, &tile, over, SUB_LAYER(l))

__kernel void point_lattice(SHADED_FIELD, __global const uchar *visible, __global const int *shown_slabs, __global const int4 *integrals,
                            __global const float4 *table, RayLatticeParams p, SampleParams sample, RayEnds ray_ends, OUTPUT, TINT_ARGUMENTS
                            ulong first_item) {
    const int order = first_item + get_global_id(0);
    if (order >= p.tiles_u * p.tiles_v)
        return;
    const int id = scheduled_tile(&p, order);
    voxels += view.first;
    const ShadingSource shading = SHADING_SOURCE;
    const Tile tile = make_tile(&p, id);
    Layer layers[2];
    layers[0].index = layers[1].index = INT_MIN;
    Accumulator gathered[TILE_ROWS];
    Interval intervals[TILE_ROWS];
    intv has_ray[TILE_ROWS];
#if BLEND == COMPOSITE
    realv dt[TILE_ROWS];
    // Table nodes of the samples at even and at odd positions, and these positions.
    Node nodes[2][TILE_ROWS];
    int nodes_at[2][TILE_ROWS];
#endif
    intv active = 0;
    const int patches = tile.bands * PATCH_ROWS;
    for (int n = 0; n < patches; n++)
        gathered[n] = empty_accumulator(&sample);
    if (p.continues) {
        for (int r = 0; r < tile.rows; r++)
            gathered[r] = LOAD_ROW(&p, &sample, target, &tile, r);
        regroup_all((realv *)gathered, RAW_FLOATS, tile.bands);
    }
    for (int n = 0; n < patches; n++) {
        const SampleRays rays = patch_rays(&p, &tile, n);
        has_ray[n] = lanes_with_rays(&p, &tile, n);
#ifdef CLIPPED
        intervals[n] = clip_sample_rays(&p, &ray_ends, &rays);
#endif
#if BLEND == COMPOSITE
        dt[n] = length_per_layer(&sample, &rays) * sample.classification.table_unit;
        nodes_at[0][n] = nodes_at[1][n] = INT_MIN;
#endif
    }
#ifdef CUT_RAYS
    cut_intervals(&p, &tile, cuts, intervals);
#endif
#ifdef CLIPPED
    const TileBounds bounds = tile_bounds(intervals, patches);
#ifdef CUT_RAYS
    // Nothing reads these samples.
    if (bounds.from >= bounds.to) {
        active_samples[id] = 0;
        return;
    }
#endif
#endif

    const int s = SAMPLES_PER_LAYER(&sample), enters = p.layer_step > 0 ? 0 : 1;
    int lowest = p.first_layer, highest = p.last_layer;
    if (p.culling)
        lowest = max(lowest, shown_slabs[0] + view.first_a), highest = min(highest, shown_slabs[1] + view.first_a);
    int open = 0; // patches that further samples can change
    for (int n = 0; n < patches; n++)
        open |= (ANY(has_ray[n] && open_rays(&sample, &gathered[n])) ? 1 : 0) << n;
    Chunk chunk = {-1, 0};
    for (int passed = 0; passed <= highest - lowest && open; passed++) {
        const int q = enters ? highest - passed : lowest + passed;
#ifdef CLIPPED
        const int within = patches_in_slab(&bounds, patches, p.layer_step * (q - RADIUS + enters - p.centre_layer));
        if (!within)
            continue;
#endif
        int over = LOW_BITS(patches);
        const int skip =
            p.culling ? slabs_to_skip(visible, &p, view.first_a, &tile, q, enters ? lowest : highest, enters, &chunk, &over) : 0;
        if (skip) {
            passed += skip - 1;
            continue;
        }
#ifdef CUT_RAYS
        over &= within;
        if (!(open & over))
            continue;
#endif
        fetch_ahead(voxels, &view, &p, &tile, q - RADIUS + 1 - enters + (RADIUS + 1) * p.layer_step);
        for (int i = 0; i < s; i++) {
            const int l0 = enters ? (q + 1) * s - i : q * s + i, l1 = l0 + p.layer_step;
            SAMPLE_SUB_LAYER(l0);
            SAMPLE_SUB_LAYER(l1);
            Layer *front = SUB_LAYER(l0), *behind = SUB_LAYER(l1);
            int shown = open & over;
#if !GATHERS_VALUES
            for (int left = shown; left; left &= left - 1) {
                const int n = LOWEST_BIT(left);
                const intv visible_lanes = is_visible_between(&sample, front->at.field[n], behind->at.field[n]);
                if (!ANY(visible_lanes))
                    shown &= ~(1 << n);
            }
#endif
            if (!shown)
                continue;
            // Lighting of all patches before any look-ups: shorter loops overlap better, 5 % on engine.
            if (sample.light.shading && LIT_AT_ENDS) {
                light_layer(&shading, &p, &sample, &tile, s, shown, front);
                light_layer(&shading, &p, &sample, &tile, s, shown, behind);
            }
            // The plane where rays enter, and the distance to the one where they leave.
            const float k = (float)l0 / s - RADIUS, step = (float)p.layer_step / s;
            const Samples *samples[3] = {&front->at, &behind->at, 0};
            int spans = 1;
#if ANALYTIC_GRADIENTS && LIT_AT_ENDS
            Samples middle;
            if (sample.light.shading) {
                find_middle(&p, &sample, shading.light, integrals, &tile, k, step, shown, samples, &middle);
                samples[1] = &middle, samples[2] = &behind->at, spans = 2;
            }
#endif
            for (int w = 0; w < spans; w++) {
                const Samples *one = samples[w], *other = samples[w + 1];
                const float length = 1.0f / spans, from_k = k + w * length * step;
                Part parts[TILE_ROWS];
#ifdef CLIPPED
                const float enters_at = p.layer_step * (from_k - p.centre_layer);
                for (int n = 0; n < patches; n++)
                    parts[n] = part_of(&intervals[n], (realv)(enters_at), (realv)(enters_at + length / s));
#endif
#if BLEND == COMPOSITE
                const float2 weights = end_weights(&sample, l0, l1);
                // Samples alternate between even and odd nodes. All look-ups before any segment: shorter loops overlap better, 4 % on
                // engine.
                const int places[2] = {spans * l0 + w * p.layer_step, spans * l0 + (w + 1) * p.layer_step};
                Node *at_front = nodes[places[0] & 1], *at_back = nodes[places[1] & 1];
                for (int end = 0; end < 2; end++) {
                    const int place = places[end], odd = place & 1;
                    const Samples *here = end ? other : one;
                    for (int left = shown; left; left &= left - 1) {
                        const int n = LOWEST_BIT(left);
                        if (nodes_at[odd][n] == place)
                            continue;
                        nodes[odd][n] = look_up_node(&sample, integrals, here->field[n], odd);
                        nodes_at[odd][n] = place;
                    }
                }
                Segment segments[TILE_ROWS];
                for (int left = shown; left; left &= left - 1) {
                    const int n = LOWEST_BIT(left);
                    const realv from = one->field[n], to = other->field[n], unit = length * dt[n];
#ifdef CLIPPED
                    if (any_clipped(&parts[n])) {
                        const realv cut_from = lerp(from, to, parts[n].from), cut_to = lerp(from, to, parts[n].to);
                        const Node at_cut = look_up_node(&sample, integrals, cut_from, places[0] & 1);
                        const Node behind_cut = look_up_node(&sample, integrals, cut_to, places[1] & 1);
                        segments[n] = segment_between(&sample, integrals, &at_cut, &behind_cut, cut_from, cut_to, weights,
                                                      unit * part_length(&parts[n]));
                        continue;
                    }
#endif
                    segments[n] = segment_between(&sample, integrals, &at_front[n], &at_back[n], from, to, weights,
                                                  CLIPPED_LENGTH(unit, &parts[n]));
                }
#endif
                for (int left = shown; left; left &= left - 1) {
                    const int n = LOWEST_BIT(left);
                    const RaySpan span = patch_span(&p, &tile, n, from_k, length * step, one->field[n], other->field[n]);
                    intv counts = 0;
#if BLEND == COMPOSITE
                    composite_span(voxels, &view, &sample, &shading, integrals, &segments[n], &parts[n], &span,
                                   CLIPPED_LENGTH(length * dt[n], &parts[n]), &one->lit[n], &other->lit[n], &gathered[n], &counts);
#elif BLEND == ISO
                    accumulate_surface(voxels, &view, &shading, &sample, &parts[n], &span, &one->lit[n], &other->lit[n],
                                       &gathered[n], &counts);
#else
                    accumulate_span(voxels, &view, &parts[n], &span, part_length(&parts[n]) / s, &gathered[n], &counts);
#endif
                    active += counts & has_ray[n];
                    if (!ANY(has_ray[n] && open_rays(&sample, &gathered[n])))
                        open &= ~(1 << n);
                }
            }
        }
    }

    regroup_all((realv *)gathered, RAW_FLOATS, tile.bands);
#ifdef CLIPPED
    regroup_all((realv *)intervals, sizeof(Interval) / sizeof(realv), tile.bands);
#endif
    uint total = sum_lanes(active, VW);
    for (int r = 0; r < tile.rows; r++)
        STORE_ROW(p, sample, table, &gathered[r], &intervals[r], target, tile, r, total)
    active_samples[id] = total;
}
