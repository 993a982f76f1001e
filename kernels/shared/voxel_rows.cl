// Voxel rows around the cells of field.cl. Included for each type of voxels: value_voxels.cl, gradient_voxels.cl.

// Four consecutive voxels at each of VW offsets from `start`.
#if defined(GATHER_WORDS) && ELEMENT_BYTES < 4
#undef UNPACK_VOXEL
#if ELEMENT_SIGNED
#define UNPACK_VOXEL(words, n) CONVERT_REALV(((words) << (32 - 8 * ELEMENT_BYTES * ((n) + 1))) >> (32 - 8 * ELEMENT_BYTES))
#else
#define UNPACK_VOXEL(words, n) CONVERT_REALV((words) >> (8 * ELEMENT_BYTES * (n)) & ((1 << 8 * ELEMENT_BYTES) - 1))
#endif
ALWAYS_INLINE Row TYPED(four_voxels)(__global const ELEMENT *start, intv at) {
#if ELEMENT_BYTES == 1
    const intv words = GATHER_WORDS(start, at);
    const Row row = {UNPACK_VOXEL(words, 0), UNPACK_VOXEL(words, 1), UNPACK_VOXEL(words, 2), UNPACK_VOXEL(words, 3)};
#else
    const intv near = GATHER_WORDS(start, at * 2), far = GATHER_WORDS(start, at * 2 + 4);
    const Row row = {UNPACK_VOXEL(near, 0), UNPACK_VOXEL(near, 1), UNPACK_VOXEL(far, 0), UNPACK_VOXEL(far, 1)};
#endif
    return row;
}
#elif VW > 1
ALWAYS_INLINE Row TYPED(four_voxels)(__global const ELEMENT *start, intv at) {
    const int *lane = (const int *)&at;
    Row row;
#define FOUR_VOXELS(n) convert_float4(vload4(0, start + lane[n]))
    COMPONENTS(FOUR_VOXELS, &row.before, &row.low, &row.high, &row.behind);
    return row;
}
#endif

// Voxel rows at the offset (dj, dk) from the cells. FAR_VOXELS: byte offsets can exceed an int.
ALWAYS_INLINE Row TYPED(voxel_row)(__global const ELEMENT *voxels, const VolumeView *view, const Cells *c, int dj, int dk) {
    Row row;
    const int *i = (const int *)&c->i, *j = (const int *)&c->j, *k = (const int *)&c->k;
#if VW > 1 && defined(FAR_VOXELS)
    if (c->interior) {
        __global const ELEMENT *plane = voxels - 1 - (long)view->first_a * view->stride_a;
#define FOUR_FAR_VOXELS(n) \
    convert_float4(vload4(0, plane + i[n] + (j[n] + dj) * view->stride_v + (k[n] + dk) * view->stride_a))
        COMPONENTS(FOUR_FAR_VOXELS, &row.before, &row.low, &row.high, &row.behind);
        row.before = ELEMENT_VALUES(view, row.before), row.low = ELEMENT_VALUES(view, row.low);
        row.high = ELEMENT_VALUES(view, row.high), row.behind = ELEMENT_VALUES(view, row.behind);
        return row;
    }
#elif VW > 1
    if (c->interior) {
        __global const ELEMENT *start = voxels + i[0] - 1 + (j[0] + dj) * view->stride_v + (k[0] + dk - view->first_a) * view->stride_a;
        const intv at = c->i - i[0] + (c->j - j[0]) * (int)view->stride_v + (c->k - k[0]) * (int)view->stride_a;
        row = TYPED(four_voxels)(start, at);
        row.before = ELEMENT_VALUES(view, row.before), row.low = ELEMENT_VALUES(view, row.low);
        row.high = ELEMENT_VALUES(view, row.high), row.behind = ELEMENT_VALUES(view, row.behind);
        return row;
    }
#else
    if (c->interior) {
        __global const ELEMENT *start =
            voxels + OFFSET_U(view, c->i - 1) + (c->j + dj) * view->stride_v + (c->k + dk - view->first_a) * view->stride_a;
        row.before = ELEMENT_VALUE(view, convert_float(start[0])), row.low = ELEMENT_VALUE(view, convert_float(start[OFFSET_U(view, 1)]));
        row.high = ELEMENT_VALUE(view, convert_float(start[OFFSET_U(view, 2)])),
        row.behind = ELEMENT_VALUE(view, convert_float(start[OFFSET_U(view, 3)]));
        return row;
    }
#endif
#if VW > 1 && !defined(FAR_VOXELS) && !defined(EDGE_GOES_ON)
    if (view->dims_u >= 4) {
        // Rows that cross the edge are moved into the volume, and their voxels back. In place of rows outside, the first one is read.
        const intv v = c->j + dj, layer = c->k + dk, first = CLAMP_INTV(c->i - 1, 0, view->dims_u - 4);
        const intv outside = v < 0 || v >= view->dims_v || layer < 0 || layer >= view->dims_a;
        const intv at = first + v * (int)view->stride_v + (layer - view->first_a) * (int)view->stride_a;
        const Row within = TYPED(four_voxels)(voxels, outside ? 0 : at);
        const intv moved = outside ? 4 : c->i - 1 - first;
        const realv *from = (const realv *)&within;
        realv *to = (realv *)&row;
#pragma unroll
        for (int e = 0; e < 4; e++) {
            to[e] = view->background;
#pragma unroll
            for (int n = 0; n < 4; n++)
                to[e] = moved == n - e ? ELEMENT_VALUES(view, from[n]) : to[e];
        }
        return row;
    }
#endif
    float *out = (float *)&row;
    for (int n = 0; n < VW; n++)
        for (int e = 0; e < 4; e++)
            out[e * VW + n] = TYPED(voxel_at)(voxels, view, i[n] - 1 + e, j[n] + dj, k[n] + dk);
    return row;
}
