/*
 * layersplat: layered volume splatting on any OpenCL device, a plain CPU included.
 *
 * A layersplat_volume and a layersplat_transfer go to a layersplat_renderer on a layersplat_device; a
 * layersplat_camera and layersplat_settings make a picture. README.md beside the folder of this file shows how.
 *
 * Status     Functions that can fail return a layersplat_status. What went wrong, in words, is layersplat_last_error()
 *            of the same thread. No call ends the program or throws.
 * Pointers   Null is an error (LAYERSPLAT_STATUS_NULL_ARGUMENT) unless a function says otherwise. Any other pointer must
 *            point to what the function says, alive and, unless it is an output, unchanged during the call. Nothing is
 *            kept of it afterwards unless a function says so. Arrays come with their length. Texts are UTF-8 and end
 *            with a zero byte.
 * Ownership  Handles are made by the functions whose last argument is the address of one, which is set to null where
 *            they fail, and freed by the ..._free of their kind, in any order. OpenCL objects of the caller's are
 *            retained as long as they are used and released then; events that are returned are the caller's.
 * Threads    Devices, volumes, transfer functions and cancellations may be used by several threads at a time, renderers
 *            by one. A handle is freed when no other call uses it.
 * Choices    Where an int32_t is "a layersplat_quality", say, the constants of that enum are accepted.
 * OpenCL     CL/cl.h is not needed, and goes together with this file in any order: struct _cl_mem * is a cl_mem.
 *            libOpenCL.so.1 is loaded when the first device is opened.
 *
 * This file is generated. Do not edit it.
 */


#ifndef LAYERSPLAT_H
#define LAYERSPLAT_H

#include <stddef.h>
#include <stdint.h>

/**
 * What a call answers. layersplat_last_error() says more about all but the first.
 */
typedef enum layersplat_status {
  /**
   * Done.
   */
  LAYERSPLAT_STATUS_OK = 0,
  /**
   * A pointer is null that must not be.
   */
  LAYERSPLAT_STATUS_NULL_ARGUMENT = 1,
  /**
   * A text is not UTF-8.
   */
  LAYERSPLAT_STATUS_NOT_UTF8 = 2,
  /**
   * A number, a name or a size is not one that is accepted; or several contradict each other.
   */
  LAYERSPLAT_STATUS_INVALID_ARGUMENT = 3,
  /**
   * An array is too small for what was to be written to it.
   */
  LAYERSPLAT_STATUS_TOO_SMALL = 4,
  /**
   * A file cannot be read or written, or holds something else than was expected.
   */
  LAYERSPLAT_STATUS_FILE = 5,
  /**
   * There is no OpenCL on this machine, or no device.
   */
  LAYERSPLAT_STATUS_NO_DEVICE = 6,
  /**
   * The host or the device has too little memory, or the memory budget is too small.
   */
  LAYERSPLAT_STATUS_OUT_OF_MEMORY = 7,
  /**
   * A kernel did not build. The message has the compiler's log.
   */
  LAYERSPLAT_STATUS_BUILD = 8,
  /**
   * An OpenCL object of the caller's cannot be used: it is of another context, too small, or of another kind.
   */
  LAYERSPLAT_STATUS_UNSUITABLE = 9,
  /**
   * A frame was given up because it took longer than it may.
   */
  LAYERSPLAT_STATUS_TOO_LONG = 10,
  /**
   * An OpenCL call failed. The message has the call and its code.
   */
  LAYERSPLAT_STATUS_OPENCL = 11,
  /**
   * The renderer is in use by another thread.
   */
  LAYERSPLAT_STATUS_BUSY = 12,
  /**
   * Something in layersplat is wrong: it panicked. A renderer to which that happened answers nothing else from then on; free it.
   */
  LAYERSPLAT_STATUS_PANIC = 13,
  /**
   * Anything else.
   */
  LAYERSPLAT_STATUS_OTHER = 14,
  /**
   * A frame was cancelled by another thread.
   */
  LAYERSPLAT_STATUS_CANCELLED = 15,
  /**
   * The call needs all voxels on the device, and this renderer streams them. Use layersplat_render_rgba8() or
   * layersplat_render_floats() instead, or a device without a memory budget.
   */
  LAYERSPLAT_STATUS_NEEDS_WHOLE_VOLUME = 16,
} layersplat_status;

/**
 * Type of a voxel.
 */
