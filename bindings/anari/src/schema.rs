//! The object types of this device and their parameters. Checks of parameters and introspection both read these tables.

mod camera;
mod extensions;
mod frame;
mod scene;

pub use extensions::EXTENSIONS;

use crate::types::DataType;
use anari_sys::*;
use std::ffi::CStr;

/// A type of objects, or a subtype.
pub struct Class {
    pub data_type: DataType,
    /// Name of the subtype; empty for types without.
    pub subtype: &'static CStr,
    pub description: &'static CStr,
    /// All but the name.
    pub parameters: &'static [Parameter],
    /// Names of the channels of a frame.
    pub channels: &'static [&'static CStr],
}

/// A parameter of a class.
pub struct Parameter {
    pub name: &'static CStr,
    /// Accepted types; the default is of the first.
    pub types: &'static [DataType],
    pub description: &'static CStr,
    /// Accepted types of elements, if a type is an array.
    pub elements: &'static [DataType],
    pub required: bool,
    pub default: DefaultValue,
    /// Smallest and largest number.
    pub range: Option<&'static [f32; 2]>,
    /// Accepted strings.
    pub values: &'static [&'static CStr],
    /// Accepted types, if the value is one.
    pub formats: &'static [DataType],
}

/// The default of a parameter.
#[derive(Clone, Copy)]
pub enum DefaultValue {
    None,
    Floats(&'static [f32]),
    Integer(&'static i32),
    Text(&'static CStr),
}

/// A parameter without further properties, for updates.
const PLAIN: Parameter = Parameter {
    name: c"",
    types: &[],
    description: c"",
    elements: &[],
    required: false,
    default: DefaultValue::None,
    range: None,
    values: &[],
    formats: &[],
};

/// A class without channels, for updates.
const OBJECT: Class = Class { data_type: ANARI_OBJECT, subtype: c"", description: c"", parameters: &[], channels: &[] };

/// The parameter that all objects have.
pub static NAME: Parameter =
    Parameter { name: c"name", types: &[ANARI_STRING], description: c"name of the object in messages", ..PLAIN };

/// Types of elements that are colours.
pub const COLORS: [DataType; 20] = [
    ANARI_UFIXED8,
    ANARI_UFIXED8_VEC2,
    ANARI_UFIXED8_VEC3,
    ANARI_UFIXED8_VEC4,
    ANARI_UFIXED8_R_SRGB,
    ANARI_UFIXED8_RA_SRGB,
    ANARI_UFIXED8_RGB_SRGB,
    ANARI_UFIXED8_RGBA_SRGB,
    ANARI_UFIXED16,
    ANARI_UFIXED16_VEC2,
    ANARI_UFIXED16_VEC3,
    ANARI_UFIXED16_VEC4,
    ANARI_UFIXED32,
    ANARI_UFIXED32_VEC2,
    ANARI_UFIXED32_VEC3,
    ANARI_UFIXED32_VEC4,
    ANARI_FLOAT32,
    ANARI_FLOAT32_VEC2,
    ANARI_FLOAT32_VEC3,
    ANARI_FLOAT32_VEC4,
];

/// All classes. Of a type, the first is the default.
pub static CLASSES: [&Class; 16] = [
    &frame::DEVICE,
    &scene::ARRAY1D,
    &scene::ARRAY2D,
    &scene::ARRAY3D,
    &frame::FRAME,
    &scene::WORLD,
    &scene::GROUP,
    &scene::SURFACE,
    &scene::INSTANCE,
    &scene::FIELD,
    &scene::VOLUME,
    &scene::LIGHT,
    &camera::PERSPECTIVE,
    &camera::ORTHOGRAPHIC,
    &frame::RENDERER,
    &frame::UNSUPPORTED,
];

/// The class of objects of a type or subtype that this device does not have. They have no parameters.
pub static UNSUPPORTED: &Class = &frame::UNSUPPORTED;

/// The classes of a type.
pub fn of_type(data_type: DataType) -> impl Iterator<Item = &'static Class> {
    CLASSES.into_iter().filter(move |class| class.data_type == data_type)
}

/// The class of a type and a subtype. Types without subtypes ignore it.
pub fn find(data_type: DataType, subtype: &CStr) -> Option<&'static Class> {
    of_type(data_type).find(|class| class.subtype.is_empty() || class.subtype == subtype)
}

impl Class {
    /// The parameter of a name.
    pub fn parameter(&self, name: &CStr) -> Option<&'static Parameter> {
        let own = self.parameters.iter().find(|parameter| parameter.name == name);
        own.or_else(|| (name == NAME.name).then_some(&NAME))
    }

    /// Whether objects of this class have a meaning here.
    pub fn is_supported(&self) -> bool {
        !std::ptr::eq(self, UNSUPPORTED)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types;
    use std::collections::BTreeSet;

    #[test]
    fn tables_are_consistent() {
        for class in CLASSES {
            let names: BTreeSet<_> = class.parameters.iter().map(|parameter| parameter.name).collect();
            assert_eq!(names.len(), class.parameters.len(), "{:?} has a parameter twice", class.subtype);
            for parameter in class.parameters {
                let name = parameter.name;
                assert!(!parameter.types.is_empty() && !parameter.description.is_empty(), "{name:?}");
                let has_array = parameter.types.iter().copied().any(types::is_array);
                assert_eq!(has_array, !parameter.elements.is_empty(), "{name:?}");
                let has_default = !matches!(parameter.default, DefaultValue::None);
                assert!(!(parameter.required && has_default), "{name:?} has a default and is required");
                if let DefaultValue::Floats(values) = parameter.default {
                    assert_eq!(types::floats(parameter.types[0]), Some(values.len()), "{name:?}");
                    let inside = |value: &f32| parameter.range.is_none_or(|[lo, hi]| (lo..=hi).contains(&value));
                    assert!(values.iter().all(inside), "{name:?}");
                }
                if let DefaultValue::Text(text) = parameter.default {
                    assert!(parameter.values.contains(&text), "{name:?}");
                }
            }
        }
    }
}
