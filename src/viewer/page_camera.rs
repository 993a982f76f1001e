//! The camera of a page.

use crate::camera::{Camera, Orbit, OrbitFrame, Projection};
use crate::error::Error;
use crate::volume::Grid;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A camera as angles about the vertical axis, with the names of the command's options.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct PageCamera {
    /// Degrees.
    pub azimuth: f64,
    /// Degrees.
    pub elevation: f64,
    /// Degrees.
    pub roll: f64,
    /// World point at the centre of the picture.
    pub center: [f64; 3],
    /// Parallel or perspective.
    pub projection: PageProjection,
}

/// A projection.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PageProjection {
    /// Half the height of the picture in world units.
    ParallelScale(f64),
    /// Vertical field of view in degrees, and distance from the eye to the centre in world units.
    Perspective([f64; 2]),
}

impl PageCamera {
    /// The page's description of a camera in the frame of an orbit.
    pub fn new(camera: &Camera, orbit: Orbit) -> Self {
        let projection = match camera.projection {
            Projection::Parallel { scale } => PageProjection::ParallelScale(scale),
            Projection::Perspective { field_of_view } => {
                PageProjection::Perspective([field_of_view, camera.position.distance(camera.focal_point)])
            }
        };
        let Orbit { azimuth, elevation, roll } = orbit;
        Self { azimuth, elevation, roll, center: camera.focal_point.to_array(), projection }
    }

    /// The page's description of any camera.
    ///
    /// # Errors
    /// If the camera has no valid view.
    pub fn of(camera: &Camera, frame: OrbitFrame) -> Result<Self, Error> {
        Ok(Self::new(camera, frame.orbit_of(camera)?))
    }

    /// The angles, in the frame of the volume's orientation.
    pub fn orbit(&self) -> Orbit {
        Orbit { azimuth: self.azimuth, elevation: self.elevation, roll: self.roll }
    }

    /// The camera, with the same bits as that of the command for `--fit volume` and these numbers.
    ///
    /// # Errors
    /// If numbers are not finite or lie outside their ranges.
    pub fn camera(&self, frame: OrbitFrame, grid: &Grid) -> Result<Camera, Error> {
        let (orbit, center) = (frame.orbit(self.orbit()), DVec3::from_array(self.center));
        let camera = match self.projection {
            PageProjection::ParallelScale(scale) => Camera::orbit(center, grid.diagonal(), orbit, Projection::Parallel { scale }),
            PageProjection::Perspective([field_of_view, distance]) => {
                Camera::orbit(center, distance, orbit, Projection::Perspective { field_of_view })
            }
        };
        camera.basis().map(|_| camera)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_are_checked() {
        const CAMERA: &str = r#"{"azimuth":1,"elevation":2,"roll":3,"center":[4,5,6],"projection":{"parallel_scale":7}}"#;
        let grid = Grid::new([4; 3], DVec3::ONE).unwrap();
        let camera: PageCamera = serde_json::from_str(CAMERA).unwrap();
        let made = camera.camera(OrbitFrame::default(), &grid).unwrap();
        assert_eq!(PageCamera::new(&made, camera.orbit()), camera);
        for projection in [
            PageProjection::ParallelScale(0.0),
            PageProjection::Perspective([180.0, 1.0]),
            PageProjection::Perspective([30.0, 0.0]),
        ] {
            assert!(PageCamera { projection, ..camera }.camera(OrbitFrame::default(), &grid).is_err(), "{projection:?}");
        }
        assert!(PageCamera { azimuth: f64::INFINITY, ..camera }.camera(OrbitFrame::default(), &grid).is_err());
    }
}
