/* Times VolPack over one turn, with layersplat's camera and transfer function: one thread, the volume classified
 * beforehand. Prints JSON.
 *
 * volpack_frames RAW X Y Z TABLE FRAMES SHADED [FRAME PPM]
 * TABLE: 256 lines of red, green, blue and opacity per voxel. uint8 voxels, x fastest. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <volpack.h>

enum { SIDE = 512, MATERIALS = 3 };
#define ELEVATION (20 * M_PI / 180)

typedef struct {
    short normal; /* the value if nothing is shaded */
    unsigned char density, gradient;
} Voxel;

static vpContext *context;

static void check(vpResult result, const char *call) {
    if (result == VP_OK)
        return;
    fprintf(stderr, "%s: %s\n", call, vpGetErrorString(result));
    exit(1);
}
#define CHECK(call) check(call, #call)

static double seconds(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

static int ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void *read_all(const char *path, size_t bytes) {
    FILE *file = fopen(path, "rb");
    void *data = malloc(bytes);
    if (!file || !data || fread(data, 1, bytes, file) != bytes) {
        perror(path);
        exit(1);
    }
    fclose(file);
    return data;
}

/* One white light from the eye, and one material per colour channel, which mix to any colour. */
static void shade_by_light(const float colors[256][3]) {
    static float shades[(VP_NORM_MAX + 1) * 3 * MATERIALS], weights[256 * MATERIALS];
    memcpy(weights, colors, sizeof weights);
    CHECK(vpSetLookupShader(context, 3, MATERIALS, 0, shades, sizeof shades, 1, weights, sizeof weights));
    for (int m = 0; m < MATERIALS; m++) {
        const double r = m == 0, g = m == 1, b = m == 2;
        const int material = VP_MATERIAL0 + m;
        CHECK(vpSetMaterial(context, material, VP_AMBIENT, VP_BOTH_SIDES, .2 * r, .2 * g, .2 * b));
        CHECK(vpSetMaterial(context, material, VP_DIFFUSE, VP_BOTH_SIDES, .7 * r, .7 * g, .7 * b));
        CHECK(vpSetMaterial(context, material, VP_SPECULAR, VP_BOTH_SIDES, .3 * r, .3 * g, .3 * b));
        CHECK(vpSetMaterial(context, material, VP_SHINYNESS, VP_BOTH_SIDES, 20, 0, 0));
    }
    CHECK(vpSetLight(context, VP_LIGHT0, VP_DIRECTION, 0, 0, -1));
    CHECK(vpSetLight(context, VP_LIGHT0, VP_COLOR, 1, 1, 1));
    CHECK(vpEnable(context, VP_LIGHT0, 1));
    CHECK(vpEnable(context, VP_LIGHT_BOTH_SIDES, 1));
}

static void look_along(double azimuth) {
    const double ce = cos(ELEVATION), se = sin(ELEVATION), ca = cos(azimuth), sa = sin(azimuth);
    const double rows[3][3] = {{ca, 0, -sa}, {-se * sa, ce, -se * ca}, {-ce * sa, -se, -ce * ca}};
    vpMatrix4 matrix;
    memset(matrix, 0, sizeof matrix);
    for (int i = 0; i < 3; i++)
        memcpy(matrix[i], rows[i], sizeof rows[i]);
    matrix[3][3] = 1;
    vpCurrentMatrix(context, VP_MODEL);
    CHECK(vpSetMatrix(context, matrix));
}

int main(int count, char **arguments) {
    if (count != 8 && count != 10) {
        fprintf(stderr, "volpack_frames RAW X Y Z TABLE FRAMES SHADED [FRAME PPM]\n");
        return 2;
    }
    const int dims[3] = {atoi(arguments[2]), atoi(arguments[3]), atoi(arguments[4])};
    const int frames = atoi(arguments[6]), shaded = atoi(arguments[7]), shown = count == 10 ? atoi(arguments[8]) : -1;
    const size_t voxels = (size_t)dims[0] * dims[1] * dims[2], row = sizeof(Voxel) * dims[0];
    unsigned char *values = read_all(arguments[1], voxels);
    static float colors[256][3], opacities[256];
    FILE *table = fopen(arguments[5], "r");
    for (int i = 0; i < 256; i++)
        if (!table || fscanf(table, "%f%f%f%f", &colors[i][0], &colors[i][1], &colors[i][2], &opacities[i]) != 4)
            return perror(arguments[5]), 1;

    context = vpCreateContext();
    Voxel *volume = calloc(voxels, sizeof(Voxel)), *none = NULL;
    CHECK(vpSetVolumeSize(context, dims[0], dims[1], dims[2]));
    CHECK(vpSetVoxelSize(context, sizeof(Voxel), 3, 2, 1));
    CHECK(vpSetVoxelField(context, 0, sizeof(short), vpFieldOffset(none, normal), shaded ? VP_NORM_MAX : 255));
    CHECK(vpSetVoxelField(context, 1, 1, vpFieldOffset(none, density), 255));
    CHECK(vpSetVoxelField(context, 2, 1, vpFieldOffset(none, gradient), VP_GRAD_MAX));
    CHECK(vpSetRawVoxels(context, volume, voxels * sizeof(Voxel), sizeof(Voxel), row, row * dims[1]));
    static float plain[256][3];
    if (shaded) {
        CHECK(vpVolumeNormals(context, values, voxels, 1, 2, 0));
        shade_by_light(colors);
    } else {
        for (size_t i = 0; i < voxels; i++)
            volume[i].normal = volume[i].density = values[i];
        for (int i = 0; i < 256 * 3; i++)
            plain[i / 3][i % 3] = 255 * colors[i / 3][i % 3];
        CHECK(vpSetLookupShader(context, 3, 1, 0, plain[0], sizeof plain, 0, NULL, 0));
    }
    CHECK(vpSetClassifierTable(context, 0, 1, opacities, sizeof opacities));
    /* Skip opacities below the resolution of an 8-bit picture. */
    CHECK(vpSetd(context, VP_MIN_VOXEL_OPACITY, 0.004));
    CHECK(vpSetd(context, VP_MAX_RAY_OPACITY, 0.99));
    CHECK(vpClassifyVolume(context));

    static unsigned char image[SIDE * SIDE * 3];
    CHECK(vpSetImage(context, image, SIDE, SIDE, SIDE * 3, VP_RGB));
    /* The longest side of the volume is 1. */
    double longest = 0, squares = 0;
    for (int i = 0; i < 3; i++)
        longest = fmax(longest, dims[i]), squares += (dims[i] - 1.) * (dims[i] - 1.);
    const double half = sqrt(squares) / 2 / longest;
    vpCurrentMatrix(context, VP_PROJECT);
    CHECK(vpIdentityMatrix(context));
    CHECK(vpWindow(context, VP_PARALLEL, -half, half, -half, half, -2, 2));

    double *times = malloc(frames * sizeof(double));
    double cpu = 0;
    for (int n = -1; n < frames; n++) {
        look_along(2 * M_PI * (n < 0 ? 0 : n) / frames);
        const double started = seconds(CLOCK_MONOTONIC), cpu_started = seconds(CLOCK_PROCESS_CPUTIME_ID);
        if (shaded)
            CHECK(vpShadeTable(context));
        CHECK(vpRenderClassifiedVolume(context));
        if (n >= 0) {
            times[n] = (seconds(CLOCK_MONOTONIC) - started) * 1e3;
            cpu += (seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu_started) * 1e3;
        }
        if (n >= 0 && n == shown) {
            FILE *picture = fopen(arguments[9], "wb");
            if (!picture)
                return perror(arguments[9]), 1;
            fprintf(picture, "P6\n%d %d\n255\n", SIDE, SIDE);
            for (int y = SIDE - 1; y >= 0; y--)
                fwrite(image + y * SIDE * 3, 3, SIDE, picture);
            fclose(picture);
        }
    }
    qsort(times, frames, sizeof(double), ascending);
    printf("{\"median_ms\": %f, \"cpu_ms\": %f, \"version\": \"%s\"}\n", times[frames / 2], cpu / frames, VP_VERSION);
    return 0;
}
