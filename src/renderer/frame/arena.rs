//! The buffers that frames write: allocated from what a frame declares, and kept for the next one.

use super::resources::{Resources, Slot};
use crate::device::{Buffer, Device, ScratchMemory};
use crate::error::Error;
use std::any::Any;
use std::collections::HashMap;
use std::sync::{Arc, Weak};

/// Buffers by the names of their slots.
#[derive(Default)]
pub(in crate::renderer) struct Arena {
    held: HashMap<&'static str, Held>,
}

struct Held {
    /// A `Buffer<T>` of the slot's `T`.
    buffer: Arc<dyn Any + Send + Sync>,
    bytes: u64,
    place: Place,
}

/// Where a buffer lies.
enum Place {
    Own,
    /// In the caller's scratch memory, for one frame.
    Scratch(Weak<ScratchMemory>, u64),
    /// The caller's memory that a picture goes to, for one frame.
    Bound,
}

impl Held {
    /// Whether a frame of this device handle that needs so many bytes can use the buffer.
    fn serves(&self, device: &Device, bytes: u64) -> bool {
        let of_frame = match (&self.place, device.scratch()) {
            (Place::Own, None) => true,
            (Place::Scratch(of, frame), Some(scratch)) => of.ptr_eq(&Arc::downgrade(scratch)) && *frame == scratch.frame(),
            _ => false,
        };
        of_frame && self.bytes >= bytes
    }
}

impl Arena {
    /// Bytes that the buffers of a frame still need.
    pub fn missing(&self, device: &Device, resources: &Resources) -> u64 {
        if device.scratch().is_some() {
            return 0;
        }
        let missing = resources.of_arena().filter(|r| !self.held.get(r.name).is_some_and(|held| held.serves(device, r.bytes)));
        missing.map(|resource| resource.bytes).sum()
    }

    /// Makes the buffers that a frame declares and that are not there.
    pub fn reserve(&mut self, device: &Device, resources: &Resources) -> Result<(), Error> {
        self.held.retain(|_, held| !matches!(held.place, Place::Bound));
        for resource in resources.of_arena() {
            if self.held.get(resource.name).is_some_and(|held| held.serves(device, resource.bytes)) {
                continue;
            }
            // The old one goes first: there may be no room for both.
            self.held.remove(resource.name);
            let scratch = device.scratch();
            let (allocate, len) = resource.allocate.expect("resources of the arena are typed");
            let buffer = allocate(device, scratch.map(|s| &**s), len, resource.name)?;
            let place = scratch.map_or(Place::Own, |s| Place::Scratch(Arc::downgrade(s), s.frame()));
            self.held.insert(resource.name, Held { buffer, bytes: resource.bytes, place });
        }
        Ok(())
    }

    /// A buffer that the frame declares.
    pub fn get<T: Copy + Send + Sync + 'static>(&self, slot: &Slot<T>) -> Arc<Buffer<T>> {
        let held = self.held.get(slot.name).unwrap_or_else(|| panic!("the frame does not declare {}", slot.name));
        held.buffer.clone().downcast().expect("a slot has one type")
    }

    /// A new buffer with a copy of values: the one before may still be read by enqueued frames.
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

    /// A buffer of at least `len` values, where that number is only known once the device has counted.
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

    /// Lets this frame write into memory of the caller instead of a buffer of the arena.
    pub fn bind<T: Copy + Send + Sync + 'static>(&mut self, slot: &Slot<T>, buffer: Arc<Buffer<T>>) {
        let bytes = buffer.bytes() as u64;
        self.held.insert(slot.name, Held { buffer, bytes, place: Place::Bound });
    }

    /// Drops all buffers but one.
    pub fn keep_only<T>(&mut self, slot: &Slot<T>) {
        self.held.retain(|name, _| *name == slot.name);
    }

    /// Drops all buffers.
    pub fn clear(&mut self) {
        self.held.clear();
    }
}
