// Tiles of screen pixels, VW columns x TILE_ROWS rows, for the kernels that draw straight onto the screen.

#ifndef TILE_ROWS
#define TILE_ROWS 16
#endif

// Mirrors `ScreenParams` in src/device/launch/params.rs. Axes are u, v, a of the voxels' layout.
typedef struct {
    float origin[3][4];    // origin[0] + x origin[1] + y origin[2], in voxels
    float direction[3][4];
    float start;           // rays start at origin + start*direction; -INFINITY in a parallel view
    float step[3];         // world size of a voxel step, in unit distances
    int width, height;
    int tiles_u, tiles_v;
} ScreenParams;
CHECK_SIZE(ScreenParams, SCREEN_PARAMS_BYTES);

// The rays of VW neighbouring pixels.
typedef struct {
    realv o[3], d[3];
    realv length; // of d, in unit distances
} RowRays;

// From a column on; columns beyond the screen take its last one's ray.
inline RowRays rays_of_row(const ScreenParams *s, int column, int row) {
    const intv columns = MIN(LANES + column, (intv)(s->width - 1));
    const realv x = CONVERT_REALV(columns) + 0.5f;
    const float y = row + 0.5f;
    RowRays rays;
    realv squares = 0.0f;
    for (int i = 0; i < 3; i++) {
        rays.o[i] = (s->origin[0][i] + y * s->origin[2][i]) + x * s->origin[1][i];
        rays.d[i] = (s->direction[0][i] + y * s->direction[2][i]) + x * s->direction[1][i];
        squares += rays.d[i] * rays.d[i] * (s->step[i] * s->step[i]);
    }
    rays.length = sqrt(squares);
    return rays;
}

inline void store_pixels(const ScreenParams *s, int column, int row, const Light *light, __global float4 *frame) {
    const float *lanes = (const float *)light;
    __global float4 *out = frame + (size_t)row * s->width + column;
    for (int i = 0; i < min(VW, s->width - column); i++)
        out[i] = (float4)(lanes[i], lanes[VW + i], lanes[2 * VW + i], 1.0f - lanes[3 * VW + i]);
}

// Samples counted in the lanes that are on the screen.
inline uint counted(const ScreenParams *s, int column, intv active) {
    uint total = 0;
    for (int i = 0; i < min(VW, s->width - column); i++)
        total += ((const int *)&active)[i];
    return total;
}
