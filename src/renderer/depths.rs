//! Depths of a picture, by ray casting, whatever draws the picture.

use super::frame::{Frame, Mode, Stage, Step};
use super::picture::Finished;
use super::plan::Plan;
use super::rays::Gathers;
use super::tiles::read_samples;
use super::{Planned, Renderer};
use crate::camera::{Camera, Projection};
use crate::device::Device;
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
        let planned = self.planned(camera, viewport, &marched(settings))?;
        let has_depths = match planned.plan {
            Plan::Raycast(..) => true,
            Plan::CastValues(..) => matches!(planned.settings.blend, Blend::Iso(_)),
            _ => false,
        };
        if !has_depths {
            let problem = "only the blend modes composite and iso show things that have a depth".into();
            return Err(Error::Settings { field: "blend", problem });
        }
        let gathered = self.gathered(&planned)?;
        // Rays' parameters are depths in the renderer's own units, from the plane of the volume's centre or, if that is behind it, the eye.
        let centre = (self.grid().centre() - camera.position).dot(camera.basis()?.forward);
        let start = if matches!(camera.projection, Projection::Perspective { .. }) { centre.max(0.0) } else { centre };
        let unit = self.engine.field.world().unit();
        let depth = |parameter: f32| (start + f64::from(parameter) * unit) as f32;
        let of = |&[first, weighted, _, alpha]: &[f32; 4]| {
            // Of the faintest pixels most is met before as much is gone as counts.
            let mean = if first.is_finite() { (weighted / alpha).max(first) } else { first };
            (depth(first), depth(mean))
        };
        let (first, mean) = gathered.iter().map(of).unzip();
        Ok(Depths::new(viewport, first, mean))
    }

    /// For each pixel the ray parameter where something is seen first, the mean one times the opacity, and the opacity last.
    fn gathered(&mut self, Planned { rays, viewport, settings, plan }: &Planned) -> Result<Vec<[f32; 4]>, Error> {
        let steps = vec![Step::Screen(plan, Gathers::Depths)];
        let stage = self.engine.declaring(*viewport, |declaring| Stage::new(steps, false, declaring));
        let host_bytes = (size_of::<[f32; 4]>() + 2 * size_of::<f32>()) as u64 * viewport.pixels() as u64;
        let frame = Frame { rays, viewport: *viewport, settings, stages: vec![stage], volume: None, into: None, host_bytes };
        let read = |device: &Device, finished: &Finished| read_samples(finished.floats(), device, viewport.pixels());
        Ok(self.engine.run(&frame, Mode::Waited, read)?.0)
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
