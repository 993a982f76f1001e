//! What frames find prepared on the device: the volume's layouts and min-max blocks, and what depends on the transfer function.
//! Everything is made when a frame first asks for it, and kept as long as memory allows.

mod blocks;
mod splat_list;
mod tables;

pub(super) use blocks::PointReach;
pub(super) use splat_list::{SplatList, Splatted, read_total};
pub(super) use tables::{Integrals, SLAB_VALUES, Table};

use super::cache::{Cache, Kept, Key};
use crate::device::launch::layered::{FootprintSet, FootprintSetArguments};
use crate::device::launch::rays::PreintegratedTable;
use crate::device::launch::sheets::{Scan, Splats};
use crate::device::launch::structs::VolumeView;
use crate::device::launch::volume::{FillMinMaxBlocks, SlabVisibility, Transpose, TransposeArguments, Visibility};
use crate::device::launch::{Launcher, VoxelBuffer};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::layers::{Axis, FOOTPRINT_SET_LEN, FOOTPRINT_SET_SIZE, set_direction};
use crate::transfer::TransferFunction;
use crate::volume::{Grid, Rescale, Stored, Volume, VoxelType};
use std::sync::Arc;

/// Bytes that may be kept besides those of the volume, twice: a second layout, and a list of splats.
const BUDGET: usize = 256 << 20;

/// A volume on the device, a transfer function, and what is made from both.
pub(super) struct Prepared {
    grid: Grid,
    stored: Stored,
    /// Whether some voxels are invalid, and count as background.
    holed: bool,
    rescale: Rescale,
    voxels: Arc<VoxelBuffer>,
    /// As it was given.
    given_transfer: TransferFunction,
    /// Of stored numbers, as all that follows takes it.
    transfer: TransferFunction,
    /// Changes with the transfer function.
    revision: u64,
    cache: Cache,
    launchers: Launchers,
}

#[derive(Default)]
struct Launchers {
    transpose: Launcher<Transpose>,
    min_max_blocks: Launcher<FillMinMaxBlocks>,
    visibility: Launcher<Visibility>,
    slab_visibility: Launcher<SlabVisibility>,
    footprint_set: Launcher<FootprintSet>,
    slicing_table: Launcher<PreintegratedTable>,
    splats: Launcher<Splats>,
    scan: Launcher<Scan>,
}

/// Voxels in which u has unit stride, and where they lie.
pub(super) struct Layout {
    pub voxels: Arc<VoxelBuffer>,
    pub view: VolumeView,
}

/// The paper's footprint images.
pub(super) struct FootprintImages {
    pub images: Buffer<u8>,
    pub shears: Buffer<[f32; 2]>,
}

/// The layout of layer axis x.
#[derive(PartialEq)]
struct TransposedVoxels;

impl Key for TransposedVoxels {
    type Value = VoxelBuffer;
}

impl Kept for VoxelBuffer {
    fn bytes(&self) -> usize {
        VoxelBuffer::bytes(self)
    }
}

impl<T: Send + Sync + Copy + 'static> Kept for Buffer<T> {
    fn bytes(&self) -> usize {
        Buffer::bytes(self)
    }
}

#[derive(PartialEq)]
struct FootprintImagesKey;

impl Key for FootprintImagesKey {
    type Value = FootprintImages;
}

impl Kept for FootprintImages {
    fn bytes(&self) -> usize {
        self.images.bytes() + self.shears.bytes()
    }
}

impl Prepared {
    /// `grid` is the volume's, in the world of frames.
    pub fn upload(device: &Device, volume: &Volume, grid: Grid, transfer: &TransferFunction) -> Result<Self, Error> {
        let voxels = VoxelBuffer::upload(device, volume)?;
        let rescale = volume.description().rescale();
        Ok(Self {
            grid,
            stored: volume.description().stored(),
            holed: volume.invalid() > 0,
            rescale,
            cache: Cache::new(BUDGET + 2 * voxels.bytes()),
            voxels: Arc::new(voxels),
            given_transfer: transfer.clone(),
            transfer: transfer.of_stored(rescale),
            revision: 0,
            launchers: Launchers::default(),
        })
    }

    pub fn set_transfer_function(&mut self, transfer: &TransferFunction) {
        if self.given_transfer != *transfer {
            self.transfer = transfer.of_stored(self.rescale);
            self.given_transfer = transfer.clone();
            self.revision += 1;
        }
    }

