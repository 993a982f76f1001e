/*
 * Renders a built-in volume or a volume file: plain [PICTURE [VOLUME [DEVICE]]]
 *
 * cc examples/c/plain.c -Ibindings/c/include -Ltarget/debug -llayersplat_c -Wl,-rpath,target/debug -o plain
 */
#include <layersplat.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 256, HEIGHT = 192 };

static void check(layersplat_status status)
{
    if (status != LAYERSPLAT_STATUS_OK) {
        fprintf(stderr, "error %d: %s\n", (int)status, layersplat_last_error());
        exit(EXIT_FAILURE);
    }
}

int main(int count, char **arguments)
{
    const char *path = count > 1 ? arguments[1] : "plain.png";
    const char *source = count > 2 ? arguments[2] : "builtin:hydrogen@48";
    const char *name = count > 3 ? arguments[3] : NULL;
    const layersplat_orbit from = {30, 20, 0};
    const float black[3] = {0, 0, 0};
    const size_t floats = 4 * (size_t)WIDTH * HEIGHT;
    float *pixels = malloc(floats * sizeof *pixels);
    layersplat_device *device;
    layersplat_volume *volume;
    layersplat_transfer *transfer;
    layersplat_renderer *renderer;
    layersplat_camera camera;
    layersplat_settings settings;

    if (!pixels)
        return EXIT_FAILURE;
    check(layersplat_device_open(name, &device));
    check(layersplat_volume_open(source, &volume));
    check(layersplat_transfer_automatic(volume, &transfer));
    check(layersplat_camera_fit_visible(volume, transfer, from, 30, WIDTH, HEIGHT, &camera));
    check(layersplat_settings_default(LAYERSPLAT_QUALITY_STANDARD, &settings, sizeof settings));
    settings.specular = 0.4;
    check(layersplat_renderer_new(device, volume, transfer, &renderer));
    check(layersplat_render_floats(renderer, &camera, WIDTH, HEIGHT, &settings, pixels, floats));
    check(layersplat_save(pixels, floats, WIDTH, HEIGHT, &settings, black, path));
    printf("%s\n", path);

    layersplat_renderer_free(renderer);
    layersplat_transfer_free(transfer);
    layersplat_volume_free(volume);
    layersplat_device_free(device);
    free(pixels);
    return EXIT_SUCCESS;
}
