//! What layers take to composite, as far as their voxels tell.

use crate::volume::{Volume, VoxelBox};
use rayon::prelude::*;

/// About how many voxels are looked at, by all processes together.
const LOOKED_AT: f64 = 4e6;
/// Samples that show nothing are skipped block by block: so many take as long as one that shows (docs/scale.md).
const SKIPPED: u64 = 24;

/// Work of each layer along x, y and z of a whole volume, of which `shows` tells what values have opacity: a voxel that shows counts once.
/// Of large volumes, where every so many voxels along each axis are looked at, layers between take what the one before them has.
/// Collective.
pub(super) fn of_layers(volume: &Volume, shows: impl Fn(f64) -> bool + Sync) -> [Vec<u64>; 3] {
    let (own, dims) = (volume.own_box(), volume.grid().dims());
    let every = every(volume.grid().voxel_count());
    let layers: Vec<usize> = sampled(&own, 2, every).collect();
    let found: Vec<[Vec<u64>; 2]> =
        volume.look(|value| layers.par_iter().map(|&z| of_layer(&own, dims, z, every, &|index| shows(value(index)))).collect());
    let mut work = dims.map(|layers| vec![0u64; layers]);
    for (z, [along_x, along_y]) in layers.into_iter().zip(found) {
        work[2][z] = along_y.iter().sum();
        work[0].iter_mut().zip(along_x).for_each(|(all, more)| *all += more);
        work[1].iter_mut().zip(along_y).for_each(|(all, more)| *all += more);
    }
    let stands_for = (every * every) as u64;
    for (axis, work) in work.iter_mut().enumerate() {
        volume.count_all(work);
        let all = (volume.grid().voxel_count() / dims[axis]) as u64;
        for layer in 0..work.len() {
            // What is sampled comes first, and is not changed before those behind it have taken it.
            work[layer] = if layer % every == 0 { work[layer] * stands_for + all / SKIPPED + 1 } else { work[layer - 1] };
        }
    }
    work
}

/// Of how many voxels along an axis one is looked at.
fn every(voxels: usize) -> usize {
    (voxels as f64 / LOOKED_AT).cbrt().ceil().max(1.0) as usize
}

/// Places along an axis of a box that are looked at: the same ones whoever looks.
fn sampled(own: &VoxelBox, axis: usize, every: usize) -> impl Iterator<Item = usize> {
    (own.first[axis].next_multiple_of(every)..own.end(axis)).step_by(every)
}

/// Voxels that show in a layer, of those that are looked at, by their x and by their y.
fn of_layer(own: &VoxelBox, dims: [usize; 3], z: usize, every: usize, shows: &(dyn Fn(usize) -> bool + Sync)) -> [Vec<u64>; 2] {
    let mut along = [vec![0; dims[0]], vec![0; dims[1]]];
    for y in sampled(own, 1, every) {
        for x in sampled(own, 0, every) {
            let one = u64::from(shows(x + dims[0] * (y + dims[1] * z)));
            along[0][x] += one;
            along[1][y] += one;
        }
    }
    along
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::OpenOptions;

    #[test]
    fn some_are_looked_at_of_any_volume() {
        for side in [1usize, 100, 512, 2048, 16384] {
            let every = every(side.pow(3));
            let looked_at = side.div_ceil(every).pow(3) as f64;
            assert!(
                (side.pow(3) as f64).min(LOOKED_AT / 4.0) <= looked_at && looked_at <= 1.2 * LOOKED_AT,
                "{side}: {looked_at}"
            );
        }
    }

    /// All voxels of a small volume; of a large one about as many, layer by layer.
    #[test]
    fn work_is_what_shows() {
        let volume = Volume::open("builtin:hydrogen@20x24x28", &OpenOptions::default()).unwrap();
        let work = of_layers(&volume, |value| value > 40.0);
        let place = |n: usize| [n % 20, n / 20 % 24, n / 480];
        for axis in 0..3 {
            let layer = 20 * 24 * 28 / volume.grid().dims()[axis] as u64;
            for (k, &work) in work[axis].iter().enumerate() {
                let shown = (0..20 * 24 * 28).filter(|&n| place(n)[axis] == k && volume.value(n) > 40.0).count() as u64;
                assert_eq!(work, shown + layer / SKIPPED + 1, "layer {k} along {axis}");
            }
        }
        let large = Volume::open("builtin:cube@300x200x400", &OpenOptions::default()).unwrap();
        for (axis, work) in of_layers(&large, |value| value > 0.0).iter().enumerate() {
            let all = 300.0 * 200.0 * 400.0 / large.grid().dims()[axis] as f64;
            assert!(work.iter().all(|&work| (work as f64 / all - 1.04).abs() < 0.05), "{axis}: {work:?} of {all}");
        }
    }
}
