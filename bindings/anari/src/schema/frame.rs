//! The device, frames and the renderer.

use super::{COLORS, Class, DefaultValue, OBJECT, PLAIN, Parameter};
use anari_sys::*;

pub static DEVICE: Class = Class {
    data_type: ANARI_DEVICE,
    description: c"volumes by layered splatting, on any OpenCL device",
    parameters: &[
        Parameter {
            name: c"statusCallback",
            types: &[ANARI_STATUS_CALLBACK],
            description: c"function for messages; unset, that of the library",
            ..PLAIN
        },
        Parameter {
            name: c"statusCallbackUserData",
            types: &[ANARI_VOID_POINTER],
            description: c"first argument of the function for messages",
            ..PLAIN
        },
    ],
    ..OBJECT
};

pub static FRAME: Class = Class {
    data_type: ANARI_FRAME,
    description: c"a picture",
    parameters: &[
        Parameter { name: c"world", types: &[ANARI_WORLD], description: c"what is drawn", required: true, ..PLAIN },
        Parameter { name: c"camera", types: &[ANARI_CAMERA], description: c"the view", required: true, ..PLAIN },
        Parameter { name: c"renderer", types: &[ANARI_RENDERER], description: c"how it is drawn", required: true, ..PLAIN },
        Parameter {
            name: c"size",
            types: &[ANARI_UINT32_VEC2],
            description: c"width and height in pixels, 1 to 16384",
            required: true,
            ..PLAIN
        },
        Parameter {
            name: c"channel.color",
            types: &[ANARI_DATA_TYPE],
            description: c"type of the colours, premultiplied by alpha",
            formats: &[ANARI_UFIXED8_VEC4, ANARI_UFIXED8_RGBA_SRGB, ANARI_FLOAT32_VEC4],
            ..PLAIN
        },
        Parameter {
            name: c"channel.depth",
            types: &[ANARI_DATA_TYPE],
            description: c"type of the distances from the camera",
            formats: &[ANARI_FLOAT32],
            ..PLAIN
        },
        Parameter {
            name: c"channel.objectId",
            types: &[ANARI_DATA_TYPE],
            description: c"type of the ids of volumes",
            formats: &[ANARI_UINT32],
            ..PLAIN
        },
        Parameter {
            name: c"accumulation",
            types: &[ANARI_BOOL],
            description: c"whether frames of an unchanged scene are averaged, up to 16",
            default: DefaultValue::Integer(&0),
            ..PLAIN
        },
        Parameter {
            name: c"frameCompletionCallback",
            types: &[ANARI_FRAME_COMPLETION_CALLBACK],
            description: c"function that is called when a frame is complete",
            ..PLAIN
        },
        Parameter {
            name: c"frameCompletionCallbackUserData",
            types: &[ANARI_VOID_POINTER],
            description: c"first argument of that function",
            ..PLAIN
        },
    ],
    channels: &[c"channel.color", c"channel.depth", c"channel.objectId"],
    ..OBJECT
};

