//! The renderer: its parameters as settings of the library.

use crate::colors::{self, Background};
use crate::light::strength_and_hue;
use crate::objects::{Object, Objects};
use crate::status::Problem;
use crate::volume::DrawnVolume;
use layersplat::settings::{
    Algorithm, AmbientOcclusion, Layered, Light, LightSpace, Lights, Look, Settings, Shading, Shadows, Sky, Studio,
};
use layersplat::{Kernel, Quality};
use std::f64::consts::PI;

/// Settings of a frame without camera and volume.
pub struct RendererSettings {
    pub settings: Settings,
    pub background: Background,
    /// Rays per pixel.
    pub samples: u32,
    /// Whether fields end at their outermost values.
    pub clips_to_bounds: bool,
}

impl RendererSettings {
    /// The parameters of a renderer. `lights` are those of the world, and `shown` its volumes. Problems are what several volumes cannot have.
    pub fn from_object(
        objects: &Objects,
        renderer: &Object,
        lights: Option<Lights>,
        shown: &[DrawnVolume],
        problems: &mut Vec<Problem>,
    ) -> Self {
        let mut refused = |what: &str| problems.push(Problem::argument(format!("{} volumes are visible: {what}", shown.len())));
        let mut quality: Quality = renderer.text(c"quality").and_then(|name| name.parse().ok()).unwrap_or_default();
        if shown.len() > 1 && quality == Quality::Paper {
            refused("quality 'paper' draws one, and 'standard' is used");
            quality = Quality::Standard;
        }
        let look: Look = renderer.text(c"look").and_then(|name| name.parse().ok()).unwrap_or_default();
        let is_studio = look == Look::Studio;
        if is_studio {
            quality = without_effect(renderer, quality, problems);
        }
        let mut settings = quality.settings();
        let mut refused = |what: &str| problems.push(Problem::argument(format!("{} volumes are visible: {what}", shown.len())));
        let kernel = renderer.text(c"kernel").and_then(|name| name.parse().ok());
        let kernel = kernel.unwrap_or_else(|| kernel_of_filter(shown, &mut refused));
        settings.algorithm = with_kernel(settings.algorithm, kernel);
        settings.gradient = renderer.text(c"gradient").and_then(|name| name.parse().ok());
        settings.gamma = renderer.float(c"gamma").map_or(settings.gamma, f64::from);
        settings.shading = if is_studio { Some(light_of_studio(renderer, lights)) } else { shading(renderer, lights) };
        settings.studio = is_studio.then(|| studio(renderer, lights));
        let is_lit = settings.shading.is_some() && !is_studio;
        settings.shadows = (lights.is_some() && !is_studio && renderer.is_set(c"shadows")).then(Shadows::default);
        settings.ambient_occlusion = (is_lit && renderer.is_set(c"ambientOcclusion")).then(AmbientOcclusion::default);
        let samples = renderer.integer(c"pixelSamples").map_or(1, |samples| samples.clamp(1, 16) as u32);
        let mut clips_to_bounds = renderer.is_set(c"clipToBounds");
        if shown.len() > 1 && std::mem::take(&mut clips_to_bounds) {
            refused("clipToBounds has no effect");
        }
        if shown.iter().any(DrawnVolume::is_sheared) && std::mem::take(&mut clips_to_bounds) {
            let text =
                "the volume is sheared: clipToBounds has no effect, and it fades within one voxel beyond its outermost values";
            problems.push(Problem::argument(text));
        }
        Self { settings, background: background(objects, renderer), samples, clips_to_bounds }
    }
}

impl Default for RendererSettings {
    /// The settings of a renderer without parameters, in a world without lights.
    fn default() -> Self {
        let settings = Settings { shading: None, ..Quality::default().settings() };
        Self { settings, background: Background::Color([0.0, 0.0, 0.0, 1.0]), samples: 1, clips_to_bounds: false }
    }
}

/// The kernel of the first field's filter.
fn kernel_of_filter(shown: &[DrawnVolume], refused: &mut impl FnMut(&str)) -> Kernel {
    let is_cubic = shown.first().is_some_and(|shown| shown.field.is_cubic);
    if shown.iter().any(|shown| shown.field.is_cubic != is_cubic) {
        refused("their filters differ, and that of the first is used");
    }
    if is_cubic { Kernel::BSpline } else { Kernel::Linear }
}

