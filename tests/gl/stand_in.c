/* An OpenCL layer (OPENCL_LAYERS) that emulates cl_khr_gl_sharing on an implementation without it. It reports the extension, enforces the
 * ownership rules of the specification, and copies released images into their textures through the host. The sharing path can thus be
 * tested without a device that supports sharing. The layer tests neither its speed nor the conformance of a driver.
 *
 * Not thread-safe: scripts/gl runs the tests sequentially. */
#define CL_TARGET_OPENCL_VERSION 300
#include <CL/cl_gl.h>
#include <CL/cl_layer.h>
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST 256
#define GL_TEXTURE_2D 0x0de1
#define GL_TEXTURE_BINDING_2D 0x8069
#define GL_TEXTURE_WIDTH 0x1000
#define GL_TEXTURE_HEIGHT 0x1001
#define GL_RGBA 0x1908
#define GL_UNSIGNED_BYTE 0x1401

static const cl_icd_dispatch *below;
static cl_icd_dispatch layer;

static struct shared { cl_context context; cl_context_properties properties[16]; size_t bytes; } contexts[MOST];
static struct texture { cl_mem memory; cl_uint name; size_t width, height; int acquired; } textures[MOST];

static void *of_egl(const char *name) {
    void *egl = dlopen("libEGL.so.1", RTLD_NOW);
    void *function = egl ? dlsym(egl, name) : NULL;
    if (!function) { fprintf(stderr, "stand_in: no %s\n", name); abort(); }
    return function;
}

/* libGL has the functions of OpenGL and GLX. With libglvnd, they also apply to EGL contexts. */
static void *of_gl(const char *name) {
    void *gl = dlopen("libGL.so.1", RTLD_NOW);
    void *function = gl ? dlsym(gl, name) : NULL;
    if (!function) { fprintf(stderr, "stand_in: no %s\n", name); abort(); }
    return function;
}

static cl_context_properties asked(void *function) {
    return (cl_context_properties)((void *(*)(void))function)();
}

/* Whether a context and its EGL or GLX display are current. */
static int is_current(cl_context_properties context, cl_context_properties egl, cl_context_properties glx) {
    if (!context || !egl == !glx) return 0;
    return egl ? context == asked(of_egl("eglGetCurrentContext")) && egl == asked(of_egl("eglGetCurrentDisplay"))
               : context == asked(of_gl("glXGetCurrentContext")) && glx == asked(of_gl("glXGetCurrentDisplay"));
}

static struct shared *shared(cl_context context) {
    for (int n = 0; n < MOST; n++)
        if (context && contexts[n].context == context) return &contexts[n];
    return NULL;
}

static struct texture *shared_texture(cl_mem memory) {
    for (int n = 0; n < MOST; n++)
        if (memory && textures[n].memory == memory) return &textures[n];
    return NULL;
}

static cl_int CL_API_CALL get_device_info(cl_device_id device, cl_device_info what, size_t size, void *value, size_t *needed) {
    static const char more[] = " cl_khr_gl_sharing";
    if (what != CL_DEVICE_EXTENSIONS) return below->clGetDeviceInfo(device, what, size, value, needed);
    char names[16384];
    cl_int code = below->clGetDeviceInfo(device, what, sizeof names - sizeof more, names, NULL);
    if (code) return code;
    strcat(names, more);
    if (needed) *needed = strlen(names) + 1;
    if (value && size <= strlen(names)) return CL_INVALID_VALUE;
    if (value) strcpy(value, names);
    return CL_SUCCESS;
}

static cl_context CL_API_CALL create_context(const cl_context_properties *given, cl_uint count, const cl_device_id *devices,
                                             void(CL_CALLBACK *notify)(const char *, const void *, size_t, void *), void *data,
                                             cl_int *code) {
    cl_context_properties rest[16] = {0}, gl = 0, egl = 0, glx = 0;
    size_t kept = 0, all = 0;
    for (; given && given[all] && all < 12; all += 2) {
        if (given[all] == CL_GL_CONTEXT_KHR) gl = given[all + 1];
        else if (given[all] == CL_EGL_DISPLAY_KHR) egl = given[all + 1];
        else if (given[all] == CL_GLX_DISPLAY_KHR) glx = given[all + 1];
        else { rest[kept++] = given[all]; rest[kept++] = given[all + 1]; }
    }
    if ((gl || egl || glx) && !is_current(gl, egl, glx)) {
        if (code) *code = CL_INVALID_GL_SHAREGROUP_REFERENCE_KHR;
        return NULL;
    }
    cl_context made = below->clCreateContext(kept ? rest : NULL, count, devices, notify, data, code);
    struct shared *before = shared(made);
    if (before) before->context = NULL; /* The address was reused. */
    for (int n = 0; made && gl; n++) {
        if (n == MOST) abort();
        if (contexts[n].context) continue;
        contexts[n] = (struct shared){.context = made, .bytes = (all + 1) * sizeof *given};
        memcpy(contexts[n].properties, given, contexts[n].bytes);
        break;
    }
    return made;
}

