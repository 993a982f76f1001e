//! The field: voxels on a device, and data derived from them alone (layouts, B-spline coefficients, min-max blocks).

mod blocks;
mod enclosed;
mod framed;
mod gradients;
mod in_place;
mod layouts;
mod resampled;
mod shape;
mod uploaded;

pub use in_place::DeviceVoxels;
pub(super) use in_place::value_range;
pub(super) use layouts::{Layout, Placement};
pub(super) use shape::FieldShape;
pub use uploaded::UploadedVolume;

use super::store::{Inputs, Store, Stored, Version};
use super::world::World;
use crate::device::launch::volume::{FillMinMaxBlocks, PrefilterColumns, PrefilterRows, Resample, Transpose};
use crate::device::launch::{Floats, Launcher, VoxelBuffer, VoxelKind};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::settings::Blend;
use crate::volume::{Description, Grid, Held, Stored as StoredNumbers, VoxelBox};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A volume, or some of its layers, on the device. Clones share the voxels and the data derived from them.
#[derive(Clone)]
pub(super) struct Field {
    /// Description of the whole volume.
    description: Description,
    world: World,
    /// Grid of the whole volume in normalised world units.
    grid: Grid,
    /// [`Grid::unit`] of the grid on which the voxels were measured, in normalised world units.
    unit_distance: f64,
    /// The voxels on the device.
    held: VoxelBox,
    voxels: Arc<VoxelBuffer>,
    /// Whether replacing the voxels failed: the buffer does not hold those of `description` then.
    is_lost: bool,
    placed: Placement,
    /// Whether the caller declared the range; voxels may then lie outside it.
    range_is_declared: bool,
    /// Value at the end of a volume that ends within its grid.
    end: Option<f64>,
    /// Where the voxels lie, if frames have another grid. `description` and `grid` are on that of frames then.
    framed: Option<Arc<framed::Framed>>,
    /// Version of the voxels as uploaded or handed over.
    version: Version,
    /// Number of voxel changes in place that this owner was notified of, and the maximum over all owners.
    changes: u64,
    all_changes: Arc<AtomicU64>,
    store: Arc<Mutex<Store>>,
}

/// Kernels that derive data from voxels; one set per renderer.
#[derive(Default)]
pub(super) struct FieldKernels {
    transpose: Launcher<Transpose>,
    prefilter_rows: Launcher<PrefilterRows>,
    prefilter_columns: Launcher<PrefilterColumns>,
    min_max_blocks: Launcher<FillMinMaxBlocks>,
    resample: Launcher<Resample>,
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

/// Cache budget in bytes besides the voxels: the layout of layer axis x, and B-spline coefficients and smoothed voxels in two layouts each.
fn budget(voxels: &VoxelBuffer, held: VoxelBox) -> usize {
    /// Budget for min-max blocks of all axes and kernels.
    const BLOCKS: usize = 64 << 20;
    BLOCKS + 2 * voxels.bytes() + 4 * size_of::<f32>() * held.count()
}

impl Field {
    pub fn new(
        description: &Description,
        held: VoxelBox,
        voxels: VoxelBuffer,
        placed: Placement,
        range_is_declared: bool,
    ) -> Self {
        let world = World::new(description.grid());
        Self {
            description: description.clone(),
            world,
            grid: world.grid(description.grid()),
            unit_distance: world.grid(description.grid()).unit(),
            held,
            store: Arc::new(Mutex::new(Store::new(budget(&voxels, held)))),
            voxels: Arc::new(voxels),
            is_lost: false,
            placed,
            range_is_declared,
            end: None,
            framed: None,
            version: Version::new(),
            changes: 0,
            all_changes: Arc::default(),
        }
    }

    /// A clone for another owner, which is notified of later voxel changes in place.
    pub fn for_renderer(&self) -> Self {
        Self { changes: self.all_changes.load(Ordering::Relaxed), ..self.clone() }
    }

    /// A clone for rehearsals, with a cache of its own.
    pub fn for_rehearsal(&self) -> Self {
        Self { store: Arc::new(Mutex::new(Store::new(budget(&self.voxels, self.held)))), ..self.clone() }
    }