typedef enum layersplat_voxel_type {
  /**
   * 8 bit, unsigned.
   */
  LAYERSPLAT_VOXEL_TYPE_UINT8 = 0,
  /**
   * 8 bit, signed.
   */
  LAYERSPLAT_VOXEL_TYPE_INT8 = 1,
  /**
   * 16 bit, unsigned.
   */
  LAYERSPLAT_VOXEL_TYPE_UINT16 = 2,
  /**
   * 16 bit, signed.
   */
  LAYERSPLAT_VOXEL_TYPE_INT16 = 3,
  /**
   * 32-bit float. Voxels that are NaN, infinite or beyond ±1e30 count as the smallest value.
   */
  LAYERSPLAT_VOXEL_TYPE_FLOAT32 = 4,
} layersplat_voxel_type;

/**
 * Bundles of settings.
 */
typedef enum layersplat_quality {
  /**
   * One sample per voxel and layer: the fastest.
   */
  LAYERSPLAT_QUALITY_DRAFT = 0,
  /**
   * What is best for the time.
   */
  LAYERSPLAT_QUALITY_STANDARD = 1,
  /**
   * Nearest to what was sampled.
   */
  LAYERSPLAT_QUALITY_HIGH = 2,
  /**
   * Layered volume splatting as it was published: slow.
   */
  LAYERSPLAT_QUALITY_PAPER = 3,
} layersplat_quality;

/**
 * Which renderer makes a picture.
 */
typedef enum layersplat_algorithm {
  /**
   * Layered volume splatting, of the quality chosen.
   */
  LAYERSPLAT_ALGORITHM_LAYERED = 0,
  /**
   * Axis-aligned sheet-buffer splatting. Cannot be enqueued.
   */
  LAYERSPLAT_ALGORITHM_AXIS_SHEETS = 1,
  /**
   * Image-aligned sheet-buffer splatting. Cannot be enqueued.
   */
  LAYERSPLAT_ALGORITHM_VIEW_SHEETS = 2,
  /**
   * Pre-integrated slicing.
   */
  LAYERSPLAT_ALGORITHM_SLICING = 3,
  /**
   * Ray casting.
   */
  LAYERSPLAT_ALGORITHM_RAYCAST = 4,
} layersplat_algorithm;

/**
 * What reconstructs the field between voxels.
 */
typedef enum layersplat_kernel {
  /**
   * What the quality says; of ray casting, linear.
   */
  LAYERSPLAT_KERNEL_AUTOMATIC = 0,
  /**
   * The paper's cubic.
   */
  LAYERSPLAT_KERNEL_CUBIC = 1,
  /**
   * Linear.
   */
  LAYERSPLAT_KERNEL_LINEAR = 2,
  /**
   * Catmull and Rom's spline.
   */
  LAYERSPLAT_KERNEL_CATMULL_ROM = 3,
  /**
   * The interpolating cubic B-spline.
   */
  LAYERSPLAT_KERNEL_BSPLINE = 4,
  /**
   * A Gaussian: of ray casting only.
   */
  LAYERSPLAT_KERNEL_GAUSSIAN = 5,
} layersplat_kernel;

/**
 * What becomes of the values along a ray.
 */
typedef enum layersplat_blend {
  /**
   * Emission and absorption.
   */
  LAYERSPLAT_BLEND_COMPOSITE = 0,
  /**
   * The largest value.
   */
  LAYERSPLAT_BLEND_MAXIMUM = 1,
  /**
   * The smallest value.
   */
  LAYERSPLAT_BLEND_MINIMUM = 2,
  /**
   * The mean.
   */
  LAYERSPLAT_BLEND_AVERAGE = 3,
  /**
   * The first surface where the field has the settings' iso_value.
   */
  LAYERSPLAT_BLEND_ISO = 4,
} layersplat_blend;

/**
 * How a camera sees.
 */
typedef enum layersplat_projection {
  /**
   * Parallel rays.
   */
  LAYERSPLAT_PROJECTION_PARALLEL = 0,
  /**
   * Rays from the eye.
   */
  LAYERSPLAT_PROJECTION_PERSPECTIVE = 1,
} layersplat_projection;

/**
 * Pixels of a picture in memory of the caller's on the device: red, green, blue, alpha.
 */
typedef enum layersplat_pixel_format {
  /**
   * A byte per channel, over a background. In images: CL_RGBA of CL_UNORM_INT8 or CL_UNSIGNED_INT8.
   */
  LAYERSPLAT_PIXEL_FORMAT_RGBA8 = 0,
  /**
   * A float per channel, premultiplied, without a background. In images: CL_RGBA of CL_FLOAT.
   */
  LAYERSPLAT_PIXEL_FORMAT_FLOATS = 1,
} layersplat_pixel_format;

