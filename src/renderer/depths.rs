//! Depths of a picture, always found by ray casting.

use super::frame::{Frame, Mode, Stage, Step};
use super::picture::Finished;
use super::rays::RayOutput;
use super::tiles::read_samples;
use super::{Planned, Renderer};
use crate::camera::{Camera, Projection};
use crate::device::Device;
use crate::error::Error;
use crate::image::Depths;
use crate::layers::Kernel;
use crate::settings::{Algorithm, Classification, Layered, Method, Settings};
use crate::viewport::Viewport;

/// Default step between samples, in smallest spacings.
const STEP: f64 = 0.5;

impl Renderer {
    /// Depths of what [`render`](Self::render) shows at the pixel centres. They are found by ray casting, independent of the
    /// algorithm of the picture, in the field of the settings' kernel. The step is that of the settings if they cast rays, and
    /// half the smallest spacing otherwise.
    ///
    /// # Errors
    /// Those of `render`, and blend modes other than composite and iso, because their pictures have no depth.
    pub fn depths(&mut self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Depths, Error> {
        self.engine.check_method(Method::Depths, settings.blend)?;
        let planned = self.planned(camera, viewport, &depth_settings(settings))?;
        let gathered = self.gather_depths(&planned)?;
        // Ray parameters are depths in normalised units from the plane through the volume's centre, or from the eye if that plane
        // is behind it.
        let centre = (self.grid().centre() - camera.position).dot(camera.basis()?.forward);
        let start = if matches!(camera.projection, Projection::Perspective { .. }) { centre.max(0.0) } else { centre };
        let unit = self.engine.base_field().world().unit();
        let depth = |parameter: f32| (start + f64::from(parameter) * unit) as f32;
        let depths = |&[first, weighted, _, alpha]: &[f32; 4]| {
            // In the faintest pixels the mean can lie in front of the first depth, which requires an opacity of 1/256.
            let mean = if first.is_finite() { (weighted / alpha).max(first) } else { first };
            (depth(first), depth(mean))
        };
        let (first, mean) = gathered.iter().map(depths).unzip();
        Ok(Depths::new(viewport, first, mean))
    }

    /// Per pixel: ray parameter of the first visible point, mean ray parameter times opacity, an unused component, and opacity.
    fn gather_depths(&mut self, Planned { rays, viewport, settings, plan }: &Planned) -> Result<Vec<[f32; 4]>, Error> {
        let stage = self.engine.declaring(*viewport, settings, |declaring| {
            let rays = Step::Screen(plan, RayOutput::Depths);
            let step = declaring.surfaces.map_or(rays.clone(), |surfaces| Step::Surfaces(vec![rays], surfaces));
            Stage::new(vec![step], false, declaring)
        });
        let host_bytes = (size_of::<[f32; 4]>() + 2 * size_of::<f32>()) as u64 * viewport.pixels() as u64;
        let frame = Frame { rays, viewport: *viewport, settings, stages: vec![stage], volume: None, into: None, host_bytes };
        let read = |device: &Device, finished: &Finished| read_samples(finished.floats(), device, viewport.pixels());
        Ok(self.engine.run(&frame, Mode::Waited, read)?.0)
    }
}

/// Settings for finding depths: ray casting in the field of the settings' kernel, unlit.
pub(crate) fn depth_settings(settings: &Settings) -> Settings {
    let (kernel, step) = match settings.algorithm {
        Algorithm::Raycast { kernel, step } => (kernel, step),
        Algorithm::Layered(Layered { classification: Classification::Preintegrated { kernel, .. }, .. }) => (kernel, STEP),
        Algorithm::Slicing { step } => (Kernel::Linear, step),
        _ => (Kernel::Cubic, STEP),
    };
    Settings {
        algorithm: Algorithm::Raycast { kernel, step },
        shading: None,
        studio: None,
        shadows: None,
        ambient_occlusion: None,
        ..*settings
    }
}
