//! Which way of a volume is up, and from where it is seen first.

use crate::camera::{Orbit, OrbitFrame, Up};
use crate::choice::choices;
use crate::volume::Grid;
use glam::DVec3;

/// Spacings that differ by less than this ratio are the same; headers round them.
const SAME_SPACING: f64 = 0.01;

/// The frame in which the views of a volume are counted, and why.
///
/// ```
/// use layersplat::camera::Up;
/// use layersplat::framing::{Orientation, UpReason};
/// use layersplat::volume::Grid;
/// use layersplat::{Camera, Orbit, Projection, glam::DVec3};
///
/// let grid = Grid::new([256, 256, 108], DVec3::new(1.0, 1.0, 1.5))?.with_anatomy();
/// let orientation = Orientation::of(&grid);
/// assert_eq!((orientation.up(), orientation.reason()), (Up::Z, UpReason::Patient));
/// // From the patient's front, a little from the left and from above.
/// let orbit = orientation.frame().orbit(Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 });
/// let camera = Camera::orbit(grid.centre(), 500.0, orbit, Projection::Parallel { scale: 200.0 });
/// assert!(camera.position.y > grid.centre().y && camera.position.x < grid.centre().x);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orientation {
    up: Up,
    reason: UpReason,
    has_anatomy: bool,
}

/// Why a direction is up.
///
/// ```
/// use layersplat::framing::UpReason;
///
/// assert_eq!(UpReason::Slices.name(), "slices");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UpReason {
    /// It was given.
    Given,
    /// The file knows its patient: the head (S) is up.
    Patient,
    /// The distance of slices along z is not the size of their pixels, so these are slices of something that stands along z.
    Slices,
    /// Nothing is known.
    Default,
}

impl UpReason {
    /// `given`, `patient`, `slices` or `default`.
    pub fn name(self) -> &'static str {
        match self {
            UpReason::Given => "given",
            UpReason::Patient => "patient",
            UpReason::Slices => "slices",
            UpReason::Default => "default",
        }
    }
}

/// A side of a volume.
///
/// ```
/// use layersplat::framing::Side;
///
/// assert!(Side::ALL.contains(&Side::Above));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Azimuth 0, elevation 0.
    Front,
    /// The right of the picture from the front, azimuth 90; where a patient is seen from anterior, the patient's right.
    Right,
    /// Azimuth 180.
    Back,
    /// Opposite to right.
    Left,
    /// Elevation 90.
    Above,
    /// Elevation −90.
    Below,
}

choices! { Side, "from"; Front = "front", Right = "right", Back = "back", Left = "left", Above = "above", Below = "below" }

impl Orientation {
    /// The orientation of a volume that is placed by `grid`.
    ///
    /// - If the world is a patient's ([`Grid::has_anatomy`]), the head is up and the view from anterior.
    /// - If there are several slices along z whose distance differs from both sides of their pixels by more than 1 %, z is up.
    /// - Otherwise y is up.
    pub fn of(grid: &Grid) -> Self {
        if grid.has_anatomy() {
            Self::new(Up::Z, UpReason::Patient, grid)
        } else if is_sliced_along_z(grid) {
            Self::new(Up::Z, UpReason::Slices, grid)
        } else {
            Self::new(Up::Y, UpReason::Default, grid)
        }
    }

    /// The orientation with a given direction up.
    pub fn with_up(up: Up, grid: &Grid) -> Self {
        Self::new(up, UpReason::Given, grid)
    }

    fn new(up: Up, reason: UpReason, grid: &Grid) -> Self {
        Self { up, reason, has_anatomy: grid.has_anatomy() }
    }

    /// The direction that points up.
    pub fn up(&self) -> Up {
        self.up
    }

    /// Why it does.
    pub fn reason(&self) -> UpReason {
        self.reason
    }

    /// The frame in which orbits are counted.
    pub fn frame(&self) -> OrbitFrame {
        OrbitFrame::about(self.up)
    }

    /// The orbit that shows a side, in the frame.
    pub fn side(&self, side: Side) -> Orbit {
        // From anterior, the patient's left is on the right.
        let right = if self.has_anatomy && self.frame().right() == DVec3::NEG_X { 270.0 } else { 90.0 };
        let (azimuth, elevation) = match side {
            Side::Front => (0.0, 0.0),
            Side::Right => (right, 0.0),
            Side::Back => (180.0, 0.0),
            Side::Left => (360.0 - right, 0.0),
            Side::Above => (0.0, 90.0),
            Side::Below => (0.0, -90.0),
        };
        Orbit { azimuth, elevation, roll: 0.0 }
    }

