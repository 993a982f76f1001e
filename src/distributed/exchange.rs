//! Voxels from the boxes that ranks have to those that they need.

use super::Brick;
use super::group::Group;
use crate::error::Error;
use crate::layers::Axis;
use crate::memory;
use crate::volume::{Description, Storage, Volume, VolumePart, VoxelBox};
use serde::Serialize;
use std::ops::Range;
use std::path::Path;

/// Voxels that went from rank to rank.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Exchanged {
    /// Bytes that this rank sent.
    pub sent_bytes: u64,
    /// Bytes that it received.
    pub received_bytes: u64,
}

/// What ranks have of a volume.
pub(super) struct Boxes {
    /// Each rank's own, of which none has another's, and all together have every voxel.
    pub own: Vec<VoxelBox>,
    /// These and what each has of others'.
    pub held: Vec<VoxelBox>,
}

impl Boxes {
    /// Of a volume's processes. Collective.
    ///
    /// # Errors
    /// As [`gather`](Self::gather).
    pub fn of(group: &Group, volume: &Volume) -> Result<Self, Error> {
        Self::gather(group, volume.description(), Brick { own: volume.own_box(), held: volume.held_box() })
    }

    /// Collective.
    ///
    /// # Errors
    /// Boxes of ranks that overlap, or that leave voxels out.
    pub fn gather(group: &Group, description: &Description, Brick { own, held }: Brick) -> Result<Self, Error> {
        let numbers: Vec<u64> = [own.first, own.dims, held.first, held.dims].concat().iter().map(|&n| n as u64).collect();
        let all = group.gather_counts(&numbers);
        let three = |numbers: &[u64]| [0, 1, 2].map(|i| numbers[i] as usize);
        let boxes = |at: usize| {
            let of_rank = |numbers: &[u64]| VoxelBox { first: three(&numbers[at..]), dims: three(&numbers[at + 3..]) };
            all.chunks_exact(12).map(of_rank).collect::<Vec<_>>()
        };
        let found = Self { own: boxes(0), held: boxes(6) };
        group.agree(found.check(description))?;
        Ok(found)
    }

    fn check(&self, volume: &Description) -> Result<(), Error> {
        let wrong = |problem: String| Err(Error::volume(Path::new(volume.name()), problem));
        for (rank, one) in self.own.iter().enumerate() {
            if let Some((other, common)) = self.own[..rank].iter().zip(0..).find_map(|(b, n)| Some((n, one.common(b)?))) {
                return wrong(format!("ranks {other} and {rank} both have {common:?} as their own: declare it as ghosts of one"));
            }
        }
        let (found, all) = (self.own.iter().map(VoxelBox::count).sum::<usize>(), volume.grid().voxel_count());
        if found != all {
            return wrong(format!("of its {all} voxels the ranks have {found}: each must be somebody's own"));
        }
        Ok(())
    }

    /// The layers along an axis that each rank has as its own, if these are whole layers in the order of the ranks.
    pub fn slabs(&self, axis: Axis, dims: [usize; 3]) -> Option<Vec<Range<usize>>> {
        let a = axis.index();
        let mut next = 0;
        let mut slab = |own: &VoxelBox| {
            let whole = (0..3).all(|i| i == a || own.dims[i] == dims[i]);
            let follows = own.dims[a] == 0 || own.first[a] == next;
            let range = if own.dims[a] == 0 { next..next } else { own.first[a]..own.end(a) };
            next = range.end;
            (whole && follows).then_some(range)
        };
        self.own.iter().map(&mut slab).collect()
    }

