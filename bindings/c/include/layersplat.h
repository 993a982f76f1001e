/*
 * layersplat: layered volume splatting on any OpenCL device, a plain CPU included.
 *
 * A layersplat_renderer draws a layersplat_volume with a layersplat_transfer on a layersplat_device. Each frame takes
 * a layersplat_camera and layersplat_settings. See bindings/c/README.md for examples.
 *
 * Status     Functions that can fail return a layersplat_status. layersplat_last_error() returns the message of the last
 *            error on the same thread. No call terminates the program or throws an exception.
 * Pointers   Null is an error (LAYERSPLAT_STATUS_NULL_ARGUMENT) unless a function states otherwise. Other pointers must
 *            be valid during the call, and inputs must not change. No pointer is kept after the call unless a function
 *            states otherwise. Arrays come with their length. Strings are UTF-8 and zero-terminated.
 * Ownership  A function whose last argument is the address of a handle creates that handle, and sets it to null on
 *            failure. Free it with the ..._free function of its type, in any order. OpenCL objects of the caller are
 *            retained while they are in use. Returned events belong to the caller.
 * Threads    Several threads may use a device, volume, sequence, transfer function, cancellation flag, or voxels, colours
 *            and labels on a device at the same time, but only one thread a renderer or a playback. Do not free a handle while another call uses it.
 * Enums      An int32_t that is documented as, for example, "a layersplat_quality" takes the constants of that enum.
 * OpenCL     CL/cl.h is not needed, and may be included before or after this file: struct _cl_mem * is a cl_mem.
 *            libOpenCL.so.1 is loaded when the first device is opened.
 *
 * This file is generated. Do not edit it.
 */


#ifndef LAYERSPLAT_H
#define LAYERSPLAT_H

#include <stddef.h>
#include <stdint.h>

/**
 * Status of a call. layersplat_last_error() describes every error.
 */
