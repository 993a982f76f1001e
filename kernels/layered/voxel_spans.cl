// Voxel rows under the columns of a tile (point_layer.cl). Included for each type of voxels: value_voxels.cl, gradient_voxels.cl.

// Row j of layer k under the columns of a tile, `vectors` of them. `inside`: known to be entirely in the volume.
ALWAYS_INLINE void TYPED(load_span)(__global const ELEMENT *voxels, const VolumeView *view, const Columns *c, int j, int k, int vectors,
                             bool inside, float *span) {
    if (inside || (c->inside && j >= 0 && j < view->dims_v && k >= 0 && k < view->dims_a)) {
        __global const ELEMENT *start = voxels + (k - view->first_a) * view->stride_a + j * view->stride_v + c->first;
        ON_SPAN(i)
            STOREV(span + i, ELEMENT_VALUES(view, LOAD_VOXELS(start + i)));
    } else {
        TYPED(load_row)(voxels, view, c->first, j, k, vectors, span);
    }
}

// Differences of rows j of layers k + 1 and k - 1, times a weight; `behind` and `before` are in the volume.
ALWAYS_INLINE void TYPED(weighted_differences)(__global const ELEMENT *voxels, const VolumeView *view, const Columns *c, int j, float weight,
                                               int vectors, float *differences) {
    __global const ELEMENT *before = voxels + (c->k - 1 - view->first_a) * view->stride_a + j * view->stride_v + c->first;
    __global const ELEMENT *behind = before + 2 * view->stride_a;
    ON_SPAN(i)
        STOREV(differences + i, weight * ELEMENT_DIFFERENCES(view, behind + i, before + i));
}
