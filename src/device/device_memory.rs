//! Memory of the caller's own on the device.

use super::Device;
use crate::error::Error;
use opencl3::error_codes::ClError;
use opencl3::memory::{
    Buffer, CL_FLOAT, CL_MEM_OBJECT_BUFFER, CL_MEM_OBJECT_IMAGE2D, CL_MEM_READ_ONLY, CL_MEM_WRITE_ONLY, CL_RGBA, CL_UNORM_INT8,
    CL_UNSIGNED_INT8, ClMem, Image, cl_mem, release_mem_object, retain_mem_object,
};
use std::mem::ManuallyDrop;

/// A buffer or a 2D image of the caller's, in the context of a device. Retained while this lives; clones retain it again.
///
/// ```
/// use layersplat::device::DeviceMemory;
/// use layersplat::opencl3::{context::Context, memory::{Buffer, CL_MEM_READ_WRITE}};
/// use layersplat::{Device, DeviceChoice};
///
/// let device = Device::open(&DeviceChoice::Default)?;
/// let context = Context::from_device(&device.id().into()).expect("a context");
/// let buffer = unsafe { Buffer::<f32>::create(&context, CL_MEM_READ_WRITE, 1000, std::ptr::null_mut()) }.expect("a buffer");
/// let memory = DeviceMemory::of_buffer(&buffer)?;
/// // Retained: it may outlive what it was made from.
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

/// What memory is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MemoryKind {
    Buffer { bytes: usize },
    Image { width: usize, height: usize, format: ImageFormat },
}

/// Pixels of images that pictures can go to.
///
/// ```
/// use layersplat::device::ImageFormat;
///
/// assert_ne!(ImageFormat::Rgba8, ImageFormat::Floats);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageFormat {
    /// `CL_RGBA` of `CL_UNORM_INT8` or `CL_UNSIGNED_INT8`.
    Rgba8,
    /// `CL_RGBA` of `CL_FLOAT`.
    Floats,
}

// SAFETY: OpenCL's memory objects may be used by any thread; nothing here changes after it was made.
unsafe impl Send for DeviceMemory {}
// SAFETY: as above.
unsafe impl Sync for DeviceMemory {}

impl DeviceMemory {
    /// A buffer.
    pub fn of_buffer<T>(buffer: &Buffer<T>) -> Result<Self, Error> {
        // SAFETY: the buffer is alive.
        unsafe { Self::from_raw(buffer.get()) }
    }

    /// A 2D image of RGBA in bytes or floats.
    pub fn of_image(image: &Image) -> Result<Self, Error> {
        // SAFETY: the image is alive.
        unsafe { Self::from_raw(image.get()) }
    }

    /// A raw `cl_mem`.
    ///
    /// # Errors
    /// Memory that is neither a buffer nor a 2D image of RGBA in bytes or floats, and what OpenCL answers.
    ///
    /// # Safety
    /// `memory` is a memory object of OpenCL's and alive during the call.
    pub unsafe fn from_raw(memory: cl_mem) -> Result<Self, Error> {
        if memory.is_null() {
            return Err(refused("is no memory: the handle is null"));
        }
        let failed = |e: ClError| failed("clGetMemObjectInfo", e);
        // It asks, and releases nothing.
        let asked = ManuallyDrop::new(Buffer::<u8>::new(memory));
        let context = asked.context().map_err(failed)? as usize;
        let flags = asked.flags().map_err(failed)?;
        let kind = match asked.mem_type().map_err(failed)? {
            CL_MEM_OBJECT_BUFFER => MemoryKind::Buffer { bytes: asked.size().map_err(failed)? },
            CL_MEM_OBJECT_IMAGE2D => image_kind(memory)?,
            _ => return Err(refused("is neither a buffer nor a 2D image")),
        };
        // SAFETY: the caller's promise; the reference that is counted here is released by `drop`.
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

    /// Refuses what kernels of a device cannot read (or with `written`, write).
    pub(crate) fn check(&self, device: &Device, what: &'static str, written: bool) -> Result<(), Error> {
        let refuse = |problem: &str| Err(Error::Memory { what, problem: problem.into() });
        if self.context != device.context() as usize {
            return refuse("is of another context than the device: make it in the device's own");
        }
        match (written, self.flags) {
            (true, flags) if flags & CL_MEM_READ_ONLY != 0 => refuse("is CL_MEM_READ_ONLY: kernels cannot write it"),
            (false, flags) if flags & CL_MEM_WRITE_ONLY != 0 => refuse("is CL_MEM_WRITE_ONLY: kernels cannot read it"),
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
                format!("is an image of channels {other:?}: make it CL_RGBA of CL_UNORM_INT8, CL_UNSIGNED_INT8 or CL_FLOAT");
            return Err(Error::Memory { what: "memory that was handed over", problem });
        }
    };
    Ok(MemoryKind::Image { width: image.width().map_err(failed)?, height: image.height().map_err(failed)?, format })
}

fn refused(problem: &str) -> Error {
    Error::Memory { what: "memory that was handed over", problem: problem.into() }
}

fn failed(call: &'static str, source: ClError) -> Error {
    Error::OpenCl { call, device: "the memory that was handed over".into(), source }
}

impl Clone for DeviceMemory {
    fn clone(&self) -> Self {
        // SAFETY: it is alive as long as `self` is. Retaining what is alive does not fail.
        unsafe { retain_mem_object(self.memory) }.expect("clRetainMemObject of live memory");
        Self { ..*self }
    }
}

impl Drop for DeviceMemory {
    fn drop(&mut self) {
        // SAFETY: the reference is this one's own.
        if let Err(code) = unsafe { release_mem_object(self.memory) } {
            tracing::warn!("clReleaseMemObject failed: {}", ClError(code));
        }
    }
}
