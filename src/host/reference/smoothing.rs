//! Voxels smoothed for gradients, with background outside the grid.

use crate::layers::smoothing;
use glam::DVec3;

/// Smooths voxels of the dimensions x, y, z along each axis, for central differences of these standard deviations in voxels.
pub(super) fn smoothed(voxels: &[f64], dims: [i64; 3], background: f64, sigmas: DVec3) -> Vec<f64> {
    let strides = [1, dims[0], dims[0] * dims[1]];
    (0..3).fold(voxels.to_vec(), |numbers, axis| {
        let taps = smoothing(sigmas[axis]);
        let (n, stride) = (dims[axis], strides[axis]);
        let at = |start: i64, i: i64| if (0..n).contains(&i) { numbers[(start + i * stride) as usize] } else { background };
        let along = |place: i64| {
            let i = place / stride % n;
            let pairs = (1..)
                .zip(&taps[1..])
                .map(|(step, tap)| tap * (at(place - i * stride, i - step) + at(place - i * stride, i + step)));
            taps[0] * numbers[place as usize] + pairs.sum::<f64>()
        };
        (0..numbers.len() as i64).map(along).collect()
    })
}
