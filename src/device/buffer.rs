//! Typed device buffers whose bytes are counted.

use super::budget::Taken;
use super::{Device, DeviceMemory, MemoryKind, ScratchMemory};
use crate::error::Error;
use opencl3::error_codes::{
    CL_INVALID_BUFFER_SIZE, CL_MEM_OBJECT_ALLOCATION_FAILURE, CL_OUT_OF_HOST_MEMORY, CL_OUT_OF_RESOURCES, ClError,
};
use opencl3::memory::{Buffer as ClBuffer, CL_MEM_COPY_HOST_PTR, CL_MEM_READ_WRITE, ClMem, Image, cl_mem, retain_mem_object};
use opencl3::types::CL_BLOCKING;
use std::ffi::c_void;
use std::mem::ManuallyDrop;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// `len` values of type `T` on a device.
pub(crate) struct Buffer<T> {
    memory: ClBuffer<T>,
    len: usize,
    /// Counter of allocated bytes. `None` for the caller's memory, which is not counted.
    allocated: Option<Arc<AtomicU64>>,
    /// Share of the handle's budget, likewise.
    _taken: Option<Taken>,
}

impl<T: Copy> Buffer<T> {
    /// An uninitialised buffer of at least one value. `what`: description of the contents for error messages.
    pub fn new(device: &Device, len: usize, what: &str) -> Result<Self, Error> {
        // SAFETY: no host pointer is given.
        unsafe { Self::create(device, len, CL_MEM_READ_WRITE, std::ptr::null(), what) }
    }

    /// A buffer with a copy of `values`. The copy is complete on return, and does not wait for any queue.
    pub fn from_slice(device: &Device, values: &[T], what: &str) -> Result<Self, Error> {
        if values.is_empty() {
            return Self::new(device, 0, what);
        }
        let flags = CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR;
        // SAFETY: the length is that of the slice.
        unsafe { Self::create(device, values.len(), flags, values.as_ptr(), what) }
    }

    /// Fails if a buffer of `len` values is larger than the device supports.
    pub fn check_size(device: &Device, len: usize, what: &str) -> Result<(), Error> {
        let (needed, available) = (len as u64 * size_of::<T>() as u64, device.largest_buffer_bytes());
        if needed <= available {
            return Ok(());
        }
        Err(Error::DeviceMemory { what: what.into(), device: device.info().name.clone(), needed, available })
    }

    /// # Safety
    /// With CL_MEM_COPY_HOST_PTR, `values` must point to `len` values; otherwise it must be null.
    unsafe fn create(device: &Device, len: usize, flags: u64, values: *const T, what: &str) -> Result<Self, Error> {
        let needed = len.max(1) as u64 * size_of::<T>() as u64;
        if device.rehearsal().is_some() {
            return Self::for_rehearsal(device, len, what);
        }
        Self::check_size(device, len, what)?;
        let taken = device.budget.take(what, needed)?;
        device.require(what, needed, 0)?;
        #[cfg(test)]
        device.shared.programs.faults.at(super::Call::Allocation).map_err(|e| creation_error(device, what, needed, e))?;
        // SAFETY: guaranteed by the caller; CL_MEM_COPY_HOST_PTR only reads the values.
        let memory =
            unsafe { ClBuffer::create(&device.shared.programs.context, flags, len.max(1), values.cast_mut().cast::<c_void>()) }
                .map_err(|e| creation_error(device, what, needed, e))?;
        let allocated = device.shared.allocated.clone();
        allocated.fetch_add(needed, Ordering::Relaxed);
        Ok(Self { memory, len, allocated: Some(allocated), _taken: Some(taken) })
    }

    /// A one-element buffer that reports `len` values. A dry run writes and reads nothing.
    fn for_rehearsal(device: &Device, len: usize, what: &str) -> Result<Self, Error> {
        // SAFETY: no host pointer is given.
        let memory = unsafe { ClBuffer::create(&device.shared.programs.context, CL_MEM_READ_WRITE, 1, std::ptr::null_mut()) };
        let memory = memory.map_err(|e| creation_error(device, what, size_of::<T>() as u64, e))?;
        Ok(Self { memory, len, allocated: None, _taken: None })
    }

