//! Buffer sizes of data derived from a field, for the field's own code and for resource declarations.

use super::layouts::Weighted;
use crate::device::launch::volume::BlockNumbers;
use crate::layers::{Axis, GradientEstimator, Kernel, PREFILTER_RADIUS};
use crate::volume::{Description, VoxelType};
use glam::DVec3;

/// Voxels on a device: type, and dimensions along x, y, z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::renderer) struct FieldShape {
    pub voxel_type: VoxelType,
    pub dims: [usize; 3],
    spacing: DVec3,
}

impl FieldShape {
    /// The shape of `dims` voxels of a volume.
    pub fn new(description: &Description, dims: [usize; 3]) -> Self {
        Self { voxel_type: description.voxel_type(), dims, spacing: description.grid().spacing() }
    }

    /// Thickness of the layers along an axis, in smallest spacings.
    pub fn thickness(&self, axis: Axis) -> f64 {
        self.spacing[axis.index()] / self.spacing.min_element()
    }

    /// Number of voxels.
    pub fn count(&self) -> usize {
        self.dims.iter().product()
    }

    /// Size of the voxels in bytes.
    pub fn voxel_bytes(&self) -> usize {
        self.count() * self.voxel_type.bytes()
    }

    /// Data type of a kernel's input.
    fn weighted(&self, kernel: Kernel) -> VoxelType {
        Weighted::for_kernel(kernel).voxel_type(self.voxel_type)
    }

    /// Bytes of each buffer besides the voxels that a kernel needs for views along an axis.
    pub fn layouts(&self, axis: Axis, kernel: Kernel) -> Vec<(&'static str, usize)> {
        self.layouts_of(axis, Weighted::for_kernel(kernel))
    }

    /// Bytes of each buffer that gradients need besides those.
    pub fn gradient_layouts(&self, axis: Axis, kernel: Kernel, estimator: GradientEstimator) -> Vec<(&'static str, usize)> {
        Weighted::for_gradients(kernel, estimator).map_or(Vec::new(), |input| self.layouts_of(axis, input))
    }

    fn layouts_of(&self, axis: Axis, input: Weighted) -> Vec<(&'static str, usize)> {
        let bytes = self.count() * input.voxel_type(self.voxel_type).bytes();
        let mut buffers = Vec::new();
        if let Some(filtered) = input.filtered() {
            buffers.push((filtered, bytes));
            buffers.push(("the taps of a filter", 3 * (PREFILTER_RADIUS + 1) * size_of::<f32>()));
        }
        if axis == Axis::X {
            buffers.push(("the layout of layer axis x", bytes));
        }
        buffers
    }

    /// Numbers of min-max blocks for a layer axis.
    pub fn blocks(&self, axis: Axis) -> BlockNumbers {
        let frame = axis.frame();
        BlockNumbers::new([frame.u, frame.v, frame.a].map(|i| self.dims[i]))
    }

    /// Bytes of the min-max blocks of a layer axis, and of each of their visibility buffers.
    pub fn visibility(&self, axis: Axis, kernel: Kernel) -> Vec<(&'static str, usize)> {
        let (numbers, radius) = (self.blocks(axis), kernel.radius());
        vec![
            ("the min-max blocks", numbers.limits() * self.weighted(kernel).bytes()),
            ("the visibility of blocks", numbers.slab_bytes(radius)),
            ("the visible slabs", 2 * size_of::<i32>()),
            ("the visible slabs", numbers.chunks(radius)),
        ]
    }
}
