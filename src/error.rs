//! What can go wrong, with the file, the value and the remedy.

use crate::volume::VoxelType;
use std::io;
use std::path::{Path, PathBuf};

/// Everything that can fail in this crate.
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
    #[error("{path}: {}x{}x{} voxels of {voxel_type} are {expected} bytes, found {found}: correct --dims or --type", dims[0], dims[1], dims[2])]
    FileSize {
        /// The file.
        path: PathBuf,
        /// Stated dimensions.
        dims: [usize; 3],
        /// Stated type.
        voxel_type: VoxelType,
        /// Bytes that these need.
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
        /// What the number is.
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
    /// Settings that contradict each other or the view.
    #[error("{problem}")]
    Settings {
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
        "no OpenCL {missing} found: install PoCL, which runs on any CPU (Debian, Ubuntu: apt install pocl-opencl-icd \
         ocl-icd-libopencl1; Fedora: dnf install pocl ocl-icd; macOS: brew install pocl), or your GPU's driver"
    )]
    NoOpenCl {
        /// Loader, platform or device.
        missing: &'static str,
    },
    /// The device does not have the memory.
    #[error("{what} needs {needed} bytes, but {device} allows {available} in one buffer: use a smaller one or another --device")]
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
    /// An OpenCL call failed.
    #[error("{call} failed on {device}: {source}")]
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
