//! The field: voxels on a device, and what is made from them alone (layouts, B-spline coefficients, min-max blocks).

mod blocks;
mod gradients;
mod in_place;
mod layouts;
mod shape;
mod uploaded;

pub use in_place::DeviceVoxels;
pub(super) use layouts::{Layout, Placement};
pub(super) use shape::FieldShape;
pub use uploaded::UploadedVolume;

use super::store::{Inputs, Store, Stored, Version};
use super::world::World;
use crate::device::launch::volume::{FillMinMaxBlocks, PrefilterColumns, PrefilterRows, Transpose};
use crate::device::launch::{Launcher, VoxelBuffer};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::settings::Blend;
use crate::volume::{Description, Grid, Held, Stored as StoredNumbers, VoxelBox};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A volume on the device, or some layers of one. Clones share the voxels and everything made from them.
#[derive(Clone)]
pub(super) struct Field {
    /// Of the whole volume.
    description: Description,
    world: World,
    /// Of the whole volume, in the world of frames.
    grid: Grid,
    /// The voxels on the device.
    held: VoxelBox,
    voxels: Arc<VoxelBuffer>,
    placed: Placement,
    /// The range is a promise of the caller: voxels may leave it.
    range_is_declared: bool,
    /// The voxels as they were handed over.
    version: Version,
    /// How often this owner was told that voxels in place have changed, and how often any was.
    changes: u64,
    all_changes: Arc<AtomicU64>,
    store: Arc<Mutex<Store>>,
}

/// The kernels that make things from voxels: one set for each renderer.
#[derive(Default)]
pub(super) struct FieldKernels {
    transpose: Launcher<Transpose>,
    prefilter_rows: Launcher<PrefilterRows>,
    prefilter_columns: Launcher<PrefilterColumns>,
    min_max_blocks: Launcher<FillMinMaxBlocks>,
}

impl Stored for VoxelBuffer {
    fn bytes(&self) -> usize {
        VoxelBuffer::bytes(self)
    }
}

impl<T: Send + Sync + Copy + 'static> Stored for Buffer<T> {
    fn bytes(&self) -> usize {
        Buffer::bytes(self)
    }
}

/// Bytes that a field keeps besides its voxels: the layout of layer axis x and the coefficients of the B-spline in two layouts.
fn budget(voxels: &VoxelBuffer, held: VoxelBox) -> usize {
    /// For min-max blocks of all axes and kernels.
    const BLOCKS: usize = 64 << 20;
    BLOCKS + 2 * voxels.bytes() + 2 * size_of::<f32>() * held.count()
}

impl Field {
    fn new(description: &Description, held: VoxelBox, voxels: VoxelBuffer, placed: Placement, range_is_declared: bool) -> Self {
        let world = World::of(description.grid());
        Self {
            description: description.clone(),
            world,
            grid: world.grid(description.grid()),
            held,
            store: Arc::new(Mutex::new(Store::new(budget(&voxels, held)))),
            voxels: Arc::new(voxels),
            placed,
            range_is_declared,
            version: Version::new(),
            changes: 0,
            all_changes: Arc::default(),
        }
    }

    /// For another owner, who is told of later changes of voxels in place.
    pub fn for_renderer(&self) -> Self {
        Self { changes: self.all_changes.load(Ordering::Relaxed), ..self.clone() }
    }

    /// For frames that are not drawn: what they make is nobody else's.
    pub fn for_rehearsal(&self) -> Self {
        Self { store: Arc::new(Mutex::new(Store::new(budget(&self.voxels, self.held)))), ..self.clone() }
    }

    /// Puts other voxels of the same volume into the same buffer, where no other renderer uses it and it has room; into a new one
    /// elsewhere. `room`: voxels that a new buffer has room for.
    pub fn replace(&mut self, device: &Device, held: &Held, room: usize) -> Result<(), Error> {
        let bytes = held.dims().iter().product::<usize>() * held.description.voxel_type().bytes();
        let voxel_box = VoxelBox { first: held.first, dims: held.dims() };
        let same_type = held.description.voxel_type() == self.voxels.voxel_type();
        let in_place = same_type && bytes <= self.voxels.bytes() && self.voxels.is_owned();
        self.store().clear();
        match Arc::get_mut(&mut self.voxels).filter(|_| in_place && Arc::strong_count(&self.store) == 1) {
            Some(voxels) => voxels.refill(device, held)?,
            None => {
                // The old buffer goes first: there may be no room for both.
                self.voxels = Arc::new(VoxelBuffer::new(device, 1, held.description.voxel_type(), "no voxels")?);
                *self = Self::new(
                    held.description,
                    voxel_box,
                    VoxelBuffer::upload_with_capacity(device, held, room)?,
                    Placement::dense(voxel_box.dims),
                    false,
                );
                return Ok(());
            }
        }
        self.description = held.description.clone();
        self.world = World::of(self.description.grid());
        self.grid = self.world.grid(self.description.grid());
        (self.held, self.placed) = (voxel_box, Placement::dense(voxel_box.dims));
        (self.version, self.changes, self.all_changes) = (Version::new(), 0, Arc::default());
        self.range_is_declared = false;
        Ok(())
    }