static cl_int CL_API_CALL get_context_info(cl_context context, cl_context_info what, size_t size, void *value, size_t *needed) {
    struct shared *found = shared(context);
    if (!found || what != CL_CONTEXT_PROPERTIES) return below->clGetContextInfo(context, what, size, value, needed);
    if (needed) *needed = found->bytes;
    if (value && size < found->bytes) return CL_INVALID_VALUE;
    if (value) memcpy(value, found->properties, found->bytes);
    return CL_SUCCESS;
}

/* Reports the platform's first device for every current context. */
static cl_int CL_API_CALL get_gl_context_info(const cl_context_properties *given, cl_gl_context_info what, size_t size, void *value,
                                              size_t *needed) {
    cl_platform_id platform = NULL;
    cl_context_properties gl = 0, egl = 0, glx = 0;
    for (; given && *given; given += 2) {
        if (*given == CL_CONTEXT_PLATFORM) platform = (cl_platform_id)given[1];
        if (*given == CL_GL_CONTEXT_KHR) gl = given[1];
        if (*given == CL_EGL_DISPLAY_KHR) egl = given[1];
        if (*given == CL_GLX_DISPLAY_KHR) glx = given[1];
    }
    if (!is_current(gl, egl, glx)) return CL_INVALID_GL_SHAREGROUP_REFERENCE_KHR;
    if (what != CL_CURRENT_DEVICE_FOR_GL_CONTEXT_KHR || (value && size < sizeof(cl_device_id))) return CL_INVALID_VALUE;
    if (needed) *needed = sizeof(cl_device_id);
    return value ? below->clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 1, value, NULL) : CL_SUCCESS;
}

static cl_mem CL_API_CALL create_from_texture(cl_context context, cl_mem_flags flags, cl_GLenum target, cl_GLint level, cl_GLuint name,
                                              cl_int *code) {
    cl_int ignored;
    if (!code) code = &ignored;
    *code = !shared(context) ? CL_INVALID_CONTEXT : level ? CL_INVALID_MIP_LEVEL : target != GL_TEXTURE_2D ? CL_INVALID_VALUE : CL_SUCCESS;
    if (*code) return NULL;
    void (*get)(cl_uint, cl_int *) = of_gl("glGetIntegerv");
    void (*bind)(cl_uint, cl_uint) = of_gl("glBindTexture");
    void (*get_level)(cl_uint, cl_int, cl_uint, cl_int *) = of_gl("glGetTexLevelParameteriv");
    cl_int before = 0, width = 0, height = 0;
    get(GL_TEXTURE_BINDING_2D, &before);
    bind(GL_TEXTURE_2D, name);
    get_level(GL_TEXTURE_2D, 0, GL_TEXTURE_WIDTH, &width);
    get_level(GL_TEXTURE_2D, 0, GL_TEXTURE_HEIGHT, &height);
    bind(GL_TEXTURE_2D, (cl_uint)before);
    cl_image_format format = {CL_RGBA, CL_UNORM_INT8};
    cl_image_desc size = {.image_type = CL_MEM_OBJECT_IMAGE2D, .image_width = (size_t)width, .image_height = (size_t)height};
    cl_mem made = below->clCreateImage(context, flags, &format, &size, NULL, code);
    struct texture *slot = shared_texture(made);
    for (int n = 0; made && !slot; n++) {
        if (n == MOST) abort();
        if (!textures[n].memory) slot = &textures[n];
    }
    if (slot) *slot = (struct texture){made, name, (size_t)width, (size_t)height, 0};
    return made;
}

