//! Program permutations as `-D` options.

use super::VoxelKind;
use crate::device::Tuning;
use crate::layers::{GradientEstimator, Kernel};
use crate::volume::VoxelType;
use std::fmt::Write;

/// Name of a voxel type in OpenCL C, and 1 where it is signed.
fn opencl_type(voxel_type: VoxelType) -> (&'static str, i32) {
    match voxel_type {
        VoxelType::Uint8 => ("uchar", 0),
        VoxelType::Int8 => ("char", 1),
        VoxelType::Uint16 => ("ushort", 0),
        VoxelType::Int16 => ("short", 1),
        VoxelType::Float32 => ("float", 1),
    }
}

/// `-D` options of a program.
pub(crate) struct Defines(pub String);

impl Defines {
    /// For kernels that compute without vectors.
    pub fn none() -> Self {
        Self(String::new())
    }

    /// For kernels that compute in vectors of `width` lanes.
    pub fn new(width: u32) -> Self {
        Self(format!("-DVW={width}"))
    }

    /// For kernels that read voxels of this type.
    pub fn with_voxel_type(self, voxel_type: VoxelType) -> Self {
        let (name, signed) = opencl_type(voxel_type);
        self.with("VOXEL", name).with("VOXEL_BYTES", voxel_type.bytes()).with("VOXEL_SIGNED", signed)
    }

    /// For kernels that estimate gradients.
    fn with_gradients(self, gradients: Gradients) -> Self {
        let estimate = match gradients.estimate {
            GradientEstimate::Central => "CENTRAL",
            GradientEstimate::Smoothed => "SMOOTHED",
            GradientEstimate::Own => "OWN",
        };
        let defines = self.with("GRADIENT", estimate);
        let Some(VoxelKind { voxel_type, far, unchecked }) = gradients.voxels else { return defines };
        let (name, signed) = opencl_type(voxel_type);
        defines
            .with_if(true, "SEPARATE_GRADIENTS")
            .with("GRADIENT_VOXEL", name)
            .with("GRADIENT_VOXEL_BYTES", voxel_type.bytes())
            .with("GRADIENT_VOXEL_SIGNED", signed)
            .with_if(unchecked, "GRADIENT_UNCHECKED")
            .with_if(far, "FAR_VOXELS")
    }

    /// For kernels that use voxel values.
    pub fn with_values(self, voxels: VoxelKind) -> Self {
        self.with_voxel_type(voxels.voxel_type).with_if(voxels.unchecked, "UNCHECKED")
    }

    /// For kernels that interpolate voxels.
    pub fn with_voxels(self, voxels: VoxelKind) -> Self {
        self.with_values(voxels).with_if(voxels.far, "FAR_VOXELS")
    }

    pub fn with(mut self, name: &str, value: impl std::fmt::Display) -> Self {
        write!(self.0, " -D{name}={value}").expect("strings take anything");
        self
    }

    pub fn with_if(mut self, on: bool, name: &str) -> Self {
        if on {
            write!(self.0, " -D{name}").expect("strings take anything");
        }
        self
    }
}

/// Flags of kernel permutations: blend mode, ray clipping, and uses of gradients.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Rendering {
    pub blend: BlendMode,
    /// Rays are clipped to their intervals, since visible data lie outside.
    pub clipped: bool,
    /// Gradient opacity may be enabled; the sample parameters decide.
    pub gradient_opacity: bool,
    /// There may be several lights; the sample parameters decide.
    pub several_lights: bool,
    /// Lights may have colours; the sample parameters decide.
    pub colored_lights: bool,
    /// Colours may fade with depth; the sample parameters decide.
    pub depth_cue: bool,
    /// Shadows or ambient occlusion are read from light volumes; the sample parameters decide which.
    pub light_volume: bool,
    /// Light scatters, in linear colours; the light volumes are those of the studio.
    pub studio: bool,
    /// Estimation of gradients, where programs reconstruct the field.
    pub gradients: Gradients,
    /// Cast rays compute depths instead of colours.
    pub depths: bool,
    /// Samples of a lattice are pixels, and their columns lean.
    pub pixel_rays: bool,
}