/**
 * Cancels frames from another thread. Any thread may use it, several at a time, also while a renderer that it was given to is in use; one
 * may serve several renderers.
 */
typedef struct layersplat_cancel layersplat_cancel;

/**
 * An OpenCL device with a context and a queue, and the kernels that were built for it. Any thread may use it, several at a time.
 */
typedef struct layersplat_device layersplat_device;

/**
 * Renders one volume on one device. It may go from thread to thread, but is used by one at a time: a second one is answered
 * LAYERSPLAT_STATUS_BUSY.
 */
typedef struct layersplat_renderer layersplat_renderer;

/**
 * Colour and opacity of a data value. Nothing changes it: any thread may use it, several at a time.
 */
typedef struct layersplat_transfer layersplat_transfer;

/**
 * A volume in the host's memory or in a file. Nothing changes it: any thread may use it, several at a time.
 */
typedef struct layersplat_volume layersplat_volume;

/**
 * What a cl_command_queue points to.
 */
typedef struct _cl_command_queue _cl_command_queue;

/**
 * What a cl_context points to.
 */
typedef struct _cl_context _cl_context;

/**
 * What a cl_device_id points to.
 */
typedef struct _cl_device_id _cl_device_id;

/**
 * What a cl_event points to.
 */
typedef struct _cl_event _cl_event;

/**
 * What a cl_mem points to.
 */
typedef struct _cl_mem _cl_mem;

/**
 * A direction to look from: degrees about the y axis (0 looks along −z), above the xz plane, and about the view.
 */
typedef struct layersplat_orbit {
  /**
   * Degrees about the y axis.
   */
  double azimuth;
  /**
   * Degrees above the xz plane.
   */
  double elevation;
  /**
   * Degrees about the view.
   */
  double roll;
} layersplat_orbit;

/**
 * What a picture shows, in world coordinates. May be filled in, or made by one of the functions layersplat_camera_….
 */
typedef struct layersplat_camera {
  /**
   * The eye. Of a parallel projection only the direction to the focal point counts.
   */
  double position[3];
  /**
   * The point in the middle of the picture.
   */
  double focal_point[3];
  /**
   * Any vector that is up in the picture.
   */
  double view_up[3];
  /**
   * A layersplat_projection.
   */
  int32_t projection;
  /**
   * Parallel: half the picture's height, world units. Perspective: its angle from bottom to top, degrees.
   */
  double extent;
} layersplat_camera;

/**
 * Where voxels lie: voxel (i, j, k) at origin + i · hx · x + j · hy · y + k · hz · z, in world units, with the spacing (hx, hy, hz) and
 * the directions x, y, z.
 */
typedef struct layersplat_grid {
  /**
   * Voxels along x, y, z; x is the fastest in memory.
   */
  size_t dims[3];
  /**
   * World distance of neighbouring voxels along x, y, z.
   */
  double spacing[3];
  /**
   * World position of voxel (0, 0, 0).
   */
  double origin[3];
  /**
   * World directions of x, y, z, one after the other: at right angles, of length 1.
   */
  double direction[3][3];
} layersplat_grid;

/**
 * A white light, far away.
 */
typedef struct layersplat_light {
  /**
   * World direction to it; (0, 0, 0): it is at the camera.
   */
  double direction[3];
  /**
   * What its diffuse light and its highlight are multiplied by, from 0 to 100.
   */
  double strength;
} layersplat_light;

/**
 * A plane in world coordinates: what lies on the side that its normal points to is shown.
 */
typedef struct layersplat_plane {
  /**
   * A point of the plane.
   */
  double point[3];
  /**
   * Its normal, of any length but 0.
   */
  double normal[3];
} layersplat_plane;

/**
 * How a picture is made. To be filled in by layersplat_settings_default() and then changed: later versions have more fields.
 */
