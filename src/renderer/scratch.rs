//! Buffers that frames write and the next frame writes again.

use crate::device::{Buffer, Device};
use crate::error::Error;

/// A buffer that only grows.
pub(super) struct Growing<T>(Option<Buffer<T>>);

impl<T> Default for Growing<T> {
    fn default() -> Self {
        Self(None)
    }
}

impl<T: Copy> Growing<T> {
    /// Bytes of a buffer of `len` values that would have to be made; 0 if it is there.
    pub fn missing(&self, len: usize) -> u64 {
        let there = self.0.as_ref().is_some_and(|b| b.len() >= len);
        if there { 0 } else { len as u64 * size_of::<T>() as u64 }
    }

    /// The buffer, made anew if it is shorter than `len`. `what` it holds is named if there is not enough memory.
    pub fn at_least(&mut self, device: &Device, len: usize, what: &str) -> Result<&mut Buffer<T>, Error> {
        if self.0.as_ref().is_some_and(|b| b.len() < len) {
            self.0 = None;
        }
        match &mut self.0 {
            Some(buffer) => Ok(buffer),
            empty => Ok(empty.insert(Buffer::new(device, len, what)?)),
        }
    }

    /// The buffer with `values` in it.
    pub fn filled(&mut self, device: &Device, values: &[T], what: &str) -> Result<&Buffer<T>, Error> {
        let buffer = self.at_least(device, values.len(), what)?;
        buffer.write(device, values)?;
        Ok(buffer)
    }
}
