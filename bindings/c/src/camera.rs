//! Cameras.

use crate::boundary::{Failure, Out, borrowed, guard};
use crate::{Grid, ProjectionChoice, Status, Transfer, Volume};
use layersplat::framing::Fixed;
use layersplat::glam::DVec3;
use layersplat::{Framing, Orbit, Projection, Viewport};

/// A camera in world coordinates. Fill it in, or use one of the functions layersplat_camera_….
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The eye. A parallel projection uses only the direction to the focal point.
    pub position: [f64; 3],
    /// The point at the centre of the picture.
    pub focal_point: [f64; 3],
    /// Any vector that points up in the picture.
    pub view_up: [f64; 3],
    /// A layersplat_projection.
    pub projection: i32,
    /// Parallel: half the picture's height in world units. Perspective: the vertical field of view in degrees.
    pub extent: f64,
}

/// A viewing direction, in degrees. With all angles 0, the camera looks along −z.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrbitAngles {
    /// Rotation about the y axis, degrees.
    pub azimuth: f64,
    /// Angle above the xz plane, degrees.
    pub elevation: f64,
    /// Rotation about the view direction, degrees.
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

    fn from_library(camera: &layersplat::Camera) -> Self {
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
    Ok(match ProjectionChoice::from_number(projection)? {
        ProjectionChoice::Parallel => Projection::Parallel { scale: extent },
        ProjectionChoice::Perspective => Projection::Perspective { field_of_view: extent },
    })
}

/// Writes a camera to the caller.
///
/// # Errors
/// A camera without a valid view.
unsafe fn set_camera(made: layersplat::Camera, camera: *mut Camera) -> Result<(), Failure> {
    made.basis()?;
    // SAFETY: upheld by the caller.
    unsafe { Out::new(camera, "camera") }?.set(Camera::from_library(&made));
    Ok(())
}

/// A camera at `distance` from `centre` (three world coordinates), looking at it. `projection` and `extent` are those of
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
        // SAFETY: upheld by the caller, here and below.
        let centre = *unsafe { borrowed(centre.cast::<[f64; 3]>(), "centre") }?;
        let projection = self::projection(projection, extent)?;
        unsafe { set_camera(layersplat::Camera::orbit(centre.into(), distance, angles.orbit(), projection), camera) }
    })
}

/// A camera that shows the whole grid in a picture of `width` x `height` pixels. The distance is the same for all angles.
/// `field_of_view` is the vertical angle of a perspective in degrees; 0 selects a parallel view.
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
        // SAFETY: upheld by the caller, here and below.
        let grid = unsafe { borrowed(grid, "grid") }?.checked()?;
        let viewport = Viewport::new(width, height)?;
        let (centre, diagonal, orbit) = (grid.centre(), grid.diagonal(), angles.orbit());
        let made = if field_of_view == 0.0 {
            layersplat::Camera::fit_parallel(centre, diagonal, viewport, orbit)
        } else {
            layersplat::Camera::fit_perspective(centre, diagonal, field_of_view, viewport, orbit)
        };
        unsafe { set_camera(made, camera) }
    })
}

/// A camera that fits the visible part of a volume: all voxels that the transfer function does not make transparent. The call scans
/// the voxels. The other arguments are those of layersplat_camera_fit_grid().
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
        // SAFETY: upheld by the caller, here and below.
        let volume = unsafe { borrowed(volume, "volume") }?;
        let transfer = unsafe { borrowed(transfer, "transfer") }?;
        let viewport = Viewport::new(width, height)?;
        let orbit = angles.orbit();
        // Framing needs finite angles.
        layersplat::Camera::orbit(DVec3::ZERO, 1.0, orbit, Projection::Parallel { scale: 1.0 }).basis()?;
        let framing = Framing::visible(&volume.0, &transfer.0, None);
        let made = if field_of_view == 0.0 {
            framing.parallel(orbit, viewport, Fixed::default())
        } else {
            framing.perspective(orbit, viewport, field_of_view, Fixed::default())
        };
        unsafe { set_camera(made, camera) }
    })
}
