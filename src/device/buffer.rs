//! Device buffers that know their length and count their bytes.

use super::Device;
use crate::error::Error;
use opencl3::memory::{Buffer as ClBuffer, CL_MEM_READ_WRITE, ClMem, cl_mem};
use opencl3::types::CL_BLOCKING;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// `len` values of type `T` on a device.
pub(crate) struct Buffer<T> {
    memory: ClBuffer<T>,
    len: usize,
    allocated: Arc<AtomicU64>,
}

impl<T: Copy> Buffer<T> {
    /// An uninitialised buffer of at least one value. `what` it holds is named if there is not enough memory.
    pub fn new(device: &Device, len: usize, what: &str) -> Result<Self, Error> {
        let needed = len.max(1) as u64 * size_of::<T>() as u64;
        let info = device.info();
        let refused = |available| Error::DeviceMemory { what: what.into(), device: info.name.clone(), needed, available };
        if needed > info.largest_buffer_bytes {
            return Err(refused(info.largest_buffer_bytes));
        }
        // SAFETY: no host pointer is given.
        let memory = unsafe { ClBuffer::create(&device.inner.context, CL_MEM_READ_WRITE, len.max(1), std::ptr::null_mut()) }
            .map_err(|_| refused(info.memory_bytes.saturating_sub(device.allocated_bytes())))?;
        let allocated = device.inner.allocated.clone();
        allocated.fetch_add(needed, Ordering::Relaxed);
        Ok(Self { memory, len, allocated })
    }

    /// A buffer with a copy of `values`.
    pub fn from_slice(device: &Device, values: &[T], what: &str) -> Result<Self, Error> {
        let mut buffer = Self::new(device, values.len(), what)?;
        buffer.write(device, values)?;
        Ok(buffer)
    }

    /// Overwrites the first values.
    pub fn write(&mut self, device: &Device, values: &[T]) -> Result<(), Error> {
        assert!(values.len() <= self.len, "{} values do not fit {}", values.len(), self.len);
        if values.is_empty() {
            return Ok(());
        }
        // SAFETY: the write blocks, so `values` outlives it, and they fit.
        unsafe { device.inner.queue.enqueue_write_buffer(&mut self.memory, CL_BLOCKING, 0, values, &[]) }
            .map_err(|e| device.error("clEnqueueWriteBuffer", e))?;
        Ok(())
    }

    /// Copies the first values into `values`.
    pub fn read(&self, device: &Device, values: &mut [T]) -> Result<(), Error> {
        assert!(values.len() <= self.len, "{} values are more than {}", values.len(), self.len);
        if values.is_empty() {
            return Ok(());
        }
        // SAFETY: the read blocks, so `values` outlives it, and there are as many.
        unsafe { device.inner.queue.enqueue_read_buffer(&self.memory, CL_BLOCKING, 0, values, &[]) }
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

impl<T> Drop for Buffer<T> {
    fn drop(&mut self) {
        self.allocated.fetch_sub(self.len.max(1) as u64 * size_of::<T>() as u64, Ordering::Relaxed);
    }
}