/// Sets the kernel, unless voxels are splatted.
fn with_kernel(algorithm: Algorithm, kernel: Kernel) -> Algorithm {
    match algorithm {
        Algorithm::Layered(layered) => Layered { classification: layered.classification.with_kernel(kernel), ..layered }.into(),
        other => other,
    }
}

/// Shading by the lights of the world and the ambient light. Without either, the volume emits its colours as they are. So it does under
/// an ambient light of 1 alone, if nothing dims that.
fn shading(renderer: &Object, lights: Option<Lights>) -> Option<Shading> {
    let (share, ambient_color) = strength_and_hue(renderer.floats::<3>(c"ambientColor").unwrap_or([1.0; 3]));
    let ambient = (share * f64::from(renderer.float(c"ambientRadiance").unwrap_or(0.0))).min(100.0);
    let keeps_colors = ambient == 1.0 && ambient_color == [1.0; 3] && !renderer.is_set(c"ambientOcclusion");
    match lights {
        Some(lights) => Some(Shading { ambient, ambient_color, lights, ..Shading::default() }),
        None if ambient == 0.0 || keeps_colors => None,
        None => Some(Shading { ambient, ambient_color, diffuse: 0.0, specular: 0.0, ..Shading::default() }),
    }
}

/// Names parameters that the studio does not have. Returns the quality that it has.
fn without_effect(renderer: &Object, quality: Quality, problems: &mut Vec<Problem>) -> Quality {
    let mut refused = |what: &str| problems.push(Problem::argument(format!("the look is 'studio': {what}")));
    for (name, text) in [(c"shadows", "shadows"), (c"ambientOcclusion", "ambientOcclusion")] {
        if renderer.is_set(name) {
            refused(&format!("{text} has no effect, its light is occluded already"));
        }
    }
    if quality != Quality::Paper {
        return quality;
    }
    refused("quality 'paper' has none, and 'standard' is used");
    Quality::Standard
}

/// The ambient light as radiance: red, green and blue.
fn sky_radiance(renderer: &Object) -> [f64; 3] {
    let (share, hue) = strength_and_hue(renderer.floats::<3>(c"ambientColor").unwrap_or([1.0; 3]));
    let radiance = (share * f64::from(renderer.float(c"ambientRadiance").unwrap_or(0.0))).min(Sky::STRENGTH.range()[1]);
    hue.map(|c| radiance * c)
}

/// Whether the scene leaves the light to the studio: it has none.
fn has_own_light(renderer: &Object, lights: Option<Lights>) -> bool {
    lights.is_none() && sky_radiance(renderer) == [0.0; 3]
}

/// The studio, whose sky is the ambient light.
fn studio(renderer: &Object, lights: Option<Lights>) -> Studio {
    let own = Studio::default();
    let radiance = sky_radiance(renderer);
    let even = Sky { top: radiance, bottom: radiance, strength: 1.0, ..own.sky.up_in(LightSpace::World) };
    Studio {
        sky: if has_own_light(renderer, lights) { own.sky } else { even },
        scattering: renderer.float(c"scattering").map_or(own.scattering, f64::from),
        exposure: renderer.float(c"exposure").map_or(own.exposure, f64::from),
        tone: renderer.text(c"tone").and_then(|name| name.parse().ok()).unwrap_or(own.tone),
    }
}

/// The lights of the studio. The library's light of strength 1 has an irradiance of pi there.
fn light_of_studio(renderer: &Object, lights: Option<Lights>) -> Shading {
    if has_own_light(renderer, lights) {
        return Studio::SHADING;
    }
    let none = Light { strength: 0.0, ..Light::AT_CAMERA };
    let lights = lights.map_or(vec![none], |lights| lights.as_slice().to_vec());
    let lights: Vec<Light> = lights.into_iter().map(|light| Light { strength: light.strength / PI, ..light }).collect();
    Shading { lights: Lights::new(&lights).unwrap_or_default(), ..Studio::SHADING }
}

fn background(objects: &Objects, renderer: &Object) -> Background {
    let image = renderer.object(c"background").and_then(|handle| objects.get(handle)?.array());
    match image {
        Some(array) => Background::Image { columns: array.dims[0], pixels: colors::decoded(array) },
        None => Background::Color(renderer.floats(c"background").unwrap_or([0.0, 0.0, 0.0, 1.0])),
    }
}
