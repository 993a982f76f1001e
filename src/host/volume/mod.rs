//! Volumes: grids, voxels and file formats. This module does not depend on rendering.

mod builtin;
mod channels;
mod color_channels;
mod colors;
mod contents;
mod covering;
mod description;
mod extent;
mod format;
mod grid;
mod labels;
mod lengths;
mod missing_data;
mod open;
mod part;
mod placed;
mod rescale;
mod sequence;
mod shared;
mod spool;
mod statistics;
mod storage;
#[cfg(feature = "mpi")]
mod unseen;
mod voxels;
mod wide;
mod write;

#[doc(hidden)]
pub use builtin::BUILTIN;
pub use builtin::builtin_volume;
pub use channels::ChannelDescription;
pub use color_channels::ColorChannels;
pub use contents::{Contents, FrameSpacing, LevelLattice};
#[doc(hidden)]
pub use covering::{reach, spacing_along};
pub use description::Description;
#[doc(hidden)]
pub use description::Stored;
pub(crate) use format::{FREESURFER_TRIANGLES, STL_BYTES, SurfaceFormat, stl_triangles, vtk};
pub use format::{Level, OpenOptions, Placement};
pub use grid::Grid;
#[doc(hidden)]
pub use labels::grid_over;
pub use labels::{Label, LabelChange, LabelLayer, LabelSurfaces, LabelTable, LabelVisibility, Labels};
#[doc(hidden)]
pub use open::Stated;
#[doc(hidden)]
pub use part::Held;
pub use part::VolumePart;
pub use rescale::Rescale;
pub use sequence::{Playback, Sequence, steps_along};
#[cfg(feature = "mpi")]
#[doc(hidden)]
pub use shared::Collective;
pub use shared::VoxelBox;
#[doc(hidden)]
pub use spool::MappedBytes;
pub use statistics::{HISTOGRAM_BINS, Statistics};
pub use storage::Storage;
#[cfg(feature = "mpi")]
#[doc(hidden)]
pub use unseen::{Layers, Unseen};
pub use voxels::{Endian, ScalarType, Voxel, VoxelType, Voxels, Wide};
pub(crate) use wide::Numbers;
pub use write::convert;

use crate::error::Error;
use crate::progress::Task;
use placed::Placed;
use shared::Shared;
use std::path::Path;
use std::sync::{Arc, OnceLock};
use voxels::{is_valid, with_voxel_type};

/// A scalar volume: a [`Description`] and voxels. `'a` is the lifetime of borrowed voxels; volumes with owned, shared or mapped voxels are
/// `'static`. Clones share the voxels.
///
/// ```
/// use layersplat::volume::{Grid, Volume};
/// use layersplat::glam::DVec3;
///
/// let densities: Vec<u16> = (0..4 * 3 * 2).collect();
/// let volume = Volume::new("densities", Grid::new([4, 3, 2], DVec3::new(0.5, 0.5, 2.0))?, &densities)?;
/// assert_eq!(volume.range(), (0.0, 23.0));
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Volume<'a> {
    description: Description,
    /// Voxels in memory: all of them, or those that this process holds of a distributed volume.
    voxels: Placed<'a>,
    invalid: usize,
    shared: Option<Shared>,
    contents: Contents,
    /// The level that stands for all levels of a data set, unless this is it.
    overview: Option<Arc<Volume<'static>>>,
    /// Counted once, for all clones.
    statistics: Arc<OnceLock<Statistics>>,
}

