// A field of a scene whose voxels lie anywhere in the frame, under a tile: its samples, their lighting, and where it can be visible.

#include "layered/channels.cl"
#include "shared/visible_points.cl"

// The plane in which sub-layer l lies.
static inline float plane_of(int s, int l) { return (float)l / s - RADIUS; }

// The rays of a tile among the voxels of a field.
static inline void set_own_rays(Channel *c) {
    OwnBeam *whole = &c->apart.whole;
    for (int n = 0; n < c->tile.bands * PATCH_ROWS; n++) {
        OwnRays *rays = &c->apart.rays[n];
        OwnBeam *beam = &c->apart.beams[n];
        const SampleRays patch = patch_rays(&c->lattice, &c->tile, n);
        const realv origin[3] = {patch.centre_u, patch.centre_v, (realv)(c->lattice.centre_layer)};
        const realv step[3] = {patch.shear_u, patch.shear_v, (realv)(1.0f)};
        to_own_voxels(c->field.place, origin, 1.0f, rays->origin);
        to_own_voxels(c->field.place, step, 0.0f, rays->step);
        for (int i = 0; i < 3; i++) {
            beam->origin[0][i] = smallest_lane(rays->origin[i]), beam->origin[1][i] = largest_lane(rays->origin[i]);
            beam->step[0][i] = smallest_lane(rays->step[i]), beam->step[1][i] = largest_lane(rays->step[i]);
            whole->origin[0][i] = n ? MIN(whole->origin[0][i], beam->origin[0][i]) : beam->origin[0][i];
            whole->origin[1][i] = n ? MAX(whole->origin[1][i], beam->origin[1][i]) : beam->origin[1][i];
            whole->step[0][i] = n ? MIN(whole->step[0][i], beam->step[0][i]) : beam->step[0][i];
            whole->step[1][i] = n ? MAX(whole->step[1][i], beam->step[1][i]) : beam->step[1][i];
        }
    }
}

// Where they cross plane k.
static inline void own_patch_points(const Channel *c, int patch, float k, realv *own) {
    const OwnRays *rays = &c->apart.rays[patch];
    for (int i = 0; i < 3; i++)
        own[i] = rays->origin[i] + (k - c->lattice.centre_layer) * rays->step[i];
}

// Samples of a field with voxels anywhere, in the missing patches of sub-layer l.
static inline void sample_apart(const Channel *c, int s, int l, int patches, Layer *layer) {
    if (layer->index != l)
        layer->index = l, layer->sampled = layer->lit = 0;
    for (int left = patches & ~layer->sampled; left; left &= left - 1) {
        const int n = LOWEST_BIT(left);
        realv own[3];
        own_patch_points(c, n, plane_of(s, l), own);
        layer->at.field[n] = value_at_own(&c->field, own, lanes_with_rays(&c->lattice, &c->tile, n));
    }
    layer->sampled |= patches;
}

// Lights such samples.
static inline void light_apart(const Channel *c, int s, int patches, Layer *layer) {
    const SampleParams *sample = &c->field.sample;
    for (int left = patches & ~layer->lit; left; left &= left - 1) {
        const int n = LOWEST_BIT(left);
        realv own[3];
        own_patch_points(c, n, plane_of(s, layer->index), own);
        const Point point = patch_points(&c->lattice, &c->tile, n, plane_of(s, layer->index));
        const intv needed = lanes_with_rays(&c->lattice, &c->tile, n);
        const Gradient gradient = gradient_at(&c->shading, &sample->field, own[0], own[1], own[2], needed);
        layer->at.lit[n] =
            light_sample(sample, c->shading.light, point, layer->at.field[n], along_frame(c->field.place, gradient));
    }
    layer->lit |= patches;
}

// Most steps from plane to plane in which cells are tested. Where rays cross more, boxes are.
#define MOST_STEPS 4