    /// The voxels, in memory of the caller, have changed.
    pub fn voxels_changed(&mut self) {
        self.changes += 1;
        self.all_changes.fetch_max(self.changes, Ordering::Relaxed);
    }

    /// The version of the voxels as this owner knows them.
    pub fn version(&self) -> Version {
        self.version.after(self.changes)
    }

    /// Drops what was made from the voxels.
    pub fn make_room(&self) {
        self.store().clear();
    }

    fn inputs(&self) -> Inputs {
        Inputs { field: Some(self.version()), ..Inputs::default() }
    }

    fn store(&self) -> MutexGuard<'_, Store> {
        self.store.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What is known of the whole volume.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// The scale of the world of frames.
    pub fn world(&self) -> World {
        self.world
    }

    /// Of the whole volume, in the world of frames.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The sizes that buffers made from this field have.
    pub fn shape(&self) -> FieldShape {
        FieldShape::new(&self.description, self.held.dims)
    }

    /// The voxels on the device.
    pub fn held(&self) -> VoxelBox {
        self.held
    }

    /// Whether the range is a promise of the caller, which voxels may break.
    pub fn range_is_declared(&self) -> bool {
        self.range_is_declared
    }

    /// As kernels see them, but for the offset.
    pub fn stored(&self) -> StoredNumbers {
        self.description.stored()
    }

    /// A value as the number that kernels see, less the offset.
    pub fn stored_value(&self, value: f64) -> f64 {
        self.description.rescale().stored(value) - self.offset()
    }

    /// Subtracted from every voxel by the kernels, so that float sums are as fine as the range of the data.
    pub fn offset(&self) -> f64 {
        self.stored().range.0
    }

    /// The background as kernels see it, and the offset that they subtract from every voxel.
    pub fn background(&self) -> (f32, f32) {
        ((self.stored().background - self.offset()) as f32, self.offset() as f32)
    }

    /// The value around the voxels, less the offset. Where values are gathered it is the smallest one, which no sum of kernel weights can
    /// be told from: edges continue there.
    pub fn background_for(&self, blend: Blend) -> f32 {
        if blend.gathers_values() { 0.0 } else { self.background().0 }
    }

    /// The blend mode of stored numbers that is this one of values.
    pub fn blend_of_numbers(&self, blend: Blend) -> Blend {
        if self.description.rescale().slope() < 0.0 { blend.reversed() } else { blend }
    }

    /// Smallest and largest number of a voxel, less the offset, invalid ones included.
    pub fn voxel_values(&self) -> [f32; 2] {
        let largest = self.stored().range.1 as f32 - self.offset() as f32;
        let (background, _) = self.background();
        let has_invalid = self.description.has_invalid_voxels();
        if has_invalid { [background.min(0.0), background.max(largest)] } else { [0.0, largest] }
    }

    /// Smallest and largest value, less the offset, that can change a ray which already holds the smallest (of minima: the largest) voxel;
    /// `None` where opacity decides.
    pub fn useful_values(&self, blend: Blend) -> Option<[f32; 2]> {
        let [least, largest] = self.voxel_values();
        match self.blend_of_numbers(blend) {
            Blend::Composite => None,
            Blend::Maximum => Some([next_value(least), f32::INFINITY]),
            Blend::Minimum => Some([f32::NEG_INFINITY, -next_value(-largest)]),
            // Only 0 adds nothing to a sum.
            Blend::Average if least < 0.0 => Some([f32::NEG_INFINITY, f32::INFINITY]),
            Blend::Average => Some([next_value(0.0), f32::INFINITY]),
            Blend::Iso(value) => Some([self.stored_value(value) as f32; 2]),
        }
    }

    /// Values made so far.
    #[cfg(test)]
    pub fn made(&self) -> usize {
        self.store().made
    }

    /// Which buffer the voxels are in.
    #[cfg(test)]
    pub fn voxel_buffer(&self) -> *const VoxelBuffer {
        Arc::as_ptr(&self.voxels)
    }

    /// Exchanges the voxels, which are as many at other places: for a test of large distances.
    #[cfg(test)]
    pub fn exchange(&mut self, voxels: VoxelBuffer, placed: Placement) {
        (self.voxels, self.placed) = (Arc::new(voxels), placed);
    }
}

/// The next float, of those that kernels tell from 0.
fn next_value(value: f32) -> f32 {
    if value == 0.0 { f32::MIN_POSITIVE } else { value.next_up() }
}