impl Volume<'static> {
    /// Creates a volume from 32-bit integers, 64-bit integers or 64-bit floats, x fastest.
    ///
    /// The numbers are converted: the smallest becomes 0, and the type is the narrowest that holds all integers, else float32. A rescale
    /// restores the values, up to the precision of float32. If float32 cannot distinguish them, a warning is logged.
    ///
    /// # Errors
    /// [`Error::VoxelCount`] if `numbers` does not fill the grid.
    pub fn from_wide<T: Wide>(name: impl Into<String>, grid: Grid, numbers: &[T]) -> Result<Self, Error> {
        let name = name.into();
        let (expected, found) = (grid.voxel_count() as u64, numbers.len() as u64);
        if found != expected {
            return Err(Error::VoxelCount { name, dims: grid.dims(), expected, found });
        }
        let numbers =
            wide::Numbers { bytes: bytemuck::cast_slice(numbers), scalar: T::TYPE, endian: Endian::NATIVE, missing: None };
        wide::volume(name, grid, numbers, Rescale::default(), None)
    }

    /// As [`Volume::new`] for stored numbers of a file. Floats that devices cannot hold as they are, beyond 1e30 or in a tiny range, are scaled.
    fn of_file(name: String, grid: Grid, storage: Storage<'static>, rescale: Rescale, most: Option<u64>) -> Result<Self, Error> {
        let found = Self::without_warning(name.clone(), grid.clone(), storage.clone());
        let is_odd = storage.voxel_type() == VoxelType::Float32 && found.as_ref().map_or(true, |volume| volume.invalid > 0);
        let placed = storage.placed(grid.dims()).filter(|_| is_odd);
        let scaled = placed.map(|placed| wide::scaled(&name, &grid, |i| placed.number(i), rescale, most));
        if let Some(volume) = scaled.transpose()?.flatten() {
            return Ok(volume);
        }
        let volume = found?;
        volume.description.warn_of_values(volume.invalid as u64);
        Ok(volume.with_rescale(rescale))
    }
}

/// Work on many voxels, compiled for each type of voxels.
#[doc(hidden)]
pub trait ReadsValues {
    /// The result.
    type Read;
    /// Works with the values of voxels by index, x fastest.
    fn read(self, value: impl Fn(usize) -> f64 + Sync) -> Self::Read;
}

impl<'a> Volume<'a> {
    /// Creates a volume from voxels in memory: a vector, a slice, an `Arc` of either, or any other [`Storage`]; x fastest unless it has
    /// strides. `name` appears in messages and reports. Stored numbers equal values until [`with_rescale`](Self::with_rescale).
    ///
    /// Float voxels that are NaN, infinite or beyond ±1e30 are invalid and take the [background](Self::background). Their number is
    /// available as [`invalid`](Self::invalid), and a warning is logged.
    ///
    /// # Errors
    /// If the voxels do not fill the grid, or their range is too narrow for 32-bit floats.
    pub fn new(name: impl Into<String>, grid: Grid, voxels: impl Into<Storage<'a>>) -> Result<Self, Error> {
        let volume = Self::without_warning(name.into(), grid, voxels.into())?;
        volume.description.warn_of_values(volume.invalid as u64);
        Ok(volume)
    }

    fn without_warning(name: String, grid: Grid, storage: Storage<'a>) -> Result<Self, Error> {
        let voxel_type = storage.voxel_type();
        let expected = grid.voxel_count() as u64;
        if let Some(found) = storage.count().filter(|&found| found != expected) {
            return Err(Error::VoxelCount { name, dims: grid.dims(), expected, found });
        }
        let Some(voxels) = storage.placed(grid.dims()) else {
            return Err(Error::volume(Path::new(&name), "its first byte and strides place voxels outside its bytes"));
        };
        let bytes = expected * voxel_type.bytes() as u64;
        tracing::info!("{name}: a first pass over {bytes} bytes, for the range of its values");
        let (range, invalid) = voxels.valid_range(&Task::new(format!("looking at {name}"), bytes));
        let description = Description::new(name, grid, voxel_type, range.unwrap_or((0.0, 0.0)))?;
        let description = if invalid > 0 { description.with_invalid_voxels() } else { description };
        let (contents, statistics) = Default::default();
        Ok(Self { description, voxels, invalid, shared: None, contents, overview: None, statistics })
    }

    /// Places the voxels on another grid of the same dimensions.
    ///
    /// # Errors
    /// [`Error::Grid`] for other dimensions.
    pub fn with_grid(mut self, grid: Grid) -> Result<Self, Error> {
        if grid.dims() != self.grid().dims() {
            let problem = format!("it has {:?} voxels, and the volume {:?}", grid.dims(), self.grid().dims());
            return Err(Error::Grid { problem });
        }
        self.description.grid = grid;
        Ok(self)
    }

