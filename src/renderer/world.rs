//! Normalised world units: the smallest spacing is 1, because the floats of kernels cannot represent worlds with sizes of 1e-20
//! or 1e20.

use crate::camera::{Camera, Projection};
use crate::error::Error;
use crate::layers::Rays;
use crate::settings::{AmbientOcclusion, ClipPlane, Clipping, Settings};
use crate::viewport::Viewport;
use crate::volume::Grid;
use std::ops::RangeInclusive;

/// Valid half heights of parallel views, in smallest spacings: floats can represent them and their reciprocals.
const SCALES: RangeInclusive<f64> = 1e-30..=1e30;

/// Scale between the caller's world units and the normalised ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct World {
    /// Normalised unit of length in the caller's world units.
    unit: f64,
}

impl World {
    /// Normalises by the smallest spacing of a grid.
    pub fn new(grid: &Grid) -> Self {
        Self { unit: grid.spacing().min_element() }
    }

    /// Normalised unit of length in the caller's world units.
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

    /// Rays and settings of a view in normalised units; `grid` is normalised, all other arguments are in the caller's units.
    pub fn normalised_view(
        self,
        grid: &Grid,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
    ) -> Result<(Rays, Settings), Error> {
        // Check first: messages are in the caller's units.
        settings.check()?;
        camera.basis()?;
        let normalised = self.camera(camera);
        if let Projection::Parallel { scale } = normalised.projection
            && !SCALES.contains(&scale)
        {
            let expected = "between 1e-30 and 1e30 times the smallest spacing";
            return Err(Error::OutOfRange { name: "scale", value: format!("{:e}", scale * self.unit), expected });
        }
        Ok((Rays::new(&normalised, viewport, grid)?.with_pixel_aspect(settings.pixel_aspect, viewport), self.settings(settings)))
    }

    pub fn settings(self, settings: &Settings) -> Settings {
        let plane = |plane: ClipPlane| ClipPlane { point: plane.point / self.unit, ..plane };
        let planes = settings.clipping.planes.map(|slot| slot.map(plane));
        Settings {
            unit_distance: settings.unit_distance.map(|d| d / self.unit),
            ambient_occlusion: settings
                .ambient_occlusion
                .map(|occlusion| AmbientOcclusion { reach: occlusion.reach.map(|d| d / self.unit), ..occlusion }),
            gradient_opacity: settings.gradient_opacity.map(|opacity| opacity.times(self.unit)),
            clipping: Clipping { planes, ..settings.clipping },
            ..*settings
        }
    }
}