    /// Wraps the first `len` values of the caller's memory, which must be large enough.
    pub fn from_memory(device: &Device, memory: &DeviceMemory, len: usize) -> Result<Self, Error> {
        debug_assert!(matches!(memory.kind(), MemoryKind::Buffer { bytes } if bytes >= len * size_of::<T>()));
        // SAFETY: the memory is alive; `ClBuffer` releases this reference.
        unsafe { retain_mem_object(memory.raw()) }.map_err(|e| device.error("clRetainMemObject", ClError(e)))?;
        Ok(Self { memory: ClBuffer::new(memory.raw()), len, allocated: None, _taken: None })
    }

    /// `len` uninitialised values in the caller's scratch memory, for the current frame.
    pub fn in_scratch(device: &Device, scratch: &ScratchMemory, len: usize, what: &str) -> Result<Self, Error> {
        let len = len.max(1);
        Self::from_memory(device, scratch.take(len * size_of::<T>(), what)?, len)
    }

    /// Overwrites values, beginning at index `first`.
    pub fn write_at(&mut self, device: &Device, first: usize, values: &[T]) -> Result<(), Error> {
        assert!(first + values.len() <= self.len, "cannot write {} values at {first}: the buffer has {}", values.len(), self.len);
        if values.is_empty() || device.rehearsal().is_some() {
            return Ok(());
        }
        device.command("clEnqueueWriteBuffer", |queue, wait| {
            // SAFETY: the write blocks, so `values` outlives it; the range is checked above.
            unsafe { queue.enqueue_write_buffer(&mut self.memory, CL_BLOCKING, first * size_of::<T>(), values, wait) }
        })?;
        device.release_finished();
        Ok(())
    }

    /// Sets the first `len` values, on the device.
    pub fn fill(&self, device: &Device, value: T, len: usize) -> Result<(), Error> {
        assert!(len <= self.len, "cannot fill {len} values: the buffer has {}", self.len);
        if len == 0 || device.rehearsal().is_some() {
            return Ok(());
        }
        // A borrowed handle: nothing is released.
        let mut to = ManuallyDrop::new(ClBuffer::<T>::new(self.memory.get()));
        device.command("clEnqueueFillBuffer", |queue, wait| {
            // SAFETY: the command copies the pattern; the range is checked above.
            unsafe { queue.enqueue_fill_buffer(&mut to, &[value], 0, len * size_of::<T>(), wait) }
        })?;
        Ok(())
    }

    /// Copies the first values into `values`.
    pub fn read(&self, device: &Device, values: &mut [T]) -> Result<(), Error> {
        self.read_at(device, 0, values)
    }

    /// Copies values into `values`, beginning at index `first`.
    pub fn read_at(&self, device: &Device, first: usize, values: &mut [T]) -> Result<(), Error> {
        assert!(first + values.len() <= self.len, "cannot read {} values at {first}: the buffer has {}", values.len(), self.len);
        if values.is_empty() || device.rehearsal().is_some() {
            return Ok(());
        }
        device.command("clEnqueueReadBuffer", |queue, wait| {
            // SAFETY: the read blocks, so `values` outlives it; the range is checked above.
            unsafe { queue.enqueue_read_buffer(&self.memory, CL_BLOCKING, first * size_of::<T>(), values, wait) }
        })?;
        device.release_finished();
        Ok(())
    }

    /// Copies `rows` rows of `columns` values to the caller's buffer, from byte offset `first` on and `pitch` bytes apart. The
    /// destination must lie within the buffer.
    pub fn copy_rows(
        &self,
        device: &Device,
        columns: usize,
        rows: usize,
        to: &DeviceMemory,
        first: usize,
        pitch: usize,
    ) -> Result<(), Error> {
        let row = columns * size_of::<T>();
        // A borrowed handle: nothing is released.
        let mut to = ManuallyDrop::new(ClBuffer::<T>::new(to.raw()));
        let (from_origin, to_origin, region) = ([0; 3], [first % pitch, first / pitch, 0], [row, rows, 1]);
        let [from_origin, to_origin, region] = [&from_origin, &to_origin, &region].map(|place| place.as_ptr());
        device.command("clEnqueueCopyBufferRect", |queue, wait| {
            // SAFETY: both buffers are alive and large enough for the rows; the arrays outlive the call.
            unsafe {
                queue.enqueue_copy_buffer_rect(&self.memory, &mut to, from_origin, to_origin, region, row, 0, pitch, 0, wait)
            }
        })?;
        Ok(())
    }

