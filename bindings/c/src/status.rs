//! Status codes.

use layersplat::Error;

/// Status of a call. layersplat_last_error() describes every error.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Success.
    Ok = 0,
    /// A required pointer is null.
    NullArgument = 1,
    /// A string is not UTF-8.
    NotUtf8 = 2,
    /// A number, a name or a size is invalid, or arguments contradict each other.
    InvalidArgument = 3,
    /// An output array is too small.
    TooSmall = 4,
    /// A file cannot be read or written, or its contents are invalid.
    File = 5,
    /// There is no OpenCL implementation or no device on this machine.
    NoDevice = 6,
    /// Host or device memory is exhausted, or the memory budget is too small.
    OutOfMemory = 7,
    /// A kernel failed to build. The message contains the compiler's log.
    Build = 8,
    /// An OpenCL object of the caller cannot be used: wrong context, too small, or the wrong kind.
    Unsuitable = 9,
    /// A frame exceeded its time limit.
    TooLong = 10,
    /// An OpenCL call failed. The message names the call and its error code.
    Opencl = 11,
    /// The renderer is in use by another thread.
    Busy = 12,
    /// A defect of layersplat: it panicked. A renderer in which this happened returns only this status; free it.
    Panic = 13,
    /// Any other error.
    Other = 14,
    /// A frame was cancelled by another thread.
    Cancelled = 15,
    /// The call needs all voxels on the device, but this renderer streams them. Use layersplat_render_rgba8() or
    /// layersplat_render_floats() instead, or a device without a memory budget.
    NeedsWholeVolume = 16,
}

impl Status {
    /// The status of a library error.
    pub(crate) fn from_error(error: &Error) -> Self {
        match error {
            Error::Read { .. }
            | Error::Write { .. }
            | Error::Volume { .. }
            | Error::FileSize { .. }
            | Error::Sheared { .. }
            | Error::Labels { .. }
            | Error::Image { .. }
            | Error::Unnamed { .. } => Status::File,
            Error::VoxelCount { .. }
            | Error::Grid { .. }
            | Error::Surface { .. }
            | Error::Transfer { .. }
            | Error::OutOfRange { .. }
            | Error::Argument { .. }
            | Error::Camera { .. }
            | Error::Settings { .. }
            | Error::UnknownName { .. } => Status::InvalidArgument,
            Error::NoOpenCl { .. } | Error::NoDevice { .. } | Error::KernelCache { .. } => Status::NoDevice,
            Error::HostMemory { .. }
            | Error::DeviceMemory { .. }
            | Error::MemoryBudget { .. }
            | Error::LightMemory { .. }
            | Error::OutOfDeviceMemory { .. } => Status::OutOfMemory,
            Error::NeedsWholeVolume { .. } => Status::NeedsWholeVolume,
            Error::Build { .. } => Status::Build,
            Error::Memory { .. } => Status::Unsuitable,
            Error::TooLong { .. } => Status::TooLong,
            Error::Cancelled { .. } => Status::Cancelled,
            Error::OpenCl { .. } => Status::Opencl,
            _ => Status::Other,
        }
    }
}
