//! Device memory owned by the caller.

use super::Device;
use crate::error::Error;
use opencl3::error_codes::ClError;
use opencl3::memory::{
    Buffer, CL_FLOAT, CL_MEM_OBJECT_BUFFER, CL_MEM_OBJECT_IMAGE2D, CL_MEM_READ_ONLY, CL_MEM_WRITE_ONLY, CL_RGBA, CL_UNORM_INT8,
    CL_UNSIGNED_INT8, ClMem, Image, cl_mem, release_mem_object, retain_mem_object,
};
use std::mem::ManuallyDrop;

/// Names the object in errors.
const WHAT: &str = "the caller's memory";

/// A buffer or a 2D image of the caller, in the context of a device. Retained until this is dropped; each clone retains it again.
///
/// ```
/// use layersplat::device::DeviceMemory;
/// use layersplat::opencl3::{context::Context, memory::{Buffer, CL_MEM_READ_WRITE}};
/// use layersplat::{Device, DeviceChoice};
///
/// let device = Device::open(&DeviceChoice::Default)?;
/// let context = Context::from_device(&device.id().into()).expect("a context");
/// let buffer = unsafe { Buffer::<f32>::create(&context, CL_MEM_READ_WRITE, 1000, std::ptr::null_mut()) }.expect("a buffer");
/// let memory = DeviceMemory::from_buffer(&buffer)?;
/// // Retained: the memory stays valid without the original handle.
/// drop(buffer);
/// assert!(!memory.raw().is_null());
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Debug)]
pub struct DeviceMemory {
    memory: cl_mem,
    kind: MemoryKind,
    context: usize,
    flags: u64,
}

/// Kind and size of a memory object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MemoryKind {
    Buffer { bytes: usize },
    Image { width: usize, height: usize, format: ImageFormat },
}

/// Pixel formats of images that pictures can be copied into.
///
/// ```
/// use layersplat::device::ImageFormat;
///
/// assert_ne!(ImageFormat::Rgba8, ImageFormat::Floats);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageFormat {
    /// `CL_RGBA` with `CL_UNORM_INT8` or `CL_UNSIGNED_INT8` channels.
    Rgba8,
    /// `CL_RGBA` with `CL_FLOAT` channels.
    Floats,
}

// SAFETY: OpenCL memory objects may be used from any thread, and the fields never change.
unsafe impl Send for DeviceMemory {}
// SAFETY: as above.
unsafe impl Sync for DeviceMemory {}

impl DeviceMemory {
    /// Wraps a buffer.
    ///
    /// # Errors
    /// OpenCL errors.
    pub fn from_buffer<T>(buffer: &Buffer<T>) -> Result<Self, Error> {
        // SAFETY: the buffer is alive.
        unsafe { Self::from_raw(buffer.get()) }
    }

    /// Wraps a 2D RGBA image with 8-bit or float channels.
    ///
    /// # Errors
    /// As [`from_raw`](Self::from_raw).
    pub fn from_image(image: &Image) -> Result<Self, Error> {
        // SAFETY: the image is alive.
        unsafe { Self::from_raw(image.get()) }
    }

    /// Wraps a raw `cl_mem`.
    ///
    /// # Errors
    /// Memory that is neither a buffer nor a 2D RGBA image with 8-bit or float channels; OpenCL errors.
    ///
    /// # Safety
    /// `memory` is null or a valid OpenCL memory object during the call.
    pub unsafe fn from_raw(memory: cl_mem) -> Result<Self, Error> {
        if memory.is_null() {
            return Err(rejected("is not a memory object: the handle is null"));
        }
        let failed = |e: ClError| failed("clGetMemObjectInfo", e);
        // Borrowed for the queries: releases nothing.
        let queried = ManuallyDrop::new(Buffer::<u8>::new(memory));
        let context = queried.context().map_err(failed)? as usize;
        let flags = queried.flags().map_err(failed)?;
        let kind = match queried.mem_type().map_err(failed)? {
            CL_MEM_OBJECT_BUFFER => MemoryKind::Buffer { bytes: queried.size().map_err(failed)? },
            CL_MEM_OBJECT_IMAGE2D => image_kind(memory)?,
            _ => return Err(rejected("is neither a buffer nor a 2D image")),
        };
        // SAFETY: guaranteed by the caller; `drop` releases this reference.
        unsafe { retain_mem_object(memory) }.map_err(|e| self::failed("clRetainMemObject", ClError(e)))?;
        Ok(Self { memory, kind, context, flags })
    }

    /// The raw handle.
    pub fn raw(&self) -> cl_mem {
        self.memory
    }

    pub(crate) fn kind(&self) -> MemoryKind {
        self.kind
    }

    /// Checks that kernels of `device` can read this memory, or write it if `written`.
    pub(crate) fn check(&self, device: &Device, what: &'static str, written: bool) -> Result<(), Error> {
        let reject = |problem: &str| Err(Error::Memory { what, problem: problem.into() });
        if self.context != device.context() as usize {
            return reject("belongs to another context: create it in the context of the device");
        }
        match (written, self.flags) {
            (true, flags) if flags & CL_MEM_READ_ONLY != 0 => reject("is CL_MEM_READ_ONLY, but kernels have to write it"),
            (false, flags) if flags & CL_MEM_WRITE_ONLY != 0 => reject("is CL_MEM_WRITE_ONLY, but kernels have to read it"),
            _ => Ok(()),
        }
    }
}

fn image_kind(memory: cl_mem) -> Result<MemoryKind, Error> {
    let image = ManuallyDrop::new(Image::new(memory));
    let failed = |e: ClError| failed("clGetImageInfo", e);
    let format = image.format().map_err(failed)?;
    let format = match format.first().map(|f| (f.image_channel_order, f.image_channel_data_type)) {
        Some((CL_RGBA, CL_UNORM_INT8 | CL_UNSIGNED_INT8)) => ImageFormat::Rgba8,
        Some((CL_RGBA, CL_FLOAT)) => ImageFormat::Floats,
        other => {
            let problem =
                format!("is an image with channels {other:?}: use CL_RGBA with CL_UNORM_INT8, CL_UNSIGNED_INT8 or CL_FLOAT");
            return Err(Error::Memory { what: WHAT, problem });
        }
    };
    Ok(MemoryKind::Image { width: image.width().map_err(failed)?, height: image.height().map_err(failed)?, format })
}

fn rejected(problem: &str) -> Error {
    Error::Memory { what: WHAT, problem: problem.into() }
}

fn failed(call: &'static str, source: ClError) -> Error {
    Error::OpenCl { call, device: WHAT.into(), source }
}

impl Clone for DeviceMemory {
    fn clone(&self) -> Self {
        // SAFETY: `self` keeps the memory alive; retaining a live object does not fail.
        unsafe { retain_mem_object(self.memory) }.expect("clRetainMemObject of live memory");
        Self { ..*self }
    }
}

impl Drop for DeviceMemory {
    fn drop(&mut self) {
        // SAFETY: releases the reference owned by `self`.
        if let Err(code) = unsafe { release_mem_object(self.memory) } {
            tracing::warn!("clReleaseMemObject failed: {}", ClError(code));
        }
    }
}