typedef struct layersplat_settings {
  /**
   * Bytes of this struct, as the program knows it. Leave it as layersplat_settings_default() sets it.
   */
  size_t size;
  /**
   * A layersplat_quality.
   */
  int32_t quality;
  /**
   * A layersplat_algorithm.
   */
  int32_t algorithm;
  /**
   * A layersplat_kernel, of layered and ray-cast pictures.
   */
  int32_t kernel;
  /**
   * Layered pictures: 1 splats layers and classifies after interpolation, as was published; 0 leaves it to the quality.
   */
  int32_t splatted;
  /**
   * A layersplat_blend.
   */
  int32_t blend;
  /**
   * Whether surfaces are lit: 1 or 0.
   */
  int32_t lit;
  /**
   * How many of `lights` count; 0: one of strength 1 is at the camera.
   */
  int32_t light_count;
  /**
   * Whether rays end where less than 1/4096 of the light passes: 1 or 0.
   */
  int32_t early_termination;
  /**
   * Whether only what lies in the box from crop_lowest to crop_highest is shown: 1 or 0.
   */
  int32_t cropped;
  /**
   * How many of `planes` count.
   */
  int32_t plane_count;
  /**
   * How many of `gradient_opacity` count; 0: gradients leave all of the opacity.
   */
  int32_t gradient_point_count;
  /**
   * Distance of slices or of samples along rays, in smallest spacings, of sheets in voxels; 0 is the algorithm's own.
   */
  double step;
  /**
   * The value of the surface of LAYERSPLAT_BLEND_ISO.
   */
  double iso_value;
  /**
   * Share of the colour that needs no light.
   */
  double ambient;
  /**
   * Share that depends on the angle to the light.
   */
  double diffuse;
  /**
   * Strength of the white highlight.
   */
  double specular;
  /**
   * Its exponent.
   */
  double power;
  /**
   * Where light comes from.
   */
  struct layersplat_light lights[4];
  /**
   * World distance that opacities are for; 0 is the smallest spacing.
   */
  double unit_distance;
  /**
   * Lengths of the field's gradient in values per world distance, ascending, and what is left of the opacity there.
   */
  double gradient_opacity[8][2];
  /**
   * The lowest corner of what is shown, in voxels.
   */
  double crop_lowest[3];
  /**
   * The highest corner of what is shown, in voxels.
   */
  double crop_highest[3];
  /**
   * What lies behind one of these is not shown.
   */
  struct layersplat_plane planes[6];
} layersplat_settings;

/**
 * A buffer or a 2D image of the caller's that pictures go to: red, green, blue, alpha, row by row from the top.
 */
typedef struct layersplat_picture {
  /**
   * The cl_mem, in the device's context. It is retained as long as it is used.
   */
  struct _cl_mem *memory;
  /**
   * A layersplat_pixel_format.
   */
  int32_t format;
  /**
   * Whether 8-bit pictures keep their alpha: 1; 0 puts them over `background`.
   */
  int32_t transparent;
  /**
   * The opaque colour below 8-bit pictures, 0 to 1.
   */
  float background[3];
  /**
   * Byte of a buffer where the first pixel goes. Of images 0.
   */
  size_t first;
  /**
   * Bytes from row to row of a buffer; 0 is without gaps. Of images 0.
   */
  size_t row_pitch;
} layersplat_picture;

/**
 * Voxels in a buffer of the caller's on the device: they stay where they are.
 */
typedef struct layersplat_voxels {
  /**
   * The cl_mem, in the device's context. It is retained as long as a renderer uses it.
   */
  struct _cl_mem *memory;
  /**
   * A layersplat_voxel_type.
   */
  int32_t voxel_type;
  /**
   * Whether some voxels may be NaN, infinite or beyond ±1e30, which then count as the smallest value: 1 or 0.
   */
  int32_t invalid_voxels;
  /**
   * Byte of the first voxel: a multiple of a voxel's, as the pitches are.
   */
  size_t first;
  /**
   * Bytes from row to row; 0 with slice_pitch 0 is without gaps.
   */
  size_t row_pitch;
  /**
   * Bytes from slice to slice.
   */
  size_t slice_pitch;
  /**
   * Where the voxels lie in the world.
   */
  struct layersplat_grid grid;
  /**
   * The smallest value that voxels will have. It is a promise: values beyond show as the range's ends do.
   */
  double smallest;
  /**
   * The largest value that voxels will have.
   */
  double largest;
} layersplat_voxels;

/**
 * How a frame uploads its volume, of layersplat_renderer_stream_plan().
 */
typedef struct layersplat_stream_plan {
  /**
   * Parts that are uploaded one after the other; 1: all voxels are on the device at once.
   */
  size_t parts;
  /**
   * Bytes of voxels that are read and uploaded, with the layers that neighbouring parts share. This and all below are 0 where nothing
   * is streamed.
   */
  uint64_t voxel_bytes;
  /**
   * Bytes of the whole volume's voxels.
   */
  uint64_t volume_bytes;
  /**
   * Most bytes of buffers on the device at a time.
   */
  uint64_t device_bytes;
  /**
   * Bytes that these may take: the memory budget less what other renderers take of it.
   */
  uint64_t available_bytes;
} layersplat_stream_plan;