    /// See [`Description::with_background`].
    pub fn with_background(self, value: f64) -> Result<Self, Error> {
        Ok(Self { description: self.description.with_background(value)?, ..self })
    }

    /// See [`Description::with_rescale`].
    pub fn with_rescale(self, rescale: Rescale) -> Self {
        Self { description: self.description.with_rescale(rescale), overview: None, statistics: Arc::default(), ..self }
    }

    /// Declares what else the file of the volume holds.
    pub(in crate::volume) fn with_contents(self, contents: Contents) -> Self {
        // Headers state a spacing of times even where there is one time.
        let frame_spacing = contents.frame_spacing.filter(|_| contents.frames > 1);
        Self { contents: Contents { frame_spacing, ..contents }, ..self }
    }

    /// Gives this level of a data set the look of all levels: that of an overview, if it is another level.
    pub(in crate::volume) fn with_overview(mut self, overview: Option<Arc<Volume<'static>>>) -> Self {
        if let Some((name, (lo, hi))) = overview.as_ref().map(|overview| (overview.name(), overview.range()))
            && let (from, to) = self.range()
            && (from < lo || hi < to)
        {
            tracing::info!("{name}: values from {from} to {to}; the level by which all are shown has {lo} to {hi}");
        }
        self.description.common = overview
            .as_ref()
            .map(|overview| description::Common { range: overview.range(), spacing: overview.grid().spacing().min_element() });
        Self { overview, ..self }
    }

