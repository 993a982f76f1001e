//! Reading and checking the values of parameters.

use crate::handle::Handle;
use crate::objects::{Object, Objects};
use crate::schema::{DefaultValue, Parameter};
use crate::status::Problem;
use crate::types::{self, DataType};
use crate::value::Value;
use anari_sys::*;
use std::ffi::{CStr, c_void};

/// Reads committed parameters.
impl Object {
    /// Floats of a parameter: as committed, by default, or `None`.
    pub fn floats<const N: usize>(&self, name: &CStr) -> Option<[f32; N]> {
        if let Some(Value::Numbers(_, bytes)) = self.committed.get(name) {
            let (floats, rest) = bytes.as_chunks::<4>();
            let floats: Vec<f32> = floats.iter().map(|&float| f32::from_ne_bytes(float)).collect();
            return floats.try_into().ok().filter(|_| rest.is_empty());
        }
        if self.committed.get(name).is_some() {
            return None;
        }
        match self.class.parameter(name)?.default {
            DefaultValue::Floats(values) => values.try_into().ok(),
            _ => None,
        }
    }

    /// A parameter with a single float.
    pub fn float(&self, name: &CStr) -> Option<f32> {
        self.floats(name).map(|[value]| value)
    }

    /// An integer, a truth value or a type.
    pub fn integer(&self, name: &CStr) -> Option<i32> {
        match self.committed.get(name) {
            Some(Value::Numbers(_, bytes)) => bytes.as_slice().try_into().ok().map(i32::from_ne_bytes),
            _ => match self.class.parameter(name)?.default {
                DefaultValue::Integer(value) => Some(*value),
                _ => None,
            },
        }
    }

    /// A truth value.
    pub fn is_set(&self, name: &CStr) -> bool {
        self.integer(name).is_some_and(|value| value != 0)
    }

    /// A string: as committed, or by default.
    pub fn text(&self, name: &CStr) -> Option<&str> {
        match self.committed.get(name) {
            Some(Value::Text(text)) => text.to_str().ok(),
            _ => match self.class.parameter(name)?.default {
                DefaultValue::Text(text) => text.to_str().ok(),
                _ => None,
            },
        }
    }

    /// Bytes of a number of this type.
    pub fn bytes_of(&self, name: &CStr, data_type: DataType) -> Option<&[u8]> {
        match self.committed.get(name) {
            Some(Value::Numbers(found, bytes)) if *found == data_type => Some(bytes),
            _ => None,
        }
    }

    /// An object.
    pub fn object(&self, name: &CStr) -> Option<Handle> {
        self.committed.get(name).and_then(Value::object)
    }

    /// An address; 0 if it is not set.
    pub fn pointer(&self, name: &CStr) -> usize {
        if let Some(Value::Pointer(address)) = self.committed.get(name) { *address } else { 0 }
    }
}

/// Reads and checks the value that the application gives for a parameter. A second problem says that the value was changed.
///
/// # Errors
/// Types and values that the parameter does not accept.
///
/// # Safety
/// `value` points to a value of `data_type`, or is the string or pointer itself.
pub unsafe fn checked(
    objects: &Objects,
    parameter: &Parameter,
    data_type: DataType,
    value: *const c_void,
) -> Result<(Value, Option<Problem>), Problem> {
    let name = parameter.name.to_string_lossy();
    if value.is_null() && data_type != ANARI_VOID_POINTER {
        return Err(Problem::argument(format!("the value of {name} is null: it stays as it was")));
    }
    if types::is_object(data_type) {
        // SAFETY: upheld by the caller.
        let handle = Handle(unsafe { value.cast::<usize>().read_unaligned() });
        return check_object(objects, parameter, handle).map(|()| (Value::Object(handle), None));
    }
    if !parameter.types.contains(&data_type) {
        let accepted = accepted(parameter.types);
        return Err(Problem::argument(format!("{name} is {accepted}, not {}: it stays as it was", types::name(data_type))));
    }
    match data_type {
        ANARI_STRING => {
            // SAFETY: upheld by the caller.
            let text = unsafe { CStr::from_ptr(value.cast()) };
            check_text(parameter, text).map(|()| (Value::Text(text.into()), None))
        }
        ANARI_VOID_POINTER => Ok((Value::Pointer(value as usize), None)),
        ANARI_STATUS_CALLBACK | ANARI_FRAME_COMPLETION_CALLBACK => {
            // SAFETY: upheld by the caller.
            Ok((Value::Pointer(unsafe { value.cast::<usize>().read_unaligned() }), None))
        }
        _ => {
            let count = types::bytes(data_type).unwrap_or(0);
            // SAFETY: upheld by the caller.
            let bytes = unsafe { std::slice::from_raw_parts(value.cast::<u8>(), count) }.to_vec();
            check_numbers(parameter, data_type, bytes)
        }
    }
}

