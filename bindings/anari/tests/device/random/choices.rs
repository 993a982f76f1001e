//! What random calls choose from.

use anari_sys::*;
use std::ffi::CStr;

/// Subtypes, some of which no type has.
pub const SUBTYPES: [&CStr; 9] = [
    c"default",
    c"perspective",
    c"orthographic",
    c"transform",
    c"directional",
    c"transferFunction1D",
    c"structuredRegular",
    c"sphere",
    c"",
];

/// Names of parameters.
pub const NAMES: [&CStr; 37] = [
    c"world",
    c"camera",
    c"renderer",
    c"size",
    c"channel.color",
    c"channel.depth",
    c"channel.objectId",
    c"accumulation",
    c"frameCompletionCallback",
    c"frameCompletionCallbackUserData",
    c"background",
    c"ambientRadiance",
    c"pixelSamples",
    c"quality",
    c"kernel",
    c"look",
    c"shadows",
    c"ambientOcclusion",
    c"region",
    c"instance",
    c"surface",
    c"volume",
    c"light",
    c"group",
    c"transform",
    c"data",
    c"origin",
    c"spacing",
    c"filter",
    c"value",
    c"valueRange",
    c"color",
    c"opacity",
    c"unitDistance",
    c"direction",
    c"name",
    c"nonsense",
];

/// Types of values.
pub const TYPES: [ANARIDataType; 26] = [
    ANARI_UNKNOWN,
    ANARI_DATA_TYPE,
    ANARI_STRING,
    ANARI_VOID_POINTER,
    ANARI_BOOL,
    ANARI_FRAME_COMPLETION_CALLBACK,
    ANARI_OBJECT,
    ANARI_ARRAY,
    ANARI_ARRAY1D,
    ANARI_ARRAY3D,
    ANARI_CAMERA,
    ANARI_FRAME,
    ANARI_SPATIAL_FIELD,
    ANARI_VOLUME,
    ANARI_WORLD,
    ANARI_UINT32,
    ANARI_INT32,
    ANARI_UINT32_VEC2,
    ANARI_FLOAT32,
    ANARI_FLOAT32_VEC3,
    ANARI_FLOAT32_VEC4,
    ANARI_FLOAT32_BOX1,
    ANARI_FLOAT64_BOX1,
    ANARI_FLOAT32_MAT4,
    ANARI_UINT64_REGION1,
    12_345,
];

/// Types of objects.
pub const MADE: [ANARIDataType; 13] = [
    ANARI_GEOMETRY,
    ANARI_MATERIAL,
    ANARI_SAMPLER,
    ANARI_SURFACE,
    ANARI_SPATIAL_FIELD,
    ANARI_VOLUME,
    ANARI_LIGHT,
    ANARI_GROUP,
    ANARI_INSTANCE,
    ANARI_WORLD,
    ANARI_CAMERA,
    ANARI_RENDERER,
    ANARI_FRAME,
];

/// Types of elements.
pub const ELEMENTS: [ANARIDataType; 13] = [
    ANARI_OBJECT,
    ANARI_UFIXED8,
    ANARI_FIXED16,
    ANARI_FLOAT32,
    ANARI_FLOAT64,
    ANARI_FLOAT32_VEC3,
    ANARI_FLOAT32_VEC4,
    ANARI_UFIXED8_RGBA_SRGB,
    ANARI_VOLUME,
    ANARI_LIGHT,
    ANARI_INSTANCE,
    ANARI_WORLD,
    ANARI_STRING,
];

/// Numbers, right and wrong ones.
pub const FLOATS: [f32; 10] = [0.0, 0.25, 0.5, 1.0, 2.0, -1.0, 1e30, 1e-30, f32::NAN, f32::INFINITY];
/// Strings.
pub const TEXTS: [&CStr; 7] = [c"linear", c"cubic", c"draft", c"standard", c"high", c"", c"\xff\xfe"];

/// Names of parameters that are objects.
pub const OF_OBJECTS: [&CStr; 11] =
    [c"world", c"camera", c"renderer", c"instance", c"volume", c"light", c"group", c"data", c"value", c"color", c"opacity"];
