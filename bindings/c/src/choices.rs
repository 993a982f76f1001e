//! Enums of the C API. C passes them as integers of any value; unknown values are rejected.

use crate::boundary::Failure;
use layersplat::{Choice, GradientEstimator, volume};

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

/// Presets that trade quality for speed.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum QualityChoice {
    /// One sample per voxel and layer: the fastest.
    Draft = 0,
    /// Best quality for its time.
    Standard = 1,
    /// Closest reconstruction of the sampled field.
    High = 2,
    /// Layered volume splatting as published: slow.
    Paper = 3,
}

/// Rendering algorithm.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum AlgorithmChoice {
    /// Layered volume splatting, in the selected quality.
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

/// Reconstruction kernel.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum KernelChoice {
    /// The kernel of the quality; for ray casting, linear.
    Automatic = 0,
    /// The paper's cubic kernel.
    Cubic = 1,
    /// Linear.
    Linear = 2,
    /// The Catmull-Rom spline.
    CatmullRom = 3,
    /// The interpolating cubic B-spline.
    Bspline = 4,
    /// A Gaussian; ray casting only.
    Gaussian = 5,
}

/// Estimation of the gradients for shading and gradient opacity.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum GradientChoice {
    /// Sobel for layers with pre-integrated classification; for ray casting the derivative of the kernel where that is continuous; else
    /// central differences.
    Automatic = 0,
    /// Central differences of the voxels.
    Central = 1,
    /// Central differences that are smoothed across their direction, which hides terraces and noise. Not with the Gaussian kernel.
    Sobel = 2,
    /// The derivative of the kernel. Catmull-Rom spline and B-spline only.
    Own = 3,
    /// Central differences of voxels that a Gaussian of gradient_sigma has smoothed. Not with the Gaussian kernel.
    Gaussian = 4,
}

/// How the values along a ray are combined.
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
    /// The first iso-surface at the settings' iso_value.
    Iso = 4,
}

/// How a picture is lit.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum LookChoice {
    /// By the lights and the ambient light, as the colours of the transfer function are.
    Plain = 0,
    /// By a sky and lights whose light scatters in the volume, in linear colours.
    Studio = 1,
}

/// Curve of bright colours in 8-bit pictures of the studio.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum ToneChoice {
    /// They are cut off.
    None = 0,
    /// They approach white.
    Shoulder = 1,
}

/// Resolution of shadows, ambient occlusion and scattered light. Below full resolution, surfaces that are nearly parallel to the light show contour rings.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum LightGridChoice {
    /// One value per voxel.
    Full = 0,
    /// One value per 2 x 2 x 2 voxels.
    Half = 1,
    /// One value per 4 x 4 x 4 voxels for ambient occlusion and scattered light; shadows have half the resolution.
    Quarter = 2,
}

/// Where the opacity of colours comes from.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum ColorOpacityChoice {
    /// The fourth component, per smallest spacing.
    Alpha = 0,
    /// The luminance (BT.709).
    Luminance = 1,
    /// The largest difference of a component from a background colour.
    Background = 2,
}

/// Surfaces of labels that are drawn by themselves.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum LabelSurfacesChoice {
    /// Surfaces lie where the interpolated share of a label is one half, and gradients are smoothed unless the settings state them.
    Smooth = 0,
    /// Each voxel has the extinction and colour of its label.
    Voxels = 1,
}

/// Projection of a camera.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum ProjectionChoice {
    /// Parallel rays.
    Parallel = 0,
    /// Rays through the eye.
    Perspective = 1,
}

/// The axis that a slice is perpendicular to.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum SliceAxisChoice {
    /// The voxels' x: y to the right, z up.
    X = 0,
    /// The voxels' y: x to the right, z up.
    Y = 1,
    /// The voxels' z: x to the right, y up.
    Z = 2,
    /// Seen from the feet: the patient's left is on the right, the front is up. Only if the file states how the patient lies.
    Axial = 3,
    /// Seen from the front: the patient's left is on the right, the head is up.
    Coronal = 4,
    /// Seen from the patient's left: the back is on the right, the head is up.
    Sagittal = 5,
}

/// Pixel format of a picture in the caller's device memory. The channels are red, green, blue, alpha.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum PixelFormat {
    /// One byte per channel, over a background. Images: CL_RGBA with CL_UNORM_INT8 or CL_UNSIGNED_INT8.
    Rgba8 = 0,
    /// One float per channel, premultiplied, without a background. Images: CL_RGBA with CL_FLOAT.
    Floats = 1,
}

