//! Cameras in world coordinates. Position and axes equal those of a vtkCamera with the same settings.

mod frame;
mod path;

pub use frame::{OrbitFrame, Up};
pub use path::{CameraPath, Key};

use crate::error::Error;
use crate::viewport::Viewport;
use glam::DVec3;

/// Projection of the world to the viewport.
///
/// ```
/// use layersplat::Projection;
///
/// let [parallel, perspective] = [Projection::Parallel { scale: 64.0 }, Projection::Perspective { field_of_view: 30.0 }];
/// assert_ne!(parallel, perspective);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Parallel rays.
    Parallel {
        /// Half the viewport's height in world units, > 0.
        scale: f64,
    },
    /// Rays from the eye.
    Perspective {
        /// Vertical field of view in degrees, between 0 and 180, exclusive.
        field_of_view: f64,
    },
}

/// A camera: position, focal point, view-up and projection.
///
/// ```
/// use layersplat::{Camera, Orbit, Viewport, glam::DVec3};
///
/// let (centre, viewport) = (DVec3::splat(31.5), Viewport::new(640, 480)?);
/// let camera = Camera::fit_parallel(centre, 110.0, viewport, Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 });
/// assert_eq!(camera.focal_point, centre);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position of the eye in world units. In a parallel projection only its direction from the focal point matters.
    pub position: DVec3,
    /// World point at the centre of the viewport.
    pub focal_point: DVec3,
    /// A vector that points upwards on the screen; it need not be orthogonal to the view direction.
    pub view_up: DVec3,
    /// Parallel or perspective projection.
    pub projection: Projection,
}

/// Orthonormal axes of a camera.
///
/// ```
/// use layersplat::{Camera, Orbit, Viewport, glam::DVec3};
///
/// let camera = Camera::fit_parallel(DVec3::ZERO, 2.0, Viewport::new(64, 64)?, Orbit { azimuth: 0.0, elevation: 30.0, roll: 0.0 });
/// let basis = camera.basis()?;
/// assert!(basis.right.cross(basis.up).distance(-basis.forward) < 1e-12);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    /// Rightwards on the screen.
    pub right: DVec3,
    /// Upwards on the screen.
    pub up: DVec3,
    /// View direction, from the eye to the focal point.
    pub forward: DVec3,
}

impl Basis {
    /// The world direction of one in camera space: (right, up, towards the viewer).
    pub fn in_world(&self, direction: DVec3) -> DVec3 {
        self.right * direction.x + self.up * direction.y - self.forward * direction.z
    }
}

/// Orientation of an orbiting camera in degrees: `azimuth` about y, `elevation` above the xz plane, `roll` about the view direction.
/// [`OrbitFrame`] converts an orbit about another axis.
///
/// ```
/// use layersplat::{Camera, Orbit, Projection, glam::DVec3};
///
/// let above = Orbit { azimuth: 0.0, elevation: 90.0, roll: 0.0 };
/// let camera = Camera::orbit(DVec3::ZERO, 5.0, above, Projection::Parallel { scale: 1.0 });
/// assert!(camera.basis()?.forward.length() > 0.999);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Orbit {
    /// Degrees about the y axis; at 0 the camera looks along −z.
    pub azimuth: f64,
    /// Degrees above the xz plane; may exceed ±90.
    pub elevation: f64,
    /// Degrees about the view direction, like `vtkCamera::Roll`.
    pub roll: f64,
}

impl Camera {
    /// A camera at `distance` (world units) from `centre`, looking at it.
    ///
    /// The direction from the centre to the eye is c = (cosE·sinA, sinE, cosE·cosA). The axes are right = (cosA, 0, −sinA) and
    /// up = c × right, also at E = ±90°. A roll φ rotates up to up·cosφ + right·sinφ.
    pub fn orbit(centre: DVec3, distance: f64, orbit: Orbit, projection: Projection) -> Self {
        let [_, view_up, to_eye] = axes(orbit);
        Self { position: centre + to_eye * distance, focal_point: centre, view_up, projection }
    }

    /// A parallel view that fits an object of the given `diagonal` (world units) in any orientation. Half the viewport's height is half the
    /// diagonal, divided by width/height if the viewport is narrower than high.
    pub fn fit_parallel(centre: DVec3, diagonal: f64, viewport: Viewport, orbit: Orbit) -> Self {
        let aspect = f64::from(viewport.width) / f64::from(viewport.height);
        let projection = Projection::Parallel { scale: diagonal / 2.0 / aspect.min(1.0) };
        Self::orbit(centre, diagonal, orbit, projection)
    }

    /// A perspective view that fits an object of the given `diagonal` (world units) in any orientation. `field_of_view` is vertical, in
    /// degrees. The distance of the eye is half the diagonal / sin(fov/2), as after vtkRenderer::ResetCamera; if the viewport is narrower
    /// than high, fov is the horizontal field of view.
    pub fn fit_perspective(centre: DVec3, diagonal: f64, field_of_view: f64, viewport: Viewport, orbit: Orbit) -> Self {
        let aspect = f64::from(viewport.width) / f64::from(viewport.height);
        let narrower = ((field_of_view.to_radians() / 2.0).tan() * aspect.min(1.0)).atan();
        let distance = diagonal / 2.0 / narrower.sin();
        Self::orbit(centre, distance, orbit, Projection::Perspective { field_of_view })
    }

