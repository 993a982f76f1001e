//! Cameras.

use crate::border::{Failure, Out, borrowed, guard};
use crate::{Grid, ProjectionChoice, Status, Transfer, Volume};
use layersplat::framing::Fixed;
use layersplat::glam::DVec3;
use layersplat::{Framing, Orbit, Projection, Viewport};

/// What a picture shows, in world coordinates. May be filled in, or made by one of the functions layersplat_camera_….
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The eye. Of a parallel projection only the direction to the focal point counts.
    pub position: [f64; 3],
    /// The point in the middle of the picture.
    pub focal_point: [f64; 3],
    /// Any vector that is up in the picture.
    pub view_up: [f64; 3],
    /// A layersplat_projection.
    pub projection: i32,
    /// Parallel: half the picture's height, world units. Perspective: its angle from bottom to top, degrees.
    pub extent: f64,
}

/// A direction to look from: degrees about the y axis (0 looks along −z), above the xz plane, and about the view.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrbitAngles {
    /// Degrees about the y axis.
    pub azimuth: f64,
    /// Degrees above the xz plane.
    pub elevation: f64,
    /// Degrees about the view.
    pub roll: f64,
}

impl OrbitAngles {
    fn orbit(self) -> Orbit {
        Orbit { azimuth: self.azimuth, elevation: self.elevation, roll: self.roll }
    }
}

impl Camera {
    pub(crate) fn checked(&self) -> Result<layersplat::Camera, Failure> {
        let [position, focal_point, view_up] = [self.position, self.focal_point, self.view_up].map(DVec3::from_array);
        let projection = projection(self.projection, self.extent)?;
        Ok(layersplat::Camera { position, focal_point, view_up, projection })
    }

    fn of(camera: &layersplat::Camera) -> Self {
        let (projection, extent) = match camera.projection {
            Projection::Parallel { scale } => (ProjectionChoice::Parallel, scale),
            Projection::Perspective { field_of_view } => (ProjectionChoice::Perspective, field_of_view),
        };
        Self {
            position: camera.position.to_array(),
            focal_point: camera.focal_point.to_array(),
            view_up: camera.view_up.to_array(),
            projection: projection as i32,
            extent,
        }
    }
}

fn projection(projection: i32, extent: f64) -> Result<Projection, Failure> {
    Ok(match ProjectionChoice::chosen(projection)? {
        ProjectionChoice::Parallel => Projection::Parallel { scale: extent },
        ProjectionChoice::Perspective => Projection::Perspective { field_of_view: extent },
    })
}

/// Gives a camera that has a view.
unsafe fn give(made: layersplat::Camera, camera: *mut Camera) -> Result<(), Failure> {
    made.basis()?;
    // SAFETY: the caller's promise.
    unsafe { Out::new(camera, "camera") }?.set(Camera::of(&made));
    Ok(())
}

/// A camera at a distance from a point (three world coordinates) that it looks at. `projection` and `extent` are those of
/// layersplat_camera.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_camera_orbit(
    centre: *const f64,
    distance: f64,
    angles: OrbitAngles,
    projection: i32,
    extent: f64,
    camera: *mut Camera,
) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let centre = *unsafe { borrowed(centre.cast::<[f64; 3]>(), "centre") }?;
        let projection = self::projection(projection, extent)?;
        unsafe { give(layersplat::Camera::orbit(centre.into(), distance, angles.orbit(), projection), camera) }
    })
}

/// A camera that a whole grid fits from every side, for pictures of `width` x `height` pixels. `field_of_view` is that of a perspective,
/// degrees; 0 is a parallel view.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_camera_fit_grid(
    grid: *const Grid,
    angles: OrbitAngles,
    field_of_view: f64,
    width: u32,
    height: u32,
    camera: *mut Camera,
) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let grid = unsafe { borrowed(grid, "grid") }?.checked()?;
        let viewport = Viewport::new(width, height)?;
        let (centre, diagonal, orbit) = (grid.centre(), grid.diagonal(), angles.orbit());
        let made = if field_of_view == 0.0 {
            layersplat::Camera::fit_parallel(centre, diagonal, viewport, orbit)
        } else {
            layersplat::Camera::fit_perspective(centre, diagonal, field_of_view, viewport, orbit)
        };
        unsafe { give(made, camera) }
    })
}

/// A camera that fits what a transfer function shows of a volume, which is looked for. The rest is as in layersplat_camera_fit_grid().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_camera_fit_visible(
    volume: *const Volume,
    transfer: *const Transfer,
    angles: OrbitAngles,
    field_of_view: f64,
    width: u32,
    height: u32,
    camera: *mut Camera,
) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let volume = unsafe { borrowed(volume, "volume") }?;
        let transfer = unsafe { borrowed(transfer, "transfer") }?;
        let viewport = Viewport::new(width, height)?;
        let orbit = angles.orbit();
        // Angles without a view would find no axes.
        layersplat::Camera::orbit(DVec3::ZERO, 1.0, orbit, Projection::Parallel { scale: 1.0 }).basis()?;
        let framing = Framing::visible(&volume.0, &transfer.0, None);
        let made = if field_of_view == 0.0 {
            framing.parallel(orbit, viewport, Fixed::default())
        } else {
            framing.perspective(orbit, viewport, field_of_view, Fixed::default())
        };
        unsafe { give(made, camera) }
    })
}
