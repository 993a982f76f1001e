//! What programs are built for: `-D` options.

use super::VoxelKind;
use crate::layers::Kernel;
use crate::volume::VoxelType;
use std::fmt::Write;

/// `-D` options.
pub(super) struct Defines(pub String);

impl Defines {
    /// Of kernels that compute in vectors of `width`.
    pub fn new(width: u32) -> Self {
        Self(format!("-DVW={width}"))
    }

    /// Of those that read voxels of a type, too.
    pub fn of_voxels(voxel_type: VoxelType, width: u32) -> Self {
        let (name, signed) = match voxel_type {
            VoxelType::Uint8 => ("uchar", 0),
            VoxelType::Int8 => ("char", 1),
            VoxelType::Uint16 => ("ushort", 0),
            VoxelType::Int16 => ("short", 1),
            VoxelType::Float32 => ("float", 1),
        };
        Self::new(width).with("VOXEL", name).with("VOXEL_BYTES", voxel_type.bytes()).with("VOXEL_SIGNED", signed)
    }

    /// Of those that take their values, too.
    pub fn of_values(voxels: VoxelKind, width: u32) -> Self {
        Self::of_voxels(voxels.voxel_type, width).with_if(voxels.unchecked, "UNCHECKED")
    }

    /// Of those that sample between them, too.
    pub fn of_kind(voxels: VoxelKind, width: u32) -> Self {
        Self::of_values(voxels, width).with_if(voxels.far, "FAR_VOXELS")
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

/// How rays end, whether they are cut, and what gradients are looked at for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Rendering {
    pub blend: BlendMode,
    /// Rays are cut to their intervals: something that shows lies beyond these.
    pub clipped: bool,
    /// Gradients leave less of the opacity, or may: samples tell.
    pub thinned: bool,
    /// There is more than one light, or may be: samples tell.
    pub several_lights: bool,
    /// Rays that are cast gather where things are, and no colours.
    pub depths: bool,
}

impl Rendering {
    /// Compositing with all that there is: what is sorted is small, and tests build it.
    pub const EVERYTHING: Self =
        Self { blend: BlendMode::Composite, clipped: true, thinned: true, several_lights: true, depths: false };
}

impl Rendering {
    /// The same with what is a matter of samples and regions left to these; where values are composited.
    pub fn general(self) -> Option<Self> {
        let general = Self { clipped: true, thinned: true, several_lights: true, ..self };
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
    /// `refined` on the field itself.
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
            .with_if(rendering.clipped, "CLIPPED")
            .with_look(rendering)
            .with_if(gathers_values, "EDGE_GOES_ON")
            .with_if(rendering.blend == BlendMode::Iso { refined: true }, "REFINED")
            .with_if(rendering.depths, "DEPTHS")
    }
}

impl Defines {
    /// Of programs that only look at gradients.
    pub fn with_look(self, rendering: Rendering) -> Self {
        self.with_if(rendering.thinned, "THINNED").with_if(rendering.several_lights, "SEVERAL_LIGHTS")
    }

    /// Of programs that reconstruct the field.
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
