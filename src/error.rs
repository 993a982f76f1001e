//! What can go wrong, with the file, the value and the remedy.

#[cfg(feature = "mpi")]
mod distributed;
#[cfg(feature = "gl-interop")]
mod gl;

#[cfg(feature = "mpi")]
pub use distributed::DistributedError;
#[cfg(feature = "gl-interop")]
pub use gl::GlError;
use std::io;
use std::path::{Path, PathBuf};

/// Everything that can fail in this crate.
///
/// ```
/// use layersplat::{Error, OpenOptions, Volume};
///
/// match Volume::open("no_such_file.raw", &OpenOptions::default()) {
///     Err(Error::Read { path, source }) => println!("{}: {source}", path.display()),
///     other => println!("{other:?}"),
/// }
/// ```
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A file could not be written; nothing was left behind.
    #[error("cannot write {path}: {source}")]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A volume file that says too little or something wrong.
    #[error("{path}: {problem}")]
    Volume {
        /// The file.
        path: PathBuf,
        /// What is wrong with it and what to do.
        problem: String,
    },
    /// A volume file of the wrong size.
    #[error("{path}: {}x{}x{} voxels of {scalar} are {expected} bytes, found {found}: correct dims, voxel_type or header_bytes", dims[0], dims[1], dims[2])]
    FileSize {
        /// The file.
        path: PathBuf,
        /// Stated dimensions.
        dims: [usize; 3],
        /// Name of the stated type.
        scalar: String,
        /// Bytes that these need, a header included.
        expected: u64,
        /// Bytes found.
        found: String,
    },
    /// Voxels in memory that do not fill their grid.
    #[error("{name}: {}x{}x{} needs {expected} voxels, found {found}", dims[0], dims[1], dims[2])]
    VoxelCount {
        /// The volume.
        name: String,
        /// Stated dimensions.
        dims: [usize; 3],
        /// Voxels that these need.
        expected: u64,
        /// Voxels found.
        found: u64,
    },
    /// A grid that cannot be rendered.
    #[error("the grid cannot be rendered: {problem}")]
    Grid {
        /// What is wrong with it and what to do.
        problem: String,
    },
    /// A transfer function that cannot be used.
    #[error("transfer function {name}: {problem}")]
    Transfer {
        /// File or name.
        name: String,
        /// What is wrong with it and what to do.
        problem: String,
    },
    /// A number outside its range.
    #[error("{name} is {value}: expected {expected}")]
    OutOfRange {
        /// The field or argument that it was given for.
        name: &'static str,
        /// The number.
        value: String,
        /// What it may be.
        expected: &'static str,
    },
    /// A camera without a view.
    #[error("camera: {problem}")]
    Camera {
        /// What is wrong with it and what to do.
        problem: &'static str,
    },
    /// A view in a file of cameras that cannot be taken.
    #[error("{path}, line {line}: {problem}")]
    Cameras {
        /// The file.
        path: PathBuf,
        /// The line, the first is 1.
        line: u64,
        /// What is wrong with it and what to do.
        problem: String,
    },
    /// A file of key cameras that there is no way through.
    #[error("{path}: {problem}")]
    Keys {
        /// The file.
        path: PathBuf,
        /// What is wrong with it and what to do.
        problem: String,
    },
    /// Settings that contradict each other or the view.
    #[error("{field}: {problem}")]
    Settings {
        /// The field that should be another.
        field: &'static str,
        /// What is wrong and what to do.
        problem: String,
    },
    /// A name that does not exist.
    #[error("unknown {what} '{name}': use {known}")]
    UnknownName {
        /// What kind of name.
        what: &'static str,
        /// The name.
        name: String,
        /// Names that exist.
        known: String,
    },
    /// A picture that cannot be read or compared.
    #[error("{path}: {problem}")]
    Image {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// There is no OpenCL on this machine.
    #[error(
        "no OpenCL {missing} found{}: install PoCL, which runs on any CPU (Debian, Ubuntu: apt install pocl-opencl-icd \
         ocl-icd-libopencl1; Fedora: dnf install pocl ocl-icd; macOS: brew install pocl), or your GPU's driver",
        listed(failures)
    )]
    NoOpenCl {
        /// Loader or platform.
        missing: &'static str,
        /// Why what is installed could not be loaded, if anything is.
        failures: Vec<String>,
    },
    /// OpenCL is there, but without a device.
    #[error("no OpenCL device found, {platforms}: look after the driver, or install PoCL, which runs on any CPU")]
    NoDevice {
        /// The platforms, with what each of them answered.
        platforms: String,
    },
    /// PoCL cannot keep the kernels that it compiles: it has no device then, or builds nothing.
    #[error(
        "PoCL cannot keep compiled kernels in {folder} ({source}): set POCL_CACHE_DIR to a folder that it can write, on a disk with room"
    )]
    KernelCache {
        /// The folder.
        folder: PathBuf,
        /// Why: a full disk, for example.
        source: io::Error,
    },
    /// A file's name does not tell what it holds, or tells it wrongly.
    #[error("{path}: {problem}: name it NAME_XxYxZ_TYPE.raw, or give {field}", path = path.display())]
    Unnamed {
        /// The file.
        path: PathBuf,
        /// What can be given instead.
        field: &'static str,
        /// What is wrong with the name.
        problem: String,
    },
    /// The machine does not have the memory.
    #[error(
        "{what} needs {needed} bytes of memory, which this process cannot get: {available} are free on the machine, and its own limit \
         (ulimit -v) may be lower; use a smaller one, or free some"
    )]
    HostMemory {
        /// What was to be stored.
        what: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes free for this process.
        available: u64,
    },
    /// More than the device has in one piece.
    #[error("{what} needs {needed} bytes, but {device} allows {available} in one buffer: use a smaller one or another device")]
    DeviceMemory {
        /// What was to be stored.
        what: String,
        /// The device.
        device: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes that the device allows.
        available: u64,
    },
    /// More than buffers on the device may take together.
    #[error("{what} needs {needed} bytes on the device beside {taken} that are taken, and the memory budget is {budget}: give at least {}", needed.saturating_add(*taken))]
    MemoryBudget {
        /// What was to be stored.
        what: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes of the budget that are taken.
        taken: u64,
        /// Bytes that were given: [`Device::with_memory`](crate::Device::with_memory).
        budget: u64,
    },
    /// A call that only a renderer of the whole volume supports, on one that streams the volume or shares it with other processes.
    #[error(
        "{what} needs a renderer that holds the whole volume, and this one streams or shares it: render into host memory instead, or \
         use a device without a memory budget whose largest buffer holds the volume"
    )]
    NeedsWholeVolume {
        /// The call.
        what: &'static str,
    },
    /// The device's memory is full.
    #[error(
        "{what} needs {needed} bytes, but {device} could not give them, with {left} not taken by this program ({source}): use a \
         smaller one or another device"
    )]
    OutOfDeviceMemory {
        /// What was to be stored.
        what: String,
        /// The device.
        device: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes of the device that this program has not taken; others may have.
        left: u64,
        /// OpenCL's code.
        source: opencl3::error_codes::ClError,
    },
    /// A kernel did not compile.
    #[error("{program} did not build on {device} ({source}); build log:\n{log}")]
    Build {
        /// The kernel file.
        program: &'static str,
        /// The device.
        device: String,
        /// OpenCL's code.
        source: opencl3::error_codes::ClError,
        /// The compiler's words.
        log: String,
    },
    /// A kernel that was to be built in the background is not, since its device is gone.
    #[error("{program} was not built in the background: its device was closed before")]
    NotBuilt {
        /// The kernel file.
        program: &'static str,
    },
    /// Memory or a queue of the caller's own that cannot be used.
    #[error("{what} {problem}")]
    Memory {
        /// What was handed over, and for what.
        what: &'static str,
        /// What is wrong with it and what to do.
        problem: String,
    },
    /// A frame that took longer than its time limit.
    #[error(
        "the frame took longer than its limit of {longest:?} and ended before {stage}: raise the limit, or choose a smaller picture or a \
         lower quality"
    )]
    TooLong {
        /// The stage that was not started.
        stage: &'static str,
        /// The time limit.
        longest: std::time::Duration,
    },
    /// A frame that another thread cancelled ([`Cancel`](crate::Cancel)).
    #[error("the frame was cancelled before {stage}")]
    Cancelled {
        /// The stage that was not started.
        stage: &'static str,
    },
    /// A device that does not draw what it should.
    #[error(
        "{device} does not draw what it should ({failures}): update its driver, choose another device, or use it unchecked if a wrong \
         picture does no harm"
    )]
    DeviceFailed {
        /// The device.
        device: String,
        /// What failed, and how.
        failures: String,
    },
    /// OpenGL, or a texture, that pictures cannot go to.
    #[cfg(feature = "gl-interop")]
    #[error(transparent)]
    Gl(#[from] GlError),
    /// Processes that render together, and one of them could not.
    #[cfg(feature = "mpi")]
    #[error(transparent)]
    Distributed(#[from] DistributedError),
    /// An OpenCL call failed.
    #[error("{call} failed on {device}: {source} ({})", source.0)]
    OpenCl {
        /// What was called.
        call: &'static str,
        /// The device.
        device: String,
        /// OpenCL's code.
        source: opencl3::error_codes::ClError,
    },
}

impl Error {
    /// The fields or arguments that are at fault, by their names in this crate: for those who give them other names.
    pub fn fields(&self) -> &[&'static str] {
        match self {
            Error::Settings { field, .. } | Error::Unnamed { field, .. } => std::slice::from_ref(field),
            Error::OutOfRange { name, .. } => std::slice::from_ref(name),
            Error::UnknownName { what, .. } => std::slice::from_ref(what),
            Error::FileSize { .. } => &["dims", "voxel_type", "header_bytes"],
            Error::DeviceFailed { .. } => &["device", "device_unchecked"],
            Error::MemoryBudget { .. } | Error::NeedsWholeVolume { .. } => &["memory"],
            Error::TooLong { .. } => &["longest"],
            Error::DeviceMemory { .. } | Error::OutOfDeviceMemory { .. } => &["device"],
            _ => &[],
        }
    }

    /// Whether a device, or its budget, has too little memory left: other buffers may make room.
    pub(crate) fn is_lack_of_device_memory(&self) -> bool {
        matches!(self, Error::MemoryBudget { .. } | Error::OutOfDeviceMemory { .. })
    }

    pub(crate) fn read(path: &Path, source: io::Error) -> Self {
        Error::Read { path: path.into(), source }
    }

    pub(crate) fn write(path: &Path, source: io::Error) -> Self {
        Error::Write { path: path.into(), source }
    }

    pub(crate) fn volume(path: &Path, problem: impl Into<String>) -> Self {
        Error::Volume { path: path.into(), problem: problem.into() }
    }
}

/// In brackets, if there are any.
fn listed(reasons: &[String]) -> String {
    if reasons.is_empty() { String::new() } else { format!(" ({})", reasons.join("; ")) }
}
