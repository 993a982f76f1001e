//! The world as frames see it: with the smallest spacing as its unit, since float kernels know no world of 1e-20 or 1e20.

use crate::camera::{Camera, Projection};
use crate::settings::{ClipPlane, Clipping, Settings};
use crate::volume::Grid;

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

    /// World units of the caller's that are one here.
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

    pub fn settings(self, settings: &Settings) -> Settings {
        let plane = |plane: ClipPlane| ClipPlane { point: plane.point / self.unit, ..plane };
        let planes = settings.clipping.planes.map(|slot| slot.map(plane));
        Settings {
            unit_distance: settings.unit_distance.map(|d| d / self.unit),
            clipping: Clipping { planes, ..settings.clipping },
            ..*settings
        }
    }
}
