//! Colours of labels over a volume, evaluated from their definition.

use crate::volume::{Grid, Volume};
use glam::{DAffine3, DVec3};

/// Colours and weights of labels, interpolated linearly between the voxels of their own grid.
#[derive(Clone)]
pub(super) struct LabelColors {
    /// From voxels of the volume to those of the labels.
    moved: DAffine3,
    dims: [i64; 3],
    /// Voxels for which the outer ones go on.
    beyond: f64,
    /// Red, green and blue times the weight, and the weight, per voxel.
    weighted: Vec<[f64; 4]>,
}

impl LabelColors {
    /// Over the voxels of `grid`. Voxel n of the labels has entry n.
    pub fn new(grid: &Grid, labels: &Volume, entries: &[[f64; 4]]) -> Self {
        let weighted = (0..labels.grid().voxel_count()).map(|voxel| {
            let [r, g, b, weight] = entries[labels.value(voxel) as usize];
            [weight * r, weight * g, weight * b, weight]
        });
        let moved = labels.grid().index_to_world().inverse() * grid.index_to_world();
        // On one grid, labels colour all that shows.
        let beyond = if labels.grid() == grid { f64::INFINITY } else { 1.0 };
        Self { moved, dims: labels.grid().dims().map(|n| n as i64), beyond, weighted: weighted.collect() }
    }

    /// A colour at a point, in voxels of the volume, mixed with that of the labels.
    pub fn mixed(&self, point: DVec3, color: [f64; 3]) -> [f64; 3] {
        let place = self.moved.transform_point3(point);
        if (0..3).any(|i| place[i] < -self.beyond || place[i] > self.dims[i] as f64 - 1.0 + self.beyond) {
            return color;
        }
        let low = place.floor();
        let mut sum = [0.0; 4];
        for n in 0..8 {
            let corner: [i64; 3] = std::array::from_fn(|i| low[i] as i64 + (n >> i & 1));
            let weight: f64 = (0..3).map(|i| 1.0 - (place[i] - corner[i] as f64).abs()).product();
            let [i, j, k] = std::array::from_fn(|i| corner[i].clamp(0, self.dims[i] - 1));
            let own = self.weighted[(i + self.dims[0] * (j + self.dims[1] * k)) as usize];
            (0..4).for_each(|c| sum[c] += weight * own[c]);
        }
        std::array::from_fn(|c| (1.0 - sum[3]) * color[c] + sum[c])
    }
}