    /// Brings each rank the voxels of its box of `wanted`; none goes to a rank that has all of its own there already. Collective.
    pub fn bring<'v>(
        &self,
        group: &Group,
        volume: &Volume<'v>,
        wanted: &[VoxelBox],
    ) -> Result<(VolumePart<'v>, Exchanged), Error> {
        let (rank, size) = (group.rank(), group.size());
        let mine = wanted[rank];
        let is_there = |rank: usize| self.held[rank].holds(&wanted[rank]);
        let voxel = volume.voxel_type().bytes();
        let sent = |to: usize| self.own[rank].common(&wanted[to]).filter(|_| !is_there(to));
        let received = |from: usize| self.own[from].common(&mine).filter(|_| !is_there(rank));
        let most = |boxes: &dyn Fn(usize) -> Option<VoxelBox>| {
            (0..size).filter_map(boxes).map(|common| common.count() * voxel).max().unwrap_or(0)
        };
        // All memory first: what fails must fail before anybody waits for voxels.
        let zeroed = |bytes: usize| memory::zeroed::<u8>(volume.name(), bytes);
        let all = zeroed(if is_there(rank) { 0 } else { mine.count() * voxel });
        let room = all.and_then(|all| Ok((all, zeroed(most(&sent))?, zeroed(most(&received))?)));
        let (mut voxels, mut going, mut coming) = group.agree(room)?;
        let mut exchanged = Exchanged::default();
        for step in 0..size {
            let (to, from) = ((rank + step) % size, (rank + size - step) % size);
            let going = match sent(to) {
                // It has its own: nothing fails any more.
                Some(common) => bytes_of(volume, &common, &mut going)?,
                None => &[],
            };
            let common = received(from);
            let coming = &mut coming[..common.map_or(0, |common| common.count() * voxel)];
            if step == 0 {
                coming.copy_from_slice(going);
            } else {
                group.swap(to, going, from, coming);
                exchanged.sent_bytes += going.len() as u64;
                exchanged.received_bytes += coming.len() as u64;
            }
            if let Some(common) = common {
                place(coming, &common, &mut voxels, &mine, voxel);
            }
        }
        let part = if is_there(rank) {
            volume.part(mine.first, mine.dims)
        } else {
            let storage = Storage::from_bytes(voxels, volume.voxel_type());
            VolumePart::new(volume.description().clone(), mine.first, mine.dims, storage)
        };
        Ok((group.agree(part)?, exchanged))
    }
}

/// Puts the voxels of a box, x fastest, into bytes that have room for them.
fn bytes_of<'a>(volume: &Volume, wanted: &VoxelBox, bytes: &'a mut [u8]) -> Result<&'a [u8], Error> {
    let bytes = &mut bytes[..wanted.count() * volume.voxel_type().bytes()];
    volume.part(wanted.first, wanted.dims)?.held().for_each_piece(|at, piece| {
        bytes[at..at + piece.len()].copy_from_slice(piece);
        Ok::<(), Error>(())
    })?;
    Ok(bytes)
}

/// Puts the voxels of a box, x fastest, where they are in a larger one.
fn place(bytes: &[u8], from: &VoxelBox, into: &mut [u8], to: &VoxelBox, voxel: usize) {
    let [x, y, z] = [0, 1, 2].map(|i| from.first[i] - to.first[i]);
    let row = from.dims[0] * voxel;
    for (n, bytes) in bytes.chunks_exact(row).enumerate() {
        let (j, k) = (y + n % from.dims[1], z + n / from.dims[1]);
        let at = (x + to.dims[0] * (j + to.dims[1] * k)) * voxel;
        into[at..at + row].copy_from_slice(bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_go_where_they_are_in_larger_ones() {
        let to = VoxelBox { first: [2, 3, 4], dims: [4, 3, 2] };
        let from = VoxelBox { first: [3, 4, 5], dims: [2, 2, 1] };
        let mut into = vec![0; 2 * to.count()];
        place(&[1, 2, 3, 4, 5, 6, 7, 8], &from, &mut into, &to, 2);
        let voxels: Vec<(usize, &[u8])> = into.chunks(2).enumerate().filter(|(_, v)| v[0] > 0).collect();
        assert_eq!(voxels, [(17, &[1, 2][..]), (18, &[3, 4]), (21, &[5, 6]), (22, &[7, 8])]);
    }
}
