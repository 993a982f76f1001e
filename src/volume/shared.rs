//! Volumes of which each of several processes holds a part.

use super::part::check;
use super::placed::Placed;
use super::{Held, Volume};
use crate::error::Error;
use std::fmt::Debug;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

/// Voxels `first` to `first + dims` along x, y, z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VoxelBox {
    /// The lowest voxel.
    pub first: [usize; 3],
    /// Voxels along x, y, z.
    pub dims: [usize; 3],
}

impl VoxelBox {
    /// All voxels of a grid.
    pub fn whole(dims: [usize; 3]) -> Self {
        Self { first: [0; 3], dims }
    }

    /// Whole layers along an axis of a grid.
    pub fn layers(dims: [usize; 3], axis: usize, layers: &Range<usize>) -> Self {
        let mut slab = Self::whole(dims);
        (slab.first[axis], slab.dims[axis]) = (layers.start, layers.len());
        slab
    }

    /// Behind the last voxel along an axis.
    pub fn end(&self, axis: usize) -> usize {
        self.first[axis].saturating_add(self.dims[axis])
    }

    /// Number of voxels.
    pub fn count(&self) -> usize {
        self.dims.iter().fold(1, |n, &d| n.saturating_mul(d))
    }

    /// Whether all voxels of another are in it.
    pub fn holds(&self, other: &Self) -> bool {
        (0..3).all(|i| self.first[i] <= other.first[i] && other.end(i) <= self.end(i))
    }

    /// Whether it has the voxel at a place.
    pub fn has(&self, place: [usize; 3]) -> bool {
        (0..3).all(|i| (self.first[i]..self.end(i)).contains(&place[i]))
    }

    /// The voxels that are in both, if any are.
    pub fn common(&self, other: &Self) -> Option<Self> {
        let first = [0, 1, 2].map(|i| self.first[i].max(other.first[i]));
        let ends = [0, 1, 2].map(|i| self.end(i).min(other.end(i)));
        (0..3).all(|i| first[i] < ends[i]).then(|| Self { first, dims: [0, 1, 2].map(|i| ends[i] - first[i]) })
    }
}

/// What processes that share a volume find out together. All ask the same, in the same order: every call waits for all of them.
pub(crate) trait Together: Send + Sync + Debug {
    /// The sums over all processes, in the order of these.
    fn add(&self, numbers: &mut [f64]);

    /// The same of whole numbers.
    fn count(&self, numbers: &mut [u64]);

    /// The numbers of all processes, one after the other.
    fn gather(&self, numbers: &[f64]) -> Vec<f64>;
}

/// How a volume is shared.
#[derive(Clone, Debug)]
pub(super) struct Shared {
    /// The voxels that this process has.
    pub held: VoxelBox,
    /// Those of them that are counted here: no other process has them as its own.
    pub own: VoxelBox,
    /// Bytes that were read for them.
    #[cfg_attr(not(feature = "mpi"), expect(dead_code, reason = "processes that speak MPI tell it"))]
    pub read_bytes: u64,
    pub together: Arc<dyn Together>,
}

/// The voxels of one box, of those of another.
pub(super) fn within<'a>(voxels: &Placed<'a>, held: &VoxelBox, wanted: &VoxelBox) -> Option<Placed<'a>> {
    let common = held.common(wanted)?;
    Some(voxels.part([0, 1, 2].map(|i| common.first[i] - held.first[i]), common.dims))
}

impl<'a> Volume<'a> {
    /// The voxels that this process has; all, of a volume that is not shared.
    pub(crate) fn held_box(&self) -> VoxelBox {
        self.shared.as_ref().map_or(VoxelBox::whole(self.grid().dims()), |shared| shared.held)
    }

    /// Bytes that this process has read of its file; 0 of a volume that is not shared, or was in memory.
    #[cfg(feature = "mpi")]
    pub(crate) fn read_bytes(&self) -> u64 {
        self.shared.as_ref().map_or(0, |shared| shared.read_bytes)
    }

    /// Those of them that are looked at here.
    pub(crate) fn own_box(&self) -> VoxelBox {
        self.shared.as_ref().map_or(VoxelBox::whole(self.grid().dims()), |shared| shared.own)
    }

    /// The voxels of its own box, if there are any.
    pub(super) fn own_voxels(&self) -> Option<Placed<'a>> {
        within(&self.voxels, &self.held_box(), &self.own_box())
    }

    /// The number of voxel `index` among those that are held; `None` if it is not.
    pub(super) fn index_in_held(&self, index: usize) -> Option<usize> {
        let Some(Shared { held, .. }) = &self.shared else { return Some(index) };
        let place = self.grid().place(index);
        held.has(place).then(|| {
            let [x, y, z] = [0, 1, 2].map(|i| place[i] - held.first[i]);
            x + held.dims[0] * (y + held.dims[1] * z)
        })
    }

    /// The voxels of a box, which are held.
    pub(super) fn voxels_of(&self, wanted: VoxelBox) -> Result<Placed<'a>, Error> {
        check(&self.description, wanted.first, wanted.dims)?;
        let held = self.held_box();
        match within(&self.voxels, &held, &wanted).filter(|_| held.holds(&wanted)) {
            Some(voxels) => Ok(voxels),
            None => {
                let problem = format!("{wanted:?} is not held here, but {held:?}: others have the rest");
                Err(Error::volume(Path::new(self.name()), problem))
            }
        }
    }

    /// Sums over all processes that share it.
    pub(crate) fn add_all(&self, numbers: &mut [f64]) {
        self.shared.iter().for_each(|shared| shared.together.add(numbers));
    }

    /// The same of whole numbers.
    pub(crate) fn count_all(&self, numbers: &mut [u64]) {
        self.shared.iter().for_each(|shared| shared.together.count(numbers));
    }

    /// Numbers of all processes that share it, one after the other.
    pub(crate) fn gather_all(&self, numbers: Vec<f64>) -> Vec<f64> {
        match &self.shared {
            Some(shared) => shared.together.gather(&numbers),
            None => numbers,
        }
    }

    /// The voxels that this process has, for a device.
    pub(crate) fn held(&self) -> Held<'_> {
        let instead = (self.invalid > 0).then(|| self.description.stored().background);
        Held { description: &self.description, first: self.held_box().first, voxels: &self.voxels, instead }
    }
}
