//! Errors. Messages name the file, the value and the remedy.

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

/// An error of this crate.
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
    /// A volume file with missing or wrong information.
    #[error("{path}: {problem}")]
    Volume {
        /// The file.
        path: PathBuf,
        /// What is wrong with it and what to do.
        problem: String,
    },
    /// A volume file whose axes are not at right angles, where these are needed.
    #[error("{path}: {problem}")]
    Sheared {
        /// The file.
        path: PathBuf,
        /// Which axes are not, and what to do.
        problem: String,
        /// Transform from voxels to the world.
        index_to_world: Box<glam::DAffine3>,
        /// Whether the world is a patient's.
        has_anatomy: bool,
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
        /// Bytes that these need, including the header.
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
    /// A surface that cannot be drawn.
    #[error("surface {name}: {problem}")]
    Surface {
        /// Its name, or the kind of shape.
        name: String,
        /// What is wrong with it and what to do.
        problem: String,
    },
    /// A number outside its range.
    #[error("{name} is {value}: expected {expected}")]
    OutOfRange {
        /// Name of the field or argument.
        name: &'static str,
        /// The number.
        value: String,
        /// Accepted values.
        expected: &'static str,
    },
    /// An argument of [`Settings::from_arguments`](crate::settings::Settings::from_arguments) with a value that it cannot have.
    #[error("{name}{} is {value}: expected {expected}", in_brackets(part))]
    Argument {
        /// Name of the argument.
        name: &'static str,
        /// Name of a value in it.
        part: Option<&'static str>,
        /// The value, as code in Python.
        value: String,
        /// Accepted values.
        expected: &'static str,
        /// Whether the value is of another kind, and not out of range.
        is_of_other_kind: bool,
    },
    /// An invalid camera.
    #[error("camera: {problem}")]
    Camera {
        /// What is wrong with it and what to do.
        problem: &'static str,
    },
    /// An invalid view in a file of cameras.
    #[error("{path}, line {line}: {problem}")]
    Cameras {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: u64,
        /// What is wrong with it and what to do.
        problem: String,
    },
    /// An invalid line in a table of labels.
    #[error("{path}, line {line}: {problem}")]
    Labels {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: u64,
        /// What is wrong with it and what to do.
        problem: String,
    },
    /// An invalid file of key cameras.
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
        /// The field to change.
        field: &'static str,
        /// What is wrong and what to do.
        problem: String,
    },
    /// An unknown name.
    #[error("unknown {what} '{name}': use {known}")]
    UnknownName {
        /// Kind of name.
        what: &'static str,
        /// The unknown name.
        name: String,
        /// Known names.
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
    /// No OpenCL implementation is installed on this machine.
    #[error(
        "no OpenCL {missing} found{}: install PoCL, which runs on any CPU (Debian, Ubuntu: apt install pocl-opencl-icd \
         ocl-icd-libopencl1; Fedora: dnf install pocl ocl-icd; macOS: brew install pocl), or your GPU's driver",
        in_parentheses(failures)
    )]
    NoOpenCl {
        /// "loader" or "platform".
        missing: &'static str,
        /// Why installed implementations could not be loaded.
        failures: Vec<String>,
    },
    /// OpenCL is installed, but has no device.
    #[error("no OpenCL device found, {platforms}: check the driver, or install PoCL, which runs on any CPU")]
    NoDevice {
        /// The platforms with the answer of each.
        platforms: String,
    },
    /// PoCL cannot write its cache of compiled kernels. It then has no device or fails to build kernels.
    #[error(
        "PoCL cannot keep compiled kernels in {folder} ({source}): set POCL_CACHE_DIR to a writable folder on a disk with free space"
    )]
    KernelCache {
        /// The folder.
        folder: PathBuf,
        /// Why, for example a full disk.
        source: io::Error,
    },
    /// A raw file whose name lacks dimensions or type, or states them wrongly.
    #[error("{path}: {problem}: name it NAME_XxYxZ_TYPE.raw, or give {field}", path = path.display())]
    Unnamed {
        /// The file.
        path: PathBuf,
        /// The field to give instead.
        field: &'static str,
        /// What is wrong with the name.
        problem: String,
    },
    /// Not enough host memory.
    #[error(
        "{what} needs {needed} bytes of memory, which this process cannot allocate: {available} are free on the machine, and the limit \
         of the process (ulimit -v) may be lower; use a smaller one, or free memory"
    )]
    HostMemory {
        /// The object to be stored.
        what: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes free for this process.
        available: u64,
    },
    /// A buffer larger than the device allows.
    #[error("{what} needs {needed} bytes, but {device} allows {available} in one buffer: use a smaller one or another device")]
    DeviceMemory {
        /// The object to be stored.
        what: String,
        /// The device.
        device: String,
        /// Bytes needed.
        needed: u64,
        /// Largest buffer of the device in bytes.
        available: u64,
    },
    /// The memory budget of the device is exceeded by a view with shadows or ambient occlusion.
    #[error(
        "{what} needs {needed} bytes on the device in addition to {taken} in use, {} more than the memory budget of {budget}: set at least \
         {}{}",
        needed.saturating_add(*taken).saturating_sub(*budget),
        needed.saturating_add(*taken),
        if *can_be_coarser { "; light_grid half needs less" } else { "" }
    )]
    LightMemory {
        /// The object to be stored.
        what: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes of the budget in use.
        taken: u64,
        /// The budget in bytes: `Device::with_memory`.
        budget: u64,
        /// Whether light of half the resolution would need less.
        can_be_coarser: bool,
    },
    /// The memory budget of the device is exceeded.
    #[error("{what} needs {needed} bytes on the device in addition to {taken} in use, but the memory budget is {budget}: set at least {}", needed.saturating_add(*taken))]
    MemoryBudget {
        /// The object to be stored.
        what: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes of the budget in use.
        taken: u64,
        /// The budget in bytes: `Device::with_memory`.
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
        "{what} needs {needed} bytes, but {device} could not allocate them, with {left} not used by this program ({source}): use a \
         smaller one or another device"
    )]
    OutOfDeviceMemory {
        /// The object to be stored.
        what: String,
        /// The device.
        device: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes of the device that this program does not use. Other programs may.
        left: u64,
        /// OpenCL error code.
        source: opencl3::error_codes::ClError,
    },
    /// A kernel did not compile.
    #[error("{program} did not build on {device} ({source}); build log:\n{log}")]
    Build {
        /// The kernel file.
        program: &'static str,
        /// The device.
        device: String,
        /// OpenCL error code.
        source: opencl3::error_codes::ClError,
        /// The compiler's log.
        log: String,
    },
    /// A kernel was not built in the background.
    #[error("{program} was not built in the background: {problem}")]
    NotBuilt {
        /// The kernel file.
        program: &'static str,
        /// Why.
        problem: &'static str,
    },
    /// A renderer whose volume was lost when replacing it failed.
    #[error("the renderer has no volume, since replacing its last one failed: set a volume, or make a new renderer")]
    NoVolume,
    /// Caller-owned memory, or a caller-owned queue, that cannot be used.
    #[error("{what} {problem}")]
    Memory {
        /// The object and its purpose.
        what: &'static str,
        /// What is wrong with it and what to do.
        problem: String,
    },
    /// A frame that exceeded its time limit.
    #[error(
        "the frame took longer than its limit of {longest:?} and was stopped before {stage}: raise the limit, or choose a smaller picture \
         or a lower quality"
    )]
    TooLong {
        /// The stage that was not started.
        stage: &'static str,
        /// The time limit.
        longest: std::time::Duration,
    },
    /// A frame that another thread cancelled (`Cancel`).
    #[error("the frame was cancelled before {stage}")]
    Cancelled {
        /// The stage that was not started.
        stage: &'static str,
    },
    /// A device that renders wrong pictures.
    #[error(
        "{device} failed its check ({failures}): update its driver, choose another device, or skip the check if wrong pictures are \
         acceptable"
    )]
    DeviceFailed {
        /// The device.
        device: String,
        /// The failed kernel families with the reason.
        failures: String,
    },
    /// An OpenGL context or texture that cannot receive pictures.
    #[cfg(feature = "gl-interop")]
    #[error(transparent)]
    Gl(#[from] GlError),
    /// An error in distributed rendering.
    #[cfg(feature = "mpi")]
    #[error(transparent)]
    Distributed(#[from] DistributedError),
    /// An OpenCL call failed.
    #[error("{call} failed on {device}: {source} ({})", source.0)]
    OpenCl {
        /// The function called.
        call: &'static str,
        /// The device.
        device: String,
        /// OpenCL error code.
        source: opencl3::error_codes::ClError,
    },
}

impl Error {
    /// Names of the fields or arguments at fault, as in this crate. Applications with other names can map them.
    pub fn fields(&self) -> &[&'static str] {
        match self {
            Error::Settings { field, .. } | Error::Unnamed { field, .. } => std::slice::from_ref(field),
            Error::OutOfRange { name, .. } | Error::Argument { name, .. } => std::slice::from_ref(name),
            Error::UnknownName { what, .. } => std::slice::from_ref(what),
            Error::FileSize { .. } => &["dims", "voxel_type", "header_bytes"],
            Error::DeviceFailed { .. } => &["device", "device_unchecked"],
            Error::LightMemory { can_be_coarser: true, .. } => &["memory", "light_grid"],
            Error::LightMemory { .. } | Error::MemoryBudget { .. } | Error::NeedsWholeVolume { .. } => &["memory"],
            Error::TooLong { .. } => &["longest"],
            Error::DeviceMemory { .. } | Error::OutOfDeviceMemory { .. } => &["device"],
            _ => &[],
        }
    }

    /// Whether a device or its budget has too little memory left. Freeing other buffers may help.
    #[doc(hidden)]
    pub fn is_lack_of_device_memory(&self) -> bool {
        matches!(self, Error::MemoryBudget { .. } | Error::LightMemory { .. } | Error::OutOfDeviceMemory { .. })
    }

    #[doc(hidden)]
    pub fn read(path: &Path, source: io::Error) -> Self {
        Error::Read { path: path.into(), source }
    }

    #[doc(hidden)]
    pub fn write(path: &Path, source: io::Error) -> Self {
        Error::Write { path: path.into(), source }
    }

    #[doc(hidden)]
    pub fn volume(path: &Path, problem: impl Into<String>) -> Self {
        Error::Volume { path: path.into(), problem: problem.into() }
    }
}

/// The name of a part as code in Python, or nothing.
fn in_brackets(part: &Option<&'static str>) -> String {
    part.map_or_else(String::new, |part| format!("['{part}']"))
}

/// The reasons in parentheses, or nothing.
fn in_parentheses(reasons: &[String]) -> String {
    if reasons.is_empty() { String::new() } else { format!(" ({})", reasons.join("; ")) }
}
