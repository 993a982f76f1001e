//! The frame in which an orbit is counted: which way is up, and where azimuth 0, elevation 0 looks from.

use super::{Camera, Orbit, axes};
use crate::choice::choices;
use crate::error::Error;
use glam::DVec3;

/// An axis of the world that points up.
///
/// ```
/// use layersplat::camera::Up;
/// use layersplat::glam::DVec3;
///
/// assert_eq!((Up::NegativeZ.name(), Up::NegativeZ.direction()), ("-z", DVec3::NEG_Z));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// +x.
    X,
    /// −x.
    NegativeX,
    /// +y, as of [`Camera::orbit`](super::Camera::orbit).
    #[default]
    Y,
    /// −y.
    NegativeY,
    /// +z.
    Z,
    /// −z.
    NegativeZ,
}

choices! { Up, "up"; X = "x", NegativeX = "-x", Y = "y", NegativeY = "-y", Z = "z", NegativeZ = "-z" }

impl Up {
    /// Unit vector in the world.
    pub fn direction(self) -> DVec3 {
        match self {
            Up::X => DVec3::X,
            Up::NegativeX => DVec3::NEG_X,
            Up::Y => DVec3::Y,
            Up::NegativeY => DVec3::NEG_Y,
            Up::Z => DVec3::Z,
            Up::NegativeZ => DVec3::NEG_Z,
        }
    }
}

/// Right-handed, orthonormal axes in which an orbit is counted: at azimuth 0, elevation 0 and roll 0 they are the camera's.
///
/// The default has y up and looks along −z, as [`Camera::orbit`](super::Camera::orbit) does.
///
/// ```
/// use layersplat::camera::{OrbitFrame, Up};
/// use layersplat::{Camera, Orbit, Projection, glam::DVec3};
///
/// // From below, about z.
/// let orbit = OrbitFrame::about(Up::Z).orbit(Orbit { azimuth: 0.0, elevation: -90.0, roll: 0.0 });
/// let camera = Camera::orbit(DVec3::ZERO, 5.0, orbit, Projection::Parallel { scale: 1.0 });
/// assert!(camera.basis()?.forward.distance(DVec3::Z) < 1e-12);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrbitFrame {
    right: DVec3,
    up: DVec3,
    to_eye: DVec3,
}

impl Default for OrbitFrame {
    fn default() -> Self {
        Self::about(Up::Y)
    }
}

impl OrbitFrame {
    /// The frame with `up` upwards. It looks from +y along −y, or from +z where y is vertical. So in a world of RAS coordinates, z up
    /// looks from anterior, with the head up and the patient's left on the right of the picture.
    pub fn about(up: Up) -> Self {
        let to_eye = if matches!(up, Up::Y | Up::NegativeY) { DVec3::Z } else { DVec3::Y };
        let up = up.direction();
        Self { right: up.cross(to_eye), up, to_eye }
    }

    /// Rightwards on the screen at azimuth 0, in the world.
    pub fn right(&self) -> DVec3 {
        self.right
    }

    /// Axis of the azimuth, in the world.
    pub fn up(&self) -> DVec3 {
        self.up
    }

    /// Direction from the focal point to the eye at azimuth 0 and elevation 0, in the world.
    pub fn to_eye(&self) -> DVec3 {
        self.to_eye
    }

    /// The orbit about y, for [`Camera::orbit`](super::Camera::orbit) and all that fit a view, that shows what `orbit` shows in this frame.
    /// The default frame returns `orbit` itself.
    pub fn orbit(&self, orbit: Orbit) -> Orbit {
        if *self == Self::default() {
            return orbit;
        }
        of_axes(axes(orbit).map(|axis| self.to_world(axis)))
    }

    /// The orbit in this frame that has the axes of a camera. Without a roll of more than rounding, the roll is 0.
    ///
    /// # Errors
    /// If the camera has no valid view.
    pub fn orbit_of(&self, camera: &Camera) -> Result<Orbit, Error> {
        /// Degrees.
        const ROUNDING: f64 = 1e-9;
        let basis = camera.basis()?;
        let in_frame = |v: DVec3| DVec3::new(v.dot(self.right), v.dot(self.up), v.dot(self.to_eye));
        let orbit = of_axes([basis.right, basis.up, -basis.forward].map(in_frame));
        Ok(if orbit.roll.abs() < ROUNDING { Orbit { roll: 0.0, ..orbit } } else { orbit })
    }

    /// Direction from the focal point to the eye of an `orbit` in this frame, in the world.
    pub fn direction_to_eye(&self, orbit: Orbit) -> DVec3 {
        let [.., to_eye] = axes(orbit);
        self.to_world(to_eye)
    }

    /// Converts a vector from this frame to the world.
    fn to_world(self, v: DVec3) -> DVec3 {
        self.right * v.x + self.up * v.y + self.to_eye * v.z
    }
}

/// The orbit about y whose camera has these axes: right, up, towards the eye.
fn of_axes([right, up, to_eye]: [DVec3; 3]) -> Orbit {
    let horizontal = to_eye.x.hypot(to_eye.z);
    let elevation = to_eye.y.atan2(horizontal);
    // At the poles, where the azimuth and the roll turn about the same axis, the azimuth does it all.
    let azimuth = if horizontal > 0.0 { to_eye.x.atan2(to_eye.z) } else { (-right.z).atan2(right.x) };
    let (azimuth, elevation) = (azimuth.to_degrees(), elevation.to_degrees());
    let [level, upright, _] = axes(Orbit { azimuth, elevation, roll: 0.0 });
    Orbit { azimuth, elevation, roll: up.dot(level).atan2(up.dot(upright)).to_degrees() }
}

