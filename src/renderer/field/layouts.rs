//! Layouts of kernel input (voxels, B-spline coefficients or smoothed voxels) for each layer axis.

use super::super::store::Key;
use super::{Field, FieldKernels};
use crate::device::launch::structs::VolumeView;
use crate::device::launch::volume::{Outside, PrefilterColumnsArguments, PrefilterRowsArguments, TransposeArguments};
use crate::device::launch::{Floats, VoxelBuffer};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::layers::{Axis, GradientEstimator, Kernel, PREFILTER_RADIUS, prefilter, smoothing};
use crate::volume::VoxelType;
use std::sync::Arc;

/// Kernel input in which u has unit stride, and its placement.
#[derive(Clone)]
pub(in crate::renderer) struct Layout {
    pub voxels: Arc<VoxelBuffer>,
    pub view: VolumeView,
}

/// Placement of voxels in their buffer: offset of the first one, row pitch and slice pitch, all in voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::renderer) struct Placement {
    pub first: i64,
    pub row: i64,
    pub slice: i64,
}

impl Placement {
    /// Placement without gaps.
    pub fn dense([x, y, _]: [usize; 3]) -> Self {
        Self { first: 0, row: x as i64, slice: x as i64 * y as i64 }
    }
}

/// Kernel input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Weighted {
    Voxels,
    /// B-spline coefficients.
    Coefficients,
    /// Voxels smoothed for gradients of this standard deviation, in voxels of the smallest spacing.
    Smoothed(f64),
}

impl Weighted {
    pub fn for_kernel(kernel: Kernel) -> Self {
        if kernel == Kernel::BSpline { Weighted::Coefficients } else { Weighted::Voxels }
    }

    /// Input of gradients, if it is not that of the kernel.
    pub fn for_gradients(kernel: Kernel, estimator: GradientEstimator) -> Option<Self> {
        match estimator {
            GradientEstimator::Gaussian(sigma) if estimator.smoothing_radius() > 0 => Some(Weighted::Smoothed(sigma)),
            GradientEstimator::Own => None,
            _ => (kernel == Kernel::BSpline).then_some(Weighted::Voxels),
        }
    }

    /// Data type, for voxels of type `voxels`.
    pub fn voxel_type(self, voxels: VoxelType) -> VoxelType {
        match self {
            Weighted::Voxels => voxels,
            Weighted::Coefficients | Weighted::Smoothed(_) => VoxelType::Float32,
        }
    }

    /// Name of the filtered voxels, for messages.
    pub fn filtered(self) -> Option<&'static str> {
        match self {
            Weighted::Voxels => None,
            Weighted::Coefficients => Some("the coefficients of the B-spline"),
            Weighted::Smoothed(_) => Some("the smoothed voxels"),
        }
    }
}

/// Key of the layout of layer axis x.
#[derive(PartialEq)]
struct Transposed(Weighted);

impl Key for Transposed {
    type Value = VoxelBuffer;
}

/// Key of filtered voxels in the order of the uploaded layout.
#[derive(PartialEq)]
struct Filtered(Weighted);

impl Key for Filtered {
    type Value = VoxelBuffer;
}

impl Field {
    /// The voxels for a layer axis. Axes y and z use the uploaded layout; x has its own.
    pub fn layout(&self, kernels: &mut FieldKernels, device: &Device, axis: Axis) -> Result<Layout, Error> {
        self.weighted_layout(kernels, device, axis, Weighted::Voxels)
    }

    /// Kernel input for a layer axis.
    pub fn weighted(&self, kernels: &mut FieldKernels, device: &Device, axis: Axis, kernel: Kernel) -> Result<Layout, Error> {
        self.weighted_layout(kernels, device, axis, Weighted::for_kernel(kernel))
    }

    /// Whether gradients are estimated from other voxels than those that are the input of the kernel.
    pub fn has_separate_gradients(kernel: Kernel, estimator: GradientEstimator) -> bool {
        Weighted::for_gradients(kernel, estimator).is_some()
    }

    /// Input of gradients for a layer axis, if it is not that of the kernel.
    pub fn gradient_layout(
        &self,
        kernels: &mut FieldKernels,
        device: &Device,
        axis: Axis,
        (kernel, estimator): (Kernel, GradientEstimator),
    ) -> Result<Option<Layout>, Error> {
        let input = Weighted::for_gradients(kernel, estimator);
        input.map(|weighted| self.weighted_layout(kernels, device, axis, weighted)).transpose()
    }

    fn weighted_layout(
        &self,
        kernels: &mut FieldKernels,
        device: &Device,
        axis: Axis,
        weighted: Weighted,
    ) -> Result<Layout, Error> {
        let placed = match weighted {
            Weighted::Voxels => self.placed,
            Weighted::Coefficients | Weighted::Smoothed(_) => Placement::dense(self.held.dims),
        };
        let [_, y, z] = self.held.dims.map(|n| n as i64);
        let (first, stride, voxels) = match axis {
            Axis::X => (0, [1, z, y * z], self.transposed(kernels, device, weighted, placed)?),
            Axis::Y => (placed.first, [1, placed.slice, placed.row], self.upright(kernels, device, weighted)?),
            Axis::Z => (placed.first, [1, placed.row, placed.slice], self.upright(kernels, device, weighted)?),
        };
        let (background, offset) = self.background();
        let frame = axis.frame();
        Ok(Layout {
            voxels,
            view: VolumeView {
                stride,
                first,
                dims: [frame.u, frame.v, frame.a].map(|i| self.own_grid().dims()[i] as i32),
                background,
                // Filtered voxels are made with the offset subtracted.
                offset: if weighted == Weighted::Voxels { offset } else { 0.0 },
                first_a: self.held.first[frame.a] as i32,
            },
        })
    }

