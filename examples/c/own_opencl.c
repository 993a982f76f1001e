/*
 * Renders voxels of an application's OpenCL buffer without copying them: own_opencl [PICTURE [PICTURE]]
 *
 * A kernel of the application fills a buffer with voxels. layersplat renders them into a second buffer, which the
 * application reads with its own queue. Events order the commands; the host waits only for the final read.
 *
 * cc examples/c/own_opencl.c -Ibindings/c/include -Ltarget/debug -llayersplat_c -Wl,-rpath,target/debug \
 *    -l:libOpenCL.so.1 -lm -o own_opencl
 */
#define _POSIX_C_SOURCE 199309L /* nanosleep */
#include "opencl.h"
#include <layersplat.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { SIDE = 32, WIDTH = 160, HEIGHT = 120, MOST_BUFFERS = 8 };

static const char *fill_source =
    "kernel void fill(global float *voxels, int side, float phase)\n"
    "{\n"
    "    int n = get_global_id(0);\n"
    "    float3 p = (float3)(n % side, n / side % side, n / (side * side)) / (side - 1) * 2 - 1;\n"
    "    float ring = hypot(p.x, p.y) - 0.6f;\n"
    "    voxels[n] = exp(-8 * (ring * ring + p.z * p.z)) * (1 + 0.5f * sin(6 * atan2(p.y, p.x) + phase));\n"
    "}\n";

static void check(layersplat_status status)
{
    if (status != LAYERSPLAT_STATUS_OK) {
        fprintf(stderr, "error %d: %s\n", (int)status, layersplat_last_error());
        exit(EXIT_FAILURE);
    }
}

static void check_cl(cl_int code, const char *what)
{
    if (code != CL_SUCCESS) {
        fprintf(stderr, "%s: %d\n", what, (int)code);
        exit(EXIT_FAILURE);
    }
}

/* The application's OpenCL objects. */
struct host {
    cl_device_id id;
    cl_context context;
    cl_command_queue queue;
    cl_program program;
    cl_kernel fill;
    cl_mem voxels, picture;
};

static struct host open_host(void)
{
    struct host host;
    cl_platform_id platform;
    cl_int code;
    check_cl(clGetPlatformIDs(1, &platform, NULL), "clGetPlatformIDs");
    check_cl(clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 1, &host.id, NULL), "clGetDeviceIDs");
    host.context = clCreateContext(NULL, 1, &host.id, NULL, NULL, &code);
    check_cl(code, "clCreateContext");
    host.queue = clCreateCommandQueue(host.context, host.id, 0, &code);
    check_cl(code, "clCreateCommandQueue");
    host.program = clCreateProgramWithSource(host.context, 1, &fill_source, NULL, &code);
    check_cl(code, "clCreateProgramWithSource");
    check_cl(clBuildProgram(host.program, 0, NULL, "", NULL, NULL), "clBuildProgram");
    host.fill = clCreateKernel(host.program, "fill", &code);
    check_cl(code, "clCreateKernel");
    host.voxels = clCreateBuffer(host.context, CL_MEM_READ_WRITE, SIDE * SIDE * SIDE * sizeof(float), NULL, &code);
    check_cl(code, "clCreateBuffer");
    host.picture = clCreateBuffer(host.context, CL_MEM_READ_WRITE, WIDTH * HEIGHT * 4 * sizeof(float), NULL, &code);
    check_cl(code, "clCreateBuffer");
    return host;
}

/* Reference counts of the context, the voxels and the picture. */
static void count_references(const struct host *host, cl_uint counts[3])
{
    check_cl(clFinish(host->queue), "clFinish");
    clGetContextInfo(host->context, CL_CONTEXT_REFERENCE_COUNT, sizeof *counts, &counts[0], NULL);
    clGetMemObjectInfo(host->voxels, CL_MEM_REFERENCE_COUNT, sizeof *counts, &counts[1], NULL);
    clGetMemObjectInfo(host->picture, CL_MEM_REFERENCE_COUNT, sizeof *counts, &counts[2], NULL);
}

/*
 * Reference counts once the driver has released its own, or those after a few seconds. Its threads may do that a
 * moment after clFinish returns.
 */
static void wait_for_references(const struct host *host, const cl_uint expected[3], cl_uint counts[3])
{
    const struct timespec pause = {0, 10 * 1000 * 1000};
    for (int tries = 0; tries < 500; tries++) {
        count_references(host, counts);
        if (memcmp(counts, expected, 3 * sizeof *counts) == 0)
            return;
        nanosleep(&pause, NULL);
    }
}

static void close_host(struct host host)
{
    clReleaseMemObject(host.picture);
    clReleaseMemObject(host.voxels);
    clReleaseKernel(host.fill);
    clReleaseProgram(host.program);
    clReleaseCommandQueue(host.queue);
    clReleaseContext(host.context);
}

/* Enqueues the kernel that writes the voxels. Its event completes when they are written. */
static cl_event fill(const struct host *host, float phase)
{
    const size_t voxels = SIDE * SIDE * SIDE;
    const cl_int side = SIDE;
    cl_event filled;
    check_cl(clSetKernelArg(host->fill, 0, sizeof host->voxels, &host->voxels), "clSetKernelArg");
    check_cl(clSetKernelArg(host->fill, 1, sizeof side, &side), "clSetKernelArg");
    check_cl(clSetKernelArg(host->fill, 2, sizeof phase, &phase), "clSetKernelArg");
    check_cl(clEnqueueNDRangeKernel(host->queue, host->fill, 1, NULL, &voxels, NULL, 0, NULL, &filled),
             "clEnqueueNDRangeKernel");
    return filled;
}

