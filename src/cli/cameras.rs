//! Cameras that the options ask for.

use super::options::{CameraOptions, Fit};
use super::orientation::Angles;
use super::scene::OpenedScene;
use crate::camera::{Camera, Orbit, Projection};
use crate::framing::{Fixed, Framing, Orientation};
use crate::volume::Grid;
use glam::DVec3;
use std::rc::Rc;

/// Makes the cameras of the options.
#[derive(Clone)]
pub(super) struct Cameras {
    options: CameraOptions,
    grid: Grid,
    orientation: Orientation,
    /// Bounds that views are fitted to. `None` fits the whole volume from all sides, which needs no pass over the volume.
    framing: Option<Rc<Framing>>,
}

impl Cameras {
    /// Creates cameras that fit `default` unless `--fit` is given.
    pub fn new(options: &CameraOptions, scene: &OpenedScene, default: Fit, orientation: Orientation) -> Self {
        let fit = options.fit.unwrap_or(default);
        let framing = (fit == Fit::Visible).then(|| Rc::new(scene.framing()));
        Self { options: options.clone(), grid: scene.extent.clone(), orientation, framing }
    }

    /// Creates cameras that fit the volume's bounding box unless `--fit` is given.
    pub fn with_bounding_box(options: &CameraOptions, scene: &OpenedScene, orientation: Orientation) -> Self {
        // The box of a single voxel has no extent.
        let framing =
            (options.fit.is_none() && scene.volume.grid().voxel_count() > 1).then(|| Rc::new(Framing::whole(&scene.volume)));
        framing.map_or_else(
            || Self::new(options, scene, Fit::Visible, orientation),
            |framing| Self { options: options.clone(), grid: scene.extent.clone(), orientation, framing: Some(framing) },
        )
    }

    /// Returns cameras with other options but the same fit.
    pub fn with_options(&self, options: CameraOptions) -> Self {
        Self { options, ..self.clone() }
    }

    pub fn options(&self) -> &CameraOptions {
        &self.options
    }

    pub fn orientation(&self) -> &Orientation {
        &self.orientation
    }

    /// Angles that the options give.
    pub fn angles(&self) -> Angles {
        self.options.angles(&self.orientation)
    }

    /// Centre of rotation of a sequence.
    pub fn centre(&self) -> DVec3 {
        let middle = || self.framing.as_ref().map_or_else(|| self.grid.centre(), |framing| framing.centre());
        self.options.center.unwrap_or_else(middle)
    }

    fn fixed(&self) -> Fixed {
        Fixed { centre: self.options.center, scale: self.options.parallel_scale, distance: self.options.distance }
    }

    /// The camera of one picture. Orbits of cameras are counted in the frame of their orientation.
    pub fn still(&self, orbit: Orbit) -> Camera {
        match &self.framing {
            Some(framing) => self.fitted(framing, orbit, self.fixed()),
            None => self.whole_volume(orbit),
        }
    }

    /// A camera fitted to `framing`; values in `fixed` are used as given.
    fn fitted(&self, framing: &Framing, orbit: Orbit, fixed: Fixed) -> Camera {
        let orbit = self.orientation.frame().orbit(orbit);
        match self.options.perspective {
            None => framing.parallel(orbit, self.options.size, fixed),
            Some(field_of_view) => framing.perspective(orbit, self.options.size, field_of_view, fixed),
        }
    }

    /// The cameras of a sequence, all with the same scale and centre.
    pub fn sequence(&self, orbits: impl Iterator<Item = Orbit>) -> Vec<Camera> {
        let Some(framing) = &self.framing else { return orbits.map(|orbit| self.whole_volume(orbit)).collect() };
        let fixed = Fixed { centre: Some(self.centre()), ..self.fixed() };
        let cameras: Vec<Camera> = orbits.map(|orbit| self.fitted(framing, orbit, fixed)).collect();
        let size = |camera: &Camera| match camera.projection {
            Projection::Parallel { scale } => scale,
            Projection::Perspective { .. } => camera.position.distance(camera.focal_point),
        };
        let largest = cameras.iter().map(size).fold(0.0, f64::max);
        let enlarge = |camera: Camera| match camera.projection {
            Projection::Parallel { .. } => Camera { projection: Projection::Parallel { scale: largest }, ..camera },
            Projection::Perspective { .. } => {
                let to_eye = (camera.position - camera.focal_point).normalize_or_zero();
                Camera { position: camera.focal_point + to_eye * largest, ..camera }
            }
        };
        cameras.into_iter().map(enlarge).collect()
    }

    /// A camera that fits the whole volume for every orbit.
    fn whole_volume(&self, orbit: Orbit) -> Camera {
        let (options, grid) = (&self.options, &self.grid);
        let orbit = self.orientation.frame().orbit(orbit);
        let centre = options.center.unwrap_or_else(|| grid.centre());
        match (options.perspective, options.parallel_scale, options.distance) {
            (Some(field_of_view), _, Some(distance)) => {
                Camera::orbit(centre, distance, orbit, Projection::Perspective { field_of_view })
            }
            (Some(field_of_view), _, None) => {
                Camera::fit_perspective(centre, grid.diagonal(), field_of_view, options.size, orbit)
            }
            (None, Some(scale), _) => Camera::orbit(centre, grid.diagonal(), orbit, Projection::Parallel { scale }),
            (None, None, _) => Camera::fit_parallel(centre, grid.diagonal(), options.size, orbit),
        }
    }
}