    /// A layout of layer axis z for kernels that count rows and columns from those of the whole volume. Parts along x or y hold some only.
    pub fn in_whole(&self, Layout { voxels, view }: Layout) -> Layout {
        let [x, y, _] = self.held.first.map(|n| n as i64);
        Layout { voxels, view: VolumeView { first: view.first - x - y * view.stride[1], ..view } }
    }

    /// Kernel input in the uploaded layout.
    fn upright(&self, kernels: &mut FieldKernels, device: &Device, weighted: Weighted) -> Result<Arc<VoxelBuffer>, Error> {
        match weighted {
            Weighted::Voxels => Ok(self.voxels.clone()),
            Weighted::Coefficients | Weighted::Smoothed(_) => self.filtered(kernels, device, weighted),
        }
    }

    fn transposed(
        &self,
        kernels: &mut FieldKernels,
        device: &Device,
        weighted: Weighted,
        placed: Placement,
    ) -> Result<Arc<VoxelBuffer>, Error> {
        let (key, inputs) = (Transposed(weighted), self.inputs());
        if let Some(kept) = self.store().get(device, &key, inputs)? {
            return Ok(kept);
        }
        let voxels = &self.upright(kernels, device, weighted)?;
        let [dims_x, dims_y, dims_z] = self.held.dims.map(|n| n as i32);
        let count = self.held.count();
        let reused = self.store().reuse(device, &key, inputs, count * voxels.voxel_type().bytes());
        let transposed = match reused {
            Some(reused) => reused,
            None => Arc::new(VoxelBuffer::like(device, count, voxels, "the layout of layer axis x")?),
        };
        let Placement { first, row: pitch_y, slice: pitch_z } = placed;
        let arguments = TransposeArguments { voxels, first, pitch_y, pitch_z, dims_x, dims_y, dims_z, transposed: &transposed };
        kernels.transpose.launch(device, voxels.kind(), &arguments)?;
        Ok(self.store().keep(key, inputs, device.produced()?, transposed))
    }

    /// The voxels on the device, less the offset, filtered along each axis, once per volume.
    fn filtered(&self, kernels: &mut FieldKernels, device: &Device, weighted: Weighted) -> Result<Arc<VoxelBuffer>, Error> {
        let (key, inputs) = (Filtered(weighted), self.inputs());
        if let Some(kept) = self.store().get(device, &key, inputs)? {
            return Ok(kept);
        }
        let [x, y, z] = self.held.dims;
        let reused = self.store().reuse(device, &key, inputs, x * y * z * VoxelType::Float32.bytes());
        let name = weighted.filtered().unwrap_or("filtered voxels");
        let filtered = match reused {
            Some(reused) => reused,
            None => Arc::new(VoxelBuffer::new(device, x * y * z, VoxelType::Float32, name)?),
        };
        let outside = if weighted == Weighted::Coefficients { Outside::Mirrored } else { Outside::Background };
        let taps = self.filter_taps(weighted).map(|taps| Buffer::from_slice(device, &taps, "the taps of a filter"));
        let [taps_x, taps_y, taps_z] = taps;
        let whole = self.own_grid().dims().map(|n| n as i32);
        let (first, held) = (self.held.first.map(|n| n as i32), self.held.dims.map(|n| n as i32));
        let upload = self.layout(kernels, device, Axis::Z)?;
        let rows = PrefilterRowsArguments {
            voxels: &upload.voxels,
            view: upload.view,
            taps: &taps_x?,
            first: first[0],
            held: held[0],
            whole: whole[0],
            rows_per_layer: y as i32,
            rows: (y * z) as i32,
            filtered: Floats(&filtered),
        };
        kernels.prefilter_rows.launch(device, (upload.voxels.kind(), outside), &rows)?;
        let strides = [1, x as u64, (x * y) as u64];
        for (axis, across, taps) in [(1, 2, taps_y?), (2, 1, taps_z?)] {
            let columns = PrefilterColumnsArguments {
                filtered: Floats(&filtered),
                taps: &taps,
                first: first[axis],
                held: held[axis],
                whole: whole[axis],
                stride: strides[axis],
                chunks: x.div_ceil(device.tuning().vector_width as usize) as i32,
                width: x as i32,
                lines: held[across],
                line_stride: strides[across],
                background: upload.view.background,
            };
            kernels.prefilter_columns.launch(device, outside, &columns)?;
        }
        Ok(self.store().keep(key, inputs, device.produced()?, filtered))
    }

    /// Taps of a filter along x, y and z, from the centre outwards.
    fn filter_taps(&self, weighted: Weighted) -> [[f32; PREFILTER_RADIUS + 1]; 3] {
        let padded = |taps: &[f64]| {
            let mut all = [0.0; PREFILTER_RADIUS + 1];
            all.iter_mut().zip(taps).for_each(|(slot, &tap)| *slot = tap as f32);
            all
        };
        let spacing = self.own_grid().spacing();
        match weighted {
            Weighted::Smoothed(sigma) => {
                (spacing.min_element() * sigma / spacing).to_array().map(|sigma| padded(&smoothing(sigma)))
            }
            _ => [padded(&prefilter()); 3],
        }
    }
}
