//! Distributed volumes: each of several processes holds a part.

use super::part::check;
use super::placed::Placed;
use super::{Held, Volume};
use crate::error::Error;
use std::fmt::Debug;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

/// A box of voxels from `first` to `first + dims` (exclusive) along x, y, z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VoxelBox {
    /// First voxel.
    pub first: [usize; 3],
    /// Number of voxels along x, y, z.
    pub dims: [usize; 3],
}

impl VoxelBox {
    /// All voxels of a grid.
    pub fn whole(dims: [usize; 3]) -> Self {
        Self { first: [0; 3], dims }
    }

    /// A range of whole layers along `axis`.
    pub fn layers(dims: [usize; 3], axis: usize, layers: &Range<usize>) -> Self {
        let mut slab = Self::whole(dims);
        (slab.first[axis], slab.dims[axis]) = (layers.start, layers.len());
        slab
    }

    /// Index after the last voxel along `axis`.
    pub fn end(&self, axis: usize) -> usize {
        self.first[axis].saturating_add(self.dims[axis])
    }

    /// Number of voxels.
    pub fn count(&self) -> usize {
        self.dims.iter().fold(1, |n, &d| n.saturating_mul(d))
    }

    /// Whether it contains all voxels of `other`.
    pub fn holds(&self, other: &Self) -> bool {
        (0..3).all(|i| self.first[i] <= other.first[i] && other.end(i) <= self.end(i))
    }

    /// Whether it contains the voxel at `place`.
    pub fn has(&self, place: [usize; 3]) -> bool {
        (0..3).all(|i| (self.first[i]..self.end(i)).contains(&place[i]))
    }

    /// Intersection; `None` if it is empty.
    pub fn common(&self, other: &Self) -> Option<Self> {
        let first = [0, 1, 2].map(|i| self.first[i].max(other.first[i]));
        let ends = [0, 1, 2].map(|i| self.end(i).min(other.end(i)));
        (0..3).all(|i| first[i] < ends[i]).then(|| Self { first, dims: [0, 1, 2].map(|i| ends[i] - first[i]) })
    }
}

/// Collective operations of the processes that share a volume. All processes must call them in the same order; each call waits for all.
#[doc(hidden)]
pub trait Collective: Send + Sync + Debug {
    /// Sums over all processes, in rank order.
    fn add(&self, numbers: &mut [f64]);

    /// Integer sums over all processes.
    fn count(&self, numbers: &mut [u64]);

    /// Concatenation of the numbers of all processes.
    fn gather(&self, numbers: &[f64]) -> Vec<f64>;
}

/// Part of a distributed volume.
#[derive(Clone, Debug)]
pub(super) struct Shared {
    /// Voxels that this process holds.
    pub held: VoxelBox,
    /// Voxels that this process owns. No other process owns them, so that sums count each voxel once.
    pub own: VoxelBox,
    /// Bytes read for the held voxels.
    #[cfg_attr(not(feature = "mpi"), expect(dead_code, reason = "only read with the feature `mpi`"))]
    pub read_bytes: u64,
    pub collective: Arc<dyn Collective>,
}

/// The voxels of `wanted` among those of `held`.
pub(super) fn within<'a>(voxels: &Placed<'a>, held: &VoxelBox, wanted: &VoxelBox) -> Option<Placed<'a>> {
    let common = held.common(wanted)?;
    Some(voxels.part([0, 1, 2].map(|i| common.first[i] - held.first[i]), common.dims))
}

impl<'a> Volume<'a> {
    /// Voxels that this process holds; all, if the volume is not distributed.
    #[doc(hidden)]
    pub fn held_box(&self) -> VoxelBox {
        self.shared.as_ref().map_or(VoxelBox::whole(self.grid().dims()), |shared| shared.held)
    }

    /// Bytes that this process read from the file; 0 if the volume is not distributed or was in memory.
    #[cfg(feature = "mpi")]
    #[doc(hidden)]
    pub fn read_bytes(&self) -> u64 {
        self.shared.as_ref().map_or(0, |shared| shared.read_bytes)
    }

    /// Voxels that this process owns; all, if the volume is not distributed.
    #[doc(hidden)]
    pub fn own_box(&self) -> VoxelBox {
        self.shared.as_ref().map_or(VoxelBox::whole(self.grid().dims()), |shared| shared.own)
    }

    /// The voxels that this process owns, if any.
    pub(super) fn own_voxels(&self) -> Option<Placed<'a>> {
        within(&self.voxels, &self.held_box(), &self.own_box())
    }

    /// Index of voxel `index` among the held voxels; `None` if it is not held.
    pub(super) fn index_in_held(&self, index: usize) -> Option<usize> {
        let Some(Shared { held, .. }) = &self.shared else { return Some(index) };
        let place = self.grid().place(index);
        held.has(place).then(|| {
            let [x, y, z] = [0, 1, 2].map(|i| place[i] - held.first[i]);
            x + held.dims[0] * (y + held.dims[1] * z)
        })
    }

    /// The voxels of a box, which must be held.
    pub(super) fn voxels_of(&self, wanted: VoxelBox) -> Result<Placed<'a>, Error> {
        check(&self.description, wanted.first, wanted.dims)?;
        let held = self.held_box();
        match within(&self.voxels, &held, &wanted).filter(|_| held.holds(&wanted)) {
            Some(voxels) => Ok(voxels),
            None => {
                let problem = format!("{wanted:?} is not held by this process, which holds {held:?}");
                Err(Error::volume(Path::new(self.name()), problem))
            }
        }
    }

    /// Sums over all processes that share the volume.
    #[doc(hidden)]
    pub fn add_all(&self, numbers: &mut [f64]) {
        self.shared.iter().for_each(|shared| shared.collective.add(numbers));
    }

    /// Integer sums over all processes that share the volume.
    #[doc(hidden)]
    pub fn count_all(&self, numbers: &mut [u64]) {
        self.shared.iter().for_each(|shared| shared.collective.count(numbers));
    }

    /// Concatenation of the numbers of all processes that share the volume.
    #[doc(hidden)]
    pub fn gather_all(&self, numbers: Vec<f64>) -> Vec<f64> {
        match &self.shared {
            Some(shared) => shared.collective.gather(&numbers),
            None => numbers,
        }
    }

    /// The held voxels, for upload to a device.
    #[doc(hidden)]
    pub fn held(&self) -> Held<'_> {
        let instead = (self.invalid > 0).then(|| self.description.stored().background);
        Held { description: &self.description, first: self.held_box().first, voxels: &self.voxels, instead }
    }
}