    /// Copies `rows` rows of `columns` pixels to the caller's image of the same size and pixel type.
    pub fn copy_to_image(&self, device: &Device, columns: usize, rows: usize, to: &DeviceMemory) -> Result<(), Error> {
        // A borrowed handle: nothing is released.
        let mut to = ManuallyDrop::new(Image::new(to.raw()));
        let (origin, region) = ([0; 3], [columns, rows, 1]);
        device.command("clEnqueueCopyBufferToImage", |queue, wait| {
            // SAFETY: both are alive and have the same size; the arrays outlive the call.
            unsafe { queue.enqueue_copy_buffer_to_image(&self.memory, &mut to, 0, origin.as_ptr(), region.as_ptr(), wait) }
        })?;
        Ok(())
    }

    /// Whether the buffer was allocated here, rather than by the caller.
    pub fn is_owned(&self) -> bool {
        self.allocated.is_some()
    }

    /// Number of values.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Number of bytes.
    pub fn bytes(&self) -> usize {
        self.len.max(1) * size_of::<T>()
    }

    /// The buffer as if it were the caller's.
    #[cfg(test)]
    pub fn as_memory(&self) -> super::DeviceMemory {
        super::DeviceMemory::from_buffer(&self.memory).expect("it is alive")
    }

    pub(super) fn handle(&self) -> cl_mem {
        self.memory.get()
    }
}

/// Errors of clCreateBuffer that mean a lack of memory.
const OUT_OF_MEMORY: [i32; 4] =
    [CL_MEM_OBJECT_ALLOCATION_FAILURE, CL_OUT_OF_RESOURCES, CL_OUT_OF_HOST_MEMORY, CL_INVALID_BUFFER_SIZE];

/// The error for a failed clCreateBuffer.
fn creation_error(device: &Device, what: &str, needed: u64, source: ClError) -> Error {
    if !OUT_OF_MEMORY.contains(&source.0) {
        return device.error("clCreateBuffer", source);
    }
    let info = device.info();
    let left = info.memory_bytes.saturating_sub(device.allocated_bytes());
    Error::OutOfDeviceMemory { what: what.into(), device: info.name.clone(), needed, left, source }
}

impl<T> Drop for Buffer<T> {
    fn drop(&mut self) {
        if let Some(allocated) = &self.allocated {
            allocated.fetch_sub(self.len.max(1) as u64 * size_of::<T>() as u64, Ordering::Relaxed);
        }
    }
}

impl Buffer<u64> {
    /// Reads a number of list entries that the device has counted.
    ///
    /// # Errors
    /// If it exceeds the range of the kernels' counters.
    pub fn read_count(&self, device: &Device, what: &str) -> Result<usize, Error> {
        let mut count = [0];
        self.read(device, &mut count)?;
        let count = count[0];
        if count > i32::MAX as u64 {
            let bytes = |entries: u64| entries.saturating_mul(size_of::<u32>() as u64);
            let device = device.info().name.clone();
            return Err(Error::DeviceMemory {
                what: what.into(),
                device,
                needed: bytes(count),
                available: bytes(i32::MAX as u64),
            });
        }
        Ok(count as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::DeviceChoice;
    use opencl3::error_codes::{CL_INVALID_CONTEXT, CL_INVALID_HOST_PTR, CL_INVALID_VALUE};

    #[test]
    fn only_a_lack_of_memory_is_reported_as_such() {
        let device = Device::open(&DeviceChoice::Default).expect("the tests need an OpenCL device: scripts/test installs PoCL");
        let message = |code| creation_error(&device, "the voxels", 12345, ClError(code)).to_string();
        for code in OUT_OF_MEMORY {
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
