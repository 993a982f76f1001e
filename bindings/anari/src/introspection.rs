//! Answers about types, subtypes and parameters. All of them are constant and stay valid.

use crate::schema::{self, Class, DefaultValue, EXTENSIONS, NAME, Parameter};
use crate::types::{self, DataType};
use anari_sys::*;
use std::collections::BTreeMap;
use std::ffi::{CStr, c_char, c_void};
use std::sync::OnceLock;

/// A list as C takes it: pointers to strings and a null pointer at the end.
struct Strings(Box<[*const c_char]>);

impl Strings {
    fn new<'a>(strings: impl Iterator<Item = &'a &'static CStr>) -> Self {
        Self(strings.map(|string| string.as_ptr()).chain([std::ptr::null()]).collect())
    }

    fn pointer(&self) -> *const c_void {
        self.0.as_ptr().cast()
    }
}

/// Lists of one parameter.
struct ParameterLists {
    values: Strings,
    formats: Box<[DataType]>,
    elements: Box<[DataType]>,
}

/// Lists of one class.
struct ClassLists {
    parameters: Box<[ANARIParameter]>,
    channels: Strings,
    of_parameters: BTreeMap<&'static CStr, ParameterLists>,
}

/// All lists, by the place of their class in [`schema::CLASSES`].
struct Lists {
    classes: Vec<ClassLists>,
    /// Names of subtypes, by type.
    subtypes: BTreeMap<DataType, Strings>,
    extensions: Strings,
}

// SAFETY: the pointers are to constants.
unsafe impl Send for Lists {}
// SAFETY: as above.
unsafe impl Sync for Lists {}

fn lists() -> &'static Lists {
    static LISTS: OnceLock<Lists> = OnceLock::new();
    LISTS.get_or_init(|| {
        let mut subtypes = BTreeMap::new();
        for class in schema::CLASSES.iter().filter(|class| !class.subtype.is_empty()) {
            subtypes
                .entry(class.data_type)
                .or_insert_with(|| Strings::new(schema::of_type(class.data_type).map(|class| &class.subtype)));
        }
        let classes = schema::CLASSES.iter().map(|class| ClassLists::new(class)).collect();
        Lists { classes, subtypes, extensions: Strings::new(EXTENSIONS.iter()) }
    })
}

impl ClassLists {
    fn new(class: &Class) -> Self {
        let all = || class.parameters.iter().chain([&NAME]);
        let each_type = |parameter: &Parameter| {
            let name = parameter.name.as_ptr();
            parameter.types.iter().map(move |&type_| ANARIParameter { name, type_ }).collect::<Vec<_>>()
        };
        let end = ANARIParameter { name: std::ptr::null(), type_: ANARI_UNKNOWN };
        let closed = |types: &[DataType]| types.iter().copied().chain([ANARI_UNKNOWN]).collect();
        let of_parameter = |parameter: &Parameter| ParameterLists {
            values: Strings::new(parameter.values.iter()),
            formats: closed(parameter.formats),
            elements: closed(parameter.elements),
        };
        Self {
            parameters: all().flat_map(each_type).chain([end]).collect(),
            channels: Strings::new(class.channels.iter()),
            of_parameters: all().map(|parameter| (parameter.name, of_parameter(parameter))).collect(),
        }
    }
}

/// The extensions of the device.
pub fn extensions() -> *const *const c_char {
    lists().extensions.0.as_ptr()
}

/// The subtypes of a type; null for types without.
pub fn subtypes(data_type: DataType) -> *const *const c_char {
    lists().subtypes.get(&data_type).map_or(std::ptr::null(), |names| names.0.as_ptr())
}

/// A class and its lists.
fn class(data_type: DataType, subtype: &CStr) -> Option<(&'static Class, &'static ClassLists)> {
    let class = schema::find(data_type, subtype).filter(|class| class.is_supported())?;
    let place = schema::CLASSES.iter().position(|other| std::ptr::eq(*other, class))?;
    Some((class, &lists().classes[place]))
}

/// Information on a class; null for what there is not.
pub fn object_info(data_type: DataType, subtype: &CStr, info: &CStr, info_type: DataType) -> *const c_void {
    let Some((class, lists)) = class(data_type, subtype) else { return std::ptr::null() };
    match (info.to_bytes(), info_type) {
        (b"description", ANARI_STRING) => class.description.as_ptr().cast(),
        (b"parameter", ANARI_PARAMETER_LIST) => lists.parameters.as_ptr().cast(),
        (b"channel", ANARI_STRING_LIST) if !class.channels.is_empty() => lists.channels.pointer(),
        (b"extension", ANARI_STRING_LIST) if [ANARI_RENDERER, ANARI_DEVICE].contains(&data_type) => extensions().cast(),
        _ => std::ptr::null(),
    }
}

/// Information on a parameter; null for what there is not.
pub fn parameter_info(
    data_type: DataType,
    subtype: &CStr,
    name: &CStr,
    parameter_type: DataType,
    info: &CStr,
    info_type: DataType,
) -> *const c_void {
    static YES_AND_NO: [i32; 2] = [0, 1];
    let nothing = std::ptr::null();
    let Some((class, lists)) = class(data_type, subtype) else { return nothing };
    let Some(parameter) = class.parameter(name).filter(|parameter| parameter.types.contains(&parameter_type)) else {
        return nothing;
    };
    let lists = &lists.of_parameters[parameter.name];
    match (info.to_bytes(), info_type) {
        (b"description", ANARI_STRING) => parameter.description.as_ptr().cast(),
        (b"required", ANARI_BOOL) => (&raw const YES_AND_NO[usize::from(parameter.required)]).cast(),
        (b"default", asked) if asked == parameter.types[0] && asked == parameter_type => match parameter.default {
            DefaultValue::None => nothing,
            DefaultValue::Floats(values) => values.as_ptr().cast(),
            DefaultValue::Integer(value) => (&raw const *value).cast(),
            DefaultValue::Text(text) => text.as_ptr().cast(),
        },
        // Other types have no limits that one number of their type says.
        (b"minimum", ANARI_FLOAT32) if parameter_type == ANARI_FLOAT32 => limit(parameter, 0),
        (b"maximum", ANARI_FLOAT32) if parameter_type == ANARI_FLOAT32 => limit(parameter, 1),
        (b"value", ANARI_STRING_LIST) if !parameter.values.is_empty() => lists.values.pointer(),
        (b"value", ANARI_DATA_TYPE_LIST) if !parameter.formats.is_empty() => lists.formats.as_ptr().cast(),
        (b"elementType", ANARI_DATA_TYPE_LIST) if types::is_array(parameter_type) => lists.elements.as_ptr().cast(),
        _ => nothing,
    }
}

fn limit(parameter: &Parameter, end: usize) -> *const c_void {
    parameter.range.map_or(std::ptr::null(), |range| (&raw const range[end]).cast())
}