/// Names of types, for messages.
fn accepted(types: &[DataType]) -> String {
    types.iter().map(|&data_type| types::name(data_type)).collect::<Vec<_>>().join(" or ")
}

fn check_object(objects: &Objects, parameter: &Parameter, handle: Handle) -> Result<(), Problem> {
    let name = parameter.name.to_string_lossy();
    let Some(object) = objects.get(handle) else {
        let what = if handle == Handle::NULL { "null" } else { "an object that this device does not know" };
        return Err(Problem::argument(format!("{name} is set to {what}: it stays as it was")));
    };
    if !parameter.types.contains(&object.data_type) {
        let (accepted, found) = (accepted(parameter.types), types::name(object.data_type));
        return Err(Problem::argument(format!("{name} is {accepted}, not {found}: it stays as it was")));
    }
    match object.array().map(|array| array.element) {
        Some(element) if !parameter.elements.contains(&element) => {
            let (accepted, found) = (accepted(parameter.elements), types::name(element));
            Err(Problem::argument(format!("{name} is an array of {accepted}, not of {found}: it stays as it was")))
        }
        _ => Ok(()),
    }
}

fn check_text(parameter: &Parameter, text: &CStr) -> Result<(), Problem> {
    if parameter.values.is_empty() || parameter.values.contains(&text) {
        return Ok(());
    }
    let values: Vec<_> = parameter.values.iter().map(|value| value.to_string_lossy()).collect();
    let (name, text) = (parameter.name.to_string_lossy(), text.to_string_lossy());
    Err(Problem::argument(format!("{name} is {}, not '{text}': it stays as it was", values.join(", "))))
}

/// Rejects numbers that are not finite, and clamps the others.
fn check_numbers(parameter: &Parameter, data_type: DataType, mut bytes: Vec<u8>) -> Result<(Value, Option<Problem>), Problem> {
    let name = parameter.name.to_string_lossy();
    if data_type == ANARI_DATA_TYPE {
        let format = bytes.as_slice().try_into().map(i32::from_ne_bytes).unwrap_or(ANARI_UNKNOWN);
        if !parameter.formats.contains(&format) {
            let (accepted, found) = (accepted(parameter.formats), types::name(format));
            return Err(Problem::argument(format!("{name} is {accepted}, not {found}: it stays as it was")));
        }
        return Ok((Value::Numbers(data_type, bytes), None));
    }
    let clamped = |value: f64| parameter.range.map_or(value, |&[lo, hi]| value.clamp(lo.into(), hi.into()));
    let mut changed = None;
    let mut change = |from: f64| {
        let to = clamped(from);
        if to != from {
            changed = Some(Problem::argument(format!("{name} is {from}, beyond its limits: {to} is taken")));
        }
        to
    };
    if types::floats(data_type).is_some() {
        for float in bytes.as_chunks_mut::<4>().0 {
            let value = f32::from_ne_bytes(*float);
            if !value.is_finite() {
                return Err(Problem::argument(format!("{name} contains {value}: it stays as it was")));
            }
            *float = (change(value.into()) as f32).to_ne_bytes();
        }
    } else if data_type == ANARI_INT32 {
        for integer in bytes.as_chunks_mut::<4>().0 {
            *integer = (change(i32::from_ne_bytes(*integer).into()) as i32).to_ne_bytes();
        }
    } else if data_type == ANARI_FLOAT64_BOX1
        && bytes.as_chunks::<8>().0.iter().any(|&double| !f64::from_ne_bytes(double).is_finite())
    {
        return Err(Problem::argument(format!("{name} contains numbers that are not finite: it stays as it was")));
    }
    Ok((Value::Numbers(data_type, bytes), changed))
}
