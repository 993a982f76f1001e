// The composited lattice onto the screen, by Catmull-Rom interpolation of premultiplied RGBA.
//
// One work-item per pixel, row by row. `from_screen` takes pixel coordinates (x, y, 1) to lattice positions (I w, J w, w), sample
// centres at whole numbers. Beyond the lattice all is transparent.

// Mirrors `WarpParams` in src/device/launch/params.rs.
typedef struct {
    float from_screen[9];
    int width, height; // of the lattice
    int columns, rows; // of the frame
    float forward;     // sign of w in front of the eye
} WarpParams;
CHECK_SIZE(WarpParams, WARP_PARAMS_BYTES);

inline float4 catmull_rom(float t) {
    const float t2 = t * t, t3 = t2 * t;
    return (float4)(-0.5f * t3 + t2 - 0.5f * t, 1.5f * t3 - 2.5f * t2 + 1.0f, -1.5f * t3 + 2.0f * t2 + 0.5f * t,
                    0.5f * t3 - 0.5f * t2);
}

inline float4 lattice_row(__global const float4 *row, int column, int width, float4 w) {
    if (column >= 1 && column + 2 < width)
        return w.x * row[column - 1] + w.y * row[column] + w.z * row[column + 1] + w.w * row[column + 2];
    const float weight[4] = {w.x, w.y, w.z, w.w};
    float4 sum = 0.0f;
    for (int i = 0; i < 4; i++)
        if (column + i >= 1 && column + i <= width)
            sum += weight[i] * row[column + i - 1];
    return sum;
}

__kernel void warp(__global const float4 *lattice, WarpParams p, __global float4 *frame) {
    const size_t pixel = get_global_id(0);
    if (pixel >= (size_t)p.columns * p.rows)
        return;
    const float x = pixel % p.columns + 0.5f, y = pixel / p.columns + 0.5f;
    const float *m = p.from_screen;
    const float w = m[6] * x + m[7] * y + m[8];
    float4 color = 0.0f;
    if (w * p.forward > 0.0f) {
        const float column = (m[0] * x + m[1] * y + m[2]) / w, row = (m[3] * x + m[4] * y + m[5]) / w;
        if (column > -2.0f && column < p.width + 1.0f && row > -2.0f && row < p.height + 1.0f) {
            const float i = floor(column), j = floor(row);
            const float4 weights_u = catmull_rom(column - i), weights_v = catmull_rom(row - j);
            const float weight[4] = {weights_v.x, weights_v.y, weights_v.z, weights_v.w};
            for (int r = 0; r < 4; r++) {
                const int sample = (int)j - 1 + r;
                if (sample >= 0 && sample < p.height)
                    color += weight[r] * lattice_row(lattice + (size_t)sample * p.width, (int)i, p.width, weights_u);
            }
            // The filter overshoots at edges: opacity stays in 0 ... 1, colours within the opacity.
            color.w = clamp(color.w, 0.0f, 1.0f);
            color.xyz = clamp(color.xyz, 0.0f, color.w);
        }
    }
    frame[pixel] = color;
}
