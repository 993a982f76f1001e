//! What calls answer.

use layersplat::Error;

/// What a call answers. layersplat_last_error() says more about all but the first.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// A pointer is null that must not be.
    NullArgument = 1,
    /// A text is not UTF-8.
    NotUtf8 = 2,
    /// A number, a name or a size is not one that is accepted; or several contradict each other.
    InvalidArgument = 3,
    /// An array is too small for what was to be written to it.
    TooSmall = 4,
    /// A file cannot be read or written, or holds something else than was expected.
    File = 5,
    /// There is no OpenCL on this machine, or no device.
    NoDevice = 6,
    /// The host or the device has too little memory, or the memory budget is too small.
    OutOfMemory = 7,
    /// A kernel did not build. The message has the compiler's log.
    Build = 8,
    /// An OpenCL object of the caller's cannot be used: it is of another context, too small, or of another kind.
    Unsuitable = 9,
    /// A frame was given up because it took longer than it may.
    TooLong = 10,
    /// An OpenCL call failed. The message has the call and its code.
    Opencl = 11,
    /// The renderer is in use by another thread.
    Busy = 12,
    /// Something in layersplat is wrong: it panicked. A renderer to which that happened answers nothing else from then on; free it.
    Panic = 13,
    /// Anything else.
    Other = 14,
    /// A frame was cancelled by another thread.
    Cancelled = 15,
    /// The call needs all voxels on the device, and this renderer streams them. Use layersplat_render_rgba8() or
    /// layersplat_render_floats() instead, or a device without a memory budget.
    NeedsWholeVolume = 16,
}

impl Status {
    /// The kind of an error of the library's.
    pub(crate) fn of(error: &Error) -> Self {
        match error {
            Error::Read { .. }
            | Error::Write { .. }
            | Error::Volume { .. }
            | Error::FileSize { .. }
            | Error::Image { .. }
            | Error::Unnamed { .. } => Status::File,
            Error::VoxelCount { .. }
            | Error::Grid { .. }
            | Error::Transfer { .. }
            | Error::OutOfRange { .. }
            | Error::Camera { .. }
            | Error::Settings { .. }
            | Error::UnknownName { .. } => Status::InvalidArgument,
            Error::NoOpenCl { .. } | Error::NoDevice { .. } | Error::KernelCache { .. } => Status::NoDevice,
            Error::HostMemory { .. }
            | Error::DeviceMemory { .. }
            | Error::MemoryBudget { .. }
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