typedef enum layersplat_status {
  /**
   * Success.
   */
  LAYERSPLAT_STATUS_OK = 0,
  /**
   * A required pointer is null.
   */
  LAYERSPLAT_STATUS_NULL_ARGUMENT = 1,
  /**
   * A string is not UTF-8.
   */
  LAYERSPLAT_STATUS_NOT_UTF8 = 2,
  /**
   * A number, a name or a size is invalid, or arguments contradict each other.
   */
  LAYERSPLAT_STATUS_INVALID_ARGUMENT = 3,
  /**
   * An output array is too small.
   */
  LAYERSPLAT_STATUS_TOO_SMALL = 4,
  /**
   * A file cannot be read or written, or its contents are invalid.
   */
  LAYERSPLAT_STATUS_FILE = 5,
  /**
   * There is no OpenCL implementation or no device on this machine.
   */
  LAYERSPLAT_STATUS_NO_DEVICE = 6,
  /**
   * Host or device memory is exhausted, or the memory budget is too small.
   */
  LAYERSPLAT_STATUS_OUT_OF_MEMORY = 7,
  /**
   * A kernel failed to build. The message contains the compiler's log.
   */
  LAYERSPLAT_STATUS_BUILD = 8,
  /**
   * An OpenCL object of the caller cannot be used: wrong context, too small, or the wrong kind.
   */
  LAYERSPLAT_STATUS_UNSUITABLE = 9,
  /**
   * A frame exceeded its time limit.
   */
  LAYERSPLAT_STATUS_TOO_LONG = 10,
  /**
   * An OpenCL call failed. The message names the call and its error code.
   */
  LAYERSPLAT_STATUS_OPENCL = 11,
  /**
   * The renderer is in use by another thread.
   */
  LAYERSPLAT_STATUS_BUSY = 12,
  /**
   * A defect of layersplat: it panicked. A renderer in which this happened returns only this status; free it.
   */
  LAYERSPLAT_STATUS_PANIC = 13,
  /**
   * Any other error.
   */
  LAYERSPLAT_STATUS_OTHER = 14,
  /**
   * A frame was cancelled by another thread.
   */
  LAYERSPLAT_STATUS_CANCELLED = 15,
  /**
   * The call needs all voxels on the device, but this renderer streams them. Use layersplat_render_rgba8() or
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
 * Presets that trade quality for speed.
 */
typedef enum layersplat_quality {
  /**
   * One sample per voxel and layer: the fastest.
   */
  LAYERSPLAT_QUALITY_DRAFT = 0,
  /**
   * Best quality for its time.
   */
  LAYERSPLAT_QUALITY_STANDARD = 1,
  /**
   * Closest reconstruction of the sampled field.
   */
  LAYERSPLAT_QUALITY_HIGH = 2,
  /**
   * Layered volume splatting as published: slow.
   */
  LAYERSPLAT_QUALITY_PAPER = 3,
} layersplat_quality;

/**
 * Rendering algorithm.
 */
typedef enum layersplat_algorithm {
  /**
   * Layered volume splatting, in the selected quality.
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
 * Reconstruction kernel.
 */
typedef enum layersplat_kernel {
  /**
   * The kernel of the quality; for ray casting, linear.
   */
  LAYERSPLAT_KERNEL_AUTOMATIC = 0,
  /**
   * The paper's cubic kernel.
   */
  LAYERSPLAT_KERNEL_CUBIC = 1,
  /**
   * Linear.
   */
  LAYERSPLAT_KERNEL_LINEAR = 2,
  /**
   * The Catmull-Rom spline.
   */
  LAYERSPLAT_KERNEL_CATMULL_ROM = 3,
  /**
   * The interpolating cubic B-spline.
   */
  LAYERSPLAT_KERNEL_BSPLINE = 4,
  /**
   * A Gaussian; ray casting only.
   */
  LAYERSPLAT_KERNEL_GAUSSIAN = 5,
} layersplat_kernel;

/**
 * Estimation of the gradients for shading and gradient opacity.
 */
typedef enum layersplat_gradient {
  /**
   * Sobel for layers with pre-integrated classification; for ray casting the derivative of the kernel where that is continuous; else
   * central differences.
   */
  LAYERSPLAT_GRADIENT_AUTOMATIC = 0,
  /**
   * Central differences of the voxels.
   */
  LAYERSPLAT_GRADIENT_CENTRAL = 1,
  /**
   * Central differences that are smoothed across their direction, which hides terraces and noise. Not with the Gaussian kernel.
   */
  LAYERSPLAT_GRADIENT_SOBEL = 2,
  /**
   * The derivative of the kernel. Catmull-Rom spline and B-spline only.
   */
  LAYERSPLAT_GRADIENT_OWN = 3,
  /**
   * Central differences of voxels that a Gaussian of gradient_sigma has smoothed. Not with the Gaussian kernel.
   */
  LAYERSPLAT_GRADIENT_GAUSSIAN = 4,
} layersplat_gradient;

/**
 * How the values along a ray are combined.
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
   * The first iso-surface at the settings' iso_value.
   */
  LAYERSPLAT_BLEND_ISO = 4,
} layersplat_blend;

/**
 * Resolution of shadows, ambient occlusion and scattered light. Below full resolution, surfaces that are nearly parallel to the light show contour rings.
 */
typedef enum layersplat_light_grid {
  /**
   * One value per voxel.
   */
  LAYERSPLAT_LIGHT_GRID_FULL = 0,
  /**
   * One value per 2 x 2 x 2 voxels.
   */
  LAYERSPLAT_LIGHT_GRID_HALF = 1,
  /**
   * One value per 4 x 4 x 4 voxels for ambient occlusion and scattered light; shadows have half the resolution.
   */
  LAYERSPLAT_LIGHT_GRID_QUARTER = 2,
} layersplat_light_grid;

/**
 * How a picture is lit.
 */
typedef enum layersplat_look {
  /**
   * By the lights and the ambient light, as the colours of the transfer function are.
   */
  LAYERSPLAT_LOOK_PLAIN = 0,
  /**
   * By a sky and lights whose light scatters in the volume, in linear colours.
   */
  LAYERSPLAT_LOOK_STUDIO = 1,
} layersplat_look;

/**
 * Curve of bright colours in 8-bit pictures of the studio.
 */
typedef enum layersplat_tone {
  /**
   * They are cut off.
   */
  LAYERSPLAT_TONE_NONE = 0,
  /**
   * They approach white.
   */
  LAYERSPLAT_TONE_SHOULDER = 1,
} layersplat_tone;

/**
 * Where the opacity of colours comes from.
 */
typedef enum layersplat_color_opacity {
  /**
   * The fourth component, per smallest spacing.
   */
  LAYERSPLAT_COLOR_OPACITY_ALPHA = 0,
  /**
   * The luminance (BT.709).
   */
  LAYERSPLAT_COLOR_OPACITY_LUMINANCE = 1,
  /**
   * The largest difference of a component from a background colour.
   */
  LAYERSPLAT_COLOR_OPACITY_BACKGROUND = 2,
} layersplat_color_opacity;

/**
 * Surfaces of labels that are drawn by themselves.
 */
typedef enum layersplat_label_surfaces {
  /**
   * Surfaces lie where the interpolated share of a label is one half, and gradients are smoothed unless the settings state them.
   */
  LAYERSPLAT_LABEL_SURFACES_SMOOTH = 0,
  /**
   * Each voxel has the extinction and colour of its label.
   */
  LAYERSPLAT_LABEL_SURFACES_VOXELS = 1,
} layersplat_label_surfaces;

/**
 * Projection of a camera.
 */
typedef enum layersplat_projection {
  /**
   * Parallel rays.
   */
  LAYERSPLAT_PROJECTION_PARALLEL = 0,
  /**
   * Rays through the eye.
   */
  LAYERSPLAT_PROJECTION_PERSPECTIVE = 1,
} layersplat_projection;

/**
 * Pixel format of a picture in the caller's device memory. The channels are red, green, blue, alpha.
 */
typedef enum layersplat_pixel_format {
  /**
   * One byte per channel, over a background. Images: CL_RGBA with CL_UNORM_INT8 or CL_UNSIGNED_INT8.
   */
  LAYERSPLAT_PIXEL_FORMAT_RGBA8 = 0,
  /**
   * One float per channel, premultiplied, without a background. Images: CL_RGBA with CL_FLOAT.
   */
  LAYERSPLAT_PIXEL_FORMAT_FLOATS = 1,
} layersplat_pixel_format;

/**
 * The axis that a slice is perpendicular to.
 */
typedef enum layersplat_slice_axis {
  /**
   * The voxels' x: y to the right, z up.
   */
  LAYERSPLAT_SLICE_AXIS_X = 0,
  /**
   * The voxels' y: x to the right, z up.
   */
  LAYERSPLAT_SLICE_AXIS_Y = 1,
  /**
   * The voxels' z: x to the right, y up.
   */
  LAYERSPLAT_SLICE_AXIS_Z = 2,
  /**
   * Seen from the feet: the patient's left is on the right, the front is up. Only if the file states how the patient lies.
   */
  LAYERSPLAT_SLICE_AXIS_AXIAL = 3,
  /**
   * Seen from the front: the patient's left is on the right, the head is up.
   */
  LAYERSPLAT_SLICE_AXIS_CORONAL = 4,
  /**
   * Seen from the patient's left: the back is on the right, the head is up.
   */
  LAYERSPLAT_SLICE_AXIS_SAGITTAL = 5,
} layersplat_slice_axis;

/**
 * A cancellation flag for frames. Several threads may use it at the same time, also while its renderers are in use. Several
 * renderers may share one.
 */
typedef struct layersplat_cancel layersplat_cancel;

/**
 * A volume of colours or labels on a device. It is immutable, and several threads may use it at the same time.
 */
typedef struct layersplat_colors layersplat_colors;

/**
 * An OpenCL device with a context, a queue and its compiled kernels. Several threads may use it at the same time.
 */
typedef struct layersplat_device layersplat_device;

/**
 * Colours of labels on a device, for layersplat_renderer_set_label_colors(). It is immutable, and several threads may use it at the same time.
 */
typedef struct layersplat_label_colors layersplat_label_colors;

/**
 * Steps of a sequence that are read ahead on a thread. Only one thread may use it at a time: concurrent calls return
 * LAYERSPLAT_STATUS_BUSY.
 */
typedef struct layersplat_playback layersplat_playback;

/**
 * A renderer of one volume on one device. It may move between threads, but only one thread may use it at a time: concurrent calls
 * return LAYERSPLAT_STATUS_BUSY.
 */
typedef struct layersplat_renderer layersplat_renderer;

/**
 * Volumes of one size and type in the order of time. It is immutable, and several threads may use it at the same time.
 */
typedef struct layersplat_sequence layersplat_sequence;

/**
 * A transfer function: colour and opacity by data value. It is immutable, and several threads may use it at the same time.
 */
typedef struct layersplat_transfer layersplat_transfer;

/**
 * Voxels on a device, which several renderers and channels may share. It is immutable, and several threads may use it at the same time.
 */
typedef struct layersplat_uploaded layersplat_uploaded;

/**
 * A volume in host memory or in a file. It is immutable, and several threads may use it at the same time.
 */
typedef struct layersplat_volume layersplat_volume;

/**
 * The type that a cl_command_queue points to.
 */
typedef struct _cl_command_queue _cl_command_queue;

/**
 * The type that a cl_context points to.
 */
typedef struct _cl_context _cl_context;

/**
 * The type that a cl_device_id points to.
 */
typedef struct _cl_device_id _cl_device_id;

/**
 * The type that a cl_event points to.
 */
typedef struct _cl_event _cl_event;

/**
 * The type that a cl_mem points to.
 */
typedef struct _cl_mem _cl_mem;

/**
 * A viewing direction, in degrees. With all angles 0, the camera looks along −z.
 */
typedef struct layersplat_orbit {
  /**
   * Rotation about the y axis, degrees.
   */
  double azimuth;
  /**
   * Angle above the xz plane, degrees.
   */
  double elevation;
  /**
   * Rotation about the view direction, degrees.
   */
  double roll;
} layersplat_orbit;

/**
 * A camera in world coordinates. Fill it in, or use one of the functions layersplat_camera_….
 */
typedef struct layersplat_camera {
  /**
   * The eye. A parallel projection uses only the direction to the focal point.
   */
  double position[3];
  /**
   * The point at the centre of the picture.
   */
  double focal_point[3];
  /**
   * Any vector that points up in the picture.
   */
  double view_up[3];
  /**
   * A layersplat_projection.
   */
  int32_t projection;
  /**
   * Parallel: half the picture's height in world units. Perspective: the vertical field of view in degrees.
   */
  double extent;
} layersplat_camera;

/**
 * The grid of a volume. Voxel (i, j, k) lies at origin + i · hx · x + j · hy · y + k · hz · z, in world units, with the spacing
 * (hx, hy, hz) and the directions x, y, z.
 */
typedef struct layersplat_grid {
  /**
   * Number of voxels along x, y, z; x is the fastest in memory.
   */
  size_t dims[3];
  /**
   * World distance between neighbouring voxels along x, y, z.
   */
  double spacing[3];
  /**
   * World position of voxel (0, 0, 0).
   */
  double origin[3];
  /**
   * World directions of x, y, z in this order: orthonormal.
   */
  double direction[3][3];
} layersplat_grid;

/**
 * A field that is drawn together with others, and how it is shown. Initialise it with layersplat_channel_default() before changing fields:
 * later versions have more of them.
 */
typedef struct layersplat_channel {
  /**
   * Size of this struct in bytes in the program's header. layersplat_channel_default() sets it; do not change it.
   */
  size_t size;
  /**
   * Its voxels; not read with `colors`.
   */
  const struct layersplat_uploaded *volume;
  /**
   * Its transfer function; not read with `colors`.
   */
  const struct layersplat_transfer *transfer;
  /**
   * Factor of the extinction, at least 0.
   */
  double factor;
  /**
   * 1, or 0 to hide it. A hidden channel costs nothing.
   */
  int32_t visible;
  /**
   * 1: `iso_value` replaces that of the settings; 0: it does not.
   */
  int32_t has_iso_value;
  /**
   * Value of its iso-surface.
   */
  double iso_value;
  /**
   * Number of points of `gradient_opacity` in use; 0: the gradient opacity of the settings.
   */
  int32_t gradient_point_count;
  /**
   * Points of its gradient opacity function: gradient magnitude in values per world unit, ascending, and opacity factor.
   */
  double gradient_opacity[8][2];
  /**
   * Null, or colours or labels that are drawn together with the other channels. Of labels of several opacities, make a channel for each.
   */
  const struct layersplat_colors *colors;
} layersplat_channel;

/**
 * How colours become opaque.
 */
typedef struct layersplat_color_options {
  /**
   * A layersplat_color_opacity.
   */
  int32_t opacity;
  /**
   * The transparent colour of LAYERSPLAT_COLOR_OPACITY_BACKGROUND, 0 to 1.
   */
  double background[3];
  /**
   * Opacities by luminance or by the difference from the background, in units of the components; null: from 0 to 0.3.
   */
  const struct layersplat_transfer *transfer;
} layersplat_color_options;

/**
 * A directional light. Its angular diameter is in `light_angles`, and its colour in `light_colors` of layersplat_settings.
 */
typedef struct layersplat_light {
  /**
   * Direction towards the light, in world axes unless `lights_in_camera_space` is 1; (0, 0, 0) is a light at the camera.
   */
  double direction[3];
  /**
   * Factor of its diffuse and specular terms, from 0 to 100.
   */
  double strength;
} layersplat_light;

/**
 * A clipping plane in world coordinates. The side that the normal points to is shown.
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
 * Render settings. Initialise them with layersplat_settings_default() before changing fields: later versions have more of them.
 */
typedef struct layersplat_settings {
  /**
   * Size of this struct in bytes in the program's header. layersplat_settings_default() sets it; do not change it.
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
   * A layersplat_kernel, for layered splatting and ray casting.
   */
  int32_t kernel;
  /**
   * Layered splatting: 1 splats layers with post-classification, as published; 0 uses the quality's classification.
   */
  int32_t splatted;
  /**
   * A layersplat_blend.
   */
  int32_t blend;
  /**
   * Shading: 1 or 0.
   */
  int32_t lit;
  /**
   * Number of `lights` in use; 0: one light of strength 1 at the camera. With shadows it is beside the camera, where they are visible:
   * at (-1, 1, 1) in camera space.
   */
  int32_t light_count;
  /**
   * Early ray termination, at a transmittance below 1/4096: 1 or 0.
   */
  int32_t early_termination;
  /**
   * Cropping to the box from crop_lowest to crop_highest: 1 or 0.
   */
  int32_t cropped;
  /**
   * Number of `planes` in use.
   */
  int32_t plane_count;
  /**
   * Number of points of `gradient_opacity` in use; 0 disables gradient opacity.
   */
  int32_t gradient_point_count;
  /**
   * Distance between slices or samples along rays in units of the smallest spacing; between sheets in voxels. 0 is the
   * algorithm's default.
   */
  double step;
  /**
   * Iso-value of LAYERSPLAT_BLEND_ISO.
   */
  double iso_value;
  /**
   * Ambient coefficient.
   */
  double ambient;
  /**
   * Diffuse coefficient.
   */
  double diffuse;
  /**
   * Specular coefficient, of highlights in the colours of the lights.
   */
  double specular;
  /**
   * Specular exponent.
   */
  double power;
  /**
   * The lights.
   */
  struct layersplat_light lights[4];
  /**
   * Thickness in world units at which the given opacities apply; 0 is the smallest spacing.
   */
  double unit_distance;
  /**
   * Points of the gradient opacity function: gradient magnitude in values per world unit, ascending, and opacity factor.
   */
  double gradient_opacity[8][2];
  /**
   * Lowest corner of the crop box, in voxels.
   */
  double crop_lowest[3];
  /**
   * Highest corner of the crop box, in voxels.
   */
  double crop_highest[3];
  /**
   * Clipping planes. The side behind any of them is hidden.
   */
  struct layersplat_plane planes[6];
  /**
   * A layersplat_gradient, for layers and ray casting.
   */
  int32_t gradient;
  /**
   * Standard deviation of LAYERSPLAT_GRADIENT_GAUSSIAN in voxels of the smallest spacing, 0.3 to 2.
   */
  double gradient_sigma;
  /**
   * Depth cueing: share of depth_cue_color at the back of the volume's bounding box, from 0 (off) to 1. It rises linearly from 0 at the
   * front.
   */
  double depth_cue;
  /**
   * Colour that samples fade to, from 0 to 1: that of the picture's background.
   */
  double depth_cue_color[3];
  /**
   * Shadows of the lights: 1 or 0. They need shading, LAYERSPLAT_BLEND_COMPOSITE or _ISO, and layers or ray casting.
   */
  int32_t shadows;
  /**
   * Ambient occlusion, which dims the ambient light where little of the surroundings is open: 1 or 0. It needs what shadows need.
   */
  int32_t ambient_occlusion;
  /**
   * A layersplat_light_grid, for shadows and ambient occlusion.
   */
  int32_t light_grid;
  /**
   * Axes of the lights' directions. 1: right, up, towards the viewer: the lights move with the camera, and shadows are computed
   * again for each view. 0: world axes.
   */
  int32_t lights_in_camera_space;
  /**
   * Share of the shadows, from 0 to 1.
   */
  double shadow_strength;
  /**
   * Factor of the light in shadows, at most full light, from 1 to 1000. 1 is physically exact, and dark.
   */
  double shadow_forgiveness;
  /**
   * World distance over which ambient occlusion decreases to 1/e; 0 or infinity: no limit.
   */
  double ao_reach;
  /**
   * Factor of the share of the sky that reaches a point, at most all of it, from 1 to 1000. 3 shows open surfaces at full light: a point of
   * an opaque plane sees half of the sky at most.
   */
  double ao_gain;
  /**
   * Angular diameters of `lights` in degrees, from 0 to 45: how soft the edges of their shadows are.
   */
  double light_angles[4];
  /**
   * Red, green and blue of `lights`, from 0 to 1.
   */
  double light_colors[4][3];
  /**
   * Red, green and blue of the ambient light, from 0 to 1.
   */
  double ambient_color[3];
  /**
   * Gamma of 8-bit pictures, from 0.2 to 5: straight colours are raised to 1/gamma. Floats are unaffected.
   */
  double gamma;
  /**
   * A layersplat_look. The studio uses the lights: with none, a key light and a rim light beside the camera. It has no use for `ambient`,
   * `ambient_color`, `diffuse`, `specular` and `power`.
   */
  int32_t look;
  /**
   * A layersplat_tone of the studio.
   */
  int32_t tone;
  /**
   * Red, green and blue of the sky above, in linear light, from 0 to 100. Up is upwards in the picture, or, with
   * `lights` in world axes, along z.
   */
  double sky_top[3];
  /**
   * The same below.
   */
  double sky_bottom[3];
  /**
   * Factor of both, from 0 to 100.
   */
  double sky_strength;
  /**
   * Factor of the light that scatters again in the studio, from 0 to 1.
   */
  double scattering;
  /**
   * Exposure of 8-bit pictures of the studio in stops, from -20 to 20.
   */
  double exposure;
  /**
   * Share of the light that surfaces of the studio reflect as by a mirror, from 0 to 100.
   */
  double studio_specular;
  /**
   * Specular exponent of the studio, above 0.
   */
  double studio_power;
} layersplat_settings;

/**
 * A buffer or a 2D image of the caller that receives pictures: red, green, blue, alpha, row by row from the top.
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
   * Alpha of 8-bit pictures. 1: straight alpha. 0: composited over `background`.
   */
  int32_t transparent;
  /**
   * The opaque background colour of 8-bit pictures, 0 to 1.
   */
  float background[3];
  /**
   * Byte offset of the first pixel in a buffer; 0 for images.
   */
  size_t first;
  /**
   * Bytes from row to row in a buffer; 0 if rows are contiguous. 0 for images.
   */
  size_t row_pitch;
} layersplat_picture;

