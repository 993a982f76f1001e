//! Slices perpendicular to an axis of the voxels or of a patient.

use crate::choice::choices;
use crate::error::Error;
use crate::volume::Grid;
use glam::DVec3;

/// The axis that a slice is perpendicular to.
///
/// ```
/// use layersplat::slice::SliceAxis;
///
/// assert_eq!("coronal".parse::<SliceAxis>()?, SliceAxis::Coronal);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SliceAxis {
    /// The voxels' x: y to the right, z up.
    X,
    /// The voxels' y: x to the right, z up.
    Y,
    /// The voxels' z: x to the right, y up.
    Z,
    /// From feet to head, seen from the feet: the patient's left is on the right, the front is up.
    Axial,
    /// From back to front, seen from the front: the patient's left is on the right, the head is up.
    Coronal,
    /// From left to right, seen from the left: the patient's back is on the right, the head is up.
    Sagittal,
}

choices! {
    SliceAxis, "axis";
    X = "x", Y = "y", Z = "z", Axial = "axial", Coronal = "coronal", Sagittal = "sagittal",
}

impl SliceAxis {
    /// The axes of the three slices to show side by side: axial, coronal and sagittal where the world is a patient's, else z, y and x.
    pub fn three(grid: &Grid) -> [Self; 3] {
        if grid.has_anatomy() {
            [SliceAxis::Axial, SliceAxis::Coronal, SliceAxis::Sagittal]
        } else {
            [SliceAxis::Z, SliceAxis::Y, SliceAxis::X]
        }
    }

    /// Index of the axis: of the voxels, or of a patient's world (right, anterior, superior).
    fn index(self) -> usize {
        match self {
            SliceAxis::X | SliceAxis::Sagittal => 0,
            SliceAxis::Y | SliceAxis::Coronal => 1,
            SliceAxis::Z | SliceAxis::Axial => 2,
        }
    }

    /// Whether the axis is a patient's.
    fn is_anatomical(self) -> bool {
        matches!(self, SliceAxis::Axial | SliceAxis::Coronal | SliceAxis::Sagittal)
    }

    fn check(self, grid: &Grid) -> Result<(), Error> {
        if !self.is_anatomical() || grid.has_anatomy() {
            return Ok(());
        }
        let problem = format!(
            "{} slices need a volume that states how the patient lies, which this one does not: use x, y or z",
            self.name()
        );
        Err(Error::Settings { field: "axis", problem })
    }

    /// World directions rightwards and upwards in the picture.
    ///
    /// # Errors
    /// [`Error::Settings`] if the axis is that of a patient and the grid has none.
    pub fn directions(self, grid: &Grid) -> Result<[DVec3; 2], Error> {
        self.check(grid)?;
        let voxels = grid.direction();
        Ok(match self {
            SliceAxis::X => [voxels.y_axis, voxels.z_axis],
            SliceAxis::Y => [voxels.x_axis, voxels.z_axis],
            SliceAxis::Z => [voxels.x_axis, voxels.y_axis],
            SliceAxis::Axial => [DVec3::NEG_X, DVec3::Y],
            SliceAxis::Coronal => [DVec3::NEG_X, DVec3::Z],
            SliceAxis::Sagittal => [DVec3::NEG_Y, DVec3::Z],
        })
    }

    /// Smallest and largest coordinate of the volume along the axis: numbers of slices of voxels, from −½ to n−½; for a patient's axes
    /// world coordinates.
    ///
    /// # Errors
    /// [`Error::Settings`] if the axis is that of a patient and the grid has none.
    pub fn range(self, grid: &Grid) -> Result<(f64, f64), Error> {
        self.check(grid)?;
        let axis = self.index();
        if !self.is_anatomical() {
            return Ok((-0.5, grid.dims()[axis] as f64 - 0.5));
        }
        let half =
            grid.index_to_world().matrix3 * glam::DMat3::from_diagonal(DVec3::from_array(grid.dims().map(|n| n as f64 / 2.0)));
        let reach = half.transpose().col(axis).abs().element_sum();
        Ok((grid.centre()[axis] - reach, grid.centre()[axis] + reach))
    }

