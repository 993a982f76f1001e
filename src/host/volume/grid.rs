//! Placement of voxels in the world.

use crate::error::Error;
use glam::{DAffine3, DMat3, DVec3};

/// A regular grid. Voxel (i, j, k) lies at `origin + direction · (i·h_x, j·h_y, k·h_z)` in world units.
///
/// ```
/// use layersplat::glam::DVec3;
/// use layersplat::volume::Grid;
///
/// let grid = Grid::new([256, 256, 128], DVec3::new(0.5, 0.5, 1.0))?;
/// assert_eq!(grid.centre(), DVec3::new(63.75, 63.75, 63.5));
/// assert!(Grid::new([256, 0, 128], DVec3::ONE).is_err());
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    dims: [usize; 3],
    spacing: DVec3,
    origin: DVec3,
    direction: DMat3,
    has_anatomy: bool,
    unit: f64,
}

impl Grid {
    /// Largest number of voxels.
    pub const MAX_VOXELS: usize = 1 << 40;

    /// Axis-aligned grid at the origin. Every dimension must be at least 1. `spacing` is in world units.
    ///
    /// # Errors
    /// If a dimension is 0, the number of voxels exceeds [`MAX_VOXELS`](Self::MAX_VOXELS), or the spacing lies outside 1e-30 … 1e30 or
    /// is too anisotropic (more than 1e6).
    pub fn new(dims: [usize; 3], spacing: DVec3) -> Result<Self, Error> {
        Self::oriented(dims, spacing, DVec3::ZERO, DMat3::IDENTITY)
    }

