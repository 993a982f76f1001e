//! Which way is up, and the angles of a view.

use super::options::CameraOptions;
use crate::camera::{Orbit, Up};
use crate::framing::{Orientation, UpReason};
use crate::volume::Grid;
use serde::Serialize;

/// The view of `render` without any angles: a little from the side and from above, so that flat faces have a shape.
pub(super) const OBLIQUE: Orbit = Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };

/// Angles of a view in degrees, as far as they are given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Angles {
    pub azimuth: Option<f64>,
    pub elevation: Option<f64>,
    pub roll: Option<f64>,
}

impl Angles {
    /// These, completed by `others`.
    pub fn or(self, others: Angles) -> Self {
        let Self { azimuth, elevation, roll } = self;
        Self { azimuth: azimuth.or(others.azimuth), elevation: elevation.or(others.elevation), roll: roll.or(others.roll) }
    }

    /// An orbit with these, each completed by that of `default`.
    pub fn or_each_of(self, default: Orbit) -> Orbit {
        Orbit {
            azimuth: self.azimuth.unwrap_or(default.azimuth),
            elevation: self.elevation.unwrap_or(default.elevation),
            roll: self.roll.unwrap_or(default.roll),
        }
    }

    /// `default` if no angle is given. Otherwise the others are 0.
    pub fn or_all_of(self, default: Orbit) -> Orbit {
        self.or_each_of(if self == Self::default() { default } else { Orbit::default() })
    }
}

impl CameraOptions {
    /// Orientation of a volume, by `--up` or by what the file says.
    pub fn orientation(&self, grid: &Grid) -> Orientation {
        self.up.map_or_else(|| Orientation::of(grid), |up| Orientation::with_up(up, grid))
    }

    /// Given angles, or those of the given side.
    pub fn angles(&self, orientation: &Orientation) -> Angles {
        let side = self.from.map(|side| orientation.side(side));
        Angles {
            azimuth: self.azimuth.or(side.map(|orbit| orbit.azimuth)),
            elevation: self.elevation.or(side.map(|orbit| orbit.elevation)),
            roll: self.roll,
        }
    }
}

/// Describes in one line which way is up and why, and where azimuth 0, elevation 0 looks from.
pub(super) fn describe(orientation: &Orientation, grid: &Grid) -> String {
    let (up, front) = (orientation.up().name(), orientation.seen_from(Orbit::default()));
    match orientation.reason() {
        UpReason::Patient => {
            format!("{up}, the head (S) of the patient that the file declares; azimuth 0 looks from anterior ({front})")
        }
        UpReason::Slices => {
            let [x, y, z] = grid.spacing().to_array();
            format!("{up}, because slices along z are {z} apart and their pixels {x} by {y}; azimuth 0 looks from {front}")
        }
        UpReason::Given | UpReason::Default => format!("{up}; azimuth 0 looks from {front}"),
    }
}

/// Direction that is up in a picture, for `--json`.
#[derive(Serialize)]
pub(super) struct UpReport {
    up: &'static str,
    up_reason: &'static str,
}

impl UpReport {
    pub fn new(orientation: &Orientation) -> Self {
        Self { up: Up::name(orientation.up()), up_reason: orientation.reason().name() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_completed() {
        let given = Angles { elevation: Some(5.0), ..Angles::default() };
        assert_eq!(Angles::default().or_all_of(OBLIQUE), OBLIQUE);
        assert_eq!(given.or_all_of(OBLIQUE), Orbit { elevation: 5.0, ..Orbit::default() });
        assert_eq!(given.or_each_of(OBLIQUE), Orbit { elevation: 5.0, ..OBLIQUE });
        let line = Angles { azimuth: Some(7.0), elevation: Some(8.0), roll: None };
        assert_eq!(line.or(given), line);
        assert_eq!(given.or(line), Angles { azimuth: Some(7.0), ..given });
        // A given 0 counts.
        assert_eq!(Angles { roll: Some(0.0), ..Angles::default() }.or_all_of(OBLIQUE), Orbit::default());
    }
}