// Whether a field with voxels anywhere can be visible, within a beam, between the front of slab q and the back of slab `end`. Slab q lies
// between the planes q - RADIUS and q - RADIUS + 1.
static inline bool is_shown_apart(const Channel *c, const OwnBeam *beam, int q, int end) {
    const float from = min(q, end) - RADIUS - c->lattice.centre_layer, to = max(q, end) - RADIUS + 1 - c->lattice.centre_layer;
    float lowest[3], highest[3];
    for (int i = 0; i < 3; i++) {
        const float least = beam->step[0][i], most = beam->step[1][i];
        lowest[i] = beam->origin[0][i] + MIN(MIN(from * least, from * most), MIN(to * least, to * most));
        highest[i] = beam->origin[1][i] + MAX(MAX(from * least, from * most), MAX(to * least, to * most));
    }
    return visible_between(c->visible, c->field.place->blocks_u, c->field.place->blocks_v, &c->field.view, lowest, highest);
}

// Patches, of some, in which rays cross plane k in cells where a field with voxels anywhere can be visible.
static inline int shown_at_plane(const Channel *c, int patches, float k) {
    __global const FieldPlacement *place = c->field.place;
    int shown = 0;
    for (int left = patches; left; left &= left - 1) {
        const int n = LOWEST_BIT(left);
        realv own[3];
        own_patch_points(c, n, k, own);
        const intv cells = cells_visible(c->visible, place->blocks_u, place->blocks_v, &c->field.view, own[0], own[1], own[2]);
        shown |= (ANY(cells) ? 1 : 0) << n;
    }
    return shown;
}

// The same at plane number q, kept for the next slab.
static inline int shown_at_layer(Channel *c, int patches, int q) {
    const int odd = q & 1;
    if (c->apart.plane[odd] != q)
        c->apart.plane[odd] = q, c->apart.shown_at[odd] = shown_at_plane(c, patches, q - RADIUS);
    return c->apart.shown_at[odd];
}

// Slabs, from q on along the rays up to `last`, in which such a field is known to be invisible; 0 if it can be visible in slab q, in the
// patches `over`. Steps between adjacent cells cannot miss what lies between them.
static inline int hidden_apart(Channel *c, int q, int last, int enters) {
    const int patches = c->tile.bands * PATCH_ROWS, end = enters ? max(q & ~7, last) : min(q | 7, last);
    if (q >> 3 != c->chunk.index) {
        c->chunk.index = q >> 3, c->chunk.bits = 0;
        c->apart.plane[0] = c->apart.plane[1] = INT_MIN;
        if (is_shown_apart(c, &c->apart.whole, q, end))
            for (int n = 0; n < patches; n++)
                c->chunk.bits |= (is_shown_apart(c, &c->apart.beams[n], q, end) ? 1 : 0) << n;
    }
    const int near = c->chunk.bits;
    if (!near)
        return abs(end - q) + 1;
    if (c->apart.steps_per_slab > MOST_STEPS) {
        for (int left = near; left; left &= left - 1) {
            const int n = LOWEST_BIT(left);
            c->over |= (is_shown_apart(c, &c->apart.beams[n], q, q) ? 1 : 0) << n;
        }
        return !c->over;
    }
    c->over = shown_at_layer(c, near, q) | shown_at_layer(c, near, q + 1);
    for (int i = 1; i < c->apart.steps_per_slab; i++)
        c->over |= shown_at_plane(c, near & ~c->over, q - RADIUS + (float)i / c->apart.steps_per_slab);
    return !c->over;
}

// Steps of at most one of the field's voxels along any axis, that the rays of a tile need from plane to plane.
static inline int steps_per_slab(__global const FieldPlacement *place, const Tile *tile) {
    const float4 shear = tile->beam.shear;
    float longest = 0.0f;
    for (int corner = 0; corner < 4; corner++) {
        const float u = corner & 1 ? shear.x : shear.z, v = corner & 2 ? shear.y : shear.w;
        for (int i = 0; i < 3; i++)
            longest = fmax(longest, fabs(place->to_own[4 * i] * u + place->to_own[4 * i + 1] * v + place->to_own[4 * i + 2]));
    }
    return (int)ceil(fmin(longest, MOST_STEPS + 1.0f));
}