    /// World distance between neighbouring slices: the spacing of the voxels along their axis; along a patient's the spacing of the
    /// voxels' axis that is nearest to it.
    pub fn spacing(self, grid: &Grid) -> f64 {
        let axis =
            if self.is_anatomical() { grid.direction().transpose().col(self.index()).abs().max_position() } else { self.index() };
        grid.spacing()[axis]
    }

    /// Coordinate of a world point along the axis.
    pub fn coordinate(self, grid: &Grid, point: DVec3) -> f64 {
        let point = if self.is_anatomical() { point } else { grid.world_to_voxel(point) };
        point[self.index()]
    }

    /// The point at a coordinate along the axis that lies in the middle of the volume otherwise.
    ///
    /// # Errors
    /// [`Error::Settings`] if the axis is that of a patient and the grid has none.
    pub fn point(self, grid: &Grid, at: f64) -> Result<DVec3, Error> {
        self.check(grid)?;
        let axis = self.index();
        if self.is_anatomical() {
            let mut point = grid.centre();
            point[axis] = at;
            return Ok(point);
        }
        let mut voxel = grid.centre_in_voxels();
        voxel[axis] = at;
        Ok(grid.index_to_world().transform_point3(voxel))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slice::Slice;
    use crate::viewport::Viewport;
    use glam::DMat3;

    /// As radiologists look at them: from the feet, from the front, from the patient's left.
    #[test]
    fn slices_of_a_patient_are_seen_from_the_usual_side() {
        let viewport = Viewport::new(8, 8).unwrap();
        // Stored from right to left and from front to back, like most CT.
        let direction = DMat3::from_cols(DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z);
        let grid = Grid::oriented([4, 5, 6], DVec3::new(1.0, 1.0, 2.0), DVec3::new(7.0, 8.0, 9.0), direction).unwrap();
        for axis in [SliceAxis::Axial, SliceAxis::Coronal, SliceAxis::Sagittal] {
            let message = Slice::through(&grid, axis, grid.centre(), viewport).unwrap_err().to_string();
            assert!(message.contains("use x, y or z"), "{message}");
        }
        let grid = grid.with_anatomy();
        for (axis, viewer) in
            [(SliceAxis::Axial, DVec3::NEG_Z), (SliceAxis::Coronal, DVec3::Y), (SliceAxis::Sagittal, DVec3::NEG_X)]
        {
            let slice = Slice::through(&grid, axis, grid.centre(), viewport).unwrap();
            assert_eq!(slice.normal().unwrap(), viewer, "{axis:?}");
            let (lo, hi) = axis.range(&grid).unwrap();
            assert_eq!(axis.coordinate(&grid, slice.centre), (lo + hi) / 2.0);
            assert_eq!(axis.coordinate(&grid, axis.point(&grid, lo).unwrap()), lo);
        }
        assert_eq!((SliceAxis::Axial.range(&grid).unwrap(), SliceAxis::Axial.spacing(&grid)), ((8.0, 20.0), 2.0));
        assert_eq!(SliceAxis::Z.range(&grid).unwrap(), (-0.5, 5.5));
        assert!(
            grid.index_to_world().transform_point3(DVec3::new(1.5, 2.0, 5.5)).distance(SliceAxis::Z.point(&grid, 5.5).unwrap())
                < 1e-12
        );
    }

    #[test]
    fn names_are_parsed() {
        for axis in SliceAxis::ALL {
            assert_eq!(axis.name().parse::<SliceAxis>().unwrap(), axis);
        }
        assert!("front".parse::<SliceAxis>().unwrap_err().to_string().contains("axial"));
    }
}
