//! The device: its objects behind a lock, messages, and the thread that draws.
//!
//! Functions of the application (messages, deleters, completed frames) are called without the lock, so they may call the device.

mod frames;
mod memory;
#[cfg(test)]
mod tests;

use crate::frame::{FrameState, Phase};
use crate::handle::Handle;
use crate::objects::{Body, Object, Objects};
use crate::parameters;
use crate::schema;
use crate::status::{Callback, Message, Problem, Reporter};
use crate::types::{self, DataType};
use crate::value::Value;
use crate::worker::{Worker, locked};
use anari_sys::*;
use std::collections::HashMap;
use std::ffi::{CStr, c_void};
use std::sync::Mutex;

/// An ANARI device.
pub struct Device {
    pub state: Mutex<State>,
    pub worker: Worker,
    /// Its handle: the address of the shim's object.
    handle: Handle,
}

/// What the lock protects.
pub struct State {
    pub objects: Objects,
    /// The state of each frame, which goes with its object.
    frames: HashMap<Handle, FrameState>,
    pub messages: Vec<Message>,
    reporter: Reporter,
    /// The reporter if the application sets none.
    default_reporter: Reporter,
}

impl State {
    /// Tells a problem of an object.
    pub fn tell(&mut self, handle: Handle, problem: Problem) {
        let data_type = self.objects.get(handle).map_or(ANARI_UNKNOWN, |object| object.data_type);
        self.messages.push(problem.of(handle, data_type));
    }

    pub fn reporter(&self) -> Reporter {
        self.reporter
    }

    /// The state of a frame; `None` for other objects.
    ///
    /// # Errors
    /// Unknown handles.
    fn frame(&mut self, handle: Handle) -> Result<Option<&mut FrameState>, Problem> {
        self.objects.known(handle)?;
        Ok(self.frames.get_mut(&handle))
    }
}

impl Device {
    pub fn new(handle: Handle, callback: Option<Callback>, user: usize, subtype: &CStr) -> Self {
        let reporter = Reporter { device: handle.0, callback, user };
        let mut objects = Objects::default();
        let class = schema::find(ANARI_DEVICE, c"").expect("there is a class of devices");
        objects.insert_device(handle, Object::new(class, ANARI_DEVICE, Body::Plain));
        let state = State { objects, frames: HashMap::new(), messages: Vec::new(), reporter, default_reporter: reporter };
        let device = Self { state: Mutex::new(state), worker: Worker::default(), handle };
        if !subtype.is_empty() && subtype != c"default" {
            let text = format!("there is no device '{}': this is the default one", subtype.to_string_lossy());
            device.call(|state| state.tell(handle, Problem::argument(text)));
        }
        device
    }

    /// Runs a call with the lock. Afterwards drops objects without references, and calls the application's function for messages.
    pub fn call<R>(&self, act: impl FnOnce(&mut State) -> R) -> R {
        let (result, dropped, messages, reporter) = {
            let mut state = locked(&self.state);
            let result = act(&mut state);
            let dropped = std::mem::take(&mut state.objects.dropped);
            let dropped: Vec<_> = dropped.into_iter().map(|(handle, o)| (handle, o, state.frames.remove(&handle))).collect();
            (result, dropped, std::mem::take(&mut state.messages), state.reporter)
        };
        for (handle, object, frame) in dropped {
            if object.data_type == ANARI_SPATIAL_FIELD {
                self.worker.forget_field(handle);
            }
            if let Some(task) = frame.and_then(|frame| frame.task) {
                self.end(&task);
            }
        }
        messages.iter().for_each(|message| reporter.report(message));
        result
    }

    /// As [`call`](Self::call), for calls that can fail. The problem is told as one of `handle`.
    pub fn try_call<R: Default>(&self, handle: Handle, act: impl FnOnce(&mut State) -> Result<R, Problem>) -> R {
        self.call(|state| {
            act(state).unwrap_or_else(|problem| {
                state.tell(handle, problem);
                R::default()
            })
        })
    }

    /// Makes an object of a type and subtype. An object of an unknown subtype accepts all calls and has no effect.
    pub fn new_object(&self, data_type: DataType, subtype: &CStr) -> Handle {
        // The specification asks for these substitutes.
        let otherwise =
            [ANARI_INSTANCE, ANARI_RENDERER].contains(&data_type).then(|| schema::of_type(data_type).next()).flatten();
        let exact = schema::find(data_type, subtype);
        let class = exact.or(otherwise).unwrap_or(schema::UNSUPPORTED);
        let is_plain = class.is_supported() || data_type == ANARI_FRAME;
        let body = if is_plain { Body::Plain } else { Body::Unsupported(Vec::new()) };
        self.call(|state| {
            let handle = state.objects.insert(Object::new(class, data_type, body));
            if data_type == ANARI_FRAME {
                state.frames.insert(handle, FrameState::default());
            }
            if exact.is_none() {
                let (kind, subtype) = (types::name(data_type), subtype.to_string_lossy());
                let effect = match otherwise {
                    Some(class) => format!("it is '{}'", class.subtype.to_string_lossy()),
                    None => "it has no effect".into(),
                };
                state.tell(handle, Problem::argument(format!("{kind} '{subtype}' is not supported: {effect}")));
            }
            handle
        })
    }