/**
 * A data value and its colour.
 */
typedef struct layersplat_color_point {
  /**
   * The data value.
   */
  double value;
  /**
   * Red, green and blue, 0 to 1.
   */
  double color[3];
} layersplat_color_point;

/**
 * A data value and its opacity.
 */
typedef struct layersplat_opacity_point {
  /**
   * The data value.
   */
  double value;
  /**
   * Opacity per unit distance (layersplat_settings), 0 to 1.
   */
  double opacity;
} layersplat_opacity_point;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * What went wrong in the last call of this thread that failed: UTF-8, empty if none did. It stays until the next call of this thread
 * that fails, or the thread's end; do not free it.
 */
const char *layersplat_last_error(void);

/**
 * A camera at a distance from a point (three world coordinates) that it looks at. `projection` and `extent` are those of
 * layersplat_camera.
 */
enum layersplat_status layersplat_camera_orbit(const double *centre,
                                               double distance,
                                               struct layersplat_orbit angles,
                                               int32_t projection,
                                               double extent,
                                               struct layersplat_camera *camera);

/**
 * A camera that a whole grid fits from every side, for pictures of `width` x `height` pixels. `field_of_view` is that of a perspective,
 * degrees; 0 is a parallel view.
 */
enum layersplat_status layersplat_camera_fit_grid(const struct layersplat_grid *grid,
                                                  struct layersplat_orbit angles,
                                                  double field_of_view,
                                                  uint32_t width,
                                                  uint32_t height,
                                                  struct layersplat_camera *camera);

/**
 * A camera that fits what a transfer function shows of a volume, which is looked for. The rest is as in layersplat_camera_fit_grid().
 */
enum layersplat_status layersplat_camera_fit_visible(const struct layersplat_volume *volume,
                                                     const struct layersplat_transfer *transfer,
                                                     struct layersplat_orbit angles,
                                                     double field_of_view,
                                                     uint32_t width,
                                                     uint32_t height,
                                                     struct layersplat_camera *camera);

/**
 * Not cancelled. To be freed by layersplat_cancel_free().
 */
enum layersplat_status layersplat_cancel_new(struct layersplat_cancel **cancel);

/**
 * Lets `cancel` end frames of a renderer, from the next one on; null: nothing does any more. Frames that are enqueued are not cancelled.
 */
enum layersplat_status layersplat_renderer_set_cancel(struct layersplat_renderer *renderer,
                                                      const struct layersplat_cancel *cancel);

/**
 * Ends the frame in progress and all later ones, until layersplat_cancel_reset(): they return LAYERSPLAT_STATUS_CANCELLED and write no
 * pixels. A frame ends before its next kernel; the one that is running is not stopped. It returns at once.
 */
enum layersplat_status layersplat_cancel_frames(const struct layersplat_cancel *cancel);

/**
 * Lets later frames be drawn again.
 */
enum layersplat_status layersplat_cancel_reset(const struct layersplat_cancel *cancel);

/**
 * Frees it. Renderers that it was given to go on, and nothing cancels them any more. Null is left alone.
 */
void layersplat_cancel_free(struct layersplat_cancel *cancel);

/**
 * Opens a device with a context and a queue of its own. `name` is an index, or part of a device's or a platform's name in any case;
 * null takes the first GPU, or where there is none, the first CPU. To be freed by layersplat_device_free().
 */
enum layersplat_status layersplat_device_open(const char *name,
                                              struct layersplat_device **device);

/**
 * The device of a cl_command_queue of the caller's, which may be in order or out of order, and is used for everything. `context` and
 * `id` are the queue's cl_context and cl_device_id; null takes whatever the queue has.
 *
 * Queue and context are retained, and released when the device and all renderers that were made from it are freed.
 */
enum layersplat_status layersplat_device_from_queue(struct _cl_context *context,
                                                    struct _cl_device_id *id,
                                                    struct _cl_command_queue *queue,
                                                    struct layersplat_device **device);

