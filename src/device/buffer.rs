//! Device buffers that know their length and count their bytes.

use super::Device;
use super::budget::Taken;
use crate::error::Error;
use opencl3::error_codes::{
    CL_INVALID_BUFFER_SIZE, CL_MEM_OBJECT_ALLOCATION_FAILURE, CL_OUT_OF_HOST_MEMORY, CL_OUT_OF_RESOURCES, ClError,
};
use opencl3::memory::{Buffer as ClBuffer, CL_MEM_READ_WRITE, ClMem, cl_mem};
use opencl3::types::CL_BLOCKING;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// `len` values of type `T` on a device.
pub(crate) struct Buffer<T> {
    memory: ClBuffer<T>,
    len: usize,
    allocated: Arc<AtomicU64>,
    _taken: Taken,
}

impl<T: Copy> Buffer<T> {
    /// An uninitialised buffer of at least one value. `what` it holds is named if there is not enough memory.
    pub fn new(device: &Device, len: usize, what: &str) -> Result<Self, Error> {
        let needed = len.max(1) as u64 * size_of::<T>() as u64;
        let info = device.info();
        let available = device.largest_buffer_bytes();
        if needed > available {
            return Err(Error::DeviceMemory { what: what.into(), device: info.name.clone(), needed, available });
        }
        let taken = device.budget.take(what, needed)?;
        device.require(what, needed, 0)?;
        // SAFETY: no host pointer is given.
        let memory = unsafe { ClBuffer::create(&device.inner.context, CL_MEM_READ_WRITE, len.max(1), std::ptr::null_mut()) }
            .map_err(|e| not_created(device, what, needed, e))?;
        let allocated = device.inner.allocated.clone();
        allocated.fetch_add(needed, Ordering::Relaxed);
        Ok(Self { memory, len, allocated, _taken: taken })
    }

    /// A buffer with a copy of `values`.
    pub fn from_slice(device: &Device, values: &[T], what: &str) -> Result<Self, Error> {
        let mut buffer = Self::new(device, values.len(), what)?;
        buffer.write(device, values)?;
        Ok(buffer)
    }

    /// Overwrites the first values.
    pub fn write(&mut self, device: &Device, values: &[T]) -> Result<(), Error> {
        self.write_at(device, 0, values)
    }

    /// Overwrites values from the one at `first` on.
    pub fn write_at(&mut self, device: &Device, first: usize, values: &[T]) -> Result<(), Error> {
        assert!(first + values.len() <= self.len, "{} values from {first} on do not fit {}", values.len(), self.len);
        if values.is_empty() {
            return Ok(());
        }
        // SAFETY: the write blocks, so `values` outlives it, and they fit.
        unsafe { device.inner.queue.enqueue_write_buffer(&mut self.memory, CL_BLOCKING, first * size_of::<T>(), values, &[]) }
            .map_err(|e| device.error("clEnqueueWriteBuffer", e))?;
        Ok(())
    }

    /// Copies the first values into `values`.
    pub fn read(&self, device: &Device, values: &mut [T]) -> Result<(), Error> {
        self.read_at(device, 0, values)
    }

    /// Copies values from the one at `first` on into `values`.
    pub fn read_at(&self, device: &Device, first: usize, values: &mut [T]) -> Result<(), Error> {
        assert!(first + values.len() <= self.len, "there are no {} values from {first} on in {}", values.len(), self.len);
        if values.is_empty() {
            return Ok(());
        }
        // SAFETY: the read blocks, so `values` outlives it, and there are as many.
        unsafe { device.inner.queue.enqueue_read_buffer(&self.memory, CL_BLOCKING, first * size_of::<T>(), values, &[]) }
            .map_err(|e| device.error("clEnqueueReadBuffer", e))?;
        Ok(())
    }

    /// Number of values.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Number of bytes.
    pub fn bytes(&self) -> usize {
        self.len.max(1) * size_of::<T>()
    }

    pub(super) fn handle(&self) -> cl_mem {
        self.memory.get()
    }
}

/// What clCreateBuffer answers where memory is short; anything else is another mistake.
const SHORT_OF_MEMORY: [i32; 4] =
    [CL_MEM_OBJECT_ALLOCATION_FAILURE, CL_OUT_OF_RESOURCES, CL_OUT_OF_HOST_MEMORY, CL_INVALID_BUFFER_SIZE];

fn not_created(device: &Device, what: &str, needed: u64, source: ClError) -> Error {
    if !SHORT_OF_MEMORY.contains(&source.0) {
        return device.error("clCreateBuffer", source);
    }
    let info = device.info();
    let left = info.memory_bytes.saturating_sub(device.allocated_bytes());
    Error::OutOfDeviceMemory { what: what.into(), device: info.name.clone(), needed, left, source }
}

impl<T> Drop for Buffer<T> {
    fn drop(&mut self) {
        self.allocated.fetch_sub(self.len.max(1) as u64 * size_of::<T>() as u64, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::DeviceChoice;
    use opencl3::error_codes::{CL_INVALID_CONTEXT, CL_INVALID_HOST_PTR, CL_INVALID_VALUE};

    #[test]
    fn only_a_lack_of_memory_is_called_so() {
        let device = Device::open(&DeviceChoice::Default).expect("the tests need an OpenCL device: scripts/test installs PoCL");
        let message = |code| not_created(&device, "the voxels", 12345, ClError(code)).to_string();
        for code in SHORT_OF_MEMORY {
            assert!(message(code).contains("the voxels needs 12345 bytes"), "{}", message(code));
        }
        let others = [(CL_INVALID_CONTEXT, "CL_INVALID_CONTEXT"), (CL_INVALID_VALUE, "CL_INVALID_VALUE")];
        for (code, name) in others.into_iter().chain([(CL_INVALID_HOST_PTR, "-37"), (-9999, "-9999")]) {
            let message = message(code);
            assert!(message.contains("clCreateBuffer failed") && message.contains(name), "{message}");
            assert!(!message.contains("bytes"), "{message}");
        }
        let too_large = Buffer::<u8>::new(&device, usize::MAX / 2, "the voxels").err().expect("no device has that much");
        assert!(too_large.to_string().contains("in one buffer"), "{too_large}");
    }
}