    /// Replaces the voxels. The buffer is reused if it is large enough, no larger than for `capacity` voxels, and no other renderer uses
    /// it; otherwise a new buffer for `capacity` voxels is allocated.
    ///
    /// # Errors
    /// If they do not fit into a buffer of the device, in which case the field is unchanged. After all other errors it has no
    /// voxels ([`require_voxels`](Self::require_voxels)).
    pub fn replace(&mut self, device: &Device, held: &Held, capacity: usize) -> Result<(), Error> {
        let bytes = held.dims().iter().product::<usize>() * held.description.voxel_type().bytes();
        let voxel_box = VoxelBox { first: held.first, dims: held.dims() };
        let same_type = held.description.voxel_type() == self.voxels.voxel_type();
        let most_bytes = capacity * held.description.voxel_type().bytes();
        let in_place = same_type && (bytes..=most_bytes).contains(&self.voxels.bytes()) && self.voxels.is_owned();
        VoxelBuffer::check_capacity(device, capacity, held.description.voxel_type(), held.description.name())?;
        self.store().clear();
        self.is_lost = true;
        match Arc::get_mut(&mut self.voxels).filter(|_| in_place && Arc::strong_count(&self.store) == 1) {
            Some(voxels) => voxels.refill(device, held)?,
            None => {
                // Free the old buffer first: there may not be enough memory for both.
                self.voxels = Arc::new(VoxelBuffer::new(device, 1, held.description.voxel_type(), "no voxels")?);
                *self = Self::new(
                    held.description,
                    voxel_box,
                    VoxelBuffer::upload_with_capacity(device, held, capacity)?,
                    Placement::dense(voxel_box.dims),
                    false,
                );
                return Ok(());
            }
        }
        self.description = held.description.clone();
        self.world = World::new(self.description.grid());
        self.grid = self.world.grid(self.description.grid());
        self.unit_distance = self.grid.unit();
        (self.held, self.placed) = (voxel_box, Placement::dense(voxel_box.dims));
        (self.version, self.changes, self.all_changes) = (Version::new(), 0, Arc::default());
        self.range_is_declared = false;
        self.is_lost = false;
        Ok(())
    }

    /// The voxels as uploaded.
    pub fn voxels(&self) -> &VoxelBuffer {
        &self.voxels
    }

    /// Program permutation of kernels that read the voxels.
    pub fn voxel_kind(&self) -> VoxelKind {
        self.voxels.kind()
    }

    /// Number of voxels for which the buffer has room.
    pub fn capacity(&self) -> usize {
        self.voxels.bytes() / self.voxels.voxel_type().bytes()
    }

    /// Frees the voxels if their buffer is larger than for `capacity` voxels. They must be replaced then.
    pub fn release_beyond(&mut self, device: &Device, capacity: Option<usize>) -> Result<(), Error> {
        if capacity.is_some_and(|capacity| self.capacity() > capacity) {
            self.is_lost = true;
            self.voxels = Arc::new(VoxelBuffer::new(device, 1, self.voxels.voxel_type(), "no voxels")?);
        }
        Ok(())
    }

    /// Whether it has the voxels of this box.
    pub fn holds(&self, voxels: VoxelBox) -> bool {
        !self.is_lost && self.held == voxels
    }

    /// Fails if replacing the voxels failed.
    pub fn require_voxels(&self) -> Result<(), Error> {
        if self.is_lost { Err(Error::NoVolume) } else { Ok(()) }
    }

    /// Records a change of the voxels in the caller's memory.
    pub fn voxels_changed(&mut self) {
        self.changes += 1;
        self.all_changes.fetch_max(self.changes, Ordering::Relaxed);
    }

    /// Version of the voxels as seen by this owner.
    pub fn version(&self) -> Version {
        self.version.after(self.changes)
    }

    /// Drops all derived data.
    pub fn drop_cached(&self) {
        self.store().clear();
    }

    fn inputs(&self) -> Inputs {
        Inputs { field: Some(self.version()), ..Inputs::default() }
    }

    fn store(&self) -> MutexGuard<'_, Store> {
        self.store.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Description of the whole volume.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// The conversion to normalised world units.
    pub fn world(&self) -> World {
        self.world
    }

