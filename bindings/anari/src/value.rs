//! Values of parameters.

use crate::handle::Handle;
use crate::types::DataType;
use std::collections::BTreeMap;
use std::ffi::{CStr, CString};

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Numbers, in memory as the application wrote them.
    Numbers(DataType, Vec<u8>),
    Text(CString),
    Object(Handle),
    /// The address of a function, or an argument for one.
    Pointer(usize),
}

impl Value {
    pub fn object(&self) -> Option<Handle> {
        if let Self::Object(handle) = self { Some(*handle) } else { None }
    }
}

/// Parameters by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parameters(BTreeMap<&'static CStr, Value>);

impl Parameters {
    /// Sets a value or removes it. Returns the one before.
    pub fn replace(&mut self, name: &'static CStr, value: Option<Value>) -> Option<Value> {
        match value {
            Some(value) => self.0.insert(name, value),
            None => self.0.remove(name),
        }
    }

    pub fn names(&self) -> Vec<&'static CStr> {
        self.0.keys().copied().collect()
    }

    pub fn get(&self, name: &CStr) -> Option<&Value> {
        self.0.get(name)
    }

    /// All objects, once per parameter.
    pub fn objects(&self) -> impl Iterator<Item = Handle> {
        self.0.values().filter_map(Value::object)
    }
}
