//! Min-max blocks: the smallest and the largest kernel input in each block of voxels.

use super::super::store::{Key, Stored};
use super::layouts::{Layout, Weighted};
use super::{Field, FieldKernels};
use crate::device::Device;
use crate::device::launch::structs::VolumeView;
use crate::device::launch::volume::{MinMaxArguments, MinMaxBlocks};
use crate::error::Error;
use crate::layers::{Axis, Kernel};
use std::sync::Arc;

/// Key: layer axis, kernel radius, kernel input.
#[derive(PartialEq)]
struct BlocksKey(Axis, i32, Weighted);

impl Key for BlocksKey {
    type Value = MinMaxBlocks;
}

impl Stored for MinMaxBlocks {
    fn bytes(&self) -> usize {
        self.limits.bytes()
    }
}

impl Field {
    /// The min-max blocks of a layer axis for a kernel.
    pub fn min_max_blocks(
        &self,
        kernels: &mut FieldKernels,
        device: &Device,
        axis: Axis,
        kernel: Kernel,
    ) -> Result<Arc<MinMaxBlocks>, Error> {
        let (key, inputs) = (BlocksKey(axis, kernel.radius(), Weighted::for_kernel(kernel)), self.inputs());
        if let Some(kept) = self.store().get(device, &key, inputs)? {
            return Ok(kept);
        }
        let Layout { voxels, view } = self.weighted(kernels, device, axis, kernel)?;
        let numbers = self.shape().blocks(axis);
        let reused = self.store().reuse(device, &key, inputs, numbers.limits() * voxels.voxel_type().bytes());
        let blocks = match reused {
            Some(reused) => reused,
            None => Arc::new(MinMaxBlocks::new(device, numbers, voxels.voxel_type())?),
        };
        // Covers only the voxels on the device. The outermost blocks of a part are therefore wrong, but no layer that it renders
        // reaches them.
        let view = VolumeView { dims: [view.dims[0], view.dims[1], blocks.numbers.layers], first_a: 0, ..view };
        let arguments = MinMaxArguments::new(&voxels, view, kernel.radius(), &blocks);
        kernels.min_max_blocks.launch(device, voxels.kind(), &arguments)?;
        Ok(self.store().keep(key, inputs, device.produced()?, blocks))
    }
}