    /// As it was given.
    pub fn transfer_function(&self) -> &TransferFunction {
        &self.given_transfer
    }

    /// A value as the number that kernels see, less the offset.
    pub fn stored_value(&self, value: f64) -> f64 {
        self.rescale.stored(value) - self.offset()
    }

    /// Whether larger values are smaller numbers.
    pub fn reverses_values(&self) -> bool {
        self.rescale.slope() < 0.0
    }

    /// Taken from every voxel by the kernels, so that float sums are as fine as the data's own range.
    fn offset(&self) -> f64 {
        self.stored.range.0
    }

    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Smallest and largest number of a voxel.
    pub fn stored_range(&self) -> (f64, f64) {
        self.stored.range
    }

    /// Whether the background itself has opacity.
    pub fn background_visible(&self) -> bool {
        self.transfer.opacity(self.stored.background) > 0.0
    }

    /// The background as kernels see it, and what they take from every voxel.
    pub fn background(&self) -> (f32, f32) {
        ((self.stored.background - self.offset()) as f32, self.offset() as f32)
    }

    pub fn voxel_type(&self) -> VoxelType {
        self.voxels.voxel_type()
    }

    /// The voxels as they were uploaded, x fastest.
    pub fn uploaded(&self) -> Arc<VoxelBuffer> {
        self.voxels.clone()
    }

    /// Strides of the upload along x, y, z, for kernels that take them per axis.
    pub fn upload_strides(&self) -> [i64; 4] {
        let [x, y, _] = self.grid.dims().map(|n| n as i64);
        [1, x, x * y, 0]
    }

    /// The voxels for a layer axis. Axes y and z read the upload; x has its own layout.
    pub fn layout(&mut self, device: &Device, axis: Axis) -> Result<Layout, Error> {
        let [x, y, z] = self.grid.dims().map(|n| n as i64);
        let (stride, voxels) = match axis {
            Axis::X => ([1, y, y * z], self.transposed(device)?),
            Axis::Y => ([1, x * y, x], self.voxels.clone()),
            Axis::Z => ([1, x, x * y], self.voxels.clone()),
        };
        let (background, offset) = self.background();
        Ok(Layout {
            voxels,
            view: VolumeView { stride, dims: self.local_dims(axis).map(|n| n as i32), background, offset, first_a: 0 },
        })
    }

    fn transposed(&mut self, device: &Device) -> Result<Arc<VoxelBuffer>, Error> {
        if let Some(kept) = self.cache.get(&TransposedVoxels) {
            return Ok(kept);
        }
        let [dims_x, dims_y, dims_z] = self.grid.dims().map(|n| n as i32);
        let transposed = VoxelBuffer::new(device, self.grid.voxel_count(), self.voxel_type(), "the layout of layer axis x")?;
        let arguments = TransposeArguments { voxels: &self.voxels, dims_x, dims_y, dims_z, transposed: &transposed };
        self.launchers.transpose.launch(device, self.voxels.voxel_type(), &arguments)?;
        Ok(self.cache.keep(TransposedVoxels, transposed))
    }

    /// The paper's footprint set.
    pub fn footprint_images(&mut self, device: &Device) -> Result<Arc<FootprintImages>, Error> {
        if let Some(kept) = self.cache.get(&FootprintImagesKey) {
            return Ok(kept);
        }
        let shears: Vec<[f32; 2]> = (0..FOOTPRINT_SET_LEN).map(|i| set_direction(i).map(|s| s as f32)).collect();
        let shears = Buffer::from_slice(device, &shears, "the footprint set")?;
        let count = FOOTPRINT_SET_LEN * FOOTPRINT_SET_SIZE * FOOTPRINT_SET_SIZE;
        let images = Buffer::new(device, count, "the footprint set")?;
        let arguments = FootprintSetArguments { shears: &shears, count: count as i32, images: &images };
        self.launchers.footprint_set.launch(device, (), &arguments)?;
        Ok(self.cache.keep(FootprintImagesKey, FootprintImages { images, shears }))
    }

    /// Voxels along u, v, a.
    fn local_dims(&self, axis: Axis) -> [usize; 3] {
        let frame = axis.frame();
        [frame.u, frame.v, frame.a].map(|i| self.grid.dims()[i])
    }
}