impl Rendering {
    /// Compositing with all features but light volumes, which sheets do not have: used for small kernels, such as sorting, and by tests.
    pub const EVERYTHING: Self = Self {
        blend: BlendMode::Composite,
        clipped: true,
        gradient_opacity: true,
        several_lights: true,
        colored_lights: true,
        depth_cue: true,
        light_volume: false,
        studio: false,
        gradients: Gradients { estimate: GradientEstimate::Central, voxels: None },
        depths: false,
        pixel_rays: false,
    };
}

/// Estimation of gradients in a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Gradients {
    pub estimate: GradientEstimate,
    /// The voxels that gradients are estimated from, if these are not the ones that values are reconstructed from.
    pub voxels: Option<VoxelKind>,
}

/// The estimates of kernels/shared/reconstruction.cl.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum GradientEstimate {
    Central,
    /// Central differences, smoothed across their direction.
    Smoothed,
    Own,
}

impl From<GradientEstimator> for GradientEstimate {
    fn from(estimator: GradientEstimator) -> Self {
        match estimator {
            GradientEstimator::Central => Self::Central,
            GradientEstimator::Sobel | GradientEstimator::Gaussian(_) => Self::Smoothed,
            GradientEstimator::Own => Self::Own,
        }
    }
}

impl Rendering {
    /// A permutation in which clipping and lighting are decided at run time; `None` for blend modes other than compositing.
    pub fn general(self) -> Option<Self> {
        let general = Self { clipped: true, gradient_opacity: true, several_lights: true, depth_cue: true, ..self };
        (self.blend == BlendMode::Composite).then_some(general)
    }
}

/// The accumulators of kernels/shared/accumulator.cl.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum BlendMode {
    Composite,
    Maximum,
    Minimum,
    Average,
    /// `refined`: the intersection is refined on the field itself.
    Iso {
        refined: bool,
    },
}

impl Defines {
    pub fn with_rendering(self, rendering: Rendering) -> Self {
        let (name, gathers_values) = match rendering.blend {
            BlendMode::Composite => ("COMPOSITE", false),
            BlendMode::Maximum => ("MAXIMUM", true),
            BlendMode::Minimum => ("MINIMUM", true),
            BlendMode::Average => ("AVERAGE", true),
            BlendMode::Iso { .. } => ("ISO", false),
        };
        self.with("BLEND", name)
            .with_gradients(rendering.gradients)
            .with_if(rendering.clipped, "CLIPPED")
            .with_lighting(rendering)
            .with_if(gathers_values, "EDGE_GOES_ON")
            .with_if(rendering.blend == BlendMode::Iso { refined: true }, "REFINED")
            .with_if(rendering.depths, "DEPTHS")
            .with_if(rendering.pixel_rays, "PIXEL_RAYS")
    }
}

impl Defines {
    /// For kernels with a work-item per tile of a lattice. Where columns of pixels lean, tiles have rows to spare.
    pub(super) fn with_tile_rows(self, rows: u32, pixel_rays: bool) -> Self {
        if !pixel_rays {
            return self.with("TILE_ROWS", rows);
        }
        let ragged = Tuning::RAGGED_ROWS;
        self.with("TILE_ROWS", Tuning::pixel_tile_rows(rows) + ragged).with("RAGGED_ROWS", ragged)
    }

    /// For programs that use gradients.
    pub fn with_lighting(self, rendering: Rendering) -> Self {
        self.with_if(rendering.gradient_opacity, "THINNED")
            .with_if(rendering.several_lights, "SEVERAL_LIGHTS")
            .with_if(rendering.colored_lights, "COLORED_LIGHTS")
            .with_if(rendering.depth_cue, "DEPTH_CUED")
            .with_if(rendering.light_volume, "LIGHT_VOLUME")
            .with_if(rendering.studio, "STUDIO")
            .with_if(rendering.light_volume && matches!(rendering.blend, BlendMode::Iso { .. }), "LIFTED_LIGHT")
    }

    /// For programs that reconstruct the field with `kernel`.
    pub fn with_kernel(self, kernel: Kernel) -> Self {
        let name = match kernel {
            Kernel::Linear => "LINEAR",
            Kernel::Cubic => "CUBIC",
            Kernel::CatmullRom => "CATMULL_ROM",
            Kernel::BSpline => "BSPLINE",
            Kernel::Gaussian => "GAUSSIAN",
        };
        self.with("KERNEL", name).with_if(kernel == Kernel::BSpline, "MIRRORED")
    }
}