/* Textures must belong to OpenGL before they are acquired, and to OpenCL before they are released. */
static cl_int check_owned(cl_uint count, const cl_mem *memory, int acquired) {
    for (cl_uint n = 0; n < count; n++) {
        struct texture *texture = shared_texture(memory[n]);
        if (!texture) return CL_INVALID_GL_OBJECT;
        if (texture->acquired != acquired) return CL_INVALID_OPERATION;
    }
    return CL_SUCCESS;
}

static cl_int CL_API_CALL acquire(cl_command_queue queue, cl_uint count, const cl_mem *memory, cl_uint waits, const cl_event *wait,
                                  cl_event *event) {
    cl_int code = check_owned(count, memory, 0);
    if (code) return code;
    for (cl_uint n = 0; n < count; n++) shared_texture(memory[n])->acquired = 1;
    return below->clEnqueueMarkerWithWaitList(queue, waits, wait, event);
}

static cl_int CL_API_CALL release(cl_command_queue queue, cl_uint count, const cl_mem *memory, cl_uint waits, const cl_event *wait,
                                  cl_event *event) {
    cl_int code = check_owned(count, memory, 1);
    void (*get)(cl_uint, cl_int *) = of_gl("glGetIntegerv");
    void (*bind)(cl_uint, cl_uint) = of_gl("glBindTexture");
    void (*write)(cl_uint, cl_int, cl_int, cl_int, cl_int, cl_int, cl_uint, cl_uint, const void *) = of_gl("glTexSubImage2D");
    for (cl_uint n = 0; n < count && !code; n++) {
        struct texture *texture = shared_texture(memory[n]);
        size_t origin[3] = {0}, region[3] = {texture->width, texture->height, 1};
        void *pixels = malloc(4 * region[0] * region[1]);
        code = below->clEnqueueReadImage(queue, memory[n], CL_TRUE, origin, region, 0, 0, pixels, waits, wait, NULL);
        cl_int before = 0;
        get(GL_TEXTURE_BINDING_2D, &before);
        bind(GL_TEXTURE_2D, texture->name);
        write(GL_TEXTURE_2D, 0, 0, 0, (cl_int)region[0], (cl_int)region[1], GL_RGBA, GL_UNSIGNED_BYTE, pixels);
        bind(GL_TEXTURE_2D, (cl_uint)before);
        texture->acquired = 0;
        free(pixels);
    }
    return code ? code : below->clEnqueueMarkerWithWaitList(queue, waits, wait, event);
}

static cl_int CL_API_CALL copy_to_image(cl_command_queue queue, cl_mem from, cl_mem to, size_t first, const size_t *origin,
                                        const size_t *region, cl_uint waits, const cl_event *wait, cl_event *event) {
    struct texture *texture = shared_texture(to);
    if (texture && !texture->acquired) return CL_INVALID_OPERATION;
    return below->clEnqueueCopyBufferToImage(queue, from, to, first, origin, region, waits, wait, event);
}

cl_int CL_API_CALL clGetLayerInfo(cl_layer_info what, size_t size, void *value, size_t *needed) {
    cl_layer_api_version version = CL_LAYER_API_VERSION_100;
    if (what != CL_LAYER_API_VERSION || (value && size < sizeof version)) return CL_INVALID_VALUE;
    if (value) memcpy(value, &version, sizeof version);
    if (needed) *needed = sizeof version;
    return CL_SUCCESS;
}

cl_int CL_API_CALL clInitLayer(cl_uint entries, const cl_icd_dispatch *target, cl_uint *used, const cl_icd_dispatch **made) {
    if (entries < sizeof layer / sizeof(void *)) return CL_INVALID_VALUE;
    below = target;
    layer = *target;
    layer.clGetDeviceInfo = get_device_info;
    layer.clCreateContext = create_context;
    layer.clGetContextInfo = get_context_info;
    layer.clGetGLContextInfoKHR = get_gl_context_info;
    layer.clCreateFromGLTexture = create_from_texture;
    layer.clEnqueueAcquireGLObjects = acquire;
    layer.clEnqueueReleaseGLObjects = release;
    layer.clEnqueueCopyBufferToImage = copy_to_image;
    *used = sizeof layer / sizeof(void *);
    *made = &layer;
    return CL_SUCCESS;
}