/**
 * Voxels in a buffer of the caller on the device. They are rendered in place, without a copy.
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
   * Whether voxels may be NaN, infinite or beyond ±1e30: 1 or 0. Such voxels count as the smallest value.
   */
  int32_t invalid_voxels;
  /**
   * Byte offset of the first voxel. Offset and pitches are multiples of the voxel size.
   */
  size_t first;
  /**
   * Bytes from row to row. If this and slice_pitch are 0, the voxels are contiguous.
   */
  size_t row_pitch;
  /**
   * Bytes from slice to slice.
   */
  size_t slice_pitch;
  /**
   * The grid of the voxels.
   */
  struct layersplat_grid grid;
  /**
   * The smallest value that voxels will have. It is not checked: values outside the range are clamped to it.
   */
  double smallest;
  /**
   * The largest value that voxels will have.
   */
  double largest;
} layersplat_voxels;

/**
 * A label.
 */
typedef struct layersplat_label {
  /**
   * Number of its voxels, at least 1; 0 is the background.
   */
  uint32_t id;
  /**
   * Red, green and blue, 0 to 1.
   */
  double color[3];
  /**
   * Opacity per smallest spacing, 0 to 1; 0 hides it.
   */
  double opacity;
} layersplat_label;

/**
 * A rectangle of a plane through a volume, in world coordinates. Fill it in, or use layersplat_slice_at() or
 * layersplat_slice_facing().
 */
