//! Estimate of the work to composite each layer, from its voxels.

use crate::volume::{Volume, VoxelBox};
use rayon::prelude::*;

/// Approximate number of sampled voxels, over all processes.
const SAMPLED_VOXELS: f64 = 4e6;
/// Invisible samples, skipped block by block, that take as long as one visible sample (docs/dev/scale.md).
const SKIPPED_PER_VISIBLE: u64 = 24;

/// Work of each layer along x, y and z of the whole volume, in units of visible voxels; `is_visible` classifies values. Large
/// volumes are sampled with a stride along each axis, and layers between the sampled ones take the work of the previous sampled
/// layer. Collective.
pub(super) fn estimate(volume: &Volume, is_visible: impl Fn(f64) -> bool + Sync) -> [Vec<u64>; 3] {
    let (own, dims) = (volume.own_box(), volume.grid().dims());
    let stride = stride(volume.grid().voxel_count());
    let layers: Vec<usize> = sampled(&own, 2, stride).collect();
    let found: Vec<[Vec<u64>; 2]> = volume.look(|value| {
        layers.par_iter().map(|&z| count_visible(&own, dims, z, stride, &|index| is_visible(value(index)))).collect()
    });
    let mut work = dims.map(|layers| vec![0u64; layers]);
    for (z, [along_x, along_y]) in layers.into_iter().zip(found) {
        work[2][z] = along_y.iter().sum();
        work[0].iter_mut().zip(along_x).for_each(|(all, more)| *all += more);
        work[1].iter_mut().zip(along_y).for_each(|(all, more)| *all += more);
    }
    let voxels_per_sample = (stride * stride) as u64;
    for (axis, work) in work.iter_mut().enumerate() {
        volume.count_all(work);
        let all = (volume.grid().voxel_count() / dims[axis]) as u64;
        for layer in 0..work.len() {
            // In ascending order, so that the sampled layer is complete before the next ones copy it.
            work[layer] = if layer % stride == 0 {
                work[layer] * voxels_per_sample + all / SKIPPED_PER_VISIBLE + 1
            } else {
                work[layer - 1]
            };
        }
    }
    work
}

/// Distance of sampled voxels along each axis.
fn stride(voxels: usize) -> usize {
    (voxels as f64 / SAMPLED_VOXELS).cbrt().ceil().max(1.0) as usize
}

/// Sampled positions along an axis of a box. They are multiples of the stride, independent of the box.
fn sampled(own: &VoxelBox, axis: usize, stride: usize) -> impl Iterator<Item = usize> {
    (own.first[axis].next_multiple_of(stride)..own.end(axis)).step_by(stride)
}

/// Visible voxels among the sampled ones of a layer, counted by x and by y.
fn count_visible(
    own: &VoxelBox,
    dims: [usize; 3],
    z: usize,
    stride: usize,
    is_visible: &(dyn Fn(usize) -> bool + Sync),
) -> [Vec<u64>; 2] {
    let mut along = [vec![0; dims[0]], vec![0; dims[1]]];
    for y in sampled(own, 1, stride) {
        for x in sampled(own, 0, stride) {
            let one = u64::from(is_visible(x + dims[0] * (y + dims[1] * z)));
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
    fn enough_voxels_of_any_volume_are_sampled() {
        for side in [1usize, 100, 512, 2048, 16384] {
            let stride = stride(side.pow(3));
            let sampled = side.div_ceil(stride).pow(3) as f64;
            assert!(
                (side.pow(3) as f64).min(SAMPLED_VOXELS / 4.0) <= sampled && sampled <= 1.2 * SAMPLED_VOXELS,
                "{side}: {sampled}"
            );
        }
    }

    /// Exact for a small volume, approximate for a large one.
    #[test]
    fn work_counts_visible_voxels() {
        let volume = Volume::open("builtin:hydrogen@20x24x28", &OpenOptions::default()).unwrap();
        let work = estimate(&volume, |value| value > 40.0);
        let position = |n: usize| [n % 20, n / 20 % 24, n / 480];
        for axis in 0..3 {
            let layer = 20 * 24 * 28 / volume.grid().dims()[axis] as u64;
            for (k, &work) in work[axis].iter().enumerate() {
                let visible = (0..20 * 24 * 28).filter(|&n| position(n)[axis] == k && volume.value(n) > 40.0).count() as u64;
                assert_eq!(work, visible + layer / SKIPPED_PER_VISIBLE + 1, "layer {k} along {axis}");
            }
        }
        let large = Volume::open("builtin:cube@300x200x400", &OpenOptions::default()).unwrap();
        for (axis, work) in estimate(&large, |value| value > 0.0).iter().enumerate() {
            let all = 300.0 * 200.0 * 400.0 / large.grid().dims()[axis] as f64;
            assert!(work.iter().all(|&work| (work as f64 / all - 1.04).abs() < 0.05), "{axis}: {work:?} of {all}");
        }
    }
}
