//! Buffers that frames write: allocated from the frame's declarations and reused across frames.

use super::resources::{Resources, Slot};
use crate::device::{Buffer, Device, ScratchMemory};
use crate::error::Error;
use std::any::Any;
use std::collections::HashMap;
use std::sync::{Arc, Weak};

/// Buffers by slot name.
#[derive(Default)]
pub(in crate::renderer) struct Arena {
    held: HashMap<&'static str, Held>,
}

struct Held {
    /// A `Buffer<T>` with the slot's `T`.
    buffer: Arc<dyn Any + Send + Sync>,
    bytes: u64,
    place: Place,
}

/// Memory of a buffer.
enum Place {
    Own,
    /// The caller's scratch memory, for one frame.
    Scratch(Weak<ScratchMemory>, u64),
    /// The caller's picture memory, for one frame.
    Bound,
}

impl Held {
    /// Whether a frame of this device handle can use the buffer for this number of bytes.
    fn serves(&self, device: &Device, bytes: u64) -> bool {
        let current = match (&self.place, device.scratch()) {
            (Place::Own, None) => true,
            (Place::Scratch(memory, frame), Some(scratch)) => {
                memory.ptr_eq(&Arc::downgrade(scratch)) && *frame == scratch.frame()
            }
            _ => false,
        };
        current && self.bytes >= bytes
    }
}

impl Arena {
    /// Bytes of a frame's buffers that are not allocated yet.
    pub fn missing(&self, device: &Device, resources: &Resources) -> u64 {
        if device.scratch().is_some() {
            return 0;
        }
        let missing =
            resources.arena_buffers().filter(|r| !self.held.get(r.name).is_some_and(|held| held.serves(device, r.bytes)));
        missing.map(|resource| resource.bytes).sum()
    }

    /// Allocates the missing buffers of a frame.
    pub fn reserve(&mut self, device: &Device, resources: &Resources) -> Result<(), Error> {
        self.held.retain(|_, held| !matches!(held.place, Place::Bound));
        for resource in resources.arena_buffers() {
            if self.held.get(resource.name).is_some_and(|held| held.serves(device, resource.bytes)) {
                continue;
            }
            // Free the old buffer first: there may not be enough memory for both.
            self.held.remove(resource.name);
            let scratch = device.scratch();
            let (allocate, len) = resource.allocate.expect("resources of the arena are typed");
            let buffer = allocate(device, scratch.map(|s| &**s), len, resource.name)?;
            let place = scratch.map_or(Place::Own, |s| Place::Scratch(Arc::downgrade(s), s.frame()));
            self.held.insert(resource.name, Held { buffer, bytes: resource.bytes, place });
        }
        Ok(())
    }

    /// A buffer declared by the frame.
    pub fn get<T: Copy + Send + Sync + 'static>(&self, slot: &Slot<T>) -> Arc<Buffer<T>> {
        let held = self.held.get(slot.name).unwrap_or_else(|| panic!("the frame does not declare {}", slot.name));
        held.buffer.clone().downcast().expect("a slot has one type")
    }

    /// A new buffer with a copy of `values`. Enqueued frames may still read the previous one.
    pub fn fill<T: Copy + Send + Sync + 'static>(
        &mut self,
        device: &Device,
        slot: &Slot<T>,
        values: &[T],
    ) -> Result<Arc<Buffer<T>>, Error> {
        self.held.remove(slot.name);
        let buffer = Arc::new(Buffer::from_slice(device, values, slot.name)?);
        self.held.insert(slot.name, Held { bytes: buffer.bytes() as u64, buffer: buffer.clone(), place: Place::Own });
        Ok(buffer)
    }

    /// A buffer for at least `len` values, for sizes that are only known after the device has counted.
    pub fn counted<T: Copy + Send + Sync + 'static>(
        &mut self,
        device: &Device,
        slot: &Slot<T>,
        len: usize,
    ) -> Result<Arc<Buffer<T>>, Error> {
        let bytes = (len.max(1) * size_of::<T>()) as u64;
        if self.held.get(slot.name).is_none_or(|held| held.bytes < bytes) {
            self.held.remove(slot.name);
            let buffer = Arc::new(Buffer::<T>::new(device, len, slot.name)?);
            self.held.insert(slot.name, Held { buffer, bytes, place: Place::Own });
        }
        Ok(self.get(slot))
    }

    /// Makes this frame write to the caller's memory instead of a buffer of the arena.
    pub fn bind<T: Copy + Send + Sync + 'static>(&mut self, slot: &Slot<T>, buffer: Arc<Buffer<T>>) {
        let bytes = buffer.bytes() as u64;
        self.held.insert(slot.name, Held { buffer, bytes, place: Place::Bound });
    }

    /// Drops all buffers except one.
    pub fn keep_only<T>(&mut self, slot: &Slot<T>) {
        self.held.retain(|name, _| *name == slot.name);
    }

    /// Drops all buffers.
    pub fn clear(&mut self) {
        self.held.clear();
    }
}
