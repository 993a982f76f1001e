//! Program permutations as `-D` options.

use super::VoxelKind;
use crate::layers::{GradientEstimator, Kernel};
use crate::volume::VoxelType;
use std::fmt::Write;

/// `-D` options of a program.
pub(super) struct Defines(pub String);

impl Defines {
    /// For kernels that compute in vectors of `width` lanes.
    pub fn new(width: u32) -> Self {
        Self(format!("-DVW={width}"))
    }

    /// For kernels that read voxels of this type.
    pub fn with_voxel_type(self, voxel_type: VoxelType) -> Self {
        let (name, signed) = match voxel_type {
            VoxelType::Uint8 => ("uchar", 0),
            VoxelType::Int8 => ("char", 1),
            VoxelType::Uint16 => ("ushort", 0),
            VoxelType::Int16 => ("short", 1),
            VoxelType::Float32 => ("float", 1),
        };
        self.with("VOXEL", name).with("VOXEL_BYTES", voxel_type.bytes()).with("VOXEL_SIGNED", signed)
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
    /// Colours may fade with depth; the sample parameters decide.
    pub depth_cue: bool,
    /// Estimation of gradients, where programs reconstruct the field.
    pub gradient: GradientEstimator,
    /// Cast rays compute depths instead of colours.
    pub depths: bool,
}

impl Rendering {
    /// Compositing with all features enabled: used for small kernels, such as sorting, and by tests.
    pub const EVERYTHING: Self = Self {
        blend: BlendMode::Composite,
        clipped: true,
        gradient_opacity: true,
        several_lights: true,
        depth_cue: true,
        gradient: GradientEstimator::Central,
        depths: false,
    };
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
        let gradient = match rendering.gradient {
            GradientEstimator::Central => "CENTRAL",
            GradientEstimator::Sobel => "SOBEL",
            GradientEstimator::Own => "OWN",
        };
        self.with("BLEND", name)
            .with("GRADIENT", gradient)
            .with_if(rendering.clipped, "CLIPPED")
            .with_lighting(rendering)
            .with_if(gathers_values, "EDGE_GOES_ON")
            .with_if(rendering.blend == BlendMode::Iso { refined: true }, "REFINED")
            .with_if(rendering.depths, "DEPTHS")
    }
}

impl Defines {
    /// For programs that use gradients.
    pub fn with_lighting(self, rendering: Rendering) -> Self {
        self.with_if(rendering.gradient_opacity, "THINNED")
            .with_if(rendering.several_lights, "SEVERAL_LIGHTS")
            .with_if(rendering.depth_cue, "DEPTH_CUED")
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
