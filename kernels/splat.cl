// What the sheet methods know of a splat.

// Mirrors `SplatParams` in src/device/launch/params.rs.
typedef struct {
    float to_screen[3][4]; // rows times (u, v, a, 1): pixel coordinates times w, and w
    float along[4];        // the same for the depth, in voxels
    float footprint[3];    // pixel offsets to voxels across the view, for w = 1: (f0 dx + f1 dy, f2 dy)
    float half_width, half_height; // of a footprint in pixels, for w = 1
    float nearest;         // splats of less depth are left out
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
    float depth;    // in voxels; of axis-aligned sheets, the layer
    float4 content; // (value less background, gradient), or of axis-aligned sheets (r, g, b, 1) times extinction
} Splat;
CHECK_SIZE(Splat, 32);

#define GAUSSIAN_RADIUS 2.0f

// The first sheet that a splat reaches, of those `sheet_distance` apart.
inline float first_reach(const SplatParams *p, float depth) { return (depth - GAUSSIAN_RADIUS) / p->sheet_distance - 0.5f; }

// Pixels under a splat's rectangle, clipped to the screen: columns [x, y], rows [z, w]; empty where x > y or z > w.
inline int4 pixels_under(const SplatParams *p, const Splat *splat, int width, int height) {
    const float hx = p->half_width / splat->w, hy = p->half_height / splat->w;
    return (int4)((int)ceil(CLAMP(splat->x - hx - 0.5f, 0.0f, (float)width)),
                  (int)floor(CLAMP(splat->x + hx - 0.5f, -1.0f, width - 1.0f)),
                  (int)ceil(CLAMP(splat->y - hy - 0.5f, 0.0f, (float)height)),
                  (int)floor(CLAMP(splat->y + hy - 0.5f, -1.0f, height - 1.0f)));
}
