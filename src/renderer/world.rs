//! The world as frames see it: with the smallest spacing as its unit, since float kernels know no world of 1e-20 or 1e20.

use crate::camera::{Camera, Projection};
use crate::error::Error;
use crate::layers::Rays;
use crate::settings::{ClipPlane, Clipping, Settings};
use crate::viewport::Viewport;
use crate::volume::Grid;
use std::ops::RangeInclusive;

/// Half heights of parallel views, in smallest spacings, that floats can hold with their reciprocals.
const SCALES: RangeInclusive<f64> = 1e-30..=1e30;

/// A scale of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct World {
    /// World units of the caller's that are one here.
    unit: f64,
}

impl World {
    /// That of a grid.
    pub fn of(grid: &Grid) -> Self {
        Self { unit: grid.spacing().min_element() }
    }

    /// World units of the caller's that are one of the frames'.
    pub fn unit(self) -> f64 {
        self.unit
    }

    pub fn grid(self, grid: &Grid) -> Grid {
        grid.in_units_of(self.unit)
    }

    pub fn camera(self, camera: &Camera) -> Camera {
        let projection = match camera.projection {
            Projection::Parallel { scale } => Projection::Parallel { scale: scale / self.unit },
            perspective @ Projection::Perspective { .. } => perspective,
        };
        Camera { position: camera.position / self.unit, focal_point: camera.focal_point / self.unit, projection, ..*camera }
    }

    /// A view as frames see it; `grid` in their world, all else in the caller's.
    pub fn seen(self, grid: &Grid, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<(Rays, Settings), Error> {
        // What is wrong is told in the caller's units.
        settings.check()?;
        camera.basis()?;
        let seen = self.camera(camera);
        if let Projection::Parallel { scale } = seen.projection
            && !SCALES.contains(&scale)
        {
            let expected = "between 1e-30 and 1e30 times the smallest spacing";
            return Err(Error::OutOfRange { name: "scale", value: format!("{:e}", scale * self.unit), expected });
        }
        Ok((Rays::new(&seen, viewport, grid)?, self.settings(settings)))
    }

    pub fn settings(self, settings: &Settings) -> Settings {
        let plane = |plane: ClipPlane| ClipPlane { point: plane.point / self.unit, ..plane };
        let planes = settings.clipping.planes.map(|slot| slot.map(plane));
        Settings {
            unit_distance: settings.unit_distance.map(|d| d / self.unit),
            gradient_opacity: settings.gradient_opacity.map(|opacity| opacity.times(self.unit)),
            clipping: Clipping { planes, ..settings.clipping },
            ..*settings
        }
    }
}
