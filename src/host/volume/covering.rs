//! Grids with axes at right angles that cover voxels on any axes.

use super::grid::{Grid, check_plane, lengths};
use super::{Rescale, Volume};
use crate::error::Error;
use crate::memory;
use crate::progress::Task;
use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;
use std::path::Path;

impl Grid {
    /// The grid that covers voxels on any axes, of which (i, j, k) lies at `index_to_world · (i, j, k)` in world units, sheared or not. It
    /// reaches one voxel beyond the outermost ones.
    ///
    /// Its x axis is theirs, and its y axis lies in the plane of their first two (Gram-Schmidt); mirrored axes stay mirrored. Along an
    /// axis d its spacing is 1 / |M⁻¹ d|, where M is the linear part of the transform: that of the voxels if they are not sheared, and
    /// else no coarser than theirs.
    ///
    /// ```
    /// use layersplat::glam::{DAffine3, DMat3, DVec3};
    /// use layersplat::volume::Grid;
    ///
    /// // A gantry tilted by 20 degrees: each layer is moved along y.
    /// let tilt = 20f64.to_radians();
    /// let axes = DMat3::from_cols(DVec3::X, DVec3::Y, 3.0 * DVec3::new(0.0, tilt.sin(), tilt.cos()));
    /// let grid = Grid::covering([64, 64, 24], DAffine3::from_mat3(axes))?;
    /// assert_eq!((grid.direction(), grid.dims()), (DMat3::IDENTITY, [66, 93, 38]));
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Grid::from_affine`], except for the angles between the axes, if these lie in one plane; and if there would be more than
    /// [`Grid::MAX_VOXELS`] voxels.
    pub fn covering(dims: [usize; 3], index_to_world: DAffine3) -> Result<Self, Error> {
        let axes = index_to_world.matrix3;
        let lengths = lengths(axes)?;
        Self::new(dims, lengths)?;
        check_plane(axes * DMat3::from_diagonal(1.0 / lengths))?;
        let direction = orthonormalised(axes);
        let to_voxels = axes.inverse();
        let spacing = DVec3::from_array([0, 1, 2].map(|axis| spacing_along(to_voxels, direction.col(axis))));
        let first = Self::oriented([1; 3], spacing, index_to_world.translation, direction)?;
        let [lowest, highest] = reach(dims, 1.0, |voxel| first.world_to_voxel(index_to_world.transform_point3(voxel)));
        let origin = first.index_to_world().transform_point3(lowest);
        Self::oriented((highest - lowest + 1.0).to_array().map(|n| n as usize), spacing, origin, direction)
    }
}

impl Volume<'static> {
    /// The same field where its voxels lie at `index_to_world`, on sheared axes: at the voxels of the grid that
    /// [covers](Grid::covering) them, interpolated linearly, as floats. Beyond its voxels lies the background.
    ///
    /// # Errors
    /// Those of [`Grid::covering`], and if memory is too small.
    pub fn covering(&self, index_to_world: DAffine3, has_anatomy: bool) -> Result<Self, Error> {
        let (dims, background) = (self.grid().dims(), self.background());
        let grid = Grid::covering(dims, index_to_world)?;
        let grid = if has_anatomy { grid.with_anatomy() } else { grid };
        let to_own = index_to_world.inverse() * grid.index_to_world();
        let [x, y, _] = grid.dims();
        // Floats hold differences from the smallest value more precisely than values that are far from 0.
        let offset = self.range().0;
        let mut values = memory::zeroed::<f32>(self.name(), grid.voxel_count())?;
        let task = Task::new(format!("resampling {}", self.name()), values.len() as u64);
        values.par_chunks_mut(x).enumerate().for_each(|(row, values)| {
            task.work(x as u64, || {
                for (i, value) in values.iter_mut().enumerate() {
                    let place = to_own.transform_point3(DVec3::new(i as f64, (row % y) as f64, (row / y) as f64));
                    *value = (self.linear(place, background) - offset) as f32;
                }
            });
        });
        task.check().map_err(|e| Error::read(Path::new(self.name()), e))?;
        Ok(Volume::new(self.name(), grid, values)?.with_rescale(Rescale::new(1.0, offset)?))
    }

    /// The value at a place in voxels by linear interpolation; NaN where the nearest voxel is invalid.
    fn linear(&self, place: DVec3, background: f64) -> f64 {
        let dims = self.grid().dims();
        let (mut sum, mut nearest) = (0.0, (0.0, false));
        for (voxel, share) in linear_shares(place) {
            let is_inside = (0..3).all(|i| voxel[i] >= 0.0 && voxel[i] < dims[i] as f64);
            let index = || voxel.x as usize + dims[0] * (voxel.y as usize + dims[1] * voxel.z as usize);
            let found = if is_inside { self.valid(index()) } else { Some(background) };
            if share > nearest.0 {
                nearest = (share, found.is_none());
            }
            sum += share * found.unwrap_or(background);
        }
        // Rounding must not widen the range.
        let (least, most) = self.field_range();
        if nearest.1 { f64::NAN } else { sum.clamp(least, most) }
    }
}

/// The eight voxels around a place, and their shares by linear interpolation.
pub(super) fn linear_shares(place: DVec3) -> impl Iterator<Item = (DVec3, f64)> {
    let first = place.floor();
    (0..8).map(move |corner| {
        let upper = DVec3::new(f64::from(corner & 1), f64::from(corner >> 1 & 1), f64::from(corner >> 2));
        (first + upper, (DVec3::ONE - upper - (place - first)).abs().element_product())
    })
}

/// The columns at right angles, each in the span of those up to it.
fn orthonormalised(axes: DMat3) -> DMat3 {
    let x = axes.x_axis.normalize();
    let y = axes.y_axis.reject_from_normalized(x).normalize();
    let z = x.cross(y);
    DMat3::from_cols(x, y, if axes.z_axis.dot(z) < 0.0 { -z } else { z })
}

/// Share of a voxel by which corners may be off.
const ROUNDING: f64 = 1e-6;

/// The first and the last whole voxels of a grid that hold all of another, with so many of its voxels `beyond` its outermost ones. `place`
/// tells where a voxel of the other lies.
#[doc(hidden)]
pub fn reach(dims: [usize; 3], beyond: f64, place: impl Fn(DVec3) -> DVec3) -> [DVec3; 2] {
    corners(dims, beyond).map(place).into_iter().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[lowest, highest], place| {
        [lowest.min((place + ROUNDING).floor()), highest.max((place - ROUNDING).ceil())]
    })
}

/// Corners so many voxels beyond the outermost ones of a grid.
fn corners(dims: [usize; 3], beyond: f64) -> [DVec3; 8] {
    let at = |n: usize, axis: usize| if n >> axis & 1 == 0 { -beyond } else { dims[axis] as f64 - 1.0 + beyond };
    std::array::from_fn(|n| DVec3::new(at(n, 0), at(n, 1), at(n, 2)))
}

/// Distance along a direction in the world between planes of voxels, weighted by how much each axis is along it. `to_voxels` is the linear
/// part of the transform from the world to voxels.
#[doc(hidden)]
pub fn spacing_along(to_voxels: DMat3, direction: DVec3) -> f64 {
    1.0 / (to_voxels * direction).length()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rotated, scaled and mirrored, without shear.
    fn unsheared() -> DAffine3 {
        let turn = DMat3::from_rotation_z(0.3) * DMat3::from_rotation_x(-1.1);
        let axes = DMat3::from_cols(turn.x_axis * -0.5, turn.y_axis * 2.0, turn.z_axis * 1.25);
        DAffine3::from_mat3_translation(axes, DVec3::new(3.0, -7.0, 11.0))
    }

    /// Sheared along each axis, and mirrored.
    fn sheared() -> DAffine3 {
        let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.6, 1.0, 0.0), DVec3::new(-0.3, 0.5, 1.0));
        let affine = unsheared();
        DAffine3 { matrix3: affine.matrix3 * shear, ..affine }
    }

    #[test]
    fn resampling_ends_when_it_is_cancelled() {
        let volume = Volume::new("t", Grid::new([2; 3], DVec3::ONE).unwrap(), vec![7u8; 8]).unwrap();
        assert!(volume.covering(sheared(), false).is_ok());
        crate::progress::cancelled(|| assert!(volume.covering(sheared(), false).is_err()));
    }

    #[test]
    fn axes_and_spacings_without_shear_are_kept() {
        let grid = Grid::covering([4, 5, 6], unsheared()).unwrap();
        let own = Grid::from_affine([4, 5, 6], unsheared()).unwrap();
        assert!(grid.direction().abs_diff_eq(own.direction(), 1e-14) && grid.spacing().abs_diff_eq(own.spacing(), 1e-14));
        // One voxel beyond on each side, so voxel 1 is the first of its own.
        assert_eq!(grid.dims(), [6, 7, 8]);
        assert!(grid.index_to_world().transform_point3(DVec3::ONE).abs_diff_eq(own.origin(), 1e-13));
    }

    #[test]
    fn all_voxels_lie_inside() {
        let dims = [9, 4, 7];
        let grid = Grid::covering(dims, sheared()).unwrap();
        let last = DVec3::from_array(grid.dims().map(|n| n as f64 - 1.0));
        let places = |beyond: f64| corners(dims, beyond).map(|voxel| grid.world_to_voxel(sheared().transform_point3(voxel)));
        let outside = |place: DVec3| place.cmplt(DVec3::splat(-1e-6)).any() || place.cmpgt(last + 1e-6).any();
        assert!(!places(1.0).into_iter().any(outside));
        // It is no larger than it must be: with another voxel, corners lie outside at all six sides.
        let far = places(2.0);
        for axis in 0..3 {
            assert!(far.iter().any(|place| place[axis] < 0.0) && far.iter().any(|place| place[axis] > last[axis]), "{axis}");
        }
    }

    #[test]
    fn spacings_are_no_coarser_and_hands_are_kept() {
        let grid = Grid::covering([9, 4, 7], sheared()).unwrap();
        let axes = sheared().matrix3;
        assert!(grid.direction().x_axis.abs_diff_eq(axes.x_axis.normalize(), 1e-14), "the first axis is kept");
        assert_eq!(grid.direction().determinant() < 0.0, axes.determinant() < 0.0);
        assert!(grid.direction().determinant() < 0.0);
        for axis in 0..3 {
            // A step along an axis of the grid is at most one voxel.
            let step = axes.inverse() * (grid.direction().col(axis) * grid.spacing()[axis]);
            assert!((step.length() - 1.0).abs() < 1e-12, "{step}");
            assert!(grid.spacing()[axis] <= axes.col(axis).length() * (1.0 + 1e-12));
        }
    }

    #[test]
    fn voxels_without_a_volume_are_refused() {
        let problem = |axes: DMat3| {
            let affine = DAffine3::from_mat3(axes);
            Grid::covering([4; 3], affine).expect_err("a degenerate transform").to_string()
        };
        assert!(problem(DMat3::from_cols(DVec3::X, DVec3::X * 2.0, DVec3::Z)).contains("plane"));
        assert!(problem(DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::X + DVec3::Y)).contains("plane"));
        assert!(problem(DMat3::from_cols(DVec3::X, DVec3::ZERO, DVec3::Z)).contains("length 0"));
        assert!(problem(DMat3::from_cols(DVec3::X, DVec3::NAN, DVec3::Z)).contains("non-finite"));
        let far = DAffine3::from_translation(DVec3::new(f64::NAN, 0.0, 0.0));
        assert!(Grid::covering([4; 3], far).unwrap_err().to_string().contains("origin"));
        assert!(matches!(Grid::covering([4, 0, 4], sheared()), Err(Error::OutOfRange { name: "dims", .. })));
        // Long thin voxels that lean towards a short axis.
        let leaning = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 1.0) * 1e5);
        let many = Grid::covering([10, 10, 1000], DAffine3::from_mat3(leaning));
        assert!(matches!(many, Err(Error::OutOfRange { name: "dims", .. })), "{many:?}");
    }
}
