// What the sheet methods know of a splat.

// Mirrors `SplatParams` in src/device/launch/params.rs.
typedef struct {
    float to_screen[3][4]; // rows times (u, v, a, 1): pixel coordinates times w, and w
    float along[4];        // the same for the depth, in voxels
    float footprint[3];    // pixel offsets to voxels across the view, for w = 1: (f0 dx + f1 dy, f2 dy)
    float half_width, half_height; // of a footprint in pixels, for w = 1
    float nearest;         // splats of less depth are left out
    float least_w;         // and splats of less w
    float nearest_sheet;   // and sheets
    float sheet_distance;  // in voxels
    int first_sheet, last_sheet; // that any splat can reach; buckets count from the first
    int backwards;         // axis-aligned sheets: voxels are met in the reverse of their order
    float background;      // less the offset
} SplatParams;
CHECK_SIZE(SplatParams, SPLAT_PARAMS_BYTES);

// A splat on the screen. Mirrored in src/device/launch/splats.rs.
typedef struct {
    float x, y;     // pixel coordinates
    float w;        // scale
    float reach;    // where it begins, in sheets from the first; of axis-aligned sheets, its layer
    float4 content; // (value less background, gradient), or of axis-aligned sheets (r, g, b, 1) times extinction
} Splat;
CHECK_SIZE(Splat, 32);

#define GAUSSIAN_RADIUS 2.0f

// Where a splat at a depth begins, in sheets from the first: the sheet at or beyond is the first that it reaches.
inline float reach_of(const SplatParams *p, float depth) {
    return (depth - GAUSSIAN_RADIUS) / p->sheet_distance - 0.5f - p->first_sheet;
}
inline int first_sheet(float reach) { return -whole_below(-reach); }

// Pixels under the rectangle of a splat at (x, y), clipped to the screen: columns [x, y], rows [z, w]; empty where x > y or z > w.
ALWAYS_INLINE int4 pixels_under(const SplatParams *p, float x, float y, float w, int width, int height) {
    const float inverse = 1.0f / w, hx = p->half_width * inverse + 0.5f, hy = p->half_height * inverse + 0.5f;
    // The first centre at or beyond an edge is one above the last before it.
    return (int4)(whole_below(CLAMP(x - hx, -1.0f, (float)width)) + 1, whole_below(CLAMP(x + hx, 0.0f, (float)width)) - 1,
                  whole_below(CLAMP(y - hy, -1.0f, (float)height)) + 1, whole_below(CLAMP(y + hy, 0.0f, (float)height)) - 1);
}