pub static RENDERER: Class = Class {
    data_type: ANARI_RENDERER,
    subtype: c"default",
    description: c"layered volume splatting",
    parameters: &[
        Parameter {
            name: c"background",
            types: &[ANARI_FLOAT32_VEC4, ANARI_ARRAY2D],
            description: c"colour and opacity behind the volume, or an image",
            elements: &COLORS,
            default: DefaultValue::Floats(&[0.0, 0.0, 0.0, 1.0]),
            ..PLAIN
        },
        Parameter {
            name: c"ambientColor",
            types: &[ANARI_FLOAT32_VEC3],
            description: c"colour of the ambient light",
            default: DefaultValue::Floats(&[1.0; 3]),
            range: Some(&[0.0, 1.0]),
            ..PLAIN
        },
        Parameter {
            name: c"ambientRadiance",
            types: &[ANARI_FLOAT32],
            description: c"ambient light",
            default: DefaultValue::Floats(&[0.0]),
            range: Some(&[0.0, 100.0]),
            ..PLAIN
        },
        Parameter {
            name: c"pixelSamples",
            types: &[ANARI_INT32],
            description: c"rays per pixel, 1 to 16",
            default: DefaultValue::Integer(&1),
            range: Some(&[1.0, 16.0]),
            ..PLAIN
        },
        Parameter {
            name: c"quality",
            types: &[ANARI_STRING],
            description: c"density of samples",
            default: DefaultValue::Text(c"standard"),
            values: &[c"draft", c"standard", c"high", c"paper"],
            ..PLAIN
        },
        Parameter {
            name: c"kernel",
            types: &[ANARI_STRING],
            description: c"reconstruction kernel; unset, by the filter of the field",
            values: &[c"linear", c"cubic", c"catmull-rom", c"bspline"],
            ..PLAIN
        },
        Parameter {
            name: c"gradient",
            types: &[ANARI_STRING],
            description: c"estimation of gradients for shading; unset, the library's default",
            values: &[c"central", c"sobel", c"own"],
            ..PLAIN
        },
        Parameter {
            name: c"clipToBounds",
            types: &[ANARI_BOOL],
            description: c"whether fields end at their outermost values; else they go on for up to one voxel, as in the command",
            default: DefaultValue::Integer(&0),
            ..PLAIN
        },
        Parameter {
            name: c"shadows",
            types: &[ANARI_BOOL],
            description: c"whether directional lights cast shadows",
            default: DefaultValue::Integer(&0),
            ..PLAIN
        },
        Parameter {
            name: c"ambientOcclusion",
            types: &[ANARI_BOOL],
            description: c"whether surroundings dim the ambient light",
            default: DefaultValue::Integer(&0),
            ..PLAIN
        },
        Parameter {
            name: c"look",
            types: &[ANARI_STRING],
            description: c"how volumes are lit: as in the command, or by light that scatters in them",
            default: DefaultValue::Text(c"plain"),
            values: &[c"plain", c"studio"],
            ..PLAIN
        },
        Parameter {
            name: c"scattering",
            types: &[ANARI_FLOAT32],
            description: c"factor of the light that scatters again in the studio",
            default: DefaultValue::Floats(&[0.95]),
            range: Some(&[0.0, 1.0]),
            ..PLAIN
        },
        Parameter {
            name: c"exposure",
            types: &[ANARI_FLOAT32],
            description: c"stops by which bytes of the studio are brighter; floats are unaffected",
            default: DefaultValue::Floats(&[0.0]),
            range: Some(&[-20.0, 20.0]),
            ..PLAIN
        },
        Parameter {
            name: c"tone",
            types: &[ANARI_STRING],
            description: c"curve of bright colours of the studio, for bytes",
            default: DefaultValue::Text(c"shoulder"),
            values: &[c"none", c"shoulder"],
            ..PLAIN
        },
        Parameter {
            name: c"gamma",
            types: &[ANARI_FLOAT32],
            description: c"colours of bytes are raised to 1/gamma; floats are unaffected",
            default: DefaultValue::Floats(&[1.0]),
            range: Some(&[0.2, 5.0]),
            ..PLAIN
        },
    ],
    ..OBJECT
};

pub static UNSUPPORTED: Class = Class { description: c"an object that is not drawn", ..OBJECT };

#[cfg(test)]
mod tests {
    use super::*;
    use layersplat::{GradientEstimator, Kernel, Quality, Settings};
    use std::collections::BTreeSet;
    use std::ffi::CStr;

    /// Names that a parameter accepts are those of the library.
    #[test]
    fn names_are_those_of_the_library() {
        let names = |parameter: &CStr| -> Vec<&str> {
            let parameter = RENDERER.parameter(parameter).unwrap();
            parameter.values.iter().map(|name| name.to_str().unwrap()).collect()
        };
        assert_eq!(names(c"quality"), Quality::ALL.map(Quality::name));
        let kernels: BTreeSet<_> = names(c"kernel").into_iter().collect();
        assert_eq!(kernels, Kernel::OF_LAYERS.map(Kernel::name).into());
        // A Gaussian has a number.
        let plain = GradientEstimator::ALL.into_iter().filter(|estimator| !matches!(estimator, GradientEstimator::Gaussian(_)));
        let gamma = RENDERER.parameter(c"gamma").unwrap().range.unwrap();
        assert_eq!(*gamma, Settings::GAMMA.range().map(|end| end as f32));
        assert_eq!(names(c"gradient"), plain.map(GradientEstimator::name).collect::<Vec<_>>());
    }
}
