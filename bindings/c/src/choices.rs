//! Numbers that stand for choices. In C any number may come where one of these is taken: those that are none are refused.

use crate::border::Failure;
use layersplat::{Kernel, Quality, volume};

/// Type of a voxel.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum VoxelType {
    /// 8 bit, unsigned.
    Uint8 = 0,
    /// 8 bit, signed.
    Int8 = 1,
    /// 16 bit, unsigned.
    Uint16 = 2,
    /// 16 bit, signed.
    Int16 = 3,
    /// 32-bit float. Voxels that are NaN, infinite or beyond ±1e30 count as the smallest value.
    Float32 = 4,
}

/// Bundles of settings.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum QualityChoice {
    /// One sample per voxel and layer: the fastest.
    Draft = 0,
    /// What is best for the time.
    Standard = 1,
    /// Nearest to what was sampled.
    High = 2,
    /// Layered volume splatting as it was published: slow.
    Paper = 3,
}

/// Which renderer makes a picture.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum AlgorithmChoice {
    /// Layered volume splatting, of the quality chosen.
    Layered = 0,
    /// Axis-aligned sheet-buffer splatting. Cannot be enqueued.
    AxisSheets = 1,
    /// Image-aligned sheet-buffer splatting. Cannot be enqueued.
    ViewSheets = 2,
    /// Pre-integrated slicing.
    Slicing = 3,
    /// Ray casting.
    Raycast = 4,
}

/// What reconstructs the field between voxels.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum KernelChoice {
    /// What the quality says; of ray casting, linear.
    Automatic = 0,
    /// The paper's cubic.
    Cubic = 1,
    /// Linear.
    Linear = 2,
    /// Catmull and Rom's spline.
    CatmullRom = 3,
    /// The interpolating cubic B-spline.
    Bspline = 4,
    /// A Gaussian: of ray casting only.
    Gaussian = 5,
}

/// What becomes of the values along a ray.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum BlendChoice {
    /// Emission and absorption.
    Composite = 0,
    /// The largest value.
    Maximum = 1,
    /// The smallest value.
    Minimum = 2,
    /// The mean.
    Average = 3,
    /// The first surface where the field has the settings' iso_value.
    Iso = 4,
}

/// How a camera sees.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum ProjectionChoice {
    /// Parallel rays.
    Parallel = 0,
    /// Rays from the eye.
    Perspective = 1,
}

/// Pixels of a picture in memory of the caller's on the device: red, green, blue, alpha.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum PixelFormat {
    /// A byte per channel, over a background. In images: CL_RGBA of CL_UNORM_INT8 or CL_UNSIGNED_INT8.
    Rgba8 = 0,
    /// A float per channel, premultiplied, without a background. In images: CL_RGBA of CL_FLOAT.
    Floats = 1,
}

/// Finds the choice that a number stands for.
macro_rules! chosen {
    ($name:ident, $what:literal, $($choice:ident)*) => {
        impl $name {
            pub(crate) fn chosen(number: i32) -> Result<Self, Failure> {
                let all = [$($name::$choice),*];
                let found = all.into_iter().find(|&choice| choice as i32 == number);
                found.ok_or_else(|| Failure::invalid(format!("{} is no {}", number, $what)))
            }
        }
    };
}

chosen!(VoxelType, "voxel type", Uint8 Int8 Uint16 Int16 Float32);
chosen!(QualityChoice, "quality", Draft Standard High Paper);
chosen!(AlgorithmChoice, "algorithm", Layered AxisSheets ViewSheets Slicing Raycast);
chosen!(KernelChoice, "kernel", Automatic Cubic Linear CatmullRom Bspline Gaussian);
chosen!(BlendChoice, "blend mode", Composite Maximum Minimum Average Iso);
chosen!(ProjectionChoice, "projection", Parallel Perspective);
chosen!(PixelFormat, "pixel format", Rgba8 Floats);

impl From<VoxelType> for volume::VoxelType {
    fn from(chosen: VoxelType) -> Self {
        match chosen {
            VoxelType::Uint8 => Self::Uint8,
            VoxelType::Int8 => Self::Int8,
            VoxelType::Uint16 => Self::Uint16,
            VoxelType::Int16 => Self::Int16,
            VoxelType::Float32 => Self::Float32,
        }
    }
}

impl From<QualityChoice> for Quality {
    fn from(chosen: QualityChoice) -> Self {
        match chosen {
            QualityChoice::Draft => Self::Draft,
            QualityChoice::Standard => Self::Standard,
            QualityChoice::High => Self::High,
            QualityChoice::Paper => Self::Paper,
        }
    }
}

impl KernelChoice {
    /// `None`: what the algorithm takes by itself.
    pub(crate) fn kernel(self) -> Option<Kernel> {
        match self {
            KernelChoice::Automatic => None,
            KernelChoice::Cubic => Some(Kernel::Cubic),
            KernelChoice::Linear => Some(Kernel::Linear),
            KernelChoice::CatmullRom => Some(Kernel::CatmullRom),
            KernelChoice::Bspline => Some(Kernel::BSpline),
            KernelChoice::Gaussian => Some(Kernel::Gaussian),
        }
    }
}