    /// The volume from which statistics, transfer functions and cameras are derived, so that they are the same for all levels of a data set: the
    /// level that stands for all, which is read with each; any other volume itself.
    pub fn overview(&self) -> &Volume<'a> {
        self.overview.as_deref().unwrap_or(self)
    }

    /// Where its voxels lie among those of the finest level of its data set.
    #[doc(hidden)]
    pub fn lattice(&self) -> LevelLattice {
        let of = |volume: &Volume| volume.contents.lattices.get(volume.contents.level).copied().unwrap_or(LevelLattice::OWN);
        if !self.contents.are_part(self.grid().dims()) {
            return of(self);
        }
        let (overview, LevelLattice { first, step }) = (self.overview(), of(self.overview()));
        LevelLattice { first: first + step * overview.grid().world_to_voxel(self.grid().origin()), ..of(self) }
    }

    /// The volume that cameras fit: one level for all levels of a data set, unless a part was read.
    #[doc(hidden)]
    pub fn framed(&self) -> &Volume<'a> {
        if self.contents.are_part(self.grid().dims()) { self } else { self.overview() }
    }

    /// What the file holds beside this volume: frames, channels and resolutions.
    pub fn contents(&self) -> &Contents {
        &self.contents
    }

    /// Unit of lengths in the world: that of the file, or `mm` for a patient.
    pub fn length_unit(&self) -> Option<&str> {
        self.contents.length_unit.as_deref().or(self.grid().has_anatomy().then_some("mm"))
    }

    /// Metadata of the volume.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// File name or `builtin:NAME`.
    pub fn name(&self) -> &str {
        self.description.name()
    }

    /// Position of the voxels in the world.
    pub fn grid(&self) -> &Grid {
        self.description.grid()
    }

    /// Type of the stored voxels.
    pub fn voxel_type(&self) -> VoxelType {
        self.description.voxel_type()
    }

    /// See [`Description::range`].
    pub fn range(&self) -> (f64, f64) {
        self.description.range()
    }

    /// See [`Description::background`].
    pub fn background(&self) -> f64 {
        self.description.background()
    }

    /// See [`Description::field_range`].
    pub fn field_range(&self) -> (f64, f64) {
        self.description.field_range()
    }

    /// Number of invalid voxels.
    pub fn invalid(&self) -> usize {
        self.invalid
    }

    /// Value of voxel `index`, x fastest. Invalid voxels and voxels of other processes have the background value.
    pub fn value(&self, index: usize) -> f64 {
        self.valid(index).unwrap_or_else(|| self.background())
    }

    /// Value of voxel `index`, x fastest, unless it is invalid or of another process.
    #[doc(hidden)]
    pub fn valid(&self, index: usize) -> Option<f64> {
        let stored = self.voxels.number(self.index_in_held(index)?);
        is_valid(stored).then(|| self.description.rescale.value(stored))
    }

    /// Passes `at` a fast version of [`value`](Self::value), for access to many voxels.
    #[doc(hidden)]
    pub fn look<R>(&self, at: impl FnOnce(&(dyn Fn(usize) -> f64 + Sync)) -> R) -> R {
        struct Looks<F>(F);
        impl<R, F: FnOnce(&(dyn Fn(usize) -> f64 + Sync)) -> R> ReadsValues for Looks<F> {
            type Read = R;
            fn read(self, value: impl Fn(usize) -> f64 + Sync) -> R {
                self.0(&value)
            }
        }
        self.read_by(Looks(at))
    }

    /// As [`look`](Self::look), with code of its own for each type of voxels.
    #[doc(hidden)]
    pub fn read_by<R: ReadsValues>(&self, reader: R) -> R::Read {
        let (rescale, background) = (self.description.rescale, self.background());
        with_voxel_type!(self.voxel_type(), T => match self.voxels.as_values::<T>().filter(|_| self.shared.is_none()) {
            None => reader.read(|index| self.value(index)),
            Some(numbers) => reader.read(|index| {
                let number: f64 = numbers[index].into();
                if is_valid(number) { rescale.value(number) } else { background }
            }),
        })
    }

    /// Smallest and largest value at each x of the rows `from` to `to` (y, z), inclusive. Invalid voxels have the background value. Voxels
    /// of other processes are ignored; a column without voxels has the range ∞ … −∞.
    #[doc(hidden)]
    pub fn column_ranges(&self, from: [usize; 2], to: [usize; 2]) -> Vec<(f64, f64)> {
        let held = self.held_box();
        let mut all = vec![(f64::INFINITY, f64::NEG_INFINITY); self.grid().dims()[0]];
        let inside = |i: usize, at: usize| at.clamp(held.first[i + 1], held.end(i + 1) - 1) - held.first[i + 1];
        if (0..2).all(|i| from[i] < held.end(i + 1) && to[i] >= held.first[i + 1]) {
            let [from, to] = [from, to].map(|row| [inside(0, row[0]), inside(1, row[1])]);
            let ranges = self.voxels.column_ranges(from, to, self.description.stored().background);
            let rescaled = ranges.into_iter().map(|range| self.description.rescale.range(range));
            all[held.first[0]..].iter_mut().zip(rescaled).for_each(|(range, found)| *range = found);
        }
        all
    }

    /// Reduces blocks of voxel values in parallel: `add` gets a value and a number of voxels that have it; invalid voxels are `None`. Returns
    /// one result per block, in order. The blocks depend on the number of voxels only, so results are reproducible. Of a distributed
    /// volume, covers the voxels owned by this process.
    #[doc(hidden)]
    pub fn sum_blocks<R: Send + Default>(&self, add: impl Fn(&mut R, Option<f64>, u64) + Sync) -> Vec<R> {
        let rescale = self.description.rescale;
        let Some(voxels) = self.own_voxels() else { return Vec::new() };
        let bytes = (voxels.len() * self.voxel_type().bytes()) as u64;
        let task = Task::new(format!("looking at {}", self.name()), bytes);
        with_voxel_type!(self.voxel_type(), T => voxels.map_blocks::<T, _>(&task, |numbers| {
            let mut sum = R::default();
            let mut add_all = |number: T, count: u64| {
                let number: f64 = number.into();
                add(&mut sum, is_valid(number).then(|| rescale.value(number)), count);
            };
            if size_of::<T>() == 1 {
                let counts = counts_of_bytes(bytemuck::cast_slice(numbers));
                let found = (0..=u8::MAX).zip(counts).filter(|&(_, count)| count > 0);
                found.for_each(|(byte, count)| add_all(bytemuck::pod_read_unaligned(&[byte]), count));
            } else {
                numbers.iter().for_each(|&number| add_all(number, 1));
            }
            sum
        }))
    }

    /// The voxels of a box of `dims` voxels from `first` on, without copying.
    ///
    /// # Errors
    /// If the box is empty, extends beyond the volume, or contains voxels of other processes.
    pub fn part(&self, first: [usize; 3], dims: [usize; 3]) -> Result<VolumePart<'a>, Error> {
        let voxels = self.voxels_of(VoxelBox { first, dims })?;
        Ok(VolumePart { description: self.description.clone(), first, voxels })
    }

    /// Range, mean and histogram of the valid voxels. Takes a pass over the voxels the first time.
    pub fn statistics(&self) -> Statistics {
        self.statistics.get_or_init(|| Statistics::new(self)).clone()
    }
}

