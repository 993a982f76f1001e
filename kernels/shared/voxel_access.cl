// Single voxels and rows of a layer, inside or outside the volume. Included for each type of voxels: value_voxels.cl, gradient_voxels.cl.

// Value of any voxel, inside or outside the volume.
static inline float TYPED(voxel_at)(__global const ELEMENT *voxels, const VolumeView *view, int u, int v, int k) {
#ifdef EDGE_GOES_ON
    u = nearest_index(u, view->dims_u), v = nearest_index(v, view->dims_v), k = nearest_index(k, view->dims_a);
#endif
    if (u < 0 || u >= view->dims_u || v < 0 || v >= view->dims_v || k < 0 || k >= view->dims_a)
        return view->background;
    return ELEMENT_VALUE(view, convert_float(voxels[OFFSET_U(view, u) + v * view->stride_v + (k - view->first_a) * view->stride_a]));
}

// Loads `vectors` x VW voxels of row v, layer k, from u on, as floats. Needs stride_u = 1.
static inline void TYPED(load_row)(__global const ELEMENT *voxels, const VolumeView *view, int u, int v, int k, int vectors, float *row) {
#ifdef EDGE_GOES_ON
    v = nearest_index(v, view->dims_v), k = nearest_index(k, view->dims_a);
#endif
    const bool inside = v >= 0 && v < view->dims_v && k >= 0 && k < view->dims_a;
    __global const ELEMENT *start = voxels + v * view->stride_v + (k - view->first_a) * view->stride_a;
    for (int c = 0; c < vectors; c++, u += VW, row += VW) {
        if (inside && u >= 0 && u + VW <= view->dims_u) {
            STOREV(row, ELEMENT_VALUES(view, LOAD_VOXELS(start + u)));
#ifdef EDGE_GOES_ON
        } else {
            for (int i = 0; i < VW; i++)
                row[i] = ELEMENT_VALUE(view, convert_float(start[nearest_index(u + i, view->dims_u)]));
        }
#else
        } else if (!inside || u + VW <= 0 || u >= view->dims_u) {
            STOREV(row, (realv)(view->background));
        } else if (view->dims_u >= VW) {
            // Across the edge: a window of the nearest whole vector between two vectors of background.
            const int nearest = clamp(u, 0, view->dims_u - VW);
            float around[3 * VW];
            STOREV(around, (realv)(view->background));
            STOREV(around + VW, ELEMENT_VALUES(view, LOAD_VOXELS(start + nearest)));
            STOREV(around + 2 * VW, (realv)(view->background));
            STOREV(row, LOADV(around + VW + (u - nearest)));
        } else {
            for (int i = 0; i < VW; i++)
                row[i] = u + i >= 0 && u + i < view->dims_u ? ELEMENT_VALUE(view, convert_float(start[u + i])) : view->background;
        }
#endif
    }
}
