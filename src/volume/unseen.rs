//! A process's part of a volume that several share, before they have looked at it together.

use super::placed::Placed;
use super::shared::{Shared, Together, VoxelBox, within};
use super::wide::{self, Numbers};
use super::{Description, Endian, Grid, OpenOptions, Rescale, ScalarType, Storage, Volume, builtin, format};
use crate::error::Error;
use crate::progress::Task;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

/// Which layers along z a process reads of a volume.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layers {
    /// Those that no other process has as its own.
    pub own: Range<usize>,
    /// These and some around them.
    pub held: Range<usize>,
}

impl Layers {
    /// The same as boxes of a grid: held, own.
    fn boxes(&self, dims: [usize; 3]) -> [VoxelBox; 2] {
        [&self.held, &self.own].map(|layers| VoxelBox::layers(dims, 2, layers))
    }
}

/// This process's part of a volume whose values nobody has looked at yet.
pub(crate) struct Unseen<'a> {
    name: String,
    grid: Grid,
    rescale: Rescale,
    background: Option<f64>,
    held: VoxelBox,
    own: VoxelBox,
    voxels: Found<'a>,
}

/// What was read.
enum Found<'a> {
    Voxels(Placed<'a>),
    /// Numbers that are no voxels of a device, x fastest: what they become depends on the range of all.
    Wide(Box<dyn AsRef<[u8]>>, ScalarType, Endian),
}

impl Unseen<'static> {
    /// Some layers of a file or built-in volume as [`Volume::open`] takes them, without a look at any other: those that `choose` takes of
    /// a volume of so many voxels along x, y, z.
    ///
    /// # Errors
    /// As [`Volume::open`], and files of which no part can be read without all before it.
    pub fn open(source: &Path, options: &OpenOptions, choose: &dyn Fn([usize; 3]) -> Layers) -> Result<Self, Error> {
        match source.to_str().and_then(|name| name.strip_prefix("builtin:")) {
            Some(name) => {
                let (name, grid, made) = builtin::sampled(name, options)?;
                let layers = choose(grid.dims());
                let [held, own] = layers.boxes(grid.dims());
                let voxels = builtin::layers(&name, &*made, grid.dims(), &layers.held)?;
                Ok(Self { background: Some(0.0), ..Self::new(name, grid, held, own, voxels)? })
            }
            None => format::layers(source, options, choose),
        }
    }

    /// Layers of numbers that are no voxels of a device.
    pub fn wide(
        name: String,
        grid: Grid,
        layers: &Layers,
        numbers: Box<dyn AsRef<[u8]>>,
        scalar: ScalarType,
        endian: Endian,
    ) -> Self {
        let [held, own] = layers.boxes(grid.dims());
        let voxels = Found::Wide(numbers, scalar, endian);
        Self { name, grid, rescale: Rescale::default(), background: None, held, own, voxels }
    }

    /// Layers of voxels as they are placed in a file.
    pub fn layers(name: String, grid: Grid, layers: &Layers, storage: Storage<'static>) -> Result<Self, Error> {
        let [held, own] = layers.boxes(grid.dims());
        Self::new(name, grid, held, own, storage)
    }
}

impl<'a> Unseen<'a> {
    /// The voxels of `held`, of which others have those that are not in `own`, too.
    ///
    /// # Errors
    /// Boxes that are empty, outside of each other or of the grid, and storage of another number of voxels.
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
            return Err(wrong(format!("of its {dims:?} voxels {held:?} cannot be held, and {own:?} of these be its own")));
        }
        let expected = held.count() as u64;
        if let Some(found) = storage.count().filter(|&found| found != expected) {
            return Err(Error::VoxelCount { name, dims: held.dims, expected, found });
        }
        let Some(voxels) = storage.placed(held.dims) else {
            return Err(wrong("its first byte and strides lead to voxels outside of its bytes".into()));
        };
        Ok(Self { name, grid, rescale: Rescale::default(), background: None, held, own, voxels: Found::Voxels(voxels) })
    }

    pub fn with_rescale(self, rescale: Rescale) -> Self {
        Self { rescale, ..self }
    }

    /// Bytes of the voxels that it holds, as they were stored.
    pub fn bytes(&self) -> u64 {
        let size = match &self.voxels {
            Found::Voxels(voxels) => voxels.voxel_type().bytes(),
            Found::Wide(_, scalar, _) => scalar.bytes(),
        };
        (self.held.count() * size) as u64
    }

    /// Layers along z of the whole volume.
    pub fn layers_of_all(&self) -> usize {
        self.grid.dims()[2]
    }

    /// Makes wide numbers voxels, by the range of those of all processes: all come here.
    pub fn converted(self, together: &dyn Together) -> Result<Self, Error> {
        let Found::Wide(bytes, scalar, endian) = &self.voxels else { return Ok(self) };
        let numbers = Numbers { bytes: (**bytes).as_ref(), scalar: *scalar, endian: *endian };
        let range = common_range(numbers.range(), together).unwrap_or((0.0, 0.0));
        let storage = wide::storage(&self.name, numbers, range, None)?;
        let rescale = Rescale::new(self.rescale.slope(), self.rescale.value(range.0))?;
        let Self { name, grid, background, held, own, .. } = self;
        Ok(Self { background, rescale, ..Self::new(name, grid, held, own, storage)? })
    }

    /// The volume, once all processes have come here: the range of its values is that of all of them. Wide numbers were
    /// [converted](Self::converted) before.
    pub fn shared(self, together: Arc<dyn Together>, read_bytes: u64) -> Result<Volume<'a>, Error> {
        let Self { name, grid, rescale, background, held, own, voxels } = self;
        let Found::Voxels(voxels) = voxels else { unreachable!("wide numbers are converted first") };
        let bytes = (own.count() * voxels.voxel_type().bytes()) as u64;
        let task = Task::new(format!("looking at {name}"), bytes);
        let (range, invalid) = within(&voxels, &held, &own).map_or((None, 0), |own| own.valid_range(task));
        let range = common_range(range, &*together).unwrap_or((0.0, 0.0));
        let mut all = [invalid as u64];
        together.count(&mut all);
        let [invalid] = all;
        let description = Description::new(name, grid, voxels.voxel_type(), range)?;
        description.warn_of_values(invalid);
        let description = if invalid > 0 { description.with_invalid_voxels() } else { description };
        let shared = Some(Shared { held, own, read_bytes, together });
        let volume = Volume { description, voxels, invalid: invalid as usize, shared }.with_rescale(rescale);
        match background {
            Some(value) => volume.with_background(value),
            None => Ok(volume),
        }
    }
}

/// The range of the numbers of all processes, if there are any.
fn common_range(own: Option<(f64, f64)>, together: &dyn Together) -> Option<(f64, f64)> {
    let (lo, hi) = own.unwrap_or((f64::INFINITY, f64::NEG_INFINITY));
    let all = together.gather(&[lo, hi]);
    let lo = all.iter().step_by(2).copied().fold(f64::INFINITY, f64::min);
    let hi = all.iter().skip(1).step_by(2).copied().fold(f64::NEG_INFINITY, f64::max);
    (lo <= hi).then_some((lo, hi))
}
