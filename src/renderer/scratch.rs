//! Buffers that frames write and the next frame writes again.

use crate::device::{Buffer, Device, ScratchMemory};
use crate::error::Error;
use std::sync::{Arc, Weak};

/// A buffer that only grows.
pub(super) struct Growing<T> {
    buffer: Option<Buffer<T>>,
    /// What the buffer was cut out of, and for which frame.
    cut: Option<(Weak<ScratchMemory>, u64)>,
    /// Whether it is cut out of the caller's scratch memory where a frame has that.
    of_frames: bool,
}

impl<T> Default for Growing<T> {
    fn default() -> Self {
        Self { buffer: None, cut: None, of_frames: false }
    }
}

impl<T: Copy> Growing<T> {
    /// One that is as large as pictures are, and comes out of the caller's scratch memory where a frame has that.
    pub fn of_frames() -> Self {
        Self { of_frames: true, ..Self::default() }
    }

    /// Bytes of a buffer of `len` values that would have to be made; 0 if it is there.
    pub fn missing(&self, device: &Device, len: usize) -> u64 {
        if self.scratch(device).is_some() || self.is_there(device, len) { 0 } else { len as u64 * size_of::<T>() as u64 }
    }

    /// The buffer, made anew if it is shorter than `len`. `what` it holds is named if there is not enough memory.
    pub fn at_least(&mut self, device: &Device, len: usize, what: &str) -> Result<&mut Buffer<T>, Error> {
        if !self.is_there(device, len) {
            // The old one goes first: there may be no room for both.
            self.buffer = None;
        }
        let scratch = self.scratch(device).cloned();
        match &mut self.buffer {
            Some(buffer) => Ok(buffer),
            empty => {
                self.cut = scratch.as_ref().map(|s| (Arc::downgrade(s), s.frame()));
                Ok(empty.insert(match scratch {
                    Some(scratch) => Buffer::in_scratch(device, &scratch, len, what)?,
                    None => Buffer::new(device, len, what)?,
                }))
            }
        }
    }

    /// A new buffer of `values`: what was there may still be read by frames on their way.
    pub fn filled(&mut self, device: &Device, values: &[T], what: &str) -> Result<&Buffer<T>, Error> {
        self.buffer = None;
        Ok(self.buffer.insert(Buffer::from_slice(device, values, what)?))
    }

    /// The scratch memory of a frame, if this is to be cut out of it.
    fn scratch<'d>(&self, device: &'d Device) -> Option<&'d Arc<ScratchMemory>> {
        device.scratch().filter(|_| self.of_frames)
    }

    /// Whether the buffer is long enough, and of this frame where it is cut out.
    fn is_there(&self, device: &Device, len: usize) -> bool {
        let of_this = match (&self.cut, self.scratch(device)) {
            (None, None) => true,
            (Some((of, frame)), Some(scratch)) => of.ptr_eq(&Arc::downgrade(scratch)) && *frame == scratch.frame(),
            _ => false,
        };
        of_this && self.buffer.as_ref().is_some_and(|buffer| buffer.len() >= len)
    }
}