    /// Grid of the whole volume in normalised world units.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Distance to which opacities refer by default, in normalised world units.
    pub fn unit_distance(&self) -> f64 {
        self.unit_distance
    }

    /// Sizes of the buffers derived from this field.
    pub fn shape(&self) -> FieldShape {
        FieldShape::new(&self.description, self.held.dims)
    }

    /// The voxels on the device.
    pub fn held(&self) -> VoxelBox {
        self.held
    }

    /// Whether the caller declared the range; voxels may then lie outside it.
    pub fn range_is_declared(&self) -> bool {
        self.range_is_declared
    }

    /// The stored numbers that kernels read, before the offset is subtracted.
    pub fn stored(&self) -> StoredNumbers {
        self.description.stored()
    }

    /// Converts a value to a stored number with the offset subtracted.
    pub fn stored_value(&self, value: f64) -> f64 {
        self.description.rescale().stored(value) - self.offset()
    }

    /// Kernels subtract this from every voxel, so that float sums have a precision relative to the range of the data.
    pub fn offset(&self) -> f64 {
        self.stored().range.0
    }

    /// The value below which [`hiding_beyond`](Self::hiding_beyond) hides all; `None` unless the volume ends within its grid.
    pub fn end(&self) -> Option<f64> {
        self.end
    }

    /// The background with the offset subtracted, and the offset.
    pub fn background(&self) -> (f32, f32) {
        ((self.stored().background - self.offset()) as f32, self.offset() as f32)
    }

    /// The value outside the voxels, with the offset subtracted. Blend modes that reduce values use the smallest value, which
    /// cannot be told from a sum of kernel weights: the field continues at its edges.
    pub fn background_for(&self, blend: Blend) -> f32 {
        if blend.gathers_values() { 0.0 } else { self.background().0 }
    }

    /// Converts a blend mode of values to one of stored numbers.
    pub fn blend_of_numbers(&self, blend: Blend) -> Blend {
        if self.description.rescale().slope() < 0.0 { blend.reversed() } else { blend }
    }

    /// Range of the voxels with the offset subtracted, including invalid voxels.
    pub fn voxel_values(&self) -> [f32; 2] {
        let largest = self.stored().range.1 as f32 - self.offset() as f32;
        let (background, _) = self.background();
        let has_invalid = self.description.has_invalid_voxels();
        if has_invalid { [background.min(0.0), background.max(largest)] } else { [0.0, largest] }
    }

    /// Range of the values, with the offset subtracted, that can change a ray which already holds the smallest voxel (for minima:
    /// the largest); `None` if opacity decides.
    pub fn useful_values(&self, blend: Blend) -> Option<[f32; 2]> {
        let [least, largest] = self.voxel_values();
        match self.blend_of_numbers(blend) {
            Blend::Composite => None,
            Blend::Maximum => Some([next_value(least), f32::INFINITY]),
            Blend::Minimum => Some([f32::NEG_INFINITY, -next_value(-largest)]),
            // Only 0 leaves a sum unchanged.
            Blend::Average if least < 0.0 => Some([f32::NEG_INFINITY, f32::INFINITY]),
            Blend::Average => Some([next_value(0.0), f32::INFINITY]),
            Blend::Iso(value) => Some([self.stored_value(value) as f32; 2]),
        }
    }

    /// Number of values made so far.
    #[cfg(test)]
    pub fn made(&self) -> usize {
        self.store().made
    }

    /// Identity of the voxel buffer.
    #[cfg(test)]
    pub fn voxel_buffer(&self) -> *const VoxelBuffer {
        Arc::as_ptr(&self.voxels)
    }

    /// Replaces the voxels by equally many with another placement, for a test of large distances.
    #[cfg(test)]
    pub fn exchange(&mut self, voxels: VoxelBuffer, placed: Placement) {
        (self.voxels, self.placed) = (Arc::new(voxels), placed);
    }
}

/// The next float that kernels distinguish from 0.
fn next_value(value: f32) -> f32 {
    if value == 0.0 { f32::MIN_POSITIVE } else { value.next_up() }
}
