//! Directions of the paper's set of 856 oriented footprint images (§3.2).
//!
//! Footprints depend on the shear only, so the set covers |s_u|, |s_v| ≤ 1. It has 28 rows at equal angles in v. The 16 middle rows have
//! 31 columns at equal angles in u; the 12 outer rows, where the arc is shorter, have 30. Every view is within 2.5° of its entry (tested
//! below); a 29×29 grid over the shears would leave 2.7°.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// Number of images in the set.
pub const FOOTPRINT_SET_LEN: usize = 856;
/// Texels per side of an image: 64² bytes per image, 3,506,176 bytes in total.
pub const FOOTPRINT_SET_SIZE: usize = 64;

const ROWS: usize = 28;
/// Rows with 30 columns at either end.
const OUTER_ROWS: usize = 6;
const OUTER_COLUMNS: usize = 30;

fn columns(row: usize) -> usize {
    OUTER_COLUMNS + usize::from((OUTER_ROWS..ROWS - OUTER_ROWS).contains(&row))
}

fn row_start(row: usize) -> usize {
    row * OUTER_COLUMNS + row.saturating_sub(OUTER_ROWS).min(ROWS - 2 * OUTER_ROWS)
}

fn cell_centre(cell: usize, cells: usize) -> f64 {
    (((cell as f64 + 0.5) / cells as f64) * FRAC_PI_2 - FRAC_PI_4).tan()
}

fn cell_of(shear: f64, cells: usize) -> usize {
    let position = (shear.atan() / FRAC_PI_2 + 0.5) * cells as f64;
    (position.max(0.0) as usize).min(cells - 1)
}

/// Shear (s_u, s_v) of image `index` < 856.
pub fn set_direction(index: usize) -> [f64; 2] {
    let row = (0..ROWS).rfind(|&row| row_start(row) <= index).unwrap_or(0);
    [cell_centre(index - row_start(row), columns(row)), cell_centre(row, ROWS)]
}

/// Index of the image for a shear with |s_u|, |s_v| ≤ 1: the nearest column of the nearest row.
pub fn nearest_in_set(shear: [f64; 2]) -> usize {
    let row = cell_of(shear[1], ROWS);
    row_start(row) + cell_of(shear[0], columns(row))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// As stated in the module documentation.
    const LARGEST_ANGLE_DEGREES: f64 = 2.5;

    #[test]
    fn there_are_856_and_each_is_its_own_nearest() {
        assert_eq!(row_start(ROWS - 1) + columns(ROWS - 1), FOOTPRINT_SET_LEN);
        for index in 0..FOOTPRINT_SET_LEN {
            assert_eq!(nearest_in_set(set_direction(index)), index);
        }
    }

    #[test]
    fn every_view_is_within_the_stated_angle_of_its_entry() {
        let direction = |s: [f64; 2]| DVec3::new(s[0], s[1], 1.0).normalize();
        let mut largest: f64 = 0.0;
        let n = 800;
        for i in 0..=n {
            for j in 0..=n {
                let shear = [i, j].map(|c| 2.0 * f64::from(c) / f64::from(n) - 1.0);
                let entry = set_direction(nearest_in_set(shear));
                largest = largest.max(direction(shear).angle_between(direction(entry)));
            }
        }
        assert!(largest.to_degrees() < LARGEST_ANGLE_DEGREES, "{}°", largest.to_degrees());
        assert!(
            largest.to_degrees() > LARGEST_ANGLE_DEGREES - 0.2,
            "the documented angle is too large: {}°",
            largest.to_degrees()
        );
    }
}