    /// Grid with an origin (the world position of voxel 0,0,0) and a direction matrix. Its columns are the world directions of the grid
    /// axes. They must be orthonormal; mirrored axes are allowed.
    ///
    /// # Errors
    /// As [`Grid::new`], and if the origin is not finite or the directions are not orthonormal.
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
        if !origin.is_finite() {
            return Err(Error::Grid { problem: format!("the origin {origin} is not finite") });
        }
        check_directions(direction)?;
        Ok(Self { dims, spacing, origin, direction, has_anatomy: false, unit: least })
    }

    /// A coarse grid of cubic voxels around a box, for scenes without a volume. Its longest edge has as many voxels as `LONGEST`.
    ///
    /// # Errors
    /// As [`Grid::new`], for boxes that are too small or too large.
    pub fn around(lowest: DVec3, highest: DVec3) -> Result<Self, Error> {
        /// Light is computed on this grid.
        const LONGEST: f64 = 16.0;
        let extent = highest - lowest;
        let spacing = if extent.max_element() > 0.0 { extent.max_element() / LONGEST } else { 1.0 };
        let edges = (extent / spacing).ceil().max(DVec3::ONE);
        let origin = (lowest + highest - edges * spacing) / 2.0;
        Self::oriented(edges.to_array().map(|n| n as usize + 1), DVec3::splat(spacing), origin, DMat3::IDENTITY)
    }

    /// Position (i, j, k) of voxel `index`, x fastest.
    #[doc(hidden)]
    pub fn place(&self, index: usize) -> [usize; 3] {
        let [x, y, _] = self.dims;
        [index % x, index / x % y, index / x / y]
    }

    /// The same grid in world units of length `unit`.
    #[doc(hidden)]
    pub fn in_units_of(&self, unit: f64) -> Self {
        Self { spacing: self.spacing / unit, origin: self.origin / unit, unit: self.unit / unit, ..*self }
    }

    /// Grid with voxel (i, j, k) at `index_to_world · (i, j, k)`. Rotations and mirrored axes are allowed.
    ///
    /// # Errors
    /// As [`Grid::oriented`]: sheared grids ([`covering`](Self::covering)) and axes of length 0 cannot be rendered.
    pub fn from_affine(dims: [usize; 3], index_to_world: DAffine3) -> Result<Self, Error> {
        let axes = index_to_world.matrix3;
        let spacing = lengths(axes)?;
        Self::oriented(dims, spacing, index_to_world.translation, axes * DMat3::from_diagonal(1.0 / spacing))
    }

    /// The same grid with voxel (0, 0, 0) at `origin`.
    ///
    /// # Errors
    /// As [`Grid::oriented`].
    pub(super) fn with_origin(&self, origin: DVec3) -> Result<Self, Error> {
        let moved = Self::oriented(self.dims, self.spacing, origin, self.direction)?;
        Ok(Self { has_anatomy: self.has_anatomy, unit: self.unit, ..moved })
    }

    /// As [`from_affine`](Self::from_affine), where axes that are sheared by up to [`ROUNDED_SHEAR`] become those at right angles next to them,
    /// about the centre. Also returns the shear in degrees, if there was such.
    pub(super) fn from_nearly_orthogonal(dims: [usize; 3], index_to_world: DAffine3) -> Result<(Self, Option<f64>), Error> {
        let axes = index_to_world.matrix3;
        let spacing = lengths(axes)?;
        let mut direction = axes * DMat3::from_diagonal(1.0 / spacing);
        let products = direction.transpose() * direction;
        let cosine = [products.x_axis.y, products.x_axis.z, products.y_axis.z].into_iter().map(f64::abs).fold(0.0, f64::max);
        let shear = cosine.min(1.0).asin().to_degrees();
        if cosine < ORTHONORMAL || shear > ROUNDED_SHEAR {
            return Self::from_affine(dims, index_to_world).map(|grid| (grid, None));
        }
        // Converges to the orthogonal matrix of its polar decomposition.
        for _ in 0..ORTHOGONAL_STEPS {
            direction = direction * (DMat3::IDENTITY * 3.0 - direction.transpose() * direction) * 0.5;
        }
        let grid = Self::oriented(dims, spacing, DVec3::ZERO, direction)?;
        let centre = grid.centre_in_voxels();
        let origin = index_to_world.transform_point3(centre) - direction * (spacing * centre);
        Ok((Self { origin, ..grid }, Some(shear)))
    }

    /// Declares that the world is a patient's: x points to the right side of the body (R), y to the front (A), z to the head (S).
    ///
    /// ```
    /// use layersplat::glam::DVec3;
    /// use layersplat::volume::Grid;
    ///
    /// let grid = Grid::new([256, 256, 128], DVec3::new(0.5, 0.5, 1.0))?.with_anatomy();
    /// assert!(grid.has_anatomy());
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    pub fn with_anatomy(self) -> Self {
        Self { has_anatomy: true, ..self }
    }

    /// Whether world coordinates are known to be a patient's (RAS). Readers declare it where the file does.
    pub fn has_anatomy(&self) -> bool {
        self.has_anatomy
    }

    /// Number of voxels along x, y, z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// World distance between adjacent voxels along x, y, z.
    pub fn spacing(&self) -> DVec3 {
        self.spacing
    }

    /// Declares a level of a data set whose finest level has `unit` as its smallest spacing.
    #[doc(hidden)]
    pub fn with_unit(self, unit: f64) -> Self {
        Self { unit, ..self }
    }

    /// World length to which opacities refer by default: the smallest spacing, that of the finest level of a data set with several.
    pub fn unit(&self) -> f64 {
        self.unit
    }

    /// World position of voxel (0, 0, 0).
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// World directions of the grid's axes, as columns.
    pub fn direction(&self) -> DMat3 {
        self.direction
    }

    /// Transform from voxel to world coordinates.
    pub fn index_to_world(&self) -> DAffine3 {
        DAffine3 { matrix3: self.direction * DMat3::from_diagonal(self.spacing), translation: self.origin }
    }

    /// Total number of voxels.
    pub fn voxel_count(&self) -> usize {
        self.dims.iter().product()
    }

    /// Centre of the volume in voxel coordinates, (n−1)/2 per axis.
    pub fn centre_in_voxels(&self) -> DVec3 {
        self.last_voxel() / 2.0
    }

    /// The outermost voxels.
    #[doc(hidden)]
    pub fn corner_voxels(&self) -> [DVec3; 8] {
        let last = self.last_voxel();
        std::array::from_fn(|n| DVec3::from_array(std::array::from_fn(|i| if n >> i & 1 == 0 { 0.0 } else { last[i] })))
    }

    /// Centre of the volume in world coordinates.
    pub fn centre(&self) -> DVec3 {
        self.origin + self.direction * (self.centre_in_voxels() * self.spacing)
    }

    /// Length of the bounding box diagonal in world units; each side is max(n−1, 1)·h.
    pub fn diagonal(&self) -> f64 {
        (self.last_voxel().max(DVec3::ONE) * self.spacing).length()
    }

    /// Converts a world position to voxel coordinates.
    pub fn world_to_voxel(&self, position: DVec3) -> DVec3 {
        self.world_to_voxel_linear() * (position - self.origin)
    }

    /// Index of the voxel nearest to a place in voxels, if that lies within half a voxel of the grid.
    pub(super) fn nearest_voxel(&self, place: DVec3) -> Option<usize> {
        let [x, y, z] = self.dims;
        let nearest = place.round();
        let inside = nearest.cmpge(DVec3::ZERO).all() && nearest.cmplt(DVec3::new(x as f64, y as f64, z as f64)).all();
        inside.then(|| {
            let [i, j, k] = nearest.to_array().map(|n| n as usize);
            i + x * (j + y * k)
        })
    }

    /// Linear part of the transform from world to voxel coordinates.
    pub fn world_to_voxel_linear(&self) -> DMat3 {
        DMat3::from_diagonal(1.0 / self.spacing) * self.world_to_grid_axes()
    }

    /// Rotation from world axes to grid axes.
    pub fn world_to_grid_axes(&self) -> DMat3 {
        self.direction.transpose()
    }

    fn last_voxel(&self) -> DVec3 {
        DVec3::from_array(self.dims.map(|n| n as f64 - 1.0))
    }
}

