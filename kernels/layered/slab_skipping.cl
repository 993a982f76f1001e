// Which slabs, the spaces between two layers, can show nothing under a tile of a lattice: by the bits that slab_visibility.cl makes.

#include "layered/ray_lattice.cl"
#include "shared/reconstruction.cl"
#include "shared/volume.cl"

// The outermost rays of a tile.
typedef struct {
    float2 first_u, last_u, first_v, last_v;
} Outermost;

static inline Outermost outermost_of(const RayLatticeParams *p, int column, int row, int columns, int rows) {
    const Outermost rays = {crossing_of(p, 0, column), crossing_of(p, 0, column + columns - 1), crossing_of(p, 1, row),
                            crossing_of(p, 1, row + rows - 1)};
    return rays;
}

// First and last voxel below the rays between two crossings.
static inline void voxels_below(float2 one, float2 other, float depth, int *lo, int *hi) {
    const float a = one.x + depth * one.y, b = other.x + depth * other.y;
    *lo = whole_below(MIN(a, b));
    *hi = whole_below(MAX(a, b));
}

// Voxels [u0, u1] x [v0, v1].
typedef struct {
    int u0, u1, v0, v1;
} Window;

// The voxels below a tile's rays at a plane.
static inline Window window_at(const Outermost *rays, float depth) {
    Window w;
    voxels_below(rays->first_u, rays->last_u, depth, &w.u0, &w.u1);
    voxels_below(rays->first_v, rays->last_v, depth, &w.v0, &w.v1);
    return w;
}

// Whether the slabs of a chunk can show anything over a window: bit q % 8. A row of blocks is read at once, in vectors; more
// than eight are not looked at.
static inline int slabs_visible(__global const uchar *visible, const RayLatticeParams *p, int chunk, Window w) {
    const int b0 = clamp(block_of(w.u0, BLOCK), 0, p->blocks_u - 1), b1 = clamp(block_of(w.u1, BLOCK), 0, p->blocks_u - 1);
    const int c0 = clamp(block_of(w.v0, POINT_BLOCK_ROWS), 0, p->blocks_v - 1);
    const int c1 = clamp(block_of(w.v1, POINT_BLOCK_ROWS), 0, p->blocks_v - 1);
    if (b1 - b0 > 7)
        return 0xff;
    __global const uchar *block = visible + ((size_t)chunk * p->blocks_v + c0) * p->blocks_u + b0;
#if VW == 1
    int bits = 0;
    for (int c = c0; c <= c1; c++, block += p->blocks_u)
        for (int b = 0; b <= b1 - b0; b++)
            bits |= block[b];
    return bits;
#else
    ulong bits = 0;
    for (int c = c0; c <= c1; c++, block += p->blocks_u)
        bits |= as_ulong(vload8(0, block));
    bits <<= 8 * (7 - (b1 - b0));
    bits |= bits >> 32;
    bits |= bits >> 16;
    bits |= bits >> 8;
    return bits & 0xff;
#endif
}

// Bits of the chunk of slabs that a tile is in.
typedef struct {
    int index, bits;
} Chunk;

// How many slabs from q on, up to `last` of a ray's order, can show nothing under a tile, as far as that is known: whole
// chunks first, then a slab of its own. `visible` counts slabs from `first`, the first layer that voxels hold. `enters`: 0 or 1, a ray enters
// slab q at layer q-RADIUS+enters.
ALWAYS_INLINE int slabs_to_skip(__global const uchar *visible, const RayLatticeParams *p, int first, const Outermost *rays, int q,
                                int last, int enters, Chunk *chunk) {
    const float to_plane = first + enters - RADIUS - p->centre_layer;
    q -= first, last -= first;
    if (q >> 3 != chunk->index) {
        chunk->index = q >> 3;
        const int end = enters ? max(q & ~7, last) : min(q | 7, last);
        const Window a = window_at(rays, q + to_plane), b = window_at(rays, end + to_plane);
        const Window both = {min(a.u0, b.u0), max(a.u1, b.u1), min(a.v0, b.v0), max(a.v1, b.v1)};
        chunk->bits = slabs_visible(visible, p, chunk->index, both);
        if (!chunk->bits)
            return abs(end - q) + 1;
    }
    if (!(chunk->bits >> (q & 7) & 1))
        return 1;
    return !(slabs_visible(visible, p, chunk->index, window_at(rays, q + to_plane)) >> (q & 7) & 1);
}
