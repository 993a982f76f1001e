// Voxels of labels with smooth surfaces: the first three moments of the opacities around each voxel, and the first times colour
// (label_surface.cl). Voxels without a label have opacity 0.
//
// LAYERED: labels overlap, and what each voxel holds is in four fields (label_voxels.cl). Otherwise it is the entry of its label.

#include "shared/volume.cl"

// Four numbers of a voxel: extinction times red, green, blue, and extinction.
#ifdef LAYERED
typedef float4 Label;
#define SAME(one, other) all((one) == (other))
#define ENTRY(label) (label)
#else
typedef int Label;
#define SAME(one, other) ((one) == (other))
#define ENTRY(label) entries[min(label, p.entry_count - 1)]
#endif

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

// One work-item per row. Beyond the ends of the volume, the nearest voxels count.
__kernel void label_moments(__global const VOXEL *labels, __global const float4 *entries, __global const float *red,
                            __global const float *green, __global const float *blue, __global const float *extinction,
                            LabelVoxelParams p, __global float *out_red, __global float *out_green, __global float *out_blue,
                            __global float *out_first, __global float *out_second, __global float *out_third, ulong first_item) {
    const ulong row = first_item + get_global_id(0);
    if (row >= (ulong)p.dims_y * p.dims_z)
        return;
    const int y = row % p.dims_y, z = row / p.dims_y;
    size_t rows[9];
    float across[9];
    for (int n = 0; n < 9; n++) {
        const int dy = n % 3 - 1, dz = n / 3 - 1;
        rows[n] = ((size_t)clamp(z + dz, 0, p.dims_z - 1) * p.dims_y + clamp(y + dy, 0, p.dims_y - 1)) * p.dims_x;
        across[n] = (dy ? p.beside_y : 1.0f) * (dz ? p.beside_z : 1.0f) / ((1.0f + 2.0f * p.beside_y) * (1.0f + 2.0f * p.beside_z));
    }
    const float here = 1.0f / (1.0f + 2.0f * p.beside_x);
    for (int x = 0; x < p.dims_x; x++) {
        Label around[27];
        bool are_equal = true;
        for (int n = 0; n < 27; n++) {
            const size_t at = rows[n / 3] + clamp(x + n % 3 - 1, 0, p.dims_x - 1);
#ifdef LAYERED
            around[n] = (float4)(red[at], green[at], blue[at], extinction[at]);
#else
            around[n] = (int)labels[at];
#endif
            are_equal = are_equal && SAME(around[n], around[0]);
        }
        const Label own = around[13];
        const Numbers of_own = numbers_of(ENTRY(own));
        Numbers mixed = {{0.0f, 0.0f, 0.0f}, (float3)(0.0f)};
        float share = 1.0f;
        if (!are_equal) {
            float others = 0.0f;
            for (int n = 0; n < 27; n++) {
                if (SAME(around[n], own))
                    continue;
                const float weight = across[n / 3] * (n % 3 == 1 ? here : p.beside_x * here);
                add(weight, numbers_of(ENTRY(around[n])), &mixed);
                others += weight;
            }
            const float smooth = 1.0f - others;
            share = smooth;
            // Where a label is one voxel thin, the cut between this voxel and the next lies in the middle.
            const float beside[3] = {p.beside_x, p.beside_y, p.beside_z};
            for (int axis = 0, step = 1; axis < 3; axis++, step *= 3)
                if (!SAME(around[13 - step], own) && !SAME(around[13 + step], own))
                    share = fmax(share, 1.0f - smooth * beside[axis]);
            const float scale = (1.0f - share) / others;
            for (int i = 0; i < 3; i++)
                mixed.moments[i] *= scale;
            mixed.colors *= scale;
        }
        add(share, of_own, &mixed);
        const size_t id = row * p.dims_x + x;
        out_red[id] = mixed.colors.x, out_green[id] = mixed.colors.y, out_blue[id] = mixed.colors.z;
        out_first[id] = mixed.moments[0];
        if (p.varied)
            out_second[id] = mixed.moments[1], out_third[id] = mixed.moments[2];
    }
}
