//! Redistribution of voxels: each rank receives the voxels that it needs from their owners.

use super::Brick;
use super::group::Group;
use crate::error::Error;
use crate::layers::Axis;
use crate::memory;
use crate::renderer::Exchanged;
use crate::volume::{Description, Storage, Volume, VolumePart, VoxelBox};
use std::ops::Range;
use std::path::Path;

/// The boxes of all ranks of a distributed volume, by rank.
pub(super) struct Boxes {
    /// Owned voxels: every voxel of the volume has exactly one owner.
    pub own: Vec<VoxelBox>,
    /// Held voxels: the owned ones and ghosts.
    pub held: Vec<VoxelBox>,
}

impl Boxes {
    /// The boxes of a distributed volume. Collective.
    ///
    /// # Errors
    /// As [`gather`](Self::gather).
    pub fn from_volume(group: &Group, volume: &Volume) -> Result<Self, Error> {
        Self::gather(group, volume.description(), Brick { own: volume.own_box(), held: volume.held_box() })
    }

    /// Gathers the boxes of all ranks. Collective.
    ///
    /// # Errors
    /// Voxels with several owners or none.
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
        let error = |problem: String| Err(Error::volume(Path::new(volume.name()), problem));
        for (rank, one) in self.own.iter().enumerate() {
            if let Some((other, common)) = self.own[..rank].iter().zip(0..).find_map(|(b, n)| Some((n, one.common(b)?))) {
                return error(format!(
                    "ranks {other} and {rank} both own {common:?}: declare these voxels as ghosts on one of them"
                ));
            }
        }
        let (found, all) = (self.own.iter().map(VoxelBox::count).sum::<usize>(), volume.grid().voxel_count());
        if found != all {
            return error(format!("the ranks own {found} of its {all} voxels: each voxel needs an owner"));
        }
        Ok(())
    }

    /// The range of layers that each rank owns along an axis, if these are whole layers in rank order.
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

    /// Sends each rank the voxels of its box in `wanted`, unless it holds all of them already. Collective.
    pub fn redistribute<'v>(
        &self,
        group: &Group,
        volume: &Volume<'v>,
        wanted: &[VoxelBox],
    ) -> Result<(VolumePart<'v>, Exchanged), Error> {
        let (rank, size) = (group.rank(), group.size());
        let mine = wanted[rank];
        let is_held = |rank: usize| self.held[rank].holds(&wanted[rank]);
        let voxel = volume.voxel_type().bytes();
        let sent = |to: usize| self.own[rank].common(&wanted[to]).filter(|_| !is_held(to));
        let received = |from: usize| self.own[from].common(&mine).filter(|_| !is_held(rank));
        let largest = |boxes: &dyn Fn(usize) -> Option<VoxelBox>| {
            (0..size).filter_map(boxes).map(|common| common.count() * voxel).max().unwrap_or(0)
        };
        // Allocate everything first: failures must occur before any rank waits for voxels.
        let zeroed = |bytes: usize| memory::zeroed::<u8>(volume.name(), bytes);
        let all = zeroed(if is_held(rank) { 0 } else { mine.count() * voxel });
        let buffers = all.and_then(|all| Ok((all, zeroed(largest(&sent))?, zeroed(largest(&received))?)));
        let (mut voxels, mut outgoing, mut incoming) = group.agree(buffers)?;
        let mut exchanged = Exchanged::default();
        for step in 0..size {
            let (to, from) = ((rank + step) % size, (rank + size - step) % size);
            let outgoing = match sent(to) {
                // Cannot fail: this rank owns the voxels.
                Some(common) => pack(volume, &common, &mut outgoing)?,
                None => &[],
            };
            let common = received(from);
            let incoming = &mut incoming[..common.map_or(0, |common| common.count() * voxel)];
            if step == 0 {
                incoming.copy_from_slice(outgoing);
            } else {
                group.swap(to, outgoing, from, incoming);
                exchanged.sent_bytes += outgoing.len() as u64;
                exchanged.received_bytes += incoming.len() as u64;
            }
            if let Some(common) = common {
                unpack(incoming, &common, &mut voxels, &mine, voxel);
            }
        }
        let part = if is_held(rank) {
            volume.part(mine.first, mine.dims)
        } else {
            let storage = Storage::from_bytes(voxels, volume.voxel_type());
            VolumePart::new(volume.description().clone(), mine.first, mine.dims, storage)
        };
        Ok((group.agree(part)?, exchanged))
    }
}

/// Sends each rank the values of the box that it has in common with this one: `common` of the ranks that have and that need values, packed by
/// `pack`. `size`: bytes per value. Collective.
pub(super) fn swap_boxes(
    group: &Group,
    size: usize,
    common: &dyn Fn(usize, usize) -> Option<VoxelBox>,
    pack: &dyn Fn(VoxelBox) -> Vec<u8>,
    receive: &dyn Fn(VoxelBox, Vec<u8>),
) -> Exchanged {
    let (rank, ranks) = (group.rank(), group.size());
    let mut exchanged = Exchanged::default();
    for step in 0..ranks {
        let (to, from) = ((rank + step) % ranks, (rank + ranks - step) % ranks);
        let outgoing = common(rank, to).map_or(Vec::new(), pack);
        let common = common(from, rank);
        let mut incoming = vec![0; common.map_or(0, |common| common.count() * size)];
        if step == 0 {
            incoming = outgoing;
        } else {
            group.swap(to, &outgoing, from, &mut incoming);
            exchanged.sent_bytes += outgoing.len() as u64;
            exchanged.received_bytes += incoming.len() as u64;
        }
        if let Some(common) = common {
            receive(common, incoming);
        }
    }
    exchanged
}

/// Copies the voxels of a box, x fastest, to the beginning of `bytes`. Returns that part.
fn pack<'a>(volume: &Volume, wanted: &VoxelBox, bytes: &'a mut [u8]) -> Result<&'a [u8], Error> {
    let bytes = &mut bytes[..wanted.count() * volume.voxel_type().bytes()];
    volume.part(wanted.first, wanted.dims)?.held().for_each_piece(|at, piece| {
        bytes[at..at + piece.len()].copy_from_slice(piece);
        Ok::<(), Error>(())
    })?;
    Ok(bytes)
}

/// Copies the voxels of the box `from`, x fastest, to their places in the larger box `to`. `voxel`: bytes per voxel.
fn unpack(bytes: &[u8], from: &VoxelBox, into: &mut [u8], to: &VoxelBox, voxel: usize) {
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
    fn boxes_are_unpacked_at_their_place_in_larger_ones() {
        let to = VoxelBox { first: [2, 3, 4], dims: [4, 3, 2] };
        let from = VoxelBox { first: [3, 4, 5], dims: [2, 2, 1] };
        let mut into = vec![0; 2 * to.count()];
        unpack(&[1, 2, 3, 4, 5, 6, 7, 8], &from, &mut into, &to, 2);
        let voxels: Vec<(usize, &[u8])> = into.chunks(2).enumerate().filter(|(_, v)| v[0] > 0).collect();
        assert_eq!(voxels, [(17, &[1, 2][..]), (18, &[3, 4]), (21, &[5, 6]), (22, &[7, 8])]);
    }
}