/// Tolerance of the lengths of directions and of the cosines between them.
const ORTHONORMAL: f64 = 1e-4;

/// Largest shear in degrees that is rounded to right angles: it moves the last of 500 voxels by less than one.
const ROUNDED_SHEAR: f64 = 0.1;
/// Each step squares the error, which begins below 2e-3.
const ORTHOGONAL_STEPS: usize = 3;

/// Lengths of the axes of a transform.
pub(super) fn lengths(axes: DMat3) -> Result<DVec3, Error> {
    let lengths = DVec3::new(axes.x_axis.length(), axes.y_axis.length(), axes.z_axis.length());
    if !lengths.is_finite() || lengths.min_element() == 0.0 {
        let problem = format!("the transform from voxels to the world, {axes}, has an axis of length 0 or a non-finite one");
        return Err(Error::Grid { problem });
    }
    Ok(lengths)
}

/// Rejects directions of length 1 that lie in one plane.
pub(super) fn check_plane(direction: DMat3) -> Result<(), Error> {
    if direction.determinant().abs() < ORTHONORMAL {
        return Err(Error::Grid { problem: format!("its axes, {direction}, lie in one plane") });
    }
    Ok(())
}

/// Rejects directions that are not orthonormal.
fn check_directions(direction: DMat3) -> Result<(), Error> {
    let products = direction.transpose() * direction;
    let unit = (0..3).all(|i| (products.col(i)[i] - 1.0).abs() < ORTHONORMAL);
    if !unit {
        return Err(Error::Grid { problem: format!("the directions of its axes, {direction}, must have length 1") });
    }
    check_plane(direction)?;
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        let cosine = products.col(i)[j];
        if cosine.abs() >= ORTHONORMAL {
            let (axes, angle) = (["x", "y", "z"], cosine.acos().to_degrees());
            let problem = format!(
                "it is sheared: the angle between its axes {} and {} is {angle:.3} degrees: resample it onto orthogonal axes, or give a spacing, \
                 which replaces its axes",
                axes[i], axes[j]
            );
            return Err(Error::Grid { problem });
        }
    }
    Ok(())
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
    fn a_transform_makes_the_grid_and_comes_back() {
        let turn = DMat3::from_rotation_z(0.3) * DMat3::from_rotation_x(-1.1);
        // Mirrored, like an axis stored in reverse.
        let axes = DMat3::from_cols(turn.x_axis * -0.5, turn.y_axis * 2.0, turn.z_axis * 1.25);
        let affine = DAffine3::from_mat3_translation(axes, DVec3::new(3.0, -7.0, 11.0));
        let grid = Grid::from_affine([4, 5, 6], affine).unwrap();
        assert!(grid.spacing().abs_diff_eq(DVec3::new(0.5, 2.0, 1.25), 1e-15));
        assert!(grid.index_to_world().abs_diff_eq(affine, 1e-14));
        let voxel = DVec3::new(1.0, 4.0, 2.0);
        assert!(grid.world_to_voxel(affine.transform_point3(voxel)).abs_diff_eq(voxel, 1e-13));
        assert!(grid.index_to_world().transform_point3(grid.centre_in_voxels()).abs_diff_eq(grid.centre(), 1e-14));
        let plain = Grid::oriented([4; 3], DVec3::new(0.3, 0.7, 1.1), DVec3::ONE, turn).unwrap();
        let again = Grid::from_affine([4; 3], plain.index_to_world()).unwrap();
        assert!(again.spacing().abs_diff_eq(plain.spacing(), 1e-15) && again.direction().abs_diff_eq(turn, 1e-15));
    }

    #[test]
    fn sheared_and_degenerate_transforms_are_named() {
        let problem = |axes: DMat3| {
            let affine = DAffine3::from_mat3_translation(axes, DVec3::ZERO);
            Grid::from_affine([4; 3], affine).expect_err("a sheared grid").to_string()
        };
        // A gantry tilted by ten degrees.
        let tilt = 10f64.to_radians();
        let tilted = problem(DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::new(0.0, tilt.sin(), tilt.cos()) * 3.0));
        assert!(tilted.contains("sheared") && tilted.contains("y and z is 80.000 degrees"), "{tilted}");
        assert!(problem(DMat3::from_cols(DVec3::X, DVec3::X * 2.0, DVec3::Z)).contains("plane"));
        assert!(problem(DMat3::from_cols(DVec3::X, DVec3::ZERO, DVec3::Z)).contains("length 0"));
        assert!(problem(DMat3::from_cols(DVec3::X, DVec3::NAN, DVec3::Z)).contains("non-finite"));
        assert!(Grid::oriented([2; 3], DVec3::ONE, DVec3::new(f64::INFINITY, 0.0, 0.0), DMat3::IDENTITY).is_err());
        // Orthogonal within the precision of float32 files.
        let rounded = (DMat3::from_rotation_y(0.7) * 0.3).as_mat3().as_dmat3();
        assert!(Grid::from_affine([2; 3], DAffine3::from_mat3(rounded)).is_ok());
    }

    #[test]
    fn small_shears_are_rounded_about_the_centre() {
        let sheared = |degrees: f64| {
            let tilt = degrees.to_radians();
            let axes =
                DMat3::from_rotation_z(0.4) * DMat3::from_cols(DVec3::X, DVec3::Y, 3.0 * DVec3::new(0.0, tilt.sin(), tilt.cos()));
            DAffine3::from_mat3_translation(axes, DVec3::new(5.0, 6.0, 7.0))
        };
        let (grid, shear) = Grid::from_nearly_orthogonal([4, 5, 6], sheared(0.09)).unwrap();
        assert!((shear.unwrap() - 0.09).abs() < 1e-9);
        let turn = grid.direction();
        assert!((turn.transpose() * turn).abs_diff_eq(DMat3::IDENTITY, 1e-14));
        let centre = sheared(0.09).transform_point3(grid.centre_in_voxels());
        assert!(grid.centre().abs_diff_eq(centre, 1e-12) && grid.spacing().abs_diff_eq(DVec3::new(1.0, 1.0, 3.0), 1e-12));
        // The shear is shared by the axes.
        let y = sheared(0.09).matrix3.y_axis.angle_between(turn.y_axis).to_degrees();
        assert!((y - 0.045).abs() < 1e-6, "{y}");
        assert!(Grid::from_nearly_orthogonal([4, 5, 6], sheared(0.11)).is_err());
        assert_eq!(Grid::from_nearly_orthogonal([4, 5, 6], sheared(0.0)).unwrap().1, None);
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
