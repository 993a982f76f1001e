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

inline float4 mix_row(__global const float4 *row, float4 w) {
    return w.x * row[0] + w.y * row[1] + w.z * row[2] + w.w * row[3];
}

// The 4 x 4 samples from (column, row) on, all in the lattice.
inline float4 mix_inside(__global const float4 *corner, int width, float4 wu, float4 wv) {
    return wv.x * mix_row(corner, wu) + wv.y * mix_row(corner + width, wu) + wv.z * mix_row(corner + 2 * width, wu) +
           wv.w * mix_row(corner + 3 * width, wu);
}

// The same where some of them are beyond it, and transparent.
inline float4 mix_edge(__global const float4 *lattice, int width, int height, int column, int row, float4 wu, float4 wv) {
    const float weight_u[4] = {wu.x, wu.y, wu.z, wu.w}, weight_v[4] = {wv.x, wv.y, wv.z, wv.w};
    float4 sum = 0.0f;
    for (int r = max(-row, 0); r < min(4, height - row); r++)
        for (int c = max(-column, 0); c < min(4, width - column); c++)
            sum += weight_v[r] * weight_u[c] * lattice[(size_t)(row + r) * width + column + c];
    return sum;
}

__kernel void warp(__global const float4 *lattice, WarpParams p, __global float4 *frame) {
    const uint pixel = get_global_id(0), columns = p.columns, line = pixel / columns;
    if (line >= (uint)p.rows)
        return;
    const float x = pixel - line * columns + 0.5f, y = line + 0.5f;
    const float *m = p.from_screen;
    const float w = m[6] * x + m[7] * y + m[8];
    float4 color = 0.0f;
    if (w * p.forward > 0.0f) {
        const float column = (m[0] * x + m[1] * y + m[2]) / w, row = (m[3] * x + m[4] * y + m[5]) / w;
        if (column > -2.0f && column < p.width + 1.0f && row > -2.0f && row < p.height + 1.0f) {
            const float i = floor(column), j = floor(row);
            const float4 wu = catmull_rom(column - i), wv = catmull_rom(row - j);
            const int first = (int)i - 1, top = (int)j - 1;
            color = first >= 0 && first + 4 <= p.width && top >= 0 && top + 4 <= p.height
                        ? mix_inside(lattice + (size_t)top * p.width + first, p.width, wu, wv)
                        : mix_edge(lattice, p.width, p.height, first, top, wu, wv);
            // The filter overshoots at edges: opacity stays in 0 ... 1, colours within the opacity.
            color.w = clamp(color.w, 0.0f, 1.0f);
            color.xyz = clamp(color.xyz, 0.0f, color.w);
        }
    }
    frame[pixel] = color;
}