    /// Sets a parameter.
    ///
    /// # Safety
    /// As [`parameters::checked`].
    pub unsafe fn set_parameter(&self, handle: Handle, name: &CStr, data_type: DataType, value: *const c_void) {
        self.try_call(handle, |state| {
            let object = state.objects.known(handle)?;
            if !object.class.is_supported() {
                return Ok(());
            }
            let parameter = object.class.parameter(name).ok_or_else(|| {
                let kind = types::name(object.data_type);
                Problem::argument(format!("{kind} has no parameter '{}': it is ignored", name.to_string_lossy()))
            })?;
            check_unmapped(state, handle, name)?;
            // SAFETY: upheld by the caller.
            let (value, changed) = unsafe { parameters::checked(&state.objects, parameter, data_type, value) }?;
            state.objects.stage(handle, parameter.name, Some(value));
            changed.into_iter().for_each(|problem| state.tell(handle, problem));
            Ok(())
        });
    }

    /// Returns a parameter to its default.
    pub fn unset_parameter(&self, handle: Handle, name: &CStr) {
        self.try_call(handle, |state| {
            let parameter = state.objects.known(handle)?.class.parameter(name);
            check_unmapped(state, handle, name)?;
            if let Some(parameter) = parameter {
                state.objects.stage(handle, parameter.name, None);
            }
            Ok(())
        });
    }

    /// Returns all parameters to their defaults.
    pub fn unset_all_parameters(&self, handle: Handle) {
        self.try_call(handle, |state| {
            for name in state.objects.known(handle)?.staged.names() {
                match check_unmapped(state, handle, name) {
                    Ok(()) => state.objects.stage(handle, name, None),
                    Err(problem) => state.tell(handle, problem),
                }
            }
            Ok(())
        });
    }

    /// Makes the parameters that were set count.
    pub fn commit(&self, handle: Handle) {
        self.try_call(handle, |state| {
            let class = state.objects.known(handle)?.class;
            state.objects.commit(handle);
            let object = state.objects.known(handle)?;
            let missing = class.parameters.iter().filter(|p| p.required && object.committed.get(p.name).is_none());
            let missing: Vec<_> = missing.map(|parameter| parameter.name.to_string_lossy()).collect();
            if !missing.is_empty() {
                state.tell(handle, Problem::argument(format!("required parameters are not set: {}", missing.join(", "))));
            }
            if handle == self.handle {
                self.set_reporter(state);
            }
            Ok(())
        });
    }

    fn set_reporter(&self, state: &mut State) {
        let Some(device) = state.objects.get(self.handle) else { return };
        let set = device.pointer(c"statusCallback");
        let user = device.committed.get(c"statusCallbackUserData").map(|_| device.pointer(c"statusCallbackUserData"));
        // SAFETY: the application says that it is a function of this type; null is none.
        let callback = unsafe { std::mem::transmute::<usize, Option<Callback>>(set) };
        let default = state.default_reporter;
        state.reporter = Reporter {
            device: default.device,
            callback: callback.or(default.callback),
            user: user.unwrap_or(if callback.is_some() { 0 } else { default.user }),
        };
    }

    /// Adds a reference.
    pub fn retain(&self, handle: Handle) {
        if handle != Handle::NULL {
            self.try_call(handle, |state| state.objects.retain(handle));
        }
    }

    /// Removes a reference. Returns whether it was the last one of the device, which the caller then frees.
    pub fn release(&self, handle: Handle) -> bool {
        if handle == Handle::NULL {
            return false;
        }
        if handle == self.handle {
            return self.call(|state| match state.objects.get_mut(handle) {
                Some(device) => {
                    device.references = device.references.saturating_sub(1);
                    device.references == 0
                }
                None => true,
            });
        }
        if self.call(|state| state.objects.get(handle).is_some_and(|object| object.references == 1)) {
            self.take_memory(handle);
        }
        self.try_call(handle, |state| state.objects.release(handle));
        false
    }

    /// Reads a property into memory of `size` bytes. Returns whether there is one.
    ///
    /// # Safety
    /// `memory` has `size` bytes.
    pub unsafe fn property(
        &self,
        handle: Handle,
        name: &CStr,
        data_type: DataType,
        memory: *mut u8,
        size: u64,
        waits: bool,
    ) -> bool {
        let task = self.task(handle);
        if let Some(task) = task.as_ref().filter(|_| waits && !self.worker.is_current()) {
            task.wait(Phase::Finished);
        }
        let found = self.try_call(handle, |state| {
            let object = state.objects.known(handle)?;
            Ok(crate::properties::property(&state.objects, object, task.as_ref(), name, data_type))
        });
        let Some(bytes) = found.filter(|_| !memory.is_null()) else { return false };
        let count = bytes.len().min(usize::try_from(size).unwrap_or(usize::MAX));
        // SAFETY: upheld by the caller.
        unsafe { memory.copy_from_nonoverlapping(bytes.as_ptr(), count) };
        true
    }
}

/// Rejects changes of a parameter whose array is mapped by [`Device::map_parameter_array`].
pub fn check_unmapped(state: &State, handle: Handle, name: &CStr) -> Result<(), Problem> {
    let set = state.objects.get(handle).and_then(|object| object.staged.get(name)).and_then(Value::object);
    let array = set.and_then(|array| state.objects.get(array)).filter(|array| array.references == 0);
    if array.and_then(Object::array).is_some_and(|array| array.maps > 0) {
        let name = name.to_string_lossy();
        return Err(Problem::operation(format!("the array of {name} is mapped: unmap it first; it stays as it was")));
    }
    Ok(())
}

impl Drop for Device {
    /// Cancels all frames, and tells what the application did not release.
    fn drop(&mut self) {
        self.call(|state| {
            let tasks = state.frames.values().filter_map(|frame| frame.task.as_ref());
            tasks.for_each(|task| task.cancel.cancel());
            let rest = state.objects.count() - 1;
            if rest > 0 {
                state.tell(self.handle, Problem::information(format!("{rest} objects were not released before the device")));
            }
        });
        self.worker.end();
    }
}