/* Gives a renderer its intermediate buffers. It retains them, so they can be released here. */
static void give_scratch(const struct host *host, layersplat_renderer *renderer, const layersplat_camera *camera,
                         const layersplat_picture *picture)
{
    size_t sizes[MOST_BUFFERS], count, n;
    cl_mem buffers[MOST_BUFFERS];
    cl_int code;
    check(layersplat_renderer_scratch_sizes(renderer, camera, WIDTH, HEIGHT, NULL, picture, sizes, MOST_BUFFERS, &count));
    for (n = 0; n < count; n++) {
        buffers[n] = clCreateBuffer(host->context, CL_MEM_READ_WRITE, sizes[n], NULL, &code);
        check_cl(code, "clCreateBuffer");
    }
    check(layersplat_renderer_set_scratch(renderer, buffers, count));
    for (n = 0; n < count; n++)
        clReleaseMemObject(buffers[n]);
}

/* Renders the voxels after `filled` has completed, and reads the picture. */
static void draw(const struct host *host, layersplat_renderer *renderer, const layersplat_camera *camera,
                 const layersplat_picture *picture, cl_event filled, float *pixels)
{
    cl_event drawn;
    check(layersplat_renderer_enqueue(renderer, camera, WIDTH, HEIGHT, NULL, picture, 1, &filled, &drawn));
    check_cl(clEnqueueReadBuffer(host->queue, host->picture, CL_TRUE, 0, WIDTH * HEIGHT * 4 * sizeof *pixels, pixels, 1,
                                 &drawn, NULL),
             "clEnqueueReadBuffer");
    clReleaseEvent(drawn);
    clReleaseEvent(filled);
}

static double difference(const float *a, const float *b)
{
    double largest = 0;
    for (size_t n = 0; n < WIDTH * HEIGHT * 4; n++)
        largest = fmax(largest, fabs((double)a[n] - b[n]));
    return largest;
}

int main(int count, char **arguments)
{
    const layersplat_orbit from = {30, 40, 0};
    const size_t floats = 4 * (size_t)WIDTH * HEIGHT;
    float *pixels[2] = {malloc(floats * sizeof(float)), malloc(floats * sizeof(float))};
    struct host host = open_host();
    cl_uint before[3], between[3], after[3];
    layersplat_device *device;
    layersplat_transfer *unit, *transfer;
    layersplat_renderer *renderer;
    layersplat_camera camera;
    layersplat_voxels voxels = {0};
    layersplat_picture picture = {0};
    cl_event filled;

    if (!pixels[0] || !pixels[1])
        return EXIT_FAILURE;
    count_references(&host, before);
    check(layersplat_device_from_queue(host.context, host.id, host.queue, &device));

    /* The range of the first voxels is determined on the device. */
    filled = fill(&host, 0);
    voxels.memory = host.voxels;
    voxels.voxel_type = LAYERSPLAT_VOXEL_TYPE_FLOAT32;
    voxels.grid = layersplat_grid_at_origin(SIDE, SIDE, SIDE, 1, 1, 1);
    check(layersplat_voxels_find_range(device, &voxels, 1, &filled));
    voxels.largest = fmax(voxels.largest, 1.5);

    check(layersplat_transfer_open("fire", NULL, &unit));
    check(layersplat_transfer_stretched(unit, voxels.smallest, voxels.largest, &transfer));
    check(layersplat_camera_fit_grid(&voxels.grid, from, 30, WIDTH, HEIGHT, &camera));
    check(layersplat_renderer_in_place(device, &voxels, transfer, &renderer));
    picture.memory = host.picture;
    picture.format = LAYERSPLAT_PIXEL_FORMAT_FLOATS;
    check(layersplat_renderer_prepare(renderer, &camera, WIDTH, HEIGHT, NULL));
    give_scratch(&host, renderer, &camera, &picture);
    draw(&host, renderer, &camera, &picture, filled, pixels[0]);

    /* New voxels in the same buffer: the renderer must be notified, and waits for the kernel that writes them. */
    filled = fill(&host, 2);
    check(layersplat_renderer_volume_changed(renderer, 1, &filled, NULL));
    draw(&host, renderer, &camera, &picture, filled, pixels[1]);
    printf("largest difference of the two pictures: %.3f\n", difference(pixels[0], pixels[1]));

    for (int n = 0; n < 2 && n + 1 < count; n++)
        check(layersplat_save(pixels[n], floats, WIDTH, HEIGHT, NULL, NULL, arguments[n + 1]));

    count_references(&host, between);
    layersplat_renderer_free(renderer);
    layersplat_transfer_free(transfer);
    layersplat_transfer_free(unit);
    layersplat_device_free(device);
    wait_for_references(&host, before, after);
    close_host(host);
    for (int n = 0; n < 3; n++) {
        printf("references: %u, in use %u, afterwards %u\n", before[n], between[n], after[n]);
        if (n < 2 && between[n] <= before[n])
            return EXIT_FAILURE;
        if (after[n] != before[n])
            return EXIT_FAILURE;
    }
    free(pixels[0]);
    free(pixels[1]);
    return EXIT_SUCCESS;
}