/// How many bytes have each value. Equal bytes in a row count in tables of their own: a count waits for the one before in its table.
fn counts_of_bytes(bytes: &[u8]) -> [u64; 256] {
    let mut tables = [[0u32; 256]; 4];
    let fours = bytes.chunks_exact(4);
    fours.remainder().iter().for_each(|&byte| tables[0][usize::from(byte)] += 1);
    for four in fours {
        tables.iter_mut().zip(four).for_each(|(table, &byte)| table[usize::from(byte)] += 1);
    }
    std::array::from_fn(|n| tables.iter().map(|table| u64::from(table[n])).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn volume(values: Vec<f32>) -> Volume<'static> {
        let grid = Grid::new([values.len(), 1, 1], DVec3::ONE).unwrap();
        Volume::new("t", grid, Voxels::Float32(values)).unwrap()
    }

    #[test]
    fn the_range_is_that_of_valid_voxels() {
        for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 2e31, -2e31] {
            let volume = volume(vec![300.0, odd, 280.0, 310.0]);
            assert_eq!((volume.range(), volume.field_range(), volume.invalid()), ((280.0, 310.0), (280.0, 310.0), 1), "{odd}");
            assert_eq!((volume.background(), volume.value(1)), (280.0, 280.0));
            let statistics = volume.statistics();
            assert_eq!((statistics.min, statistics.max, statistics.histogram.iter().sum::<u64>()), (280.0, 310.0, 3));
            assert!((statistics.mean - 890.0 / 3.0).abs() < 1e-9);
        }
        assert_eq!(volume(vec![f32::NAN; 4]).field_range(), (0.0, 0.0));
    }

    #[test]
    fn the_background_is_the_smallest_valid_value_or_what_is_given() {
        assert_eq!(volume(vec![5.0, 7.0]).background(), 5.0);
        assert_eq!(volume(vec![-5.0, 7.0]).background(), -5.0);
        let given = volume(vec![5.0, f32::NAN, 7.0]).with_background(-2.0).unwrap();
        assert_eq!((given.background(), given.range(), given.field_range()), (-2.0, (5.0, 7.0), (-2.0, 7.0)));
        assert_eq!([0, 1, 2].map(|i| given.value(i)), [5.0, -2.0, 7.0]);
        assert_eq!(given.with_background(9.0).unwrap().field_range(), (5.0, 9.0));
        for bad in [f64::NAN, f64::INFINITY, -2e30] {
            assert!(volume(vec![5.0]).with_background(bad).is_err());
        }
    }

    #[test]
    fn a_wrong_count_or_a_lost_range_is_refused() {
        let grid = Grid::new([2, 2, 2], DVec3::ONE).unwrap();
        assert!(Volume::new("t", grid.clone(), Voxels::Uint8(vec![0; 7])).is_err());
        let tiny = Voxels::Float32((0..8).map(|i| i as f32 * 1e-35).collect());
        assert!(Volume::new("t", grid, tiny).unwrap_err().to_string().contains("scale them up"));
    }
}
