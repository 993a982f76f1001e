//! Where voxels lie in the world.

use crate::error::Error;
use glam::{DMat3, DVec3};

/// A regular grid. Voxel (i, j, k) sits at `origin + direction · (i·h_x, j·h_y, k·h_z)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    dims: [usize; 3],
    spacing: DVec3,
    origin: DVec3,
    direction: DMat3,
}

impl Grid {
    /// Most voxels a grid may have.
    pub const MAX_VOXELS: usize = 1 << 40;

    /// A grid at the origin, aligned with the world's axes. Every dimension must be at least 1, spacing finite and > 0.
    pub fn new(dims: [usize; 3], spacing: DVec3) -> Result<Self, Error> {
        Self::oriented(dims, spacing, DVec3::ZERO, DMat3::IDENTITY)
    }

    /// A grid with an origin (the position of voxel 0,0,0) and a direction matrix, whose columns are the world
    /// directions of the grid's axes: orthonormal, mirrored or not.
    pub fn oriented(dims: [usize; 3], spacing: DVec3, origin: DVec3, direction: DMat3) -> Result<Self, Error> {
        let count = dims.iter().try_fold(1usize, |n, &d| n.checked_mul(d)).unwrap_or(usize::MAX);
        if !(1..=Self::MAX_VOXELS).contains(&count) {
            let value = format!("{}x{}x{}", dims[0], dims[1], dims[2]);
            return Err(Error::OutOfRange { name: "dims", value, expected: "at least 1 per axis and at most 2^40 voxels" });
        }
        let (least, most) = (spacing.min_element(), spacing.max_element());
        if !(spacing.is_finite() && least >= 1e-30 && most <= 1e30 && most <= 1e6 * least) {
            let value = format!("{},{},{}", spacing.x, spacing.y, spacing.z);
            let expected = "numbers from 1e-30 to 1e30, none above a million times another";
            return Err(Error::OutOfRange { name: "spacing", value, expected });
        }
        let deviation = direction.transpose() * direction - DMat3::IDENTITY;
        if !origin.is_finite() || !deviation.to_cols_array().iter().all(|d| d.abs() < 1e-4) {
            let value = format!("{origin}, {direction}");
            return Err(Error::OutOfRange {
                name: "grid orientation",
                value,
                expected: "a finite origin and an orthonormal matrix",
            });
        }
        Ok(Self { dims, spacing, origin, direction })
    }

    /// The same grid in a world of which `unit` is one.
    pub(crate) fn in_units_of(&self, unit: f64) -> Self {
        Self { spacing: self.spacing / unit, origin: self.origin / unit, ..*self }
    }

    /// Voxels along x, y, z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// World distance between neighbouring voxels along x, y, z.
    pub fn spacing(&self) -> DVec3 {
        self.spacing
    }

    /// World position of voxel (0, 0, 0).
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// World directions of the grid's axes, as columns.
    pub fn direction(&self) -> DMat3 {
        self.direction
    }

    /// Number of voxels.
    pub fn voxel_count(&self) -> usize {
        self.dims.iter().product()
    }

    /// The volume's centre in voxels, (n−1)/2 per axis.
    pub fn centre_in_voxels(&self) -> DVec3 {
        self.last_voxel() / 2.0
    }

    /// The volume's centre in the world.
    pub fn centre(&self) -> DVec3 {
        self.origin + self.direction * (self.centre_in_voxels() * self.spacing)
    }

    /// Length of the diagonal of the extent, max(n−1, 1)·h per axis, in world units.
    pub fn diagonal(&self) -> f64 {
        (self.last_voxel().max(DVec3::ONE) * self.spacing).length()
    }

    /// A world position in voxels.
    pub fn world_to_voxel(&self, position: DVec3) -> DVec3 {
        self.world_to_voxel_linear() * (position - self.origin)
    }

    /// Takes world vectors to voxel units.
    pub fn world_to_voxel_linear(&self) -> DMat3 {
        DMat3::from_diagonal(1.0 / self.spacing) * self.world_to_grid_axes()
    }

    /// Takes world vectors to the grid's axes, lengths kept.
    pub fn world_to_grid_axes(&self) -> DMat3 {
        self.direction.transpose()
    }

    fn last_voxel(&self) -> DVec3 {
        DVec3::from_array(self.dims.map(|n| n as f64 - 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centre_and_orientation() {
        let turn = DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z);
        let grid = Grid::oriented([3, 5, 7], DVec3::new(1.0, 2.0, 0.5), DVec3::new(10.0, 0.0, 0.0), turn).unwrap();
        assert_eq!(grid.centre(), DVec3::new(6.0, 1.0, 1.5));
        assert_eq!(grid.world_to_voxel(grid.centre()), grid.centre_in_voxels());
    }

    #[test]
    fn grids_without_a_place_are_refused() {
        assert!(Grid::new([0, 1, 1], DVec3::ONE).is_err());
        assert!(Grid::new([usize::MAX, 2, 2], DVec3::ONE).is_err());
        for h in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Grid::new([2; 3], DVec3::new(1.0, h, 1.0)).is_err());
        }
        assert!(Grid::oriented([2; 3], DVec3::ONE, DVec3::ZERO, DMat3::ZERO).is_err());
    }
}
