// The C++ side of the device: each virtual function calls a function of src/boundary.rs, which has the same arguments.

#include "anari/backend/DeviceImpl.h"
#include "anari/backend/LibraryImpl.h"

// The device in Rust.
struct Device;

extern "C" {
Device *layersplat_anari_new(void *handle, ANARIStatusCallback, const void *user, const char *subtype);
void layersplat_anari_free(Device *);
void *layersplat_anari_new_array(Device *, const void *memory, ANARIMemoryDeleter, const void *user, int element, uint64_t, uint64_t,
    uint64_t, int dimensions);
void *layersplat_anari_new_object(Device *, int type, const char *subtype);
void layersplat_anari_set_parameter(Device *, void *object, const char *name, int type, const void *value);
void layersplat_anari_unset_parameter(Device *, void *object, const char *name);
void layersplat_anari_unset_all_parameters(Device *, void *object);
void *layersplat_anari_map_parameter_array(Device *, void *object, const char *name, int element, uint64_t, uint64_t, uint64_t,
    int dimensions, uint64_t *stride);
void layersplat_anari_unmap_parameter_array(Device *, void *object, const char *name);
void layersplat_anari_commit(Device *, void *object);
// Returns 1 if this was the last reference to the device.
int layersplat_anari_release(Device *, void *object);
void layersplat_anari_retain(Device *, void *object);
void *layersplat_anari_map_array(Device *, void *array);
void layersplat_anari_unmap_array(Device *, void *array);
int layersplat_anari_get_property(Device *, void *object, const char *name, int type, void *memory, uint64_t size, uint32_t wait);
const char **layersplat_anari_subtypes(int type);
const void *layersplat_anari_object_info(int type, const char *subtype, const char *info, int info_type);
const void *layersplat_anari_parameter_info(int type, const char *subtype, const char *parameter, int parameter_type, const char *info,
    int info_type);
const void *layersplat_anari_map_frame(Device *, void *frame, const char *channel, uint32_t *width, uint32_t *height, int *type);
void layersplat_anari_unmap_frame(Device *, void *frame, const char *channel);
void layersplat_anari_render_frame(Device *, void *frame);
int layersplat_anari_frame_ready(Device *, void *frame, uint32_t wait);
void layersplat_anari_discard_frame(Device *, void *frame);
const char **layersplat_anari_extensions();
void *layersplat_anari_shim_new_library(void *library, ANARIStatusCallback, const void *user);
}

namespace {

struct ShimDevice : anari::DeviceImpl
{
  ShimDevice(ANARILibrary library, const char *subtype) : DeviceImpl(library)
  {
    device = layersplat_anari_new(this, defaultStatusCallback(), defaultStatusCallbackUserPtr(), subtype);
  }
  ~ShimDevice() override { layersplat_anari_free(device); }

  ANARIArray1D newArray1D(const void *m, ANARIMemoryDeleter d, const void *u, ANARIDataType t, uint64_t n) override
  {
    return (ANARIArray1D)layersplat_anari_new_array(device, m, d, u, t, n, 1, 1, 1);
  }
  ANARIArray2D newArray2D(const void *m, ANARIMemoryDeleter d, const void *u, ANARIDataType t, uint64_t n1, uint64_t n2) override
  {
    return (ANARIArray2D)layersplat_anari_new_array(device, m, d, u, t, n1, n2, 1, 2);
  }
  ANARIArray3D newArray3D(
      const void *m, ANARIMemoryDeleter d, const void *u, ANARIDataType t, uint64_t n1, uint64_t n2, uint64_t n3) override
  {
    return (ANARIArray3D)layersplat_anari_new_array(device, m, d, u, t, n1, n2, n3, 3);
  }
  ANARIGeometry newGeometry(const char *s) override { return (ANARIGeometry)make(ANARI_GEOMETRY, s); }
  ANARIMaterial newMaterial(const char *s) override { return (ANARIMaterial)make(ANARI_MATERIAL, s); }
  ANARISampler newSampler(const char *s) override { return (ANARISampler)make(ANARI_SAMPLER, s); }
  ANARISurface newSurface() override { return (ANARISurface)make(ANARI_SURFACE, nullptr); }
  ANARISpatialField newSpatialField(const char *s) override { return (ANARISpatialField)make(ANARI_SPATIAL_FIELD, s); }
  ANARIVolume newVolume(const char *s) override { return (ANARIVolume)make(ANARI_VOLUME, s); }
  ANARILight newLight(const char *s) override { return (ANARILight)make(ANARI_LIGHT, s); }
  ANARIGroup newGroup() override { return (ANARIGroup)make(ANARI_GROUP, nullptr); }
  ANARIInstance newInstance(const char *s) override { return (ANARIInstance)make(ANARI_INSTANCE, s); }
  ANARIWorld newWorld() override { return (ANARIWorld)make(ANARI_WORLD, nullptr); }
  ANARICamera newCamera(const char *s) override { return (ANARICamera)make(ANARI_CAMERA, s); }
  ANARIRenderer newRenderer(const char *s) override { return (ANARIRenderer)make(ANARI_RENDERER, s); }
  ANARIFrame newFrame() override { return (ANARIFrame)make(ANARI_FRAME, nullptr); }