/**
 * The same device with a memory budget: buffers that renderers make through the new handle take at most `bytes` together. Volumes that do
 * not fit are streamed in parts, to the same picture. Streaming covers layers on a lattice; views and settings that need all
 * voxels at once return LAYERSPLAT_STATUS_OUT_OF_MEMORY, and calls that do LAYERSPLAT_STATUS_NEEDS_WHOLE_VOLUME. The message of
 * layersplat_last_error() says how many bytes are enough. Each handle has a budget of its own. To be freed by layersplat_device_free().
 */
enum layersplat_status layersplat_device_with_memory(const struct layersplat_device *device,
                                                     uint64_t bytes,
                                                     struct layersplat_device **limited);

/**
 * The device's name, with the zero byte at its end, into `room` bytes.
 */
enum layersplat_status layersplat_device_name(const struct layersplat_device *device,
                                              char *name,
                                              size_t room);

/**
 * The device's cl_context, for buffers of its own to render from or into. It is not retained: it lives as long as the device. Null if
 * `device` is null.
 */
struct _cl_context *layersplat_device_context(const struct layersplat_device *device);

/**
 * The device's cl_device_id; null if `device` is null.
 */
struct _cl_device_id *layersplat_device_id(const struct layersplat_device *device);

/**
 * The device's cl_command_queue, not retained: it lives as long as the device. Null if `device` is null.
 */
struct _cl_command_queue *layersplat_device_queue(const struct layersplat_device *device);

/**
 * Frees a device. Renderers that were made from it go on. Null is left alone.
 */
void layersplat_device_free(struct layersplat_device *device);

/**
 * Enqueues a frame into memory of the caller's own, after `wait_count` events, and returns at once. `event`, unless it is null, gets the
 * cl_event that is complete when the picture is there; the caller releases it with clReleaseEvent. Nothing is read back, and no queue is
 * waited for. What the arguments point to may change as soon as this returns.
 *
 * Kernels that were not built yet are built first, which takes seconds: layersplat_renderer_prepare() does that beforehand. Sheets
 * cannot be enqueued. An error leaves the queue usable, the picture undefined, and no event.
 */
enum layersplat_status layersplat_renderer_enqueue(struct layersplat_renderer *renderer,
                                                   const struct layersplat_camera *camera,
                                                   uint32_t width,
                                                   uint32_t height,
                                                   const struct layersplat_settings *settings,
                                                   const struct layersplat_picture *picture,
                                                   uint32_t wait_count,
                                                   struct _cl_event *const *wait_list,
                                                   struct _cl_event **event);

/**
 * Makes what frames like this one need, from any side: kernels are built, tables made. It waits until all of it is there.
 */
enum layersplat_status layersplat_renderer_prepare(struct layersplat_renderer *renderer,
                                                   const struct layersplat_camera *camera,
                                                   uint32_t width,
                                                   uint32_t height,
                                                   const struct layersplat_settings *settings);

/**
 * The voxels of layersplat_renderer_in_place() change, or have changed: frames from here on are of what is there after `wait_count`
 * events. `event`, unless it is null, gets the cl_event that is complete when those are, for the caller to release; frames wait for it by
 * themselves.
 */
enum layersplat_status layersplat_renderer_volume_changed(struct layersplat_renderer *renderer,
                                                          uint32_t wait_count,
                                                          struct _cl_event *const *wait_list,
                                                          struct _cl_event **event);

/**
 * Bytes of each buffer of scratch that a frame needs, into `sizes`, which has room for `room` of them; `count` is how many there are.
 * With `room` 0, only that is told. Besides, a renderer keeps tables of its own.
 */
enum layersplat_status layersplat_renderer_scratch_sizes(struct layersplat_renderer *renderer,
                                                         const struct layersplat_camera *camera,
                                                         uint32_t width,
                                                         uint32_t height,
                                                         const struct layersplat_settings *settings,
                                                         const struct layersplat_picture *picture,
                                                         size_t *sizes,
                                                         size_t room,
                                                         size_t *count);

/**
 * Gives cl_mem buffers for what enqueued frames write besides the picture: one for each of layersplat_renderer_scratch_sizes(), in any
 * order. They are retained. No buffers, and the renderer makes its own again. Another renderer whose frames may be drawn at the same time
 * must not be given them.
 */
enum layersplat_status layersplat_renderer_set_scratch(struct layersplat_renderer *renderer,
                                                       struct _cl_mem *const *buffers,
                                                       size_t count);

/**
 * A grid at the origin along the world's axes: voxels and their distance along x, y, z.
 */
struct layersplat_grid layersplat_grid_at_origin(size_t nx,
                                                 size_t ny,
                                                 size_t nz,
                                                 double hx,
                                                 double hy,
                                                 double hz);

