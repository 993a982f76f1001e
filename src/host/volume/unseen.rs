//! A process's part of a distributed volume, before the processes exchange its range.

use super::missing_data::MissingData;
use super::placed::Placed;
use super::shared::{Collective, Shared, VoxelBox, within};
use super::wide::{self, Numbers};
use super::{Contents, Description, Endian, Grid, Rescale, ScalarType, Storage, Volume};
use crate::error::Error;
use crate::progress::Task;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

/// The z layers that a process reads.
#[derive(Clone, Debug, PartialEq)]
#[doc(hidden)]
pub struct Layers {
    /// Layers that this process owns.
    pub own: Range<usize>,
    /// The owned layers and some around them.
    pub held: Range<usize>,
}

impl Layers {
    /// The held and the owned box of a grid.
    pub fn boxes(&self, dims: [usize; 3]) -> [VoxelBox; 2] {
        [&self.held, &self.own].map(|layers| VoxelBox::layers(dims, 2, layers))
    }
}

/// This process's part of a volume whose range is not known yet.
#[doc(hidden)]
pub struct Unseen<'a> {
    name: String,
    grid: Grid,
    rescale: Rescale,
    background: Option<f64>,
    held: VoxelBox,
    own: VoxelBox,
    voxels: Found<'a>,
    overview: Option<Arc<Volume<'static>>>,
}

/// The data read.
enum Found<'a> {
    Voxels(Placed<'a>),
    /// Their conversion depends on the range of all processes.
    Wide(WideNumbers),
}

/// Numbers of a type without device support, or of which some may be missing, x fastest.
pub(super) struct WideNumbers {
    pub bytes: Box<dyn AsRef<[u8]> + Send + Sync>,
    pub scalar: ScalarType,
    pub endian: Endian,
    pub missing: Option<MissingData>,
}

impl Unseen<'static> {
    /// Layers of numbers that have to be converted.
    pub(super) fn wide(name: String, grid: Grid, layers: &Layers, numbers: WideNumbers) -> Self {
        let [held, own] = layers.boxes(grid.dims());
        let voxels = Found::Wide(numbers);
        Self { name, grid, rescale: Rescale::default(), background: None, held, own, voxels, overview: None }
    }

    /// Layers of voxels, as stored in a file.
    pub fn layers(name: String, grid: Grid, layers: &Layers, storage: Storage<'static>) -> Result<Self, Error> {
        let [held, own] = layers.boxes(grid.dims());
        Self::new(name, grid, held, own, storage)
    }
}

impl<'a> Unseen<'a> {
    /// Sets the value around the volume.
    pub fn with_background(self, background: f64) -> Self {
        Self { background: Some(background), ..self }
    }

    /// The voxels of `held`; this process owns those in `own`.
    ///
    /// # Errors
    /// If a box is empty or `own`, `held` and the grid are not nested, or the storage has another number of voxels.
    pub fn new(
        name: impl Into<String>,
        grid: Grid,
        held: VoxelBox,
        own: VoxelBox,
        voxels: impl Into<Storage<'a>>,
    ) -> Result<Self, Error> {
        let (name, storage) = (name.into(), voxels.into());
        let wrong = |problem: String| Error::volume(Path::new(&name), problem);
        if !VoxelBox::whole(grid.dims()).holds(&held) || !held.holds(&own) || held.count() == 0 {
            let dims = grid.dims();
            return Err(wrong(format!("invalid boxes for its {dims:?} voxels: held {held:?}, owned {own:?}")));
        }
        let expected = held.count() as u64;
        if let Some(found) = storage.count().filter(|&found| found != expected) {
            return Err(Error::VoxelCount { name, dims: held.dims, expected, found });
        }
        let Some(voxels) = storage.placed(held.dims) else {
            return Err(wrong("its first byte and strides place voxels outside its bytes".into()));
        };
        let (rescale, voxels) = (Rescale::default(), Found::Voxels(voxels));
        Ok(Self { name, grid, rescale, background: None, held, own, voxels, overview: None })
    }

    pub fn with_rescale(self, rescale: Rescale) -> Self {
        Self { rescale, ..self }
    }

    /// See [`Volume::overview`].
    pub(super) fn with_overview(self, overview: Option<Arc<Volume<'static>>>) -> Self {
        Self { overview, ..self }
    }

    /// Bytes of the held voxels, as stored.
    pub fn bytes(&self) -> u64 {
        let size = match &self.voxels {
            Found::Voxels(voxels) => voxels.voxel_type().bytes(),
            Found::Wide(numbers) => numbers.scalar.bytes(),
        };
        (self.held.count() * size) as u64
    }

    /// Number of z layers of the whole volume.
    pub fn layers_of_all(&self) -> usize {
        self.grid.dims()[2]
    }

    /// Collective: converts numbers without device support to voxels, by the range over all processes.
    pub fn converted(self, collective: &dyn Collective) -> Result<Self, Error> {
        let Found::Wide(WideNumbers { bytes, scalar, endian, missing }) = &self.voxels else { return Ok(self) };
        let numbers = Numbers { bytes: (**bytes).as_ref(), scalar: *scalar, endian: *endian, missing: missing.as_ref() };
        let range = common_range(numbers.range(), collective).unwrap_or((0.0, 0.0));
        let (storage, offset) = wide::storage(&self.name, numbers, range, None)?;
        let rescale = Rescale::new(self.rescale.slope(), self.rescale.value(offset))?;
        let Self { name, grid, background, held, own, overview, .. } = self;
        Ok(Self { background, rescale, overview, ..Self::new(name, grid, held, own, storage)? })
    }

    /// Collective: creates the volume with the range over all processes. Numbers must be [converted](Self::converted) before.
    pub fn shared(self, collective: Arc<dyn Collective>, read_bytes: u64) -> Result<Volume<'a>, Error> {
        let Self { name, grid, rescale, background, held, own, voxels, overview } = self;
        let Found::Voxels(voxels) = voxels else { unreachable!("wide numbers are converted first") };
        let bytes = (own.count() * voxels.voxel_type().bytes()) as u64;
        let task = Task::new(format!("scanning {name}"), bytes);
        let (range, invalid) = within(&voxels, &held, &own).map_or((None, 0), |own| own.valid_range(&task));
        let range = common_range(range, &*collective).unwrap_or((0.0, 0.0));
        let mut all = [invalid as u64];
        collective.count(&mut all);
        let [invalid] = all;
        let description = Description::new(name, grid, voxels.voxel_type(), range)?;
        description.warn_of_values(invalid);
        let description = if invalid > 0 { description.with_invalid_voxels() } else { description };
        let shared = Some(Shared { held, own, read_bytes, collective });
        let (contents, statistics) = (Contents::default(), Arc::default());
        let volume = Volume { description, voxels, invalid: invalid as usize, shared, contents, overview: None, statistics };
        let volume = volume.with_rescale(rescale).with_overview(overview);
        match background {
            Some(value) => volume.with_background(value),
            None => Ok(volume),
        }
    }
}

/// Range of the numbers of all processes, if there are any.
fn common_range(own: Option<(f64, f64)>, collective: &dyn Collective) -> Option<(f64, f64)> {
    let (lo, hi) = own.unwrap_or((f64::INFINITY, f64::NEG_INFINITY));
    let all = collective.gather(&[lo, hi]);
    let lo = all.iter().step_by(2).copied().fold(f64::INFINITY, f64::min);
    let hi = all.iter().skip(1).step_by(2).copied().fold(f64::NEG_INFINITY, f64::max);
    (lo <= hi).then_some((lo, hi))
}