/// Implements the conversion from the integer that C passes.
macro_rules! from_number {
    ($name:ident, $what:literal, $($choice:ident)*) => {
        impl $name {
            pub(crate) fn from_number(number: i32) -> Result<Self, Failure> {
                let all = [$($name::$choice),*];
                let found = all.into_iter().find(|&choice| choice as i32 == number);
                found.ok_or_else(|| Failure::invalid(format!("{} is not a valid {}", number, $what)))
            }
        }
    };
}

from_number!(VoxelType, "voxel type", Uint8 Int8 Uint16 Int16 Float32);
from_number!(GradientChoice, "gradient", Automatic Central Sobel Own Gaussian);
from_number!(ColorOpacityChoice, "color opacity", Alpha Luminance Background);
from_number!(ProjectionChoice, "projection", Parallel Perspective);
from_number!(PixelFormat, "pixel format", Rgba8 Floats);

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

impl GradientChoice {
    /// `None` means that of the kernel. `sigma`: standard deviation of the Gaussian.
    pub(crate) fn estimator(self, sigma: f64) -> Option<GradientEstimator> {
        match self {
            GradientChoice::Automatic => None,
            GradientChoice::Central => Some(GradientEstimator::Central),
            GradientChoice::Sobel => Some(GradientEstimator::Sobel),
            GradientChoice::Own => Some(GradientEstimator::Own),
            GradientChoice::Gaussian => Some(GradientEstimator::Gaussian(sigma)),
        }
    }
}

/// The choice with a number. The enums of C count as [`Choice::ALL`] does, from `first`: 1 if 0 is the default.
fn numbered<T: Choice>(number: i32, first: i32) -> Result<T, Failure> {
    let found = number.checked_sub(first).and_then(|n| T::ALL.get(usize::try_from(n).ok()?));
    found.copied().ok_or_else(|| {
        let names = T::ALL.iter().zip(first..).map(|(choice, n)| format!("{n} ({})", choice.name()));
        let known: Vec<_> = (first == 1).then(|| "0 (default)".into()).into_iter().chain(names).collect();
        Failure::invalid(format!("{} is {number}: expected {}", T::FIELD, known.join(", ")))
    })
}

/// The choice with a number from 0.
pub(crate) fn chosen<T: Choice>(number: i32) -> Result<T, Failure> {
    numbered(number, 0)
}

/// The choice with a number from 1; 0 is the default.
pub(crate) fn chosen_or_default<T: Choice>(number: i32) -> Result<Option<T>, Failure> {
    (number != 0).then(|| numbered(number, 1)).transpose()
}

#[cfg(test)]
mod tests {
    use layersplat::settings::{Algorithm, Blend, LightGrid, Look, Tone};
    use layersplat::slice::SliceAxis;
    use layersplat::volume::LabelSurfaces;
    use layersplat::{Choice, Kernel, Quality};

    /// The constants of an enum of the header in order, from `first` on.
    fn constants(prefix: &str, first: usize) -> Vec<String> {
        let header = include_str!("../include/layersplat.h");
        let number =
            |n: usize| header.lines().find_map(|line| line.trim().strip_prefix(prefix)?.strip_suffix(&format!(" = {n},")));
        (first..).map_while(number).map(|name| name.to_lowercase().replace('_', "-")).collect()
    }

    fn check<T: Choice>(prefix: &str, first: usize) {
        let names: Vec<_> = T::ALL.iter().map(|choice| choice.name()).collect();
        assert_eq!(constants(prefix, first), names, "{prefix}");
    }

    #[test]
    fn constants_count_as_the_library_does() {
        check::<Quality>("LAYERSPLAT_QUALITY_", 0);
        check::<Algorithm>("LAYERSPLAT_ALGORITHM_", 0);
        check::<Kernel>("LAYERSPLAT_KERNEL_", 1);
        check::<Blend>("LAYERSPLAT_BLEND_", 0);
        check::<LightGrid>("LAYERSPLAT_LIGHT_GRID_", 0);
        check::<Look>("LAYERSPLAT_LOOK_", 0);
        check::<Tone>("LAYERSPLAT_TONE_", 0);
        check::<LabelSurfaces>("LAYERSPLAT_LABEL_SURFACES_", 0);
        check::<SliceAxis>("LAYERSPLAT_SLICE_AXIS_", 0);
    }
}