    /// The camera's axes.
    ///
    /// # Errors
    /// If the eye is at the focal point, view-up is parallel to the view direction, a number is not finite, or the projection is invalid.
    pub fn basis(&self) -> Result<Basis, Error> {
        let invalid = |problem: &'static str| Error::Camera { problem };
        // Before the projection: a scale that was fitted to angles that are not finite is not finite either.
        if !(self.position.is_finite() && self.focal_point.is_finite() && self.view_up.is_finite()) {
            return Err(invalid(
                "position, focal point and view-up must be finite: check these, or azimuth, elevation, roll, centre and distance",
            ));
        }
        self.projection.check()?;
        let to_eye = unit(self.position - self.focal_point)
            .ok_or(invalid("position and focal point coincide, or are too far apart: move one of them"))?;
        let right = unit(self.view_up)
            .and_then(|up| up.cross(to_eye).try_normalize())
            .ok_or(invalid("view-up is zero or parallel to the view: choose another"))?;
        Ok(Basis { right, up: to_eye.cross(right), forward: -to_eye })
    }
}

impl Projection {
    fn check(self) -> Result<(), Error> {
        let (name, value, good) = match self {
            Projection::Parallel { scale } => ("scale", scale, scale > 0.0 && scale.is_finite()),
            Projection::Perspective { field_of_view: fov } => ("field_of_view", fov, fov > 0.0 && fov < 180.0),
        };
        if good {
            return Ok(());
        }
        let expected = match self {
            Projection::Parallel { .. } => "a finite number above 0",
            Projection::Perspective { .. } => "degrees between 0 and 180, exclusive",
        };
        Err(Error::OutOfRange { name, value: value.to_string(), expected })
    }
}

/// The vector with length 1; `None` for zero and for vectors that are not finite.
fn unit(vector: DVec3) -> Option<DVec3> {
    // Squares overflow from 1e154 on and lose digits below 1e-154, where the vector itself is still exact.
    let exact = vector.length_squared().is_normal();
    if exact { vector.try_normalize() } else { (vector / vector.abs().max_element()).try_normalize() }
}

/// Axes of an orbit: rightwards, upwards and to the eye.
fn axes(orbit: Orbit) -> [DVec3; 3] {
    let (sin_a, cos_a) = exact_sin_cos(orbit.azimuth);
    let (sin_e, cos_e) = exact_sin_cos(orbit.elevation);
    let (sin_r, cos_r) = exact_sin_cos(orbit.roll);
    let to_eye = DVec3::new(cos_e * sin_a, sin_e, cos_e * cos_a);
    let level = DVec3::new(cos_a, 0.0, -sin_a);
    let upright = to_eye.cross(level);
    [level * cos_r - upright * sin_r, upright * cos_r + level * sin_r, to_eye]
}

/// Sine and cosine of an angle in degrees, exact at multiples of 90°.
fn exact_sin_cos(degrees: f64) -> (f64, f64) {
    let turns = (degrees / 90.0).round();
    let (s, c) = (degrees - turns * 90.0).to_radians().sin_cos();
    match turns.rem_euclid(4.0) as u8 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn basis(azimuth: f64, elevation: f64, roll: f64) -> Basis {
        let orbit = Orbit { azimuth, elevation, roll };
        Camera::orbit(DVec3::ONE, 5.0, orbit, Projection::Parallel { scale: 1.0 }).basis().unwrap()
    }

    #[test]
    fn axes_are_those_of_a_vtk_camera() {
        let b = basis(0.0, 0.0, 0.0);
        assert_eq!((b.right, b.up, b.forward), (DVec3::X, DVec3::Y, DVec3::NEG_Z));
        let b = basis(90.0, 0.0, 0.0);
        assert_eq!((b.right, b.up, b.forward), (DVec3::NEG_Z, DVec3::Y, DVec3::NEG_X));
        let b = basis(0.0, 0.0, 90.0);
        assert!((b.up - DVec3::X).length() < 1e-15 && (b.right - DVec3::NEG_Y).length() < 1e-15);
    }

    #[test]
    fn poles_have_an_up() {
        let b = basis(30.0, 90.0, 0.0);
        assert!((b.forward - DVec3::NEG_Y).length() < 1e-15);
        assert!((b.right - DVec3::new(30f64.to_radians().cos(), 0.0, -0.5)).length() < 1e-15);
    }

    #[test]
    fn far_and_near_eyes_have_axes() {
        for scale in [1e-300, 1e-160, 1e160, 1e300] {
            let orbit = Orbit { azimuth: 30.0, elevation: 20.0, roll: 10.0 };
            let camera = Camera::orbit(DVec3::ZERO, 2.0 * scale, orbit, Projection::Parallel { scale });
            let (found, expected) = (camera.basis().unwrap(), basis(30.0, 20.0, 10.0));
            assert!((found.forward - expected.forward).length() < 1e-15 && (found.up - expected.up).length() < 1e-15, "{scale}");
        }
    }

    #[test]
    fn cameras_without_a_view_are_refused() {
        let good = Camera::orbit(DVec3::ZERO, 1.0, Orbit::default(), Projection::Parallel { scale: 1.0 });
        assert!(Camera { position: good.focal_point, ..good }.basis().is_err());
        assert!(Camera { view_up: DVec3::Z, ..good }.basis().is_err());
        assert!(Camera { view_up: DVec3::ZERO, ..good }.basis().is_err());
        for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Camera { projection: Projection::Parallel { scale }, ..good }.basis().is_err());
        }
        for field_of_view in [0.0, 180.0, -3.0, f64::NAN] {
            assert!(Camera { projection: Projection::Perspective { field_of_view }, ..good }.basis().is_err());
        }
    }
}