typedef struct layersplat_slice {
  /**
   * The point at the centre of the picture.
   */
  double centre[3];
  /**
   * Direction that points right in the picture. Its length does not matter.
   */
  double right[3];
  /**
   * Any vector that points up in the picture.
   */
  double up[3];
  /**
   * Half the height of the picture in world units.
   */
  double scale;
} layersplat_slice;

/**
 * Colours of a slice: a window of grey, or those of the renderer's transfer function.
 */
typedef struct layersplat_slice_colors {
  /**
   * Value shown as middle grey.
   */
  double window_level;
  /**
   * Width of the window in data values: black below it, white above it. 0: colours of the transfer function.
   */
  double window_width;
  /**
   * Without a window: opacity of a layer this many unit distances thick. 0: opaque wherever there is any opacity.
   */
  double thickness;
} layersplat_slice_colors;

/**
 * How a frame uploads its volume. See layersplat_renderer_stream_plan().
 */
typedef struct layersplat_stream_plan {
  /**
   * Number of parts that are uploaded in sequence; 1: all voxels are on the device at once.
   */
  size_t parts;
  /**
   * Bytes of voxels that are read and uploaded, including the layers that neighbouring parts share. This and all fields below
   * are 0 if nothing is streamed.
   */
  uint64_t voxel_bytes;
  /**
   * Bytes of the whole volume's voxels.
   */
  uint64_t volume_bytes;
  /**
   * Peak bytes of buffers on the device.
   */
  uint64_t device_bytes;
  /**
   * Bytes available for these buffers: the memory budget minus the allocations of other renderers.
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
 * Message of the last failed call on this thread: UTF-8, empty if no call has failed. The text stays valid until the next failed
 * call on this thread, or until the thread ends. Do not free it.
 */
const char *layersplat_last_error(void);

/**
 * A camera at `distance` from `centre` (three world coordinates), looking at it. `projection` and `extent` are those of
 * layersplat_camera.
 */
enum layersplat_status layersplat_camera_orbit(const double *centre,
                                               double distance,
                                               struct layersplat_orbit angles,
                                               int32_t projection,
                                               double extent,
                                               struct layersplat_camera *camera);

/**
 * A camera that shows the whole grid in a picture of `width` x `height` pixels. The distance is the same for all angles.
 * `field_of_view` is the vertical angle of a perspective in degrees; 0 selects a parallel view.
 */
enum layersplat_status layersplat_camera_fit_grid(const struct layersplat_grid *grid,
                                                  struct layersplat_orbit angles,
                                                  double field_of_view,
                                                  uint32_t width,
                                                  uint32_t height,
                                                  struct layersplat_camera *camera);

/**
 * A camera that fits the visible part of a volume: all voxels that the transfer function does not make transparent. The call scans
 * the voxels. The other arguments are those of layersplat_camera_fit_grid().
 */
enum layersplat_status layersplat_camera_fit_visible(const struct layersplat_volume *volume,
                                                     const struct layersplat_transfer *transfer,
                                                     struct layersplat_orbit angles,
                                                     double field_of_view,
                                                     uint32_t width,
                                                     uint32_t height,
                                                     struct layersplat_camera *camera);

/**
 * Creates a cancellation flag that is not set. To be freed by layersplat_cancel_free().
 */
enum layersplat_status layersplat_cancel_new(struct layersplat_cancel **cancel);

/**
 * Attaches a cancellation flag to a renderer, effective from the next frame. Null detaches it. Enqueued frames cannot be cancelled.
 */
enum layersplat_status layersplat_renderer_set_cancel(struct layersplat_renderer *renderer,
                                                      const struct layersplat_cancel *cancel);

/**
 * Cancels the current frame and all later ones until layersplat_cancel_reset(). They return LAYERSPLAT_STATUS_CANCELLED and write
 * no pixels. A frame stops before its next kernel; a running kernel is not interrupted. The call does not block.
 */
enum layersplat_status layersplat_cancel_frames(const struct layersplat_cancel *cancel);

/**
 * Clears the flag. Later frames are rendered again.
 */
enum layersplat_status layersplat_cancel_reset(const struct layersplat_cancel *cancel);

/**
 * Frees a cancellation flag. Its renderers stay usable without it. Null is ignored.
 */
void layersplat_cancel_free(struct layersplat_cancel *cancel);

/**
 * Uploads a volume to a device, for channels. The volume may be freed afterwards. To be freed by layersplat_uploaded_free().
 */
enum layersplat_status layersplat_uploaded_new(const struct layersplat_device *device,
                                               const struct layersplat_volume *volume,
                                               struct layersplat_uploaded **uploaded);

/**
 * Frees voxels on a device. Renderers that draw them stay usable. Null is ignored.
 */
void layersplat_uploaded_free(struct layersplat_uploaded *uploaded);

/**
 * A visible channel with factor 1. `volume` and `transfer` are kept by the struct, and must stay until a call has used it; null for a channel
 * whose `colors` are set then. Pass
 * sizeof(layersplat_channel) as `size`.
 */
enum layersplat_status layersplat_channel_default(const struct layersplat_uploaded *volume,
                                                  const struct layersplat_transfer *transfer,
                                                  struct layersplat_channel *channel,
                                                  size_t size);

/**
 * Creates a renderer that draws 1 to 8 channels together, on the device of their voxels. Extinctions add, and colours are weighted by them;
 * the order does not matter. The grids may differ. Volumes and transfer functions may be freed afterwards. To be freed by
 * layersplat_renderer_free().
 */
enum layersplat_status layersplat_renderer_from_channels(const struct layersplat_channel *channels,
                                                         size_t count,
                                                         struct layersplat_renderer **renderer);

/**
 * Replaces all that a renderer draws by 1 to 8 channels, effective from the next frame. What belongs to voxels and transfer functions that
 * stay is not computed again. After an error the renderer keeps what it draws. Renderers that stream their volume return
 * LAYERSPLAT_STATUS_NEEDS_WHOLE_VOLUME.
 */
enum layersplat_status layersplat_renderer_set_channels(struct layersplat_renderer *renderer,
                                                        const struct layersplat_channel *channels,
                                                        size_t count);

/**
 * A transfer function for a channel: one colour (red, green, blue), 0 to 1, and an opacity that rises from the end of the background's noise
 * to the 99.9th percentile of the voxels. `ramp` 1: colours rise from black too, for LAYERSPLAT_BLEND_MAXIMUM, _MINIMUM and _AVERAGE; else
 * 0. To be freed by layersplat_transfer_free().
 */
enum layersplat_status layersplat_transfer_channel(const struct layersplat_volume *volume,
                                                   const double *color,
                                                   int32_t ramp,
                                                   struct layersplat_transfer **transfer);

/**
 * Colours of `count` channels, red, green and blue each, for layersplat_transfer_channel(). A fluorophore in a name has its usual colour (DAPI
 * is blue); other channels get well separated ones, also for the colour-blind. A single channel is white. Names may be null. `capacity` is the
 * number of values of `colors`, at least 3 `count`.
 */
enum layersplat_status layersplat_channel_colors(const char *const *names,
                                                 size_t count,
                                                 double *colors,
                                                 size_t capacity);

/**
 * Uploads colours. The voxels have `components` values each, red, green, blue and possibly alpha, contiguous and x fastest. `voxel_type` is a
 * layersplat_voxel_type: UINT8, UINT16, or FLOAT32 from 0 to 1; `bytes` is the total size. `options` may be null: alpha if there is one, else
 * luminance. Extinction times colour, and extinction, are interpolated, so transparent voxels do not bleed their colour. To be freed by
 * layersplat_colors_free().
 */
enum layersplat_status layersplat_colors_new(const struct layersplat_device *device,
                                             const void *voxels,
                                             size_t bytes,
                                             int32_t voxel_type,
                                             int32_t components,
                                             const struct layersplat_grid *grid,
                                             const struct layersplat_color_options *options,
                                             struct layersplat_colors **colors);

/**
 * Opens and uploads the colours of a file: red, green, blue and possibly alpha, its first three or four channels. Files of colours are PNG, TIFF
 * (RGB), NRRD, NIfTI (RGB24, RGBA32), DICOM and VTK; any other file of three channels or more is drawn so, too. `options` as in
 * layersplat_colors_new(). To be freed by layersplat_colors_free().
 */
enum layersplat_status layersplat_colors_open(const struct layersplat_device *device,
                                              const char *source,
                                              const struct layersplat_color_options *options,
                                              struct layersplat_colors **colors);

/**
 * The grid of colours or labels, for layersplat_camera_fit_grid().
 */
enum layersplat_status layersplat_colors_grid(const struct layersplat_colors *colors,
                                              struct layersplat_grid *grid);

/**
 * Frees colours or labels. Renderers that draw them stay usable. Null is ignored.
 */
void layersplat_colors_free(struct layersplat_colors *colors);

/**
 * Creates a renderer of colours or labels, on their device. They are drawn by layers, with LAYERSPLAT_BLEND_COMPOSITE. To be freed by
 * layersplat_renderer_free().
 */
enum layersplat_status layersplat_renderer_from_colors(const struct layersplat_colors *colors,
                                                       struct layersplat_renderer **renderer);

/**
 * Replaces all that a renderer draws by colours or labels, effective from the next frame. Renderers that stream their volume return
 * LAYERSPLAT_STATUS_NEEDS_WHOLE_VOLUME.
 */
enum layersplat_status layersplat_renderer_set_colors(struct layersplat_renderer *renderer,
                                                      const struct layersplat_colors *colors);

/**
 * Opens a device with its own context and queue. `name` is an index, or part of a device or platform name (case-insensitive). Null
 * selects the first GPU, or the first CPU if there is no GPU. To be freed by layersplat_device_free().
 */
enum layersplat_status layersplat_device_open(const char *name,
                                              struct layersplat_device **device);

/**
 * Creates a device from a cl_command_queue of the caller. All commands go to this queue, which may be in-order or out-of-order.
 * `context` and `id` are the queue's cl_context and cl_device_id, checked against it; null skips the check.
 *
 * Queue and context are retained. They are released when the device and all its renderers are freed. To be freed by
 * layersplat_device_free().
 */
enum layersplat_status layersplat_device_from_queue(struct _cl_context *context,
                                                    struct _cl_device_id *id,
                                                    struct _cl_command_queue *queue,
                                                    struct layersplat_device **device);

/**
 * A handle to the same device with a memory budget: the buffers of all renderers made with it take at most `bytes` together.
 * Volumes that do not fit are streamed in parts; the picture is identical. Streaming supports layers on a lattice. Views and
 * settings that need all voxels at once return LAYERSPLAT_STATUS_OUT_OF_MEMORY, and the message states how many bytes are enough.
 * Calls that need the whole volume return LAYERSPLAT_STATUS_NEEDS_WHOLE_VOLUME. Each handle has its own budget. To be freed by
 * layersplat_device_free().
 */
enum layersplat_status layersplat_device_with_memory(const struct layersplat_device *device,
                                                     uint64_t bytes,
                                                     struct layersplat_device **limited);

/**
 * Copies the name of the device, zero-terminated, to `name`, an array of `capacity` bytes.
 */
enum layersplat_status layersplat_device_name(const struct layersplat_device *device,
                                              char *name,
                                              size_t capacity);

/**
 * The device's cl_context, for example to create buffers for voxels and pictures. It is not retained: it lives as long as the
 * device. Null if `device` is null.
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
 * Frees a device. Renderers that were made from it stay usable. Null is ignored.
 */
void layersplat_device_free(struct layersplat_device *device);

/**
 * Enqueues a frame into device memory of the caller, after `wait_count` events, and returns without waiting. If `event` is not
 * null, it receives a cl_event that completes when the picture is written; the caller releases it with clReleaseEvent. Nothing is
 * read back to the host. The arguments may change as soon as the call returns.
 *
 * Missing kernels are built first, which takes seconds: layersplat_renderer_prepare() builds them in advance. Sheet-buffer
 * splatting cannot be enqueued. After an error the queue is usable, the picture is undefined, and there is no event.
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
 * Builds the kernels and tables that frames with these settings need, for every view direction. The call blocks until they are
 * ready.
 */
enum layersplat_status layersplat_renderer_prepare(struct layersplat_renderer *renderer,
                                                   const struct layersplat_camera *camera,
                                                   uint32_t width,
                                                   uint32_t height,
                                                   const struct layersplat_settings *settings);

/**
 * Notifies a renderer of layersplat_renderer_in_place() that its voxels have changed, or will have changed after `wait_count`
 * events. Later frames use the new voxels. If `event` is not null, it receives a cl_event that completes when those events have;
 * the caller releases it. Frames wait for it automatically.
 */
enum layersplat_status layersplat_renderer_volume_changed(struct layersplat_renderer *renderer,
                                                          uint32_t wait_count,
                                                          struct _cl_event *const *wait_list,
                                                          struct _cl_event **event);

/**
 * Sizes in bytes of the scratch buffers that a frame needs. `sizes` is an array of `capacity` elements; `count` is set to the number
 * of buffers. If `capacity` is 0, only `count` is set. The renderer's own tables are not included.
 */
enum layersplat_status layersplat_renderer_scratch_sizes(struct layersplat_renderer *renderer,
                                                         const struct layersplat_camera *camera,
                                                         uint32_t width,
                                                         uint32_t height,
                                                         const struct layersplat_settings *settings,
                                                         const struct layersplat_picture *picture,
                                                         size_t *sizes,
                                                         size_t capacity,
                                                         size_t *count);

/**
 * Sets the cl_mem scratch buffers of enqueued frames: one for each size of layersplat_renderer_scratch_sizes(), in any order. They
 * are retained. If `count` is 0, the renderer allocates its own again. Renderers whose frames may run concurrently must not share
 * scratch buffers.
 */
enum layersplat_status layersplat_renderer_set_scratch(struct layersplat_renderer *renderer,
                                                       struct _cl_mem *const *buffers,
                                                       size_t count);

/**
 * An axis-aligned grid at the origin: the number of voxels and their spacing along x, y, z.
 */
struct layersplat_grid layersplat_grid_at_origin(size_t nx,
                                                 size_t ny,
                                                 size_t nz,
                                                 double hx,
                                                 double hy,
                                                 double hz);

/**
 * Determines the range of the voxels on the device, after `wait_count` events. Sets `smallest`, `largest` and `invalid_voxels`.
 * The call blocks until they are known.
 */
enum layersplat_status layersplat_voxels_find_range(const struct layersplat_device *device,
                                                    struct layersplat_voxels *voxels,
                                                    uint32_t wait_count,
                                                    struct _cl_event *const *wait_list);

/**
 * Creates a renderer of voxels in a buffer of the caller, without copying them. The voxels may change between frames, ordered by
 * the queue and events. Call layersplat_renderer_volume_changed() after each change. To be freed by layersplat_renderer_free().
 */
enum layersplat_status layersplat_renderer_in_place(const struct layersplat_device *device,
                                                    const struct layersplat_voxels *voxels,
                                                    const struct layersplat_transfer *transfer,
                                                    struct layersplat_renderer **renderer);

/**
 * Uploads labels, which are drawn with `surfaces`, a layersplat_label_surfaces. Voxels are ids, of LAYERSPLAT_VOXEL_TYPE_UINT8 or _UINT16, contiguous and x fastest;
 * `bytes` is the total size. Ids without a label are opaque, in a colour that depends on the id. To be freed by layersplat_colors_free().
 */
enum layersplat_status layersplat_labels_new(const struct layersplat_device *device,
                                             const void *voxels,
                                             size_t bytes,
                                             int32_t voxel_type,
                                             const struct layersplat_grid *grid,
                                             const struct layersplat_label *labels,
                                             size_t label_count,
                                             int32_t surfaces,
                                             struct layersplat_colors **colors);

/**
 * Opens and uploads a file of labels: .seg.nrrd, NIfTI, OME-Zarr, or any volume of whole numbers up to 4294967295. Names and colours come from
 * the file `table`; null: from the volume's own metadata. `changes` are texts that change the table, such as 3,7-9:#ff0000:0.4 or liver:only:
 * colour, opacity, and show, hide, only or highlight. `surfaces`: as for layersplat_labels_new(). To be freed by layersplat_colors_free().
 */
enum layersplat_status layersplat_labels_open(const struct layersplat_device *device,
                                              const char *source,
                                              const char *table,
                                              const char *const *changes,
                                              size_t change_count,
                                              int32_t surfaces,
                                              struct layersplat_colors **colors);

/**
 * Uploads the colours of labels, which a volume is drawn in: one or two bytes per voxel. The arguments are those of layersplat_labels_new(),
 * without surfaces. To be freed by layersplat_label_colors_free().
 */
enum layersplat_status layersplat_label_colors_new(const struct layersplat_device *device,
                                                   const void *voxels,
                                                   size_t bytes,
                                                   int32_t voxel_type,
                                                   const struct layersplat_grid *grid,
                                                   const struct layersplat_label *labels,
                                                   size_t label_count,
                                                   struct layersplat_label_colors **colors);

/**
 * Opens a file of labels and uploads their colours, which a volume is drawn in. The arguments are those of layersplat_labels_open(),
 * without surfaces. To be freed by layersplat_label_colors_free().
 */
enum layersplat_status layersplat_label_colors_open(const struct layersplat_device *device,
                                                    const char *source,
                                                    const char *table,
                                                    const char *const *changes,
                                                    size_t change_count,
                                                    struct layersplat_label_colors **colors);

/**
 * Frees colours of labels. Renderers that draw in them stay usable. Null is ignored.
 */
void layersplat_label_colors_free(struct layersplat_label_colors *colors);

/**
 * Draws the volume of a renderer in the colours of labels, effective from the next frame; null: in its own again. Its opacities stay. The
 * colour C of the volume becomes (1 - w) C + w L where a label has the colour L and the opacity w, before lighting. Labels of the volume's size
 * at unit spacing and the origin lie where the volume does; those outside the volume return LAYERSPLAT_STATUS_FILE.
 * Pre-integrated layers and cast rays have them, with LAYERSPLAT_BLEND_COMPOSITE and _ISO; other frames, slices, and frames of several
 * channels or of colours return LAYERSPLAT_STATUS_INVALID_ARGUMENT. Renderers that stream their volume return
 * LAYERSPLAT_STATUS_NEEDS_WHOLE_VOLUME.
 */
enum layersplat_status layersplat_renderer_set_label_colors(struct layersplat_renderer *renderer,
                                                            const struct layersplat_label_colors *colors);

/**
 * Renders a picture of `width` x `height` pixels with 8 bits per channel: red, green, blue, alpha, contiguous, row by row from the
 * top. `background` is an opaque colour (three floats, 0 to 1), or null for straight alpha. `bytes` is the size of `pixels`: at
 * least 4 * width * height. Null settings are those of the standard quality. The call blocks until the picture is complete.
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
 * Renders a picture of floats: premultiplied red, green, blue, and alpha, without a background, contiguous, row by row from the top.
 * `floats` is the number of elements of `pixels`: at least 4 * width * height. The other arguments are those of
 * layersplat_render_rgba8().
 */
enum layersplat_status layersplat_render_floats(struct layersplat_renderer *renderer,
                                                const struct layersplat_camera *camera,
                                                uint32_t width,
                                                uint32_t height,
                                                const struct layersplat_settings *settings,
                                                float *pixels,
                                                size_t floats);

/**
 * Renders depth maps: distances from the eye along the view direction in world units, row by row from the top, infinite where
 * nothing is visible. `first` is the first visible depth: where the accumulated opacity reaches 1/256, or at the iso-surface.
 * `mean` is the mean depth weighted by opacity. `floats` is the number of elements of each: at least width * height. Depths are
 * always computed by ray casting. Only the blend modes composite and iso are supported. The other arguments are those of
 * layersplat_render_rgba8().
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
 * Writes a picture of layersplat_render_floats() to a file: .png, .jpg, .tif or .webp (8 bit), .exr or .npy (float32). `settings`: those of
 * the picture, whose exposure, tone curve and gamma go into files of 8 bit; null: those of the default, which has none.
 * `background` is an opaque colour (three floats, 0 to 1), or null to keep alpha. `floats` is 4 * width * height. The file is
 * written completely or not at all.
 */
enum layersplat_status layersplat_save(const float *pixels,
                                       size_t floats,
                                       uint32_t width,
                                       uint32_t height,
                                       const struct layersplat_settings *settings,
                                       const float *background,
                                       const char *path);

/**
 * Creates a renderer of a volume with a transfer function. Device, volume and transfer function may be freed afterwards. To be freed
 * by layersplat_renderer_free().
 *
 * The voxels are uploaded immediately. They are uploaded during frames instead if the device has a memory budget
 * (layersplat_device_with_memory()) or the volume exceeds the largest buffer of the device: completely if they fit, otherwise in
 * parts.
 */
enum layersplat_status layersplat_renderer_new(const struct layersplat_device *device,
                                               const struct layersplat_volume *volume,
                                               const struct layersplat_transfer *transfer,
                                               struct layersplat_renderer **renderer);

/**
 * Sets the transfer function, effective from the next frame.
 */
enum layersplat_status layersplat_renderer_set_transfer(struct layersplat_renderer *renderer,
                                                        const struct layersplat_transfer *transfer);

/**
 * Replaces the volume, effective from the next frame. Size, type and range may differ. The volume may be freed afterwards. If memory
 * is insufficient, the renderer may have no volume: frames then return an error until a volume is set.
 */
enum layersplat_status layersplat_renderer_set_volume(struct layersplat_renderer *renderer,
                                                      const struct layersplat_volume *volume);

/**
 * Sets the time limit per frame in seconds, effective from the next frame; 0: no limit. A frame that exceeds it returns
 * LAYERSPLAT_STATUS_TOO_LONG before its next kernel; a running kernel is not interrupted. Enqueued frames are not limited. To end a
 * frame from another thread, use layersplat_cancel_frames().
 */
enum layersplat_status layersplat_renderer_limit(struct layersplat_renderer *renderer,
                                                 double seconds);

/**
 * Frees a renderer and its device memory. No call may be using it. Enqueued frames still complete. Null is ignored.
 */
void layersplat_renderer_free(struct layersplat_renderer *renderer);

/**
 * Opens the frames of `count` sources as one sequence. A source is what layersplat_volume_open() takes: a file with a time axis has a step
 * per frame, and a .pvd of ParaView and NAME%d.EXT have those of all their files. Only headers are read; a step is read when it is asked
 * for. All steps must have the same size and type. To be freed by layersplat_sequence_free().
 */
enum layersplat_status layersplat_sequence_open(const char *const *sources,
                                                size_t count,
                                                struct layersplat_sequence **sequence);

/**
 * Number of steps, at least 1.
 */
enum layersplat_status layersplat_sequence_length(const struct layersplat_sequence *sequence, size_t *length);

/**
 * Reads a step, counted from 0. To be freed by layersplat_volume_free().
 */
enum layersplat_status layersplat_sequence_step(const struct layersplat_sequence *sequence,
                                                size_t step,
                                                struct layersplat_volume **volume);

/**
 * A volume with the values of all steps, or of 16 from the first to the last, for layersplat_transfer_automatic() and
 * layersplat_transfer_open(). It is not to be drawn. To be freed by layersplat_volume_free().
 */
enum layersplat_status layersplat_sequence_overview(const struct layersplat_sequence *sequence,
                                                    struct layersplat_volume **volume);

/**
 * Frees a sequence. Volumes and playbacks that were made from it stay usable. Null is ignored.
 */
void layersplat_sequence_free(struct layersplat_sequence *sequence);

/**
 * Reads a step and makes it the volume of a renderer, effective from the next frame, as layersplat_renderer_set_volume() does.
 */
enum layersplat_status layersplat_renderer_set_step(struct layersplat_renderer *renderer,
                                                    const struct layersplat_sequence *sequence,
                                                    size_t step);

/**
 * Starts to read `count` steps, in any order, on a thread of its own: each while the program uses the one before. The sequence may be freed
 * afterwards. To be freed by layersplat_playback_free().
 */
enum layersplat_status layersplat_sequence_play(const struct layersplat_sequence *sequence,
                                                const size_t *steps,
                                                size_t count,
                                                struct layersplat_playback **playback);

/**
 * The next step, once it is read: a volume to be freed by layersplat_volume_free(), or null after the last one. Fails if the step cannot be
 * read; the next call returns the step after it.
 */
enum layersplat_status layersplat_playback_next(struct layersplat_playback *playback,
                                                struct layersplat_volume **volume);

/**
 * Frees a playback, after the step that is being read. Null is ignored.
 */
void layersplat_playback_free(struct layersplat_playback *playback);

/**
 * Default settings of a layersplat_quality: composited, lit from the camera, without clipping. Pass sizeof(layersplat_settings) as
 * `size`: a program compiled with an older header gets the fields of that header, and one with a newer header than this library an error.
 */
enum layersplat_status layersplat_settings_default(int32_t quality,
                                                   struct layersplat_settings *settings,
                                                   size_t size);

/**
 * The slice perpendicular to an axis (a layersplat_slice_axis). `at`: for x, y and z the number of a slice of voxels, or any number
 * between two; for axial, coronal and sagittal the world coordinate along the axis. NaN: the middle. The slice shows the whole volume.
 */
enum layersplat_status layersplat_slice_at(const struct layersplat_volume *volume,
                                           int32_t axis,
                                           double at,
                                           uint32_t width,
                                           uint32_t height,
                                           struct layersplat_slice *slice);

/**
 * The slice through a world point (three numbers), seen from where `normal` points; `up` points up as far as possible. It shows the
 * whole section through the volume.
 */
enum layersplat_status layersplat_slice_facing(const struct layersplat_volume *volume,
                                               const double *point,
                                               const double *normal,
                                               const double *up,
                                               uint32_t width,
                                               uint32_t height,
                                               struct layersplat_slice *slice);

/**
 * Draws a slice as floats: premultiplied red, green, blue, and alpha, transparent outside the volume, contiguous, row by row from the
 * top. `kernel` is a layersplat_kernel; automatic is linear. Null colours are those of the transfer function, opaque. `floats` is the
 * number of elements of `pixels`: at least 4 * width * height. The call blocks until the picture is complete. The renderer must hold
 * the whole volume.
 */
enum layersplat_status layersplat_render_slice(struct layersplat_renderer *renderer,
                                               const struct layersplat_slice *slice,
                                               uint32_t width,
                                               uint32_t height,
                                               int32_t kernel,
                                               const struct layersplat_slice_colors *colors,
                                               float *pixels,
                                               size_t floats);

/**
 * The data values of a slice, one per pixel, NaN outside the volume. `floats` is the number of elements of `values`: at least
 * width * height. The other arguments are those of layersplat_render_slice().
 */
enum layersplat_status layersplat_slice_values(struct layersplat_renderer *renderer,
                                               const struct layersplat_slice *slice,
                                               uint32_t width,
                                               uint32_t height,
                                               int32_t kernel,
                                               float *values,
                                               size_t floats);

/**
 * The streaming plan of a frame, without rendering it. Returns the same out-of-memory errors as rendering would.
 */
enum layersplat_status layersplat_renderer_stream_plan(struct layersplat_renderer *renderer,
                                                       const struct layersplat_camera *camera,
                                                       uint32_t width,
                                                       uint32_t height,
                                                       const struct layersplat_settings *settings,
                                                       struct layersplat_stream_plan *plan);

/**
 * A default transfer function from the histogram of a volume. To be freed by layersplat_transfer_free().
 */
enum layersplat_status layersplat_transfer_automatic(const struct layersplat_volume *volume,
                                                     struct layersplat_transfer **transfer);

/**
 * Opens a built-in transfer function by name, or a ParaView colour map: FILE or FILE#PRESET. The error message for an unknown name
 * lists the built-in ones. These span the range of `volume`, or 0 to 1 if it is null (see layersplat_transfer_stretched()). To be
 * freed by layersplat_transfer_free().
 */
enum layersplat_status layersplat_transfer_open(const char *source,
                                                const struct layersplat_volume *volume,
                                                struct layersplat_transfer **transfer);

/**
 * Creates a piecewise linear transfer function, constant beyond its end points. At least one point each, ascending by value. Two
 * points at the same value make a step. To be freed by layersplat_transfer_free().
 */
enum layersplat_status layersplat_transfer_points(const struct layersplat_color_point *colors,
                                                  size_t color_count,
                                                  const struct layersplat_opacity_point *opacities,
                                                  size_t opacity_count,
                                                  struct layersplat_transfer **transfer);

/**
 * A copy of a transfer function, mapped linearly to the range from `smallest` to `largest`. To be freed by
 * layersplat_transfer_free().
 */
enum layersplat_status layersplat_transfer_stretched(const struct layersplat_transfer *transfer,
                                                     double smallest,
                                                     double largest,
                                                     struct layersplat_transfer **stretched);

/**
 * Frees a transfer function. Renderers keep a copy. Null is ignored.
 */
void layersplat_transfer_free(struct layersplat_transfer *transfer);

/**
 * Creates a volume from a copy of voxels. `voxel_type` is a layersplat_voxel_type and `bytes` is the total size. Voxels are
 * contiguous, x fastest, in native byte order. To be freed by layersplat_volume_free().
 */
enum layersplat_status layersplat_volume_copy(const void *voxels,
                                              size_t bytes,
                                              int32_t voxel_type,
                                              const struct layersplat_grid *grid,
                                              struct layersplat_volume **volume);

/**
 * Creates a volume like layersplat_volume_copy(), but without a copy. The voxels must stay valid and unchanged until the volume is
 * freed. A renderer normally keeps a copy on the device. A renderer that streams the volume (layersplat_renderer_new()) reads the
 * voxels in every frame: they must also stay until that renderer is freed.
 */
enum layersplat_status layersplat_volume_borrow(const void *voxels,
                                                size_t bytes,
                                                int32_t voxel_type,
                                                const struct layersplat_grid *grid,
                                                struct layersplat_volume **volume);

/**
 * Opens builtin:NAME, builtin:NAME@SIZE (voxels along each side) or a volume file. Uncompressed files are memory-mapped: they must
 * not be truncated before the volume and all renderers that stream it are freed. To be freed by layersplat_volume_free().
 */
enum layersplat_status layersplat_volume_open(const char *source,
                                              struct layersplat_volume **volume);

/**
 * Opens a Zarr like layersplat_volume_open(), or a part of it as if it were all: `region` is x0, x1, y0, y1, z0, z1 in voxels of level 0,
 * without the last ones, or null for all. Of URLs, `download` is the most bytes of voxels, 0 for 2 GB, and chunks that the server refuses are
 * an error unless `fills_refused` is 1: then they count as not stored. To be freed by layersplat_volume_free().
 */
enum layersplat_status layersplat_volume_open_part(const char *source,
                                                   const size_t *region,
                                                   uint64_t download,
                                                   int32_t fills_refused,
                                                   struct layersplat_volume **volume);

/**
 * The grid of a volume.
 */
enum layersplat_status layersplat_volume_grid(const struct layersplat_volume *volume,
                                              struct layersplat_grid *grid);

/**
 * The smallest and the largest value of all valid voxels.
 */
enum layersplat_status layersplat_volume_range(const struct layersplat_volume *volume,
                                               double *smallest,
                                               double *largest);

/**
 * Frees a volume. Renderers that were made from it stay usable. Null is ignored.
 */
void layersplat_volume_free(struct layersplat_volume *volume);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* LAYERSPLAT_H */
