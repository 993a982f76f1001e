//! Parts of volumes, and voxels to be uploaded to a device.

use super::placed::Placed;
#[cfg(feature = "mpi")]
use super::shared::{VoxelBox, within};
use super::storage::Storage;
use super::{Description, VoxelType};
use crate::error::Error;
use std::path::Path;

/// A box of voxels of a volume, with the metadata of the whole volume.
///
/// ```
/// use layersplat::{OpenOptions, Volume};
///
/// let volume = Volume::open("builtin:hydrogen@32", &OpenOptions::default())?;
/// let lower_half = volume.part([0, 0, 0], [32, 32, 16])?;
/// assert_eq!(lower_half.description().range(), volume.range());
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct VolumePart<'a> {
    pub(super) description: Description,
    pub(super) first: [usize; 3],
    pub(super) voxels: Placed<'a>,
}

impl<'a> VolumePart<'a> {
    /// The box of `dims` voxels from `first` on, of the described volume.
    ///
    /// # Errors
    /// If the box is empty or extends beyond the volume, or the voxels have another type or number.
    pub fn new(
        description: Description,
        first: [usize; 3],
        dims: [usize; 3],
        voxels: impl Into<Storage<'a>>,
    ) -> Result<Self, Error> {
        check(&description, first, dims)?;
        let storage = voxels.into();
        let name = Path::new(description.name());
        if storage.voxel_type() != description.voxel_type() {
            let (found, expected) = (storage.voxel_type(), description.voxel_type());
            return Err(Error::volume(name, format!("the voxels of a part are {found}, those of the volume {expected}")));
        }
        let expected = dims.iter().map(|&n| n as u64).product();
        if let Some(found) = storage.count().filter(|&found| found != expected) {
            return Err(Error::VoxelCount { name: description.name().into(), dims, expected, found });
        }
        match storage.placed(dims) {
            Some(voxels) => Ok(Self { description, first, voxels }),
            None => Err(Error::volume(name, "a part's first byte and strides place voxels outside its bytes")),
        }
    }

    /// Metadata of the whole volume.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// The voxels of a box inside this one.
    #[cfg(feature = "mpi")]
    #[doc(hidden)]
    pub fn part(&self, wanted: VoxelBox) -> Result<Self, Error> {
        let held = VoxelBox { first: self.first, dims: self.voxels.dims() };
        match within(&self.voxels, &held, &wanted).filter(|_| held.holds(&wanted)) {
            Some(voxels) => Ok(Self { description: self.description.clone(), first: wanted.first, voxels }),
            None => Err(Error::volume(Path::new(self.description.name()), format!("{wanted:?} is not in {held:?}"))),
        }
    }

    #[doc(hidden)]
    pub fn held(&self) -> Held<'_> {
        // Replace invalid floats without a scan for them, which would be another pass over all voxels.
        let floats = self.description.voxel_type() == VoxelType::Float32;
        let instead = floats.then(|| self.description.stored().background);
        Held { description: &self.description, first: self.first, voxels: &self.voxels, instead }
    }
}

/// Rejects boxes that are empty or extend beyond the volume.
pub(super) fn check(description: &Description, first: [usize; 3], dims: [usize; 3]) -> Result<(), Error> {
    let all = description.grid().dims();
    if (0..3).all(|i| dims[i] > 0 && first[i].checked_add(dims[i]).is_some_and(|end| end <= all[i])) {
        return Ok(());
    }
    let problem = format!("a box of {dims:?} voxels from {first:?} on is empty or extends beyond its {all:?} voxels");
    Err(Error::volume(Path::new(description.name()), problem))
}

/// Voxels to be uploaded to a device, of a volume or a part.
#[doc(hidden)]
pub struct Held<'v> {
    pub description: &'v Description,
    /// First voxel of the box.
    pub first: [usize; 3],
    pub(super) voxels: &'v Placed<'v>,
    /// Replacement of invalid voxels; `None` if there are none.
    pub(super) instead: Option<f64>,
}

impl Held<'_> {
    /// Voxels along x, y, z.
    pub fn dims(&self) -> [usize; 3] {
        self.voxels.dims()
    }

    /// Calls `visit` with consecutive pieces of all voxels in device layout, and the byte offset of each piece. Device layout is x fastest,
    /// without gaps, in native byte order, with the background in place of invalid voxels.
    pub fn for_each_piece<E>(&self, visit: impl FnMut(usize, &[u8]) -> Result<(), E>) -> Result<(), E> {
        self.voxels.for_each_piece(self.instead, visit)
    }
}