/**
 * Finds the smallest and the largest value of voxels, and whether some are invalid, by looking at all of them on the device, after
 * `wait_count` events; sets `smallest`, `largest` and `invalid_voxels`. It returns when they are found.
 */
enum layersplat_status layersplat_voxels_find_range(const struct layersplat_device *device,
                                                    struct layersplat_voxels *voxels,
                                                    uint32_t wait_count,
                                                    struct _cl_event *const *wait_list);

/**
 * A renderer of voxels that stay where they are. They may change from frame to frame, in the order of the queue and its events, if the
 * renderer is told so: layersplat_renderer_volume_changed().
 */
enum layersplat_status layersplat_renderer_in_place(const struct layersplat_device *device,
                                                    const struct layersplat_voxels *voxels,
                                                    const struct layersplat_transfer *transfer,
                                                    struct layersplat_renderer **renderer);

/**
 * Renders a picture of `width` x `height` pixels of 8 bits: red, green, blue, alpha; row by row from the top, without gaps, over an opaque
 * colour (three floats, 0 to 1), or where `background` is null, with straight alpha. `bytes` are those that `pixels` has room for:
 * 4 * width * height or more. Null settings are those of the standard quality. It returns when the picture is there.
 */
enum layersplat_status layersplat_render_rgba8(struct layersplat_renderer *renderer,
                                               const struct layersplat_camera *camera,
                                               uint32_t width,
                                               uint32_t height,
                                               const struct layersplat_settings *settings,
                                               const float *background,
                                               uint8_t *pixels,
                                               size_t bytes);

/**
 * Renders a picture of floats: red, green, blue, premultiplied, and alpha, without a background; row by row from the top, without gaps.
 * `floats` are those that `pixels` has room for: 4 * width * height or more. The rest is as in layersplat_render_rgba8().
 */
enum layersplat_status layersplat_render_floats(struct layersplat_renderer *renderer,
                                                const struct layersplat_camera *camera,
                                                uint32_t width,
                                                uint32_t height,
                                                const struct layersplat_settings *settings,
                                                float *pixels,
                                                size_t floats);

/**
 * How far away is what a picture shows: distances from the eye along the view's direction, in world units, row by row from the top, infinite
 * where nothing is seen. `first`: where something is seen first, where 1/256 of the light is stopped or at the iso-surface; `mean`: of all
 * that is seen, weighted by opacity. Each has room for `floats` of them: width * height or more. Found by ray casting, whatever draws
 * pictures; refused for blend modes other than composite and iso. The rest is as in layersplat_render_rgba8().
 */
enum layersplat_status layersplat_render_depths(struct layersplat_renderer *renderer,
                                                const struct layersplat_camera *camera,
                                                uint32_t width,
                                                uint32_t height,
                                                const struct layersplat_settings *settings,
                                                float *first,
                                                float *mean,
                                                size_t floats);

/**
 * Writes a picture of floats, as layersplat_render_floats() makes them, to a file: .png or .jpg (8 bit), .exr or .npy (float32),
 * over an opaque colour (three floats, 0 to 1), or where `background` is null, with its alpha. `floats` is 4 * width * height. The file
 * is written whole or not at all.
 */
enum layersplat_status layersplat_save(const float *pixels,
                                       size_t floats,
                                       uint32_t width,
                                       uint32_t height,
                                       const float *background,
                                       const char *path);

/**
 * Makes a renderer of a volume, seen through a transfer function. Device, volume and transfer function may be freed afterwards; the
 * renderer by layersplat_renderer_free().
 *
 * The voxels are uploaded at once. A renderer on a device with a memory budget (layersplat_device_with_memory()), and one whose
 * volume is larger than the device's largest buffer, uploads them during frames instead: all of them if they fit, in parts if not.
 */
enum layersplat_status layersplat_renderer_new(const struct layersplat_device *device,
                                               const struct layersplat_volume *volume,
                                               const struct layersplat_transfer *transfer,
                                               struct layersplat_renderer **renderer);

/**
 * Takes another transfer function from the next frame on.
 */
enum layersplat_status layersplat_renderer_set_transfer(struct layersplat_renderer *renderer,
                                                        const struct layersplat_transfer *transfer);

/**
 * Longest time of a frame in seconds, from the next one on; 0: no limit. A longer frame returns LAYERSPLAT_STATUS_TOO_LONG before its next
 * kernel; the one that is running is not stopped. Frames that are enqueued are not limited. Another thread ends a frame by
 * layersplat_cancel_frames().
 */