  void setParameter(ANARIObject o, const char *name, ANARIDataType type, const void *value) override
  {
    layersplat_anari_set_parameter(device, o, name, type, value);
  }
  void unsetParameter(ANARIObject o, const char *name) override { layersplat_anari_unset_parameter(device, o, name); }
  void unsetAllParameters(ANARIObject o) override { layersplat_anari_unset_all_parameters(device, o); }
  void *mapParameterArray1D(ANARIObject o, const char *name, ANARIDataType t, uint64_t n, uint64_t *stride) override
  {
    return layersplat_anari_map_parameter_array(device, o, name, t, n, 1, 1, 1, stride);
  }
  void *mapParameterArray2D(ANARIObject o, const char *name, ANARIDataType t, uint64_t n1, uint64_t n2, uint64_t *stride) override
  {
    return layersplat_anari_map_parameter_array(device, o, name, t, n1, n2, 1, 2, stride);
  }
  void *mapParameterArray3D(
      ANARIObject o, const char *name, ANARIDataType t, uint64_t n1, uint64_t n2, uint64_t n3, uint64_t *stride) override
  {
    return layersplat_anari_map_parameter_array(device, o, name, t, n1, n2, n3, 3, stride);
  }
  void unmapParameterArray(ANARIObject o, const char *name) override { layersplat_anari_unmap_parameter_array(device, o, name); }
  void commitParameters(ANARIObject o) override { layersplat_anari_commit(device, o); }
  void release(ANARIObject o) override
  {
    if (layersplat_anari_release(device, o))
      delete this;
  }
  void retain(ANARIObject o) override { layersplat_anari_retain(device, o); }
  void *mapArray(ANARIArray a) override { return layersplat_anari_map_array(device, a); }
  void unmapArray(ANARIArray a) override { layersplat_anari_unmap_array(device, a); }
  int getProperty(ANARIObject o, const char *name, ANARIDataType type, void *memory, uint64_t size, ANARIWaitMask wait) override
  {
    return layersplat_anari_get_property(device, o, name, type, memory, size, wait);
  }

  const char **getObjectSubtypes(ANARIDataType type) override { return layersplat_anari_subtypes(type); }
  const void *getObjectInfo(ANARIDataType type, const char *subtype, const char *info, ANARIDataType infoType) override
  {
    return layersplat_anari_object_info(type, subtype, info, infoType);
  }
  const void *getParameterInfo(ANARIDataType type, const char *subtype, const char *parameter, ANARIDataType parameterType,
      const char *info, ANARIDataType infoType) override
  {
    return layersplat_anari_parameter_info(type, subtype, parameter, parameterType, info, infoType);
  }

  const void *frameBufferMap(ANARIFrame f, const char *channel, uint32_t *width, uint32_t *height, ANARIDataType *type) override
  {
    int found = ANARI_UNKNOWN;
    const void *pixels = layersplat_anari_map_frame(device, f, channel, width, height, &found);
    if (type)
      *type = found;
    return pixels;
  }
  void frameBufferUnmap(ANARIFrame f, const char *channel) override { layersplat_anari_unmap_frame(device, f, channel); }
  void renderFrame(ANARIFrame f) override { layersplat_anari_render_frame(device, f); }
  int frameReady(ANARIFrame f, ANARIWaitMask wait) override { return layersplat_anari_frame_ready(device, f, wait); }
  void discardFrame(ANARIFrame f) override { layersplat_anari_discard_frame(device, f); }

 private:
  void *make(ANARIDataType type, const char *subtype) { return layersplat_anari_new_object(device, type, subtype); }

  Device *device{nullptr};
};

struct ShimLibrary : anari::LibraryImpl
{
  using LibraryImpl::LibraryImpl;

  ANARIDevice newDevice(const char *subtype) override { return (ANARIDevice) new ShimDevice(this_library(), subtype); }
  const char **getDeviceExtensions(const char *) override { return layersplat_anari_extensions(); }
};

} // namespace

// Called by the entry point, which is in Rust because a Rust library exports its own functions only.
void *layersplat_anari_shim_new_library(void *library, ANARIStatusCallback callback, const void *user)
{
  return (ANARILibrary) new ShimLibrary(library, callback, user);
}