    /// Where the eye of an orbit in the frame is, by the axes of the world that it has a part of: `+x-z`, or the patient's sides `RI`.
    pub fn seen_from(&self, orbit: Orbit) -> String {
        /// Smaller parts are rounding errors of an axis.
        const PART: f64 = 1e-6;
        let names =
            if self.has_anatomy { [["R", "L"], ["A", "P"], ["S", "I"]] } else { [["+x", "-x"], ["+y", "-y"], ["+z", "-z"]] };
        let to_eye = self.frame().direction_to_eye(orbit).to_array();
        let name = |(part, [positive, negative]): (f64, [&'static str; 2])| match part {
            part if part.abs() < PART => "",
            part if part > 0.0 => positive,
            _ => negative,
        };
        to_eye.into_iter().zip(names).map(name).collect()
    }
}

/// Whether the world's z axis is that of slices whose distance is not the size of their pixels.
fn is_sliced_along_z(grid: &Grid) -> bool {
    let (spacing, [.., slices]) = (grid.spacing(), grid.dims());
    let differs = |other: f64| (spacing.z - other).abs() > SAME_SPACING * other;
    let along_z = grid.direction().z_axis.z.abs() > std::f64::consts::FRAC_1_SQRT_2;
    slices > 1 && along_z && differs(spacing.x) && differs(spacing.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;

    fn grid(dims: [usize; 3], spacing: [f64; 3]) -> Grid {
        Grid::new(dims, DVec3::from_array(spacing)).unwrap()
    }

    #[test]
    fn what_is_known_decides() {
        let chosen = |grid: &Grid| {
            let orientation = Orientation::of(grid);
            (orientation.up(), orientation.reason())
        };
        for (dims, spacing, expected) in [
            ([9; 3], [1.0, 1.0, 1.5], (Up::Z, UpReason::Slices)),
            ([9; 3], [1.0, 0.9, 0.5], (Up::Z, UpReason::Slices)),
            ([9; 3], [1.0, 1.0, 1.005], (Up::Y, UpReason::Default)),
            ([9; 3], [2.0, 1.0, 1.0], (Up::Y, UpReason::Default)),
            ([9; 3], [1.0, 2.0, 2.0], (Up::Y, UpReason::Default)),
            // A picture is no stack of slices.
            ([9, 9, 1], [1.0, 1.0, 5.0], (Up::Y, UpReason::Default)),
        ] {
            assert_eq!(chosen(&grid(dims, spacing)), expected, "{dims:?} {spacing:?}");
            assert_eq!(chosen(&grid(dims, spacing).with_anatomy()), (Up::Z, UpReason::Patient));
        }
        // Slices along another axis of the world.
        let turn = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y);
        let turned = Grid::oriented([9; 3], DVec3::new(1.0, 1.0, 3.0), DVec3::ZERO, turn).unwrap();
        assert_eq!(chosen(&turned), (Up::Y, UpReason::Default));
        assert_eq!(Orientation::with_up(Up::NegativeX, &turned).reason(), UpReason::Given);
    }

    /// Sides of a world of which nothing is known, and of a patient, in every frame.
    #[test]
    fn sides_have_names() {
        let plain = grid([4; 3], [1.0; 3]);
        let patient = plain.clone().with_anatomy();
        for (grid, up, expected) in [
            (&plain, Up::Y, ["+z", "+x", "-z", "-x", "+y", "-y"]),
            (&plain, Up::NegativeY, ["+z", "-x", "-z", "+x", "-y", "+y"]),
            (&plain, Up::Z, ["+y", "-x", "-y", "+x", "+z", "-z"]),
            (&plain, Up::NegativeZ, ["+y", "+x", "-y", "-x", "-z", "+z"]),
            (&plain, Up::X, ["+y", "+z", "-y", "-z", "+x", "-x"]),
            (&plain, Up::NegativeX, ["+y", "-z", "-y", "+z", "-x", "+x"]),
            (&patient, Up::Y, ["S", "R", "I", "L", "A", "P"]),
            (&patient, Up::NegativeY, ["S", "R", "I", "L", "P", "A"]),
            (&patient, Up::Z, ["A", "R", "P", "L", "S", "I"]),
            (&patient, Up::NegativeZ, ["A", "R", "P", "L", "I", "S"]),
            (&patient, Up::X, ["A", "S", "P", "I", "R", "L"]),
            (&patient, Up::NegativeX, ["A", "I", "P", "S", "L", "R"]),
        ] {
            let orientation = Orientation::with_up(up, grid);
            assert_eq!(Side::ALL.map(|side| orientation.seen_from(orientation.side(side))), expected, "{up:?}");
        }
        let oblique = Orbit { azimuth: 45.0, elevation: 35.26, roll: 0.0 };
        assert_eq!(Orientation::of(&patient).seen_from(oblique), "LAS");
        assert_eq!(Orientation::of(&plain).seen_from(oblique), "+x+y+z");
    }
}