#[cfg(test)]
mod tests {
    use super::super::{Basis, Projection};
    use super::*;

    /// Rounding error of an orientation that passed through three angles in degrees.
    const ROUNDING: f64 = 1e-14;

    fn basis(orbit: Orbit) -> Basis {
        Camera::orbit(DVec3::ZERO, 1.0, orbit, Projection::Parallel { scale: 1.0 }).basis().unwrap()
    }

    fn frames() -> impl Iterator<Item = (Up, OrbitFrame)> {
        Up::ALL.into_iter().map(|up| (up, OrbitFrame::about(up)))
    }

    /// Each frame is right-handed and orthonormal; the camera at azimuth 0 has its axes, and up is up on the screen.
    #[test]
    fn the_first_view_has_the_axes_of_the_frame() {
        for (up, frame) in frames() {
            assert_eq!(frame.right().cross(frame.up()), frame.to_eye(), "{up:?}");
            assert!(frame.up() == up.direction() && frame.right().length() == 1.0 && frame.right().dot(frame.up()) == 0.0);
            let seen = basis(frame.orbit(Orbit::default()));
            let apart = seen.right.distance(frame.right()) + seen.up.distance(up.direction());
            assert!(apart + seen.forward.distance(-frame.to_eye()) < ROUNDING, "{up:?}: {seen:?}");
        }
    }

    #[test]
    fn patients_are_seen_from_anterior_with_their_left_on_the_right() {
        // RAS: −x is the left, z the head, y the front.
        let frame = OrbitFrame::about(Up::Z);
        assert_eq!((frame.right(), frame.up(), frame.to_eye()), (DVec3::NEG_X, DVec3::Z, DVec3::Y));
    }

    /// Turning a view within the frame, and turning its axes in the world, give the same camera, at the poles and near them, too.
    #[test]
    fn orbits_turn_about_the_axis_of_the_frame() {
        for (up, frame) in frames() {
            for azimuth in [0.0, 30.0, 90.0, -135.0, 180.0, 400.0] {
                for elevation in [0.0, 20.0, -35.0, 90.0, -90.0, 90.0 - 1e-9, 120.0] {
                    for roll in [0.0, 15.0, -90.0, 180.0] {
                        let orbit = Orbit { azimuth, elevation, roll };
                        let (found, about_y) = (basis(frame.orbit(orbit)), basis(orbit));
                        let expected = [about_y.right, about_y.up, about_y.forward].map(|axis| frame.to_world(axis));
                        let apart = found.right.distance(expected[0]) + found.up.distance(expected[1]);
                        assert!(apart + found.forward.distance(expected[2]) < ROUNDING, "{up:?}, {orbit:?}: {found:?}");
                    }
                }
            }
            // The azimuth keeps the height of the eye above the plane across the axis.
            let height = |azimuth| -basis(frame.orbit(Orbit { azimuth, elevation: 20.0, roll: 0.0 })).forward.dot(frame.up());
            assert!((0..12).all(|n| (height(30.0 * f64::from(n)) - 20f64.to_radians().sin()).abs() < ROUNDING), "{up:?}");
        }
    }

    /// The orbit of a camera makes the same camera again, whatever its view-up was.
    #[test]
    fn orbits_are_found_again() {
        for (up, frame) in frames() {
            for elevation in [0.0, 20.0, -35.0, 90.0, -90.0] {
                for roll in [0.0, 15.0, -90.0] {
                    let orbit = frame.orbit(Orbit { azimuth: 30.0, elevation, roll });
                    let camera = Camera::orbit(DVec3::ONE, 2.0, orbit, Projection::Parallel { scale: 1.0 });
                    let tilted = Camera { view_up: camera.view_up + 0.5 * (camera.position - camera.focal_point), ..camera };
                    let (expected, found) = (basis(orbit), basis(frame.orbit(frame.orbit_of(&tilted).unwrap())));
                    let apart = found.right.distance(expected.right) + found.up.distance(expected.up);
                    assert!(apart + found.forward.distance(expected.forward) < 4.0 * ROUNDING, "{up:?}, {orbit:?}: {found:?}");
                    if roll == 0.0 && elevation.abs() < 90.0 && up == Up::Y {
                        assert_eq!(frame.orbit_of(&tilted).unwrap().roll, 0.0);
                    }
                }
            }
        }
        let nowhere = Camera {
            position: DVec3::ZERO,
            focal_point: DVec3::ZERO,
            ..Camera::orbit(DVec3::ZERO, 1.0, Orbit::default(), Projection::Parallel { scale: 1.0 })
        };
        assert!(OrbitFrame::default().orbit_of(&nowhere).is_err());
    }

    #[test]
    fn y_up_changes_no_bit() {
        let odd = Orbit { azimuth: -0.0, elevation: 1e-300, roll: 12_345.678 };
        for frame in [OrbitFrame::default(), OrbitFrame::about(Up::Y)] {
            let same = frame.orbit(odd);
            let bits = |orbit: Orbit| [orbit.azimuth, orbit.elevation, orbit.roll].map(f64::to_bits);
            assert_eq!(bits(same), bits(odd));
        }
    }

    #[test]
    fn angles_that_are_not_finite_stay_so() {
        for angle in [f64::NAN, f64::INFINITY] {
            for [azimuth, elevation, roll] in [[angle, 0.0, 0.0], [0.0, angle, 0.0], [0.0, 0.0, angle]] {
                let orbit = OrbitFrame::about(Up::Z).orbit(Orbit { azimuth, elevation, roll });
                assert!(![orbit.azimuth, orbit.elevation, orbit.roll].iter().all(|angle| angle.is_finite()));
            }
        }
    }
}