enum layersplat_status layersplat_renderer_limit(struct layersplat_renderer *renderer,
                                                 double seconds);

/**
 * Frees a renderer, which no call may be using, with all that it keeps on the device. What was enqueued is drawn to its end. Null is left
 * alone.
 */
void layersplat_renderer_free(struct layersplat_renderer *renderer);

/**
 * The settings of a layersplat_quality, composited, lit from the camera, nothing cut off. `size` is sizeof(layersplat_settings): a
 * program that was compiled with a later header than this library's is told so.
 */
enum layersplat_status layersplat_settings_default(int32_t quality,
                                                   struct layersplat_settings *settings,
                                                   size_t size);

/**
 * How a frame would upload its volume, without drawing it. The errors are those that drawing it would return for want of memory.
 */
enum layersplat_status layersplat_renderer_stream_plan(struct layersplat_renderer *renderer,
                                                       const struct layersplat_camera *camera,
                                                       uint32_t width,
                                                       uint32_t height,
                                                       const struct layersplat_settings *settings,
                                                       struct layersplat_stream_plan *plan);

/**
 * A sensible first transfer function, from the histogram of a volume. To be freed by layersplat_transfer_free().
 */
enum layersplat_status layersplat_transfer_automatic(const struct layersplat_volume *volume,
                                                     struct layersplat_transfer **transfer);

/**
 * A built-in transfer function (an unknown name's message lists them), or one of a ParaView colour-map file: FILE, or FILE#PRESET.
 * Built-in ones reach over the values of `volume`; where that is null, from 0 to 1 (see layersplat_transfer_stretched()).
 */
enum layersplat_status layersplat_transfer_open(const char *source,
                                                const struct layersplat_volume *volume,
                                                struct layersplat_transfer **transfer);

/**
 * Colours and opacities that are linear between points and constant beyond them: at least one of each, ascending by value. Two at one
 * value make a step.
 */
enum layersplat_status layersplat_transfer_points(const struct layersplat_color_point *colors,
                                                  size_t color_count,
                                                  const struct layersplat_opacity_point *opacities,
                                                  size_t opacity_count,
                                                  struct layersplat_transfer **transfer);

/**
 * The same function with its values mapped linearly onto those from `smallest` to `largest`.
 */
enum layersplat_status layersplat_transfer_stretched(const struct layersplat_transfer *transfer,
                                                     double smallest,
                                                     double largest,
                                                     struct layersplat_transfer **stretched);

/**
 * Frees a transfer function. Renderers that it was given to keep a copy. Null is left alone.
 */
void layersplat_transfer_free(struct layersplat_transfer *transfer);

/**
 * A volume of a copy of voxels: `bytes` of them in all, of a layersplat_voxel_type, x fastest, without gaps, of this machine's byte
 * order. To be freed by layersplat_volume_free().
 */
enum layersplat_status layersplat_volume_copy(const void *voxels,
                                              size_t bytes,
                                              int32_t voxel_type,
                                              const struct layersplat_grid *grid,
                                              struct layersplat_volume **volume);

/**
 * The same without a copy: the voxels must stay there unchanged until the volume is freed. Renderers have a copy on the device, but one
 * that streams the volume (layersplat_renderer_new()) reads the voxels in every frame: they must stay until it is freed, too.
 */
enum layersplat_status layersplat_volume_borrow(const void *voxels,
                                                size_t bytes,
                                                int32_t voxel_type,
                                                const struct layersplat_grid *grid,
                                                struct layersplat_volume **volume);

/**
 * Opens builtin:NAME, builtin:NAME@SIZE (voxels along each side) or a file of a format that layersplat reads. Files that hold voxels as
 * they are get mapped: they must not be cut short before the volume and all renderers that stream it are freed.
 */
enum layersplat_status layersplat_volume_open(const char *source,
                                              struct layersplat_volume **volume);

/**
 * Where the voxels lie.
 */
enum layersplat_status layersplat_volume_grid(const struct layersplat_volume *volume,
                                              struct layersplat_grid *grid);

/**
 * The smallest and the largest value of a valid voxel.
 */
enum layersplat_status layersplat_volume_range(const struct layersplat_volume *volume,
                                               double *smallest,
                                               double *largest);

/**
 * Frees a volume. Renderers that were made from it go on. Null is left alone.
 */
void layersplat_volume_free(struct layersplat_volume *volume);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* LAYERSPLAT_H */
