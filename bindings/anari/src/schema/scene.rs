//! What a world consists of.

use super::{COLORS, Class, DefaultValue, OBJECT, PLAIN, Parameter};
use anari_sys::*;

pub static ARRAY1D: Class = Class {
    data_type: ANARI_ARRAY1D,
    description: c"array of one dimension",
    parameters: &[Parameter {
        name: c"region",
        types: &[ANARI_UINT64_REGION1],
        description: c"elements in use, from the first to the one after the last",
        ..PLAIN
    }],
    ..OBJECT
};

pub static ARRAY2D: Class = Class { data_type: ANARI_ARRAY2D, description: c"array of two dimensions", ..OBJECT };

pub static ARRAY3D: Class = Class { data_type: ANARI_ARRAY3D, description: c"array of three dimensions", ..OBJECT };

const SURFACES: Parameter = Parameter {
    name: c"surface",
    types: &[ANARI_ARRAY1D],
    description: c"surfaces, which this device does not draw",
    elements: &[ANARI_SURFACE],
    ..PLAIN
};
const VOLUMES: Parameter =
    Parameter { name: c"volume", types: &[ANARI_ARRAY1D], description: c"volumes", elements: &[ANARI_VOLUME], ..PLAIN };
const LIGHTS: Parameter =
    Parameter { name: c"light", types: &[ANARI_ARRAY1D], description: c"lights", elements: &[ANARI_LIGHT], ..PLAIN };

pub static WORLD: Class = Class {
    data_type: ANARI_WORLD,
    description: c"all that is drawn",
    parameters: &[
        Parameter { name: c"instance", types: &[ANARI_ARRAY1D], description: c"instances", elements: &[ANARI_INSTANCE], ..PLAIN },
        SURFACES,
        VOLUMES,
        LIGHTS,
    ],
    ..OBJECT
};

pub static GROUP: Class = Class {
    data_type: ANARI_GROUP,
    description: c"objects with one transform",
    parameters: &[SURFACES, VOLUMES, LIGHTS],
    ..OBJECT
};

/// Accepted so that scenes with surfaces can be made; they are not drawn.
pub static SURFACE: Class = Class {
    data_type: ANARI_SURFACE,
    description: c"a surface, which this device does not draw",
    parameters: &[
        Parameter { name: c"geometry", types: &[ANARI_GEOMETRY], description: c"its shape", ..PLAIN },
        Parameter { name: c"material", types: &[ANARI_MATERIAL], description: c"its appearance", ..PLAIN },
        Parameter { name: c"id", types: &[ANARI_UINT32], description: c"id for the channel objectId", ..PLAIN },
        Parameter { name: c"visible", types: &[ANARI_BOOL], description: c"whether it is visible", ..PLAIN },
    ],
    ..OBJECT
};

pub static INSTANCE: Class = Class {
    data_type: ANARI_INSTANCE,
    subtype: c"transform",
    description: c"a group with a transform",
    parameters: &[
        Parameter { name: c"group", types: &[ANARI_GROUP], description: c"the group", required: true, ..PLAIN },
        Parameter {
            name: c"transform",
            types: &[ANARI_FLOAT32_MAT4],
            description: c"affine transform from the group to the world, in columns; axes of volumes must stay perpendicular",
            default: DefaultValue::Floats(&[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]),
            ..PLAIN
        },
    ],
    ..OBJECT
};

pub static FIELD: Class = Class {
    data_type: ANARI_SPATIAL_FIELD,
    subtype: c"structuredRegular",
    description: c"values on a regular grid",
    parameters: &[
        Parameter {
            name: c"data",
            types: &[ANARI_ARRAY3D],
            description: c"the values at the vertices of the grid",
            elements: &[ANARI_UFIXED8, ANARI_FIXED16, ANARI_UFIXED16, ANARI_FLOAT32, ANARI_FLOAT64],
            required: true,
            ..PLAIN
        },
        Parameter {
            name: c"origin",
            types: &[ANARI_FLOAT32_VEC3],
            description: c"position of the first value",
            default: DefaultValue::Floats(&[0.0; 3]),
            ..PLAIN
        },
        Parameter {
            name: c"spacing",
            types: &[ANARI_FLOAT32_VEC3],
            description: c"distance between adjacent values",
            default: DefaultValue::Floats(&[1.0; 3]),
            range: Some(&[1e-30, 1e30]),
            ..PLAIN
        },
        Parameter {
            name: c"filter",
            types: &[ANARI_STRING],
            description: c"reconstruction between values: linear, or cubic by an interpolating B-spline",
            default: DefaultValue::Text(c"linear"),
            values: &[c"linear", c"cubic"],
            ..PLAIN
        },
    ],
    ..OBJECT
};

