//! The values of a light volume.

use crate::layers::AxisFrame;
use glam::DVec3;

/// A grid of one value per `voxels`³ voxels, with a margin of one value on each side. Values lie in the middle of their voxels; x is the
/// fastest axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::renderer) struct ValueGrid {
    /// Along x, y, z, without the margin.
    inner: [usize; 3],
    voxels: usize,
}

/// Distance from the end of the grid at which look-ups are clamped, so that the cell of a position is inside. Floats of 4000 resolve it.
const INSIDE: f64 = 1e-3;

impl ValueGrid {
    /// A grid for a volume of `dims` voxels along x, y, z.
    pub fn new(dims: [usize; 3], voxels: usize) -> Self {
        Self { inner: dims.map(|n| n.div_ceil(voxels)), voxels }
    }

    /// Values along x, y, z, without the margin.
    pub fn inner(&self) -> [usize; 3] {
        self.inner
    }

    /// Voxels per value and axis.
    pub fn voxels(&self) -> usize {
        self.voxels
    }

    /// Number of values.
    pub fn values(&self) -> usize {
        self.outer().iter().product()
    }

    fn outer(&self) -> [usize; 3] {
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

    /// Distance of neighbouring values along u, v and a.
    pub fn strides(&self, frame: AxisFrame) -> [i32; 3] {
        let [x, y, _] = self.outer();
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
}
