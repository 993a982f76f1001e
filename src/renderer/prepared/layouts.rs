//! The numbers that kernels weight, in the layouts that layer axes need: voxels, or the B-spline's coefficients.

use super::super::cache::Key;
use super::{Prepared, local};
use crate::device::launch::structs::VolumeView;
use crate::device::launch::volume::{PrefilterColumnsArguments, PrefilterRowsArguments, TransposeArguments};
use crate::device::launch::{Floats, VoxelBuffer};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::layers::{Axis, Kernel, prefilter};
use crate::volume::VoxelType;
use std::sync::Arc;

/// Numbers in which u has unit stride, and where they lie.
pub(in crate::renderer) struct Layout {
    pub voxels: Arc<VoxelBuffer>,
    pub view: VolumeView,
}

/// Where voxels lie in their buffer, all in voxels: the first one, and how far it is from row to row and from layer to layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::renderer) struct Placement {
    pub first: i64,
    pub row: i64,
    pub slice: i64,
}

impl Placement {
    /// Without gaps.
    pub fn dense([x, y, _]: [usize; 3]) -> Self {
        Self { first: 0, row: x as i64, slice: x as i64 * y as i64 }
    }
}

/// What a kernel weights.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Weighted {
    Voxels,
    Coefficients,
}

impl Weighted {
    pub fn by(kernel: Kernel) -> Self {
        if kernel == Kernel::BSpline { Weighted::Coefficients } else { Weighted::Voxels }
    }
}

/// The layout of layer axis x.
#[derive(PartialEq)]
struct Transposed(Weighted);

impl Key for Transposed {
    type Value = VoxelBuffer;
    const OF_VOXELS: bool = true;
}

/// The coefficients, in the upload's own layout.
#[derive(PartialEq)]
struct Coefficients;

impl Key for Coefficients {
    type Value = VoxelBuffer;
    const OF_VOXELS: bool = true;
}

impl Prepared {
    /// The voxels for a layer axis. Axes y and z read the upload; x has its own layout.
    pub fn layout(&mut self, device: &Device, axis: Axis) -> Result<Layout, Error> {
        self.layout_of(device, axis, Weighted::Voxels)
    }

    /// The same of what a kernel weights.
    pub fn weighted(&mut self, device: &Device, axis: Axis, kernel: Kernel) -> Result<Layout, Error> {
        self.layout_of(device, axis, Weighted::by(kernel))
    }

    fn layout_of(&mut self, device: &Device, axis: Axis, weighted: Weighted) -> Result<Layout, Error> {
        let placed = match weighted {
            Weighted::Voxels => self.placed,
            Weighted::Coefficients => Placement::dense(self.held_dims),
        };
        let [_, y, z] = self.held_dims.map(|n| n as i64);
        let (first, stride, voxels) = match axis {
            Axis::X => (0, [1, z, y * z], self.transposed(device, weighted, placed)?),
            Axis::Y => (placed.first, [1, placed.slice, placed.row], self.upright(device, weighted)?),
            Axis::Z => (placed.first, [1, placed.row, placed.slice], self.upright(device, weighted)?),
        };
        let (background, offset) = self.background();
        Ok(Layout {
            voxels,
            view: VolumeView {
                stride,
                first,
                dims: local(axis, self.grid.dims()).map(|n| n as i32),
                background,
                // Coefficients are made without it.
                offset: if weighted == Weighted::Voxels { offset } else { 0.0 },
                first_a: self.held_layers(axis).start as i32,
            },
        })
    }

    /// In the upload's layout.
    fn upright(&mut self, device: &Device, weighted: Weighted) -> Result<Arc<VoxelBuffer>, Error> {
        match weighted {
            Weighted::Voxels => Ok(self.voxels.clone()),
            Weighted::Coefficients => self.coefficients(device),
        }
    }

    fn transposed(&mut self, device: &Device, weighted: Weighted, placed: Placement) -> Result<Arc<VoxelBuffer>, Error> {
        if let Some(kept) = self.cache.get(&Transposed(weighted)) {
            return Ok(kept);
        }
        let voxels = &self.upright(device, weighted)?;
        let [dims_x, dims_y, dims_z] = self.held_dims.map(|n| n as i32);
        let count = self.held_dims.iter().product();
        let transposed = match self.cache.take_stale(&Transposed(weighted)) {
            Some(stale) => stale,
            None => Arc::new(VoxelBuffer::like(device, count, voxels, "the layout of layer axis x")?),
        };
        let Placement { first, row: pitch_y, slice: pitch_z } = placed;
        let arguments = TransposeArguments { voxels, first, pitch_y, pitch_z, dims_x, dims_y, dims_z, transposed: &transposed };
        self.launchers.transpose.launch(device, voxels.kind(), &arguments)?;
        Ok(self.cache.keep(Transposed(weighted), transposed))
    }

    /// The B-spline's coefficients of the voxels that are held, less the offset: a prefilter along each axis, once per volume.
    fn coefficients(&mut self, device: &Device) -> Result<Arc<VoxelBuffer>, Error> {
        if let Some(kept) = self.cache.get(&Coefficients) {
            return Ok(kept);
        }
        let [x, y, z] = self.held_dims;
        let coefficients = match self.cache.take_stale(&Coefficients) {
            Some(stale) => stale,
            None => Arc::new(VoxelBuffer::new(device, x * y * z, VoxelType::Float32, "the coefficients of the B-spline")?),
        };
        let taps = Buffer::from_slice(device, &prefilter().map(|tap| tap as f32), "the prefilter")?;
        let whole = self.grid.dims().map(|n| n as i32);
        let (first, held) = (self.held_first.map(|n| n as i32), self.held_dims.map(|n| n as i32));
        let upload = self.layout(device, Axis::Z)?;
        let rows = PrefilterRowsArguments {
            voxels: &upload.voxels,
            view: upload.view,
            taps: &taps,
            first: first[0],
            held: held[0],
            whole: whole[0],
            rows_per_layer: y as i32,
            rows: (y * z) as i32,
            coefficients: Floats(&coefficients),
        };
        self.launchers.prefilter_rows.launch(device, upload.voxels.kind(), &rows)?;
        let strides = [1, x as u64, (x * y) as u64];
        for (axis, across) in [(1, 2), (2, 1)] {
            let columns = PrefilterColumnsArguments {
                coefficients: Floats(&coefficients),
                taps: &taps,
                first: first[axis],
                held: held[axis],
                whole: whole[axis],
                stride: strides[axis],
                chunks: x.div_ceil(device.tuning().vector_width as usize) as i32,
                width: x as i32,
                lines: held[across],
                line_stride: strides[across],
            };
            self.launchers.prefilter_columns.launch(device, (), &columns)?;
        }
        Ok(self.cache.keep(Coefficients, coefficients))
    }
}
