//! What layers take to composite, as far as their voxels tell.

use crate::volume::{Volume, VoxelBox};
use rayon::prelude::*;

/// About how many voxels of a process's own are looked at.
const LOOKED_AT: usize = 1 << 20;
/// Samples that show nothing are skipped block by block: so many take as long as one that shows (docs/scale.md).
const SKIPPED: u64 = 24;

/// Work of each layer along x, y and z of a whole volume, of which `shows` tells what values have opacity: a voxel that shows counts once.
/// Collective.
pub(super) fn of_layers(volume: &Volume, shows: impl Fn(f64) -> bool + Sync) -> [Vec<u64>; 3] {
    let (own, dims) = (volume.own_box(), volume.grid().dims());
    // Every so many rows, of each layer along y and z alike.
    let every = own.count().div_ceil(LOOKED_AT).max(1);
    let found: Vec<[Vec<u64>; 2]> = volume.look(|value| {
        let layers = (own.first[2]..own.end(2)).into_par_iter();
        layers.map(|z| of_layer(&own, dims, z, every, &|index| shows(value(index)))).collect()
    });
    let mut work = dims.map(|layers| vec![0u64; layers]);
    for (z, [along_x, along_y]) in (own.first[2]..).zip(found) {
        work[2][z] = along_y.iter().sum();
        work[0].iter_mut().zip(along_x).for_each(|(all, more)| *all += more);
        work[1].iter_mut().zip(along_y).for_each(|(all, more)| *all += more);
    }
    for (axis, work) in work.iter_mut().enumerate() {
        work.iter_mut().for_each(|shown| *shown *= every as u64);
        volume.count_all(work);
        let all = (volume.grid().voxel_count() / dims[axis]) as u64;
        work.iter_mut().for_each(|work| *work += all / SKIPPED + 1);
    }
    work
}

/// Voxels that show in a layer, by their x and by their y.
fn of_layer(own: &VoxelBox, dims: [usize; 3], z: usize, every: usize, shows: &(dyn Fn(usize) -> bool + Sync)) -> [Vec<u64>; 2] {
    let mut along = [vec![0; dims[0]], vec![0; dims[1]]];
    for y in (own.first[1]..own.end(1)).filter(|y| (y + z).is_multiple_of(every)) {
        for x in own.first[0]..own.end(0) {
            let one = u64::from(shows(x + dims[0] * (y + dims[1] * z)));
            along[0][x] += one;
            along[1][y] += one;
        }
    }
    along
}
