//! Cameras.

use super::{Class, DefaultValue, OBJECT, PLAIN, Parameter};
use anari_sys::*;
use std::f32::consts::PI;

const POSITION: Parameter = Parameter {
    name: c"position",
    types: &[ANARI_FLOAT32_VEC3],
    description: c"position of the camera",
    default: DefaultValue::Floats(&[0.0; 3]),
    ..PLAIN
};
const DIRECTION: Parameter = Parameter {
    name: c"direction",
    types: &[ANARI_FLOAT32_VEC3],
    description: c"view direction",
    default: DefaultValue::Floats(&[0.0, 0.0, -1.0]),
    ..PLAIN
};
const UP: Parameter = Parameter {
    name: c"up",
    types: &[ANARI_FLOAT32_VEC3],
    description: c"upwards on the screen",
    default: DefaultValue::Floats(&[0.0, 1.0, 0.0]),
    ..PLAIN
};
const IMAGE_REGION: Parameter = Parameter {
    name: c"imageRegion",
    types: &[ANARI_FLOAT32_BOX2],
    description: c"part of the view that the frame shows, from the lower left (0, 0) to the upper right (1, 1)",
    default: DefaultValue::Floats(&[0.0, 0.0, 1.0, 1.0]),
    ..PLAIN
};
const ASPECT: Parameter = Parameter {
    name: c"aspect",
    types: &[ANARI_FLOAT32],
    description: c"width by height of the whole view; without it, pixels are square",
    range: Some(&[1e-6, 1e6]),
    ..PLAIN
};
const NEAR: Parameter = Parameter {
    name: c"near",
    types: &[ANARI_FLOAT32],
    description: c"distance of the near clip plane; unset, none",
    range: Some(&[0.0, f32::MAX]),
    ..PLAIN
};
const FAR: Parameter = Parameter {
    name: c"far",
    types: &[ANARI_FLOAT32],
    description: c"distance of the far clip plane; unset, none",
    range: Some(&[0.0, f32::MAX]),
    ..PLAIN
};

pub static PERSPECTIVE: Class = Class {
    data_type: ANARI_CAMERA,
    subtype: c"perspective",
    description: c"perspective camera",
    parameters: &[
        POSITION,
        DIRECTION,
        UP,
        IMAGE_REGION,
        Parameter {
            name: c"fovy",
            types: &[ANARI_FLOAT32],
            description: c"vertical field of view in radians",
            default: DefaultValue::Floats(&[PI / 3.0]),
            range: Some(&[1e-4, 3.1]),
            ..PLAIN
        },
        ASPECT,
        NEAR,
        FAR,
    ],
    ..OBJECT
};

pub static ORTHOGRAPHIC: Class = Class {
    data_type: ANARI_CAMERA,
    subtype: c"orthographic",
    description: c"camera with parallel rays",
    parameters: &[
        POSITION,
        DIRECTION,
        UP,
        IMAGE_REGION,
        Parameter {
            name: c"height",
            types: &[ANARI_FLOAT32],
            description: c"height of the view in world units",
            default: DefaultValue::Floats(&[1.0]),
            range: Some(&[1e-30, 1e30]),
            ..PLAIN
        },
        ASPECT,
        NEAR,
        FAR,
    ],
    ..OBJECT
};
