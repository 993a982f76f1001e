//! A field at the voxels of another grid.

use super::enclosed::{STEEPEST, value_at_end};
use super::{Field, FieldKernels, Placement};
use crate::device::Device;
use crate::device::launch::VoxelBuffer;
use crate::device::launch::structs::ResampleParams;
use crate::device::launch::volume::ResampleArguments;
use crate::error::Error;
use crate::layers::{Axis, Kernel};
use crate::volume::{Grid, VoxelBox, VoxelType};
use glam::{DAffine3, DVec3};

/// Reconstructs the field at voxels. It interpolates: a voxel at the place of one of the source has its value.
const KERNEL: Kernel = Kernel::CatmullRom;

impl Field {
    /// This field at the voxels of another grid, if its own lie at `index_to_world`; both in the caller's world units. Opacities keep the
    /// unit distance of the own voxels. Beyond these lies the background; if the field `ends` there, values that
    /// [`hiding_beyond`](Self::hiding_beyond) hides.
    ///
    /// # Errors
    /// If its voxels do not fit into a buffer of the device.
    pub fn resampled(
        &self,
        kernels: &mut FieldKernels,
        device: &Device,
        index_to_world: DAffine3,
        grid: &Grid,
        ends: bool,
    ) -> Result<Self, Error> {
        let own = &self.description;
        let inner = own.background();
        let end = if ends { value_at_end(own.range(), inner) } else { inner };
        let description = own.resampled(grid.clone()).with_background(inner + STEEPEST * (end - inner))?;
        let name = description.name();
        VoxelBuffer::check_capacity(device, grid.voxel_count(), VoxelType::Float32, name)?;
        let resampled = VoxelBuffer::new(device, grid.voxel_count(), VoxelType::Float32, "a resampled volume")?;
        let layout = self.layout(kernels, device, Axis::Z)?;
        let to_source = index_to_world.inverse() * grid.index_to_world();
        let row = |i: usize| to_source.matrix3.row(i).extend(to_source.translation[i]).as_vec4().to_array();
        let [least, largest] = self.voxel_values();
        let background = layout.view.background;
        let arguments = ResampleArguments {
            voxels: &layout.voxels,
            view: layout.view,
            p: ResampleParams {
                to_source: [row(0), row(1), row(2)],
                dims: grid.dims().map(|n| n as i32),
                range: [least.min(background), largest.max(background)],
                end: (description.rescale().stored(end) - self.offset()) as f32,
                steepest: STEEPEST as f32,
            },
            resampled: super::Floats(&resampled),
        };
        kernels.resample.launch(device, (layout.voxels.kind(), KERNEL), &arguments)?;
        let held = VoxelBox { first: [0; 3], dims: grid.dims() };
        let field = Self::new(&description, held, resampled, Placement::dense(grid.dims()), self.range_is_declared);
        let axes = index_to_world.matrix3;
        let smallest = [axes.x_axis, axes.y_axis, axes.z_axis].map(DVec3::length).into_iter().fold(f64::INFINITY, f64::min);
        let unit_distance = self.unit_distance * smallest / field.world.unit();
        Ok(Self { unit_distance, end: ends.then_some(end), ..field })
    }
}
