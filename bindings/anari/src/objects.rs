//! The table of objects.

use crate::arrays::Array;
use crate::handle::Handle;
use crate::schema::Class;
use crate::status::Problem;
use crate::types::DataType;
use crate::value::{Parameters, Value};
use std::collections::HashMap;
use std::ffi::{CStr, CString};

/// An object and its references.
pub struct Object {
    pub class: &'static Class,
    /// The type, also of objects that this device does not support.
    pub data_type: DataType,
    /// References of the application.
    pub references: u32,
    /// References by parameters and arrays.
    pub uses: u32,
    /// Parameters as they were set.
    pub staged: Parameters,
    /// Parameters as of the last commit.
    pub committed: Parameters,
    /// When it was last committed.
    pub version: u64,
    pub body: Body,
}

/// What an object has beside parameters.
pub enum Body {
    Plain,
    /// Arrays that are mapped as parameters of an object without parameters, by name. Nobody reads them.
    Unsupported(Vec<(CString, Array)>),
    Array(Array),
}

impl Object {
    pub fn new(class: &'static Class, data_type: DataType, body: Body) -> Self {
        let (staged, committed) = (Parameters::default(), Parameters::default());
        Self { class, data_type, references: 1, uses: 0, staged, committed, version: 0, body }
    }

    pub fn array(&self) -> Option<&Array> {
        if let Body::Array(array) = &self.body { Some(array) } else { None }
    }

    pub fn array_mut(&mut self) -> Option<&mut Array> {
        if let Body::Array(array) = &mut self.body { Some(array) } else { None }
    }

    /// The objects that this one refers to, once per reference.
    fn referred(&self) -> Vec<Handle> {
        let parameters = self.staged.objects().chain(self.committed.objects());
        parameters.chain(self.array().into_iter().flat_map(|array| array.elements.iter().copied())).collect()
    }
}

/// All objects of a device.
#[derive(Default)]
pub struct Objects {
    last: usize,
    clock: u64,
    all: HashMap<Handle, Object>,
    /// Objects without references, to be dropped where deleters of the application may run.
    pub dropped: Vec<(Handle, Object)>,
}

impl Objects {
    pub fn insert(&mut self, object: Object) -> Handle {
        self.last += Handle::STEP;
        let handle = Handle(self.last);
        self.all.insert(handle, object);
        handle
    }

    /// Inserts the device itself, whose handle is its address.
    pub fn insert_device(&mut self, handle: Handle, object: Object) {
        self.all.insert(handle, object);
    }

    pub fn get(&self, handle: Handle) -> Option<&Object> {
        self.all.get(&handle)
    }

    pub fn get_mut(&mut self, handle: Handle) -> Option<&mut Object> {
        self.all.get_mut(&handle)
    }

    /// The object of a handle.
    ///
    /// # Errors
    /// If there is none.
    pub fn known(&self, handle: Handle) -> Result<&Object, Problem> {
        self.get(handle).ok_or_else(|| unknown(handle))
    }

    /// As [`known`](Self::known).
    pub fn known_mut(&mut self, handle: Handle) -> Result<&mut Object, Problem> {
        self.get_mut(handle).ok_or_else(|| unknown(handle))
    }

    /// A number that is larger than all before.
    pub fn tick(&mut self) -> u64 {
        self.clock += 1;
        self.clock
    }

    /// Number of objects.
    pub fn count(&self) -> usize {
        self.all.len()
    }

    /// Adds a reference of the application.
    pub fn retain(&mut self, handle: Handle) -> Result<(), Problem> {
        self.known_mut(handle)?.references += 1;
        Ok(())
    }

    /// Removes a reference of the application.
    pub fn release(&mut self, handle: Handle) -> Result<(), Problem> {
        let object = self.known_mut(handle)?;
        object.references = object.references.checked_sub(1).ok_or_else(|| {
            Problem::operation("this object was released already and lives only because others refer to it: it stays")
        })?;
        self.drop_unused(handle);
        Ok(())
    }

    /// Adds a reference of a parameter or an array.
    pub fn add_use(&mut self, handle: Handle) {
        if let Some(object) = self.get_mut(handle) {
            object.uses += 1;
        }
    }

    /// Removes a reference of a parameter or an array.
    pub fn remove_use(&mut self, handle: Handle) {
        if let Some(object) = self.get_mut(handle) {
            object.uses -= 1;
        }
        self.drop_unused(handle);
    }

    /// Takes an object without references out of the table, and all objects that only it referred to.
    fn drop_unused(&mut self, handle: Handle) {
        let mut candidates = vec![handle];
        while let Some(candidate) = candidates.pop() {
            let is_unused = self.get(candidate).is_some_and(|object| object.references == 0 && object.uses == 0);
            let Some(object) = is_unused.then(|| self.all.remove(&candidate)).flatten() else { continue };
            for referred in object.referred() {
                if let Some(object) = self.get_mut(referred) {
                    object.uses -= 1;
                }
                candidates.push(referred);
            }
            self.dropped.push((candidate, object));
        }
    }

    /// Sets a parameter, or removes it.
    pub fn stage(&mut self, handle: Handle, name: &'static CStr, value: Option<Value>) {
        let added = value.as_ref().and_then(Value::object);
        let Some(object) = self.get_mut(handle) else { return };
        let removed = object.staged.replace(name, value).and_then(|value| value.object());
        added.into_iter().for_each(|handle| self.add_use(handle));
        removed.into_iter().for_each(|handle| self.remove_use(handle));
    }

    /// Makes the parameters that were set count.
    pub fn commit(&mut self, handle: Handle) {
        let version = self.tick();
        let Some(object) = self.get_mut(handle) else { return };
        object.version = version;
        let added: Vec<_> = object.staged.objects().collect();
        let before = std::mem::replace(&mut object.committed, object.staged.clone());
        added.into_iter().for_each(|handle| self.add_use(handle));
        before.objects().for_each(|handle| self.remove_use(handle));
    }

    /// Replaces the objects that an array refers to.
    pub fn set_elements(&mut self, handle: Handle, elements: Vec<Handle>) {
        elements.iter().for_each(|&element| self.add_use(element));
        let Some(array) = self.get_mut(handle).and_then(Object::array_mut) else { return };
        let before = std::mem::replace(&mut array.elements, elements);
        before.into_iter().for_each(|element| self.remove_use(element));
    }
}

fn unknown(handle: Handle) -> Problem {
    Problem::operation(format!("{:#x} is not an object of this device: it was released, or never made", handle.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schema;
    use anari_sys::*;

    fn made(objects: &mut Objects, data_type: DataType, subtype: &CStr) -> Handle {
        objects.insert(Object::new(schema::find(data_type, subtype).unwrap(), data_type, Body::Plain))
    }

    #[test]
    fn objects_live_as_long_as_something_refers_to_them() {
        let mut objects = Objects::default();
        let volume = made(&mut objects, ANARI_VOLUME, c"transferFunction1D");
        let field = made(&mut objects, ANARI_SPATIAL_FIELD, c"structuredRegular");
        objects.stage(volume, c"value", Some(Value::Object(field)));
        objects.commit(volume);
        objects.release(field).unwrap();
        assert!(objects.release(field).is_err(), "a second release changes nothing");
        // Unset, but committed: the field stays until the next commit.
        objects.stage(volume, c"value", None);
        assert_eq!((objects.count(), objects.get(field).unwrap().uses), (2, 1));
        objects.commit(volume);
        assert_eq!((objects.count(), objects.dropped.len()), (1, 1));
        assert!(objects.retain(field).is_err());
        objects.release(volume).unwrap();
        assert_eq!(objects.count(), 0);
    }
}
