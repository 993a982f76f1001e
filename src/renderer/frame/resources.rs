//! Device resources of a frame, declared by its passes before anything is allocated.
//!
//! The same list serves the arena, the caller's scratch memory, the memory budget, the streaming plan, and the log.

use super::super::field::FieldShape;
use crate::device::{Buffer, Device, ScratchMemory};
use crate::error::Error;
use crate::layers::{Axis, Kernel};
use std::any::Any;
use std::fmt;
use std::marker::PhantomData;
use std::sync::Arc;

/// A buffer of values `T` that frames write, identified by its name in messages.
pub(in crate::renderer) struct Slot<T> {
    pub name: &'static str,
    values: PhantomData<fn() -> T>,
}

impl<T> Slot<T> {
    pub const fn new(name: &'static str) -> Self {
        Self { name, values: PhantomData }
    }
}

/// Lifetime and origin of a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::renderer) enum Lifetime {
    /// Written by kernels in each frame. The arena reuses it across frames; it may be placed in the caller's scratch memory.
    Frame,
    /// Copied from the host in each frame.
    Host,
    /// Kept in a store until its inputs change.
    Kept,
    /// The voxels.
    Field,
}

/// A buffer that a frame needs.
#[derive(Clone)]
pub(in crate::renderer) struct Resource {
    pub name: &'static str,
    pub bytes: u64,
    pub lifetime: Lifetime,
    /// Allocation function of the arena, and number of values.
    pub(super) allocate: Option<(Allocate, usize)>,
}

/// Allocates a buffer of this many values, in the caller's scratch memory if there is any.
pub(super) type Allocate = fn(&Device, Option<&ScratchMemory>, usize, &str) -> Result<Arc<dyn Any + Send + Sync>, Error>;

fn allocate<T: Copy + Send + Sync + 'static>(
    device: &Device,
    scratch: Option<&ScratchMemory>,
    len: usize,
    what: &str,
) -> Result<Arc<dyn Any + Send + Sync>, Error> {
    Ok(Arc::new(match scratch {
        Some(scratch) => Buffer::<T>::in_scratch(device, scratch, len, what)?,
        None => Buffer::<T>::new(device, len, what)?,
    }))
}

/// Kind of cached data: name, layer axis, kernel, number of the field.
type Kind = (&'static str, Option<Axis>, Option<Kernel>, usize);

/// All buffers that a frame needs.
#[derive(Clone, Default)]
pub(in crate::renderer) struct Resources {
    list: Vec<Resource>,
    kinds: Vec<Kind>,
}

impl Resources {
    /// Declares a buffer of `len` values that kernels write in each frame. Passes that declare the same slot share it.
    pub fn frame<T: Copy + Send + Sync + 'static>(&mut self, slot: &Slot<T>, len: usize) {
        let bytes = buffer_bytes::<T>(len);
        let resource =
            Resource { name: slot.name, bytes, lifetime: Lifetime::Frame, allocate: Some((allocate::<T>, len.max(1))) };
        match self.list.iter_mut().find(|r| r.name == slot.name && r.lifetime == Lifetime::Frame) {
            Some(declared) if declared.bytes >= bytes => {}
            Some(declared) => *declared = resource,
            None => self.list.push(resource),
        }
    }

    /// Declares a buffer of `len` values copied from the host in each frame.
    pub fn host<T>(&mut self, slot: &Slot<T>, len: usize) {
        let bytes = buffer_bytes::<T>(len);
        match self.list.iter_mut().find(|r| r.name == slot.name) {
            Some(declared) => declared.bytes = declared.bytes.max(bytes),
            None => self.list.push(Resource { name: slot.name, bytes, lifetime: Lifetime::Host, allocate: None }),
        }
    }

    /// Declares cached buffers, once per kind.
    pub fn kept(&mut self, kind: Kind, buffers: impl IntoIterator<Item = (&'static str, usize)>) {
        if !self.kinds.contains(&kind) {
            self.kinds.push(kind);
            self.add(Lifetime::Kept, buffers);
        }
    }

    /// Declares the voxels.
    pub fn field(&mut self, shape: &FieldShape) {
        self.add(Lifetime::Field, [("the voxels", shape.voxel_bytes())]);
    }

    fn add(&mut self, lifetime: Lifetime, buffers: impl IntoIterator<Item = (&'static str, usize)>) {
        // Empty buffers are allocated with one byte.
        let resources =
            buffers.into_iter().map(|(name, bytes)| Resource { name, bytes: bytes.max(1) as u64, lifetime, allocate: None });
        self.list.extend(resources);
    }

    /// All buffers.
    pub fn iter(&self) -> impl Iterator<Item = &Resource> {
        self.list.iter()
    }

    /// The buffers that the arena allocates.
    pub fn arena_buffers(&self) -> impl Iterator<Item = &Resource> {
        self.iter().filter(|resource| resource.lifetime == Lifetime::Frame)
    }

    /// Bytes of all buffers.
    pub fn bytes(&self) -> Bytes {
        self.iter().fold(Bytes::default(), |all, r| Bytes { sum: all.sum + r.bytes, largest: all.largest.max(r.bytes) })
    }
}

/// Bytes of a buffer of `len` values, at least one.
fn buffer_bytes<T>(len: usize) -> u64 {
    len.max(1) as u64 * size_of::<T>() as u64
}

/// Sizes of a set of buffers in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::renderer) struct Bytes {
    /// Sum of all buffers.
    pub sum: u64,
    /// Largest buffer.
    pub largest: u64,
}

impl Bytes {
    /// Of sets of which one after the other is there.
    pub fn max(self, other: Self) -> Self {
        Self { sum: self.sum.max(other.sum), largest: self.largest.max(other.largest) }
    }
}

impl fmt::Display for Resources {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Bytes { sum, largest } = self.bytes();
        write!(f, "{} buffers of {sum} bytes, the largest of {largest}: ", self.list.len())?;
        for (n, Resource { name, bytes, lifetime, .. }) in self.iter().enumerate() {
            let separator = if n == 0 { "" } else { ", " };
            write!(f, "{separator}{} {bytes} ({})", name.trim_start_matches("the "), format!("{lifetime:?}").to_lowercase())?;
        }
        Ok(())
    }
}
