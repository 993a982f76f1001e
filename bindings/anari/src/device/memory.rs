//! Calls on arrays.

use super::{Device, State, check_unmapped};
use crate::arrays::{ApplicationMemory, Array, OBJECTS};
use crate::handle::Handle;
use crate::objects::{Body, Object};
use crate::schema;
use crate::status::Problem;
use crate::types::{self, DataType};
use crate::value::Value;
use anari_sys::ANARI_OBJECT;
use std::ffi::CStr;
use std::sync::Arc;

impl Device {
    /// Makes an array of `rank` dimensions. If that is not possible, the array is one that has no effect.
    ///
    /// # Safety
    /// As [`Array::new`].
    pub unsafe fn new_array(&self, given: ApplicationMemory, element: DataType, dims: [u64; 3], rank: usize) -> Handle {
        let data_type = anari_sys::ANARI_ARRAY1D + rank as DataType - 1;
        let is_shared = !given.memory.is_null();
        // SAFETY: upheld by the caller. Deleters may run here, without the lock.
        let made = unsafe { Array::new(given, element, dims) };
        self.call(|state| match made {
            Ok(array) => {
                let handle = insert(state, array, data_type, 1);
                // Memory of the device has no elements yet.
                if is_shared {
                    read_elements(state, handle);
                }
                handle
            }
            Err(problem) => {
                let handle = state.objects.insert(Object::new(schema::UNSUPPORTED, data_type, Body::Plain));
                state.tell(handle, problem);
                handle
            }
        })
    }

    /// Maps an array, when no frame is being drawn.
    pub fn map_array(&self, handle: Handle) -> *mut u8 {
        self.worker.wait();
        self.try_call(handle, |state| {
            let array = state.objects.known_mut(handle)?.array_mut();
            let array = array.ok_or_else(|| Problem::operation("only arrays are mapped"))?;
            array.maps += 1;
            Ok(Some(array.memory.first()))
        })
        .unwrap_or(std::ptr::null_mut())
    }

    /// Unmaps an array, whose elements have changed.
    pub fn unmap_array(&self, handle: Handle) {
        self.try_call(handle, |state| {
            state.objects.known(handle)?;
            unmap(state, handle)
        });
    }

    /// Maps a new array that becomes the value of a parameter. Returns the first element and the distance of elements.
    pub fn map_parameter_array(
        &self,
        handle: Handle,
        name: &CStr,
        element: DataType,
        dims: [u64; 3],
        rank: usize,
    ) -> Option<(*mut u8, u64)> {
        let given = ApplicationMemory { memory: std::ptr::null(), deleter: None, user: std::ptr::null() };
        // SAFETY: there is no memory of the application.
        let made = unsafe { Array::new(given, element, dims) };
        self.try_call(handle, |state| {
            let object = state.objects.known_mut(handle)?;
            if let Body::Unsupported(mapped) = &mut object.body {
                // Programs that write their arrays without a look at what they get shall not crash.
                let array = made?;
                let first = (array.memory.first(), array.stride());
                mapped.push((name.into(), array));
                return Ok(Some(first));
            }
            let data_type = anari_sys::ANARI_ARRAY1D + rank as DataType - 1;
            let parameter =
                object.class.parameter(name).filter(|parameter| parameter.types.contains(&data_type)).ok_or_else(|| {
                    let (name, kind) = (name.to_string_lossy(), types::name(data_type));
                    Problem::argument(format!("'{name}' is not a parameter that takes {kind}: nothing is mapped"))
                })?;
            check_unmapped(state, handle, name)?;
            if !parameter.elements.contains(&element) {
                let (name, element) = (parameter.name.to_string_lossy(), types::name(element));
                return Err(Problem::argument(format!("{name} cannot be an array of {element}: nothing is mapped")));
            }
            let mut array = made?;
            array.maps = 1;
            let mapped = (array.memory.first(), array.stride());
            // The parameter alone refers to it.
            let array = insert(state, array, data_type, 0);
            state.objects.stage(handle, parameter.name, Some(Value::Object(array)));
            Ok(Some(mapped))
        })
    }

    /// Unmaps the array of a parameter.
    pub fn unmap_parameter_array(&self, handle: Handle, name: &CStr) {
        self.try_call(handle, |state| {
            let object = state.objects.known_mut(handle)?;
            if let Body::Unsupported(mapped) = &mut object.body {
                mapped.retain(|(mapped, _)| mapped.as_c_str() != name);
                return Ok(());
            }
            let array = object.staged.get(name).and_then(Value::object);
            let array = array.filter(|&array| state.objects.get(array).is_some_and(|object| object.references == 0));
            match array {
                Some(array) => unmap(state, array),
                None => Err(Problem::operation(format!("{} is not mapped", name.to_string_lossy()))),
            }
        });
    }

    /// Copies the memory of an array that the application is about to release, if anything else still needs it.
    pub(super) fn take_memory(&self, handle: Handle) {
        let shared = |state: &mut State| {
            let array = state.objects.get(handle)?.array()?;
            let memory = array.memory.is_of_the_application().then(|| array.memory.clone());
            memory.zip(state.objects.get(handle).map(|object| object.uses > 0))
        };
        let Some((memory, is_used)) = self.call(shared) else { return };
        self.worker.wait();
        self.worker.painter().forget(handle);
        if !is_used {
            return;
        }
        let copy = (*memory).copied();
        self.try_call(handle, |state| {
            if let Some(array) = state.objects.known_mut(handle)?.array_mut() {
                array.memory = Arc::new(copy?);
            }
            Ok(())
        });
    }
}

/// Inserts an array with so many references of the application.
fn insert(state: &mut State, mut array: Array, data_type: DataType, references: u32) -> Handle {
    array.version = state.objects.tick();
    let class = schema::find(data_type, c"").unwrap_or(schema::UNSUPPORTED);
    let object = Object { references, ..Object::new(class, data_type, Body::Array(array)) };
    state.objects.insert(object)
}

/// Ends a mapping. The elements count as changed.
fn unmap(state: &mut State, handle: Handle) -> Result<(), Problem> {
    let version = state.objects.tick();
    let array = state.objects.get_mut(handle).and_then(Object::array_mut);
    let array = array.filter(|array| array.maps > 0).ok_or_else(|| Problem::operation("the array is not mapped"))?;
    array.maps -= 1;
    array.version = version;
    read_elements(state, handle);
    Ok(())
}

/// Reads the objects of an array. Handles of other objects, and of none, count as none.
fn read_elements(state: &mut State, handle: Handle) {
    let Some(array) = state.objects.get(handle).and_then(Object::array) else { return };
    let mut elements = array.handles();
    let type_of = |element: Handle| state.objects.get(element).map(|object| object.data_type);
    let element = match array.element {
        ANARI_OBJECT => elements.iter().find_map(|&e| type_of(e).filter(|found| OBJECTS.contains(found))).unwrap_or(ANARI_OBJECT),
        element => element,
    };
    let mut wrong = 0;
    for place in &mut elements {
        if type_of(*place) != Some(element) {
            wrong += 1;
            *place = Handle::NULL;
        }
    }
    if let Some(array) = state.objects.get_mut(handle).and_then(Object::array_mut) {
        array.element = element;
    }
    state.objects.set_elements(handle, elements);
    if wrong > 0 {
        let text = format!("{wrong} elements are not {} of this device: they are left out", types::name(element));
        state.tell(handle, Problem::argument(text));
    }
}
