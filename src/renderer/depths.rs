//! Depths of a picture, by ray casting, whatever draws the picture.

use super::Renderer;
use super::plan::Plan;
use super::rays::Gathers;
use super::scene::View;
use super::tiles::read_samples;
use crate::camera::{Camera, Projection};
use crate::error::Error;
use crate::image::Depths;
use crate::layers::Kernel;
use crate::settings::{Algorithm, Blend, Classification, Layered, Settings};
use crate::viewport::Viewport;

/// Smallest spacings from a sample to the next, where settings do not tell.
const STEP: f64 = 0.5;

impl Renderer {
    /// How far away is what [`render`](Self::render) shows through pixels' centres: found by casting rays through the field of the
    /// settings' kernel, with their step if they cast rays and half a smallest spacing otherwise, whatever draws the picture.
    ///
    /// # Errors
    /// Those of `render`, and blend modes other than composite and iso, where what is seen has no depth.
    pub fn depths(&mut self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Depths, Error> {
        let device = self.frame_device()?;
        let (rays, settings) = self.seen(camera, viewport, &marched(settings))?;
        let what = format!("depths of a picture of {}x{}", viewport.width, viewport.height);
        let on_host = (size_of::<[f32; 4]>() + 2 * size_of::<f32>()) as u64 * viewport.pixels() as u64;
        device.require(&what, self.target.missing(&device, viewport.pixels()), on_host)?;
        let plan = Plan::new(&rays, viewport, self.prepared.grid(), &settings)?;
        let Self { prepared, target, .. } = self;
        let scene = &mut View { device: &device, rays: &rays, viewport, settings: &settings }.of(prepared);
        match (plan, settings.blend) {
            (Plan::Raycast(kernel, step), _) => self.rays.cast(scene, kernel, step, Gathers::Depths, target)?,
            (Plan::CastValues(kernel, step), Blend::Iso(_)) => {
                self.rays.cast_values(scene, kernel, step, Gathers::Depths, target)?;
            }
            _ => {
                let problem = "only the blend modes composite and iso show things that have a depth".into();
                return Err(Error::Settings { field: "blend", problem });
            }
        }
        let gathered = read_samples(target.drawn(&device)?.0, &device, viewport.pixels())?;
        // Rays' parameters are depths in the renderer's own units, from the plane of the volume's centre or, if that is behind it, the eye.
        let centre = (self.grid.centre() - camera.position).dot(camera.basis()?.forward);
        let start = if matches!(camera.projection, Projection::Perspective { .. }) { centre.max(0.0) } else { centre };
        let depth = |parameter: f32| (start + f64::from(parameter) * self.world.unit()) as f32;
        let of = |&[first, weighted, _, alpha]: &[f32; 4]| {
            // Of the faintest pixels most is met before as much is gone as counts.
            let mean = if first.is_finite() { (weighted / alpha).max(first) } else { first };
            (depth(first), depth(mean))
        };
        let (first, mean) = gathered.iter().map(of).unzip();
        Ok(Depths::new(viewport, first, mean))
    }
}

/// What depths are found with: rays through the field of the settings' kernel, without looking at colours.
pub(crate) fn marched(settings: &Settings) -> Settings {
    let (kernel, step) = match settings.algorithm {
        Algorithm::Raycast { kernel, step } => (kernel, step),
        Algorithm::Layered(Layered { classification: Classification::Preintegrated { kernel, .. }, .. }) => (kernel, STEP),
        Algorithm::Slicing { step } => (Kernel::Linear, step),
        _ => (Kernel::Cubic, STEP),
    };
    Settings { algorithm: Algorithm::Raycast { kernel, step }, shading: None, ..*settings }
}
