//! How a patient lies in a slice.

use super::Slice;
use crate::choice::choices;
use crate::error::Error;
use glam::DVec3;

/// Side of a slice on which the patient's left is shown.
///
/// ```
/// use layersplat::slice::Convention;
///
/// assert_eq!(Convention::Radiological.name(), "radiological");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Convention {
    /// The patient's left is on the right.
    Radiological,
    /// The patient's left is on the left.
    Neurological,
}

choices! { Convention, "convention"; Radiological = "radiological", Neurological = "neurological" }

/// Letters of the positive and negative axes of a patient's world: right, anterior, superior.
const LETTERS: [[char; 2]; 3] = [['R', 'L'], ['A', 'P'], ['S', 'I']];
/// Least share of a direction that has a letter: 20 degrees out of a plane.
const LEAST: f64 = 0.34;

/// Letters of a direction in a patient's world (right, anterior, superior), the largest component first: `L`, or `LA` between left and anterior.
///
/// ```
/// use layersplat::glam::DVec3;
/// use layersplat::slice::patient_letters;
///
/// assert_eq!(patient_letters(DVec3::new(-1.0, 0.5, 0.01)), "LA");
/// ```
pub fn patient_letters(direction: DVec3) -> String {
    let parts = direction.normalize_or_zero().to_array();
    let mut axes = [0, 1, 2];
    axes.sort_by(|&a, &b| parts[b].abs().total_cmp(&parts[a].abs()));
    let letter = |axis: usize| LETTERS[axis][usize::from(parts[axis] < 0.0)];
    axes.into_iter().filter(|&axis| parts[axis].abs() >= LEAST).map(letter).collect()
}

impl Slice {
    /// Side on which a patient's left is shown; `None` where left and right lie along the line of sight or upwards, as in sagittal slices. The
    /// world must be a patient's.
    ///
    /// # Errors
    /// If the directions are invalid.
    pub fn convention(&self) -> Result<Option<Convention>, Error> {
        let [right, _] = self.basis()?;
        Ok(match right.x {
            x if x <= -LEAST => Some(Convention::Radiological),
            x if x >= LEAST => Some(Convention::Neurological),
            _ => None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slice::SliceAxis;
    use crate::viewport::Viewport;
    use crate::volume::Grid;
    use glam::DMat3;

    /// The slices of the guide: of a patient's axes, and of voxels whose x points to the patient's left and right.
    #[test]
    fn slices_say_where_left_is() {
        let size = Viewport::new(8, 8).unwrap();
        let of = |first: DVec3, axis: SliceAxis| {
            let direction = DMat3::from_cols(first, DVec3::Y, DVec3::Z);
            let grid = Grid::oriented([4; 3], DVec3::ONE, DVec3::ZERO, direction).unwrap().with_anatomy();
            let slice = Slice::at(&grid, axis, 0.0, size).unwrap();
            let [right, up] = slice.basis().unwrap();
            (slice.convention().unwrap(), [right, -right, up, -up].map(patient_letters).join(" "))
        };
        let (radiological, neurological) = (Some(Convention::Radiological), Some(Convention::Neurological));
        assert_eq!(of(DVec3::X, SliceAxis::Axial), (radiological, "L R A P".into()));
        assert_eq!(of(DVec3::X, SliceAxis::Coronal), (radiological, "L R S I".into()));
        assert_eq!(of(DVec3::X, SliceAxis::Sagittal), (None, "P A S I".into()));
        assert_eq!(of(DVec3::X, SliceAxis::Z), (neurological, "R L A P".into()));
        assert_eq!(of(DVec3::NEG_X, SliceAxis::Z), (radiological, "L R A P".into()));
    }
}
