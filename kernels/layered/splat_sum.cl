// The splat sum of a layer for a single ray, with exact footprints. VW is 1.
//
// The integral over the depth of the kernel is moved out of the sum: S = integral of f(z) g(u + s_u z, v + s_v z) dz, where g is the
// layer interpolated with f in u and v. Between the knots this is a polynomial of degree 9 over one cell: five Gauss nodes, four voxels.

#include "layered/footprint.cl"
#include "shared/volume.cl"

static inline float exact_splat_sum(__global const VOXEL *voxels, const VolumeView *view, int k, float u, float v, float s_u, float s_v) {
    if (IS_OUTSIDE(k, view))
        return view->background;
    float sum = 0.0f;
    for (float z = -1.0f; z < 1.0f;) {
        const float end = end_of_piece(u, v, s_u, s_v, z);
        const float centre = 0.5f * (z + end), half_length = 0.5f * (end - z);
        const int i = floor(u + s_u * centre), j = floor(v + s_v * centre);
        const float v00 = voxel_at(voxels, view, i, j, k), v10 = voxel_at(voxels, view, i + 1, j, k);
        const float v01 = voxel_at(voxels, view, i, j + 1, k), v11 = voxel_at(voxels, view, i + 1, j + 1, k);
        float piece = 0.0f;
        for (int n = 0; n < 5; n++) {
            const float node = centre + half_length * GAUSS_NODE[n];
            const float x = u + s_u * node - i, y = v + s_v * node - j;
            const float value = mix(mix(v00, v10, SMOOTHSTEP(x)), mix(v01, v11, SMOOTHSTEP(x)), SMOOTHSTEP(y));
            piece += GAUSS_WEIGHT[n] * kernel_function(node) * value;
        }
        sum += half_length * piece;
        z = end;
    }
    return sum;
}
