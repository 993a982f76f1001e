//! The values of a light volume.

use crate::layers::{Axis, AxisFrame};
use crate::volume::VoxelBox;
use glam::DVec3;
use std::ops::Range;

/// A grid of one value per `voxels`³ voxels, with a margin of one value on each side, or some of its layers. Values lie in the middle of
/// their voxels; x is the fastest axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::renderer) struct ValueGrid {
    /// Along x, y, z, without the margin.
    inner: [usize; 3],
    voxels: usize,
    /// The values that are held, counted from the first of the margin.
    held: VoxelBox,
}

/// Largest distance in voxels at which a part of a volume looks light up beside the layers that it holds. Samples lie at least one layer
/// inside these. Surfaces look light up at most 2.25 smallest spacings off (`LIFT`, `LIFT_TO_LIGHT`), other samples at most one.
const AROUND_PART: usize = 2;

/// Distance from the end of the grid at which look-ups are clamped, so that the cell of a position is inside. Floats of 4000 resolve it.
const INSIDE: f64 = 1e-3;

impl ValueGrid {
    /// A grid for a volume of `dims` voxels along x, y, z.
    pub fn new(dims: [usize; 3], voxels: usize) -> Self {
        let inner = dims.map(|n| n.div_ceil(voxels));
        Self { inner, voxels, held: VoxelBox::whole(inner.map(|n| n + 2)) }
    }

    /// These layers of the grid, counted from the first of the margin.
    pub fn with_layers(self, axis: Axis, layers: &Range<usize>) -> Self {
        Self { held: VoxelBox::layers(self.outer(), axis.index(), layers), ..self }
    }

    /// The layers in which samples look light up between these layers of voxels along an axis.
    pub fn around_part(&self, axis: Axis, voxels: &Range<usize>) -> Self {
        let at = |voxel: f64| self.position(DVec3::splat(voxel)).x.max(0.0) as usize;
        let end = at((voxels.end - 1 + AROUND_PART) as f64) + 2;
        let first = at(voxels.start as f64 - AROUND_PART as f64);
        self.with_layers(axis, &(first..end.min(self.outer()[axis.index()])))
    }

    /// As many layers as [`around_part`](Self::around_part) has at most for this many layers of voxels.
    pub fn around_any_part(&self, axis: Axis, voxels: usize) -> Self {
        let layers = (voxels + 2 * AROUND_PART - 1).div_ceil(self.voxels) + 2;
        self.with_layers(axis, &(0..layers.min(self.outer()[axis.index()])))
    }

    /// Values along x, y, z, without the margin.
    pub fn inner(&self) -> [usize; 3] {
        self.inner
    }

    /// Voxels per value and axis.
    pub fn voxels(&self) -> usize {
        self.voxels
    }

    /// Number of values that are held.
    pub fn values(&self) -> usize {
        self.held.count()
    }

    /// The values that are held, counted from the first of the margin.
    pub fn held(&self) -> VoxelBox {
        self.held
    }

    /// Values along x, y, z, with the margin.
    pub fn outer(&self) -> [usize; 3] {
        self.inner.map(|n| n + 2)
    }

    /// Values per voxel and axis.
    pub fn values_per_voxel(&self) -> f64 {
        1.0 / self.voxels as f64
    }

    /// Position of a point given in voxels; the first value of the margin is at 0.
    pub fn position(&self, voxel: DVec3) -> DVec3 {
        let middle = (self.voxels as f64 - 1.0) / 2.0;
        (voxel - middle) * self.values_per_voxel() + 1.0
    }

    /// Largest positions for look-ups.
    pub fn last(&self) -> DVec3 {
        DVec3::from_array(self.outer().map(|n| n as f64 - 1.0 - INSIDE))
    }

    /// Distance of neighbouring values along u, v and a, among those that are held.
    pub fn strides(&self, frame: AxisFrame) -> [i32; 3] {
        let [x, y, _] = self.held.dims;
        let strides = [1, x, x * y].map(|stride| stride as i32);
        [frame.u, frame.v, frame.a].map(|i| strides[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layers::Axis;

    #[test]
    fn values_lie_in_the_middle_of_their_voxels() {
        let full = ValueGrid::new([5, 1, 3], 1);
        assert_eq!((full.inner(), full.values()), ([5, 1, 3], 7 * 3 * 5));
        assert_eq!(full.position(DVec3::new(0.0, -1.0, 2.0)), DVec3::new(1.0, 0.0, 3.0));
        let half = ValueGrid::new([5, 4, 3], 2);
        assert_eq!(half.inner(), [3, 2, 2]);
        assert_eq!(half.position(DVec3::new(0.5, 2.5, 4.5)), DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(half.strides(Axis::X.frame()), [20, 5, 1]);
    }

    #[test]
    fn parts_hold_the_cells_around_their_voxels() {
        for voxels in [1, 2, 4] {
            let grid = ValueGrid::new([50; 3], voxels);
            for (start, end) in [(0, 5), (0, 50), (7, 8), (13, 30), (45, 50)] {
                let part = grid.around_part(Axis::Y, &(start..end));
                let (first, last) = (part.held().first[1] as f64, (part.held().end(1) - 1) as f64);
                for voxel in [start as f64 - 2.0, (end - 1) as f64 + 2.0] {
                    let place = grid.position(DVec3::splat(voxel)).y.clamp(0.0, grid.last().y);
                    assert!(first <= place.floor() && place.floor() + 1.0 <= last, "{voxel} of {start}..{end}: {part:?}");
                }
                assert!(part.values() <= grid.around_any_part(Axis::Y, end - start).values(), "{start}..{end}: {part:?}");
                assert_eq!(
                    part.strides(Axis::Z.frame()),
                    [1, grid.outer()[0] as i32, (grid.outer()[0] * part.held().dims[1]) as i32]
                );
            }
        }
    }
}
