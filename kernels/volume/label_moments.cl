// Voxels of labels with smooth surfaces: the first three moments of the opacities around each voxel, and the first times colour
// (label_surface.cl). Voxels without a label have opacity 0.
//
// THICK: slices are thick. Then shares are those of the distance to the nearest voxel of another label in the slice, so that interpolation
// between slices moves edges from their place in one to that in the other.

#include "volume/label_at.cl"

// The fields: opacity, its square, its cube, and opacity times red, green, blue.
typedef struct {
    float moments[3];
    float3 colors;
} Numbers;

static inline Numbers numbers_of(float4 entry) {
    const float opacity = -expm1(-entry.w);
    Numbers n = {{opacity, opacity * opacity, opacity * opacity * opacity}, (float3)(0.0f)};
    if (entry.w > 0.0f)
        n.colors = opacity / entry.w * entry.xyz;
    return n;
}

static inline void add(float weight, Numbers other, Numbers *sum) {
    for (int i = 0; i < 3; i++)
        sum->moments[i] += weight * other.moments[i];
    sum->colors += weight * other.colors;
}

#ifdef THICK
// A voxel of another label.
typedef struct {
    float distance;
    size_t at;
} Nearest;

// The nearest voxel of another label in a slice, within reach.
static inline Nearest nearest_other(const Labels *of, __global const float *runs, LabelVoxelParams p, const int *place, size_t id, Label own) {
    const int u = p.thick == 0 ? 1 : 0, v = 3 - u - p.thick;
    const float across[3] = {p.across_x, p.across_y, p.across_z};
    const int reaches[3] = {p.reach_x, p.reach_y, p.reach_z};
    const size_t step_u = stride_of(p, u), step_v = stride_of(p, v);
    Nearest nearest = {INFINITY, id};
    for (int n = max(-reaches[v], -place[v]); n <= min(reaches[v], dims_of(p, v) - 1 - place[v]); n++) {
        size_t at = id + n * (long)step_v;
        float away = 0.0f;
        if (SAME(label_at(of, at), own)) {
            const float run = runs[at];
            if (run == 0.0f)
                continue;
            away = fabs(run) * across[u];
            at += (long)run * (long)step_u;
        }
        const float distance = hypot(away, n * across[v]);
        if (distance < nearest.distance)
            nearest.distance = distance, nearest.at = at;
    }
    return nearest;
}
#endif

// One work-item per row. Beyond the ends of the volume, the nearest voxels count. `runs`: of label_runs.cl, if THICK.
__kernel void label_moments(LABEL_FIELDS, __global const float *runs, __global float *out_red, __global float *out_green,
                            __global float *out_blue, __global float *out_first, __global float *out_second, __global float *out_third,
                            ulong first_item) {
    const ulong row = first_item + get_global_id(0);
    if (row >= (ulong)p.dims_y * p.dims_z)
        return;
    const Labels of = LABELS_OF_ARGUMENTS;
    const int y = row % p.dims_y, z = row / p.dims_y;
    size_t rows[9];
    float weights[9];
    for (int n = 0; n < 9; n++) {
        const int dy = n % 3 - 1, dz = n / 3 - 1;
        rows[n] = ((size_t)clamp(z + dz, 0, p.dims_z - 1) * p.dims_y + clamp(y + dy, 0, p.dims_y - 1)) * p.dims_x;
        weights[n] = (dy ? p.beside_y : 1.0f) * (dz ? p.beside_z : 1.0f) / ((1.0f + 2.0f * p.beside_y) * (1.0f + 2.0f * p.beside_z));
    }
    const float here = 1.0f / (1.0f + 2.0f * p.beside_x), beside[3] = {p.beside_x, p.beside_y, p.beside_z};
    for (int x = 0; x < p.dims_x; x++) {
        const size_t id = row * p.dims_x + x;
        const Label own = label_at(&of, id);
        Label around[27];
        bool are_equal = true;
        for (int n = 0; n < 27; n++) {
            around[n] = label_at(&of, rows[n / 3] + clamp(x + n % 3 - 1, 0, p.dims_x - 1));
            are_equal = are_equal && SAME(around[n], own);
        }
        Numbers others = {{0.0f, 0.0f, 0.0f}, (float3)(0.0f)};
        float of_others = 0.0f;
        for (int n = 0; n < 27 && !are_equal; n++) {
            const float weight = SAME(around[n], own) ? 0.0f : weights[n / 3] * (n % 3 == 1 ? here : p.beside_x * here);
            if (weight > 0.0f)
                add(weight, numbers_of(entry_of(&of, around[n])), &others);
            of_others += weight;
        }
        float share = 1.0f - of_others;
        // Where a label is one voxel thin, the cut between this voxel and the next lies in the middle.
        for (int axis = 0, step = 1; axis < 3 && of_others > 0.0f; axis++, step *= 3)
            if (beside[axis] > 0.0f && !SAME(around[13 - step], own) && !SAME(around[13 + step], own))
                share = fmax(share, 1.0f - (1.0f - of_others) * beside[axis]);
#ifdef THICK
        // Distance to the edge, in voxels of the slice: of smoothed shares near it.
        float distance = 2.0f * share - 1.0f;
        if (of_others == 0.0f) {
            const int place[3] = {x, y, z};
            const Nearest nearest = nearest_other(&of, runs, p, place, id, own);
            distance = fmin(nearest.distance - 0.5f, p.farthest);
            others = numbers_of(entry_of(&of, label_at(&of, nearest.at))), of_others = 1.0f;
        }
        share = 0.5f + 0.5f * distance / p.farthest;
#endif
        Numbers mixed = {{0.0f, 0.0f, 0.0f}, (float3)(0.0f)};
        add(share, numbers_of(entry_of(&of, own)), &mixed);
        if (share < 1.0f)
            add((1.0f - share) / of_others, others, &mixed);
        out_red[id] = mixed.colors.x, out_green[id] = mixed.colors.y, out_blue[id] = mixed.colors.z;
        out_first[id] = mixed.moments[0];
        if (p.varied)
            out_second[id] = mixed.moments[1], out_third[id] = mixed.moments[2];
    }
}