pub static VOLUME: Class = Class {
    data_type: ANARI_VOLUME,
    subtype: c"transferFunction1D",
    description: c"a field with a transfer function",
    parameters: &[
        Parameter { name: c"value", types: &[ANARI_SPATIAL_FIELD], description: c"the field", required: true, ..PLAIN },
        Parameter {
            name: c"valueRange",
            // pynari has no boxes.
            types: &[ANARI_FLOAT32_BOX1, ANARI_FLOAT64_BOX1, ANARI_FLOAT32_VEC2],
            description: c"values of the first and the last colour and opacity",
            default: DefaultValue::Floats(&[0.0, 1.0]),
            ..PLAIN
        },
        Parameter {
            name: c"color",
            types: &[ANARI_FLOAT32_VEC4, ANARI_FLOAT32_VEC3, ANARI_ARRAY1D],
            description: c"colours over the range of values, or one",
            elements: &COLORS,
            default: DefaultValue::Floats(&[1.0; 4]),
            ..PLAIN
        },
        Parameter {
            name: c"opacity",
            types: &[ANARI_FLOAT32, ANARI_ARRAY1D],
            description: c"opacities over the range of values, or one",
            elements: &[ANARI_FLOAT32],
            default: DefaultValue::Floats(&[1.0]),
            range: Some(&[0.0, 1.0]),
            ..PLAIN
        },
        Parameter {
            name: c"unitDistance",
            types: &[ANARI_FLOAT32],
            description: c"world distance to which opacities apply",
            default: DefaultValue::Floats(&[1.0]),
            range: Some(&[1e-30, 1e30]),
            ..PLAIN
        },
        Parameter {
            name: c"visible",
            types: &[ANARI_BOOL],
            description: c"whether it is drawn",
            default: DefaultValue::Integer(&1),
            ..PLAIN
        },
        Parameter {
            name: c"id",
            types: &[ANARI_UINT32],
            description: c"id for the channel objectId; unset, the index in the array of volumes",
            ..PLAIN
        },
    ],
    ..OBJECT
};

pub static LIGHT: Class = Class {
    data_type: ANARI_LIGHT,
    subtype: c"directional",
    description: c"parallel light",
    parameters: &[
        Parameter {
            name: c"direction",
            types: &[ANARI_FLOAT32_VEC3],
            description: c"direction in which it shines",
            default: DefaultValue::Floats(&[0.0, 0.0, -1.0]),
            ..PLAIN
        },
        Parameter {
            name: c"color",
            types: &[ANARI_FLOAT32_VEC3],
            description: c"colour",
            default: DefaultValue::Floats(&[1.0; 3]),
            range: Some(&[0.0, 1.0]),
            ..PLAIN
        },
        Parameter {
            name: c"irradiance",
            types: &[ANARI_FLOAT32],
            description: c"strength, 1 for the light of the command",
            default: DefaultValue::Floats(&[1.0]),
            range: Some(&[0.0, 100.0]),
            ..PLAIN
        },
        Parameter {
            name: c"radiance",
            types: &[ANARI_FLOAT32],
            description: c"strength by solid angle, for lights with a diameter and without an irradiance",
            range: Some(&[0.0, f32::MAX]),
            ..PLAIN
        },
        Parameter {
            name: c"angularDiameter",
            types: &[ANARI_FLOAT32],
            description: c"apparent diameter in radians, which softens shadows",
            default: DefaultValue::Floats(&[0.0]),
            range: Some(&[0.0, 0.785]),
            ..PLAIN
        },
    ],
    ..OBJECT
};
