//! Lighting of a frame: lights, gradient opacity and depth cueing.

use super::depth_cue::CuePlane;
use super::field::Field;
use super::light::{LightSources, ValueGrid};
use crate::device::launch::structs::{LightParams, LightVolumeParams};
use crate::layers::{AxisFrame, Rays};
use crate::settings::{GradientOpacity, Light, LightSpace, Lights, Settings, Shading, WHITE};
use crate::volume::Grid;
use glam::DVec3;

/// Shading that leaves colours unchanged, for frames with gradient opacity or depth cueing alone.
const UNLIT: Shading =
    Shading { ambient: 1.0, ambient_color: WHITE, diffuse: 0.0, specular: 0.0, power: 1.0, lights: Lights::AT_CAMERA };

/// The lighting of a field in one view. Directions are along the axes of the grid.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Lighting {
    shading: Shading,
    /// Directions of each light.
    directions: Vec<LightDirections>,
    /// Gradient opacity, for gradients in value ranges per voxel of the smallest spacing.
    gradient_opacity: Option<GradientOpacity>,
    depth_cue: Option<CuePlane>,
    /// Shadows and ambient occlusion.
    sources: Option<LightSources>,
    to_eye: DVec3,
    needs_gradients: bool,
}

/// Unit vectors of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LightDirections {
    to_light: DVec3,
    /// Half vector between the directions to the light and to the eye.
    half_way: DVec3,
}

impl LightDirections {
    fn new(light: &Light, grid: &Grid, rays: &Rays) -> Self {
        let to_eye = rays.to_eye;
        let to_light = light.direction.map_or(to_eye, |l| match light.space {
            LightSpace::World => grid.world_to_grid_axes() * l.normalize(),
            LightSpace::Camera => rays.from_camera_axes(l.normalize()),
        });
        Self { to_light, half_way: (to_light + to_eye).normalize_or(to_eye) }
    }

    fn local(&self, frame: AxisFrame) -> [[f32; 3]; 2] {
        [self.to_light, self.half_way].map(|v| frame.local(v).as_vec3().to_array())
    }
}

impl Lighting {
    /// The lighting of a field seen along `rays`.
    pub fn new(settings: &Settings, field: &Field, rays: &Rays) -> Self {
        let shading = settings.shading.unwrap_or(UNLIT);
        Self {
            sources: Self::sources_in(settings, field.grid(), rays),
            // In the studio colours are all that is reflected.
            shading: if settings.studio.is_some() { Shading { diffuse: 1.0, ..shading } } else { shading },
            directions: Self::directions(settings, field.grid(), rays),
            gradient_opacity: settings.gradient_opacity.map(|opacity| opacity.times(field.gradient_per_value())),
            depth_cue: CuePlane::new(settings, field, rays),
            to_eye: rays.to_eye,
            needs_gradients: settings.looks_at_gradients(),
        }
    }

    fn directions(settings: &Settings, grid: &Grid, rays: &Rays) -> Vec<LightDirections> {
        let lights = settings.shading.unwrap_or(UNLIT).lights;
        lights.as_slice().iter().map(|light| LightDirections::new(light, grid, rays)).collect()
    }

    /// The light volumes of a grid seen along `rays`, if any.
    pub fn sources_in(settings: &Settings, grid: &Grid, rays: &Rays) -> Option<LightSources> {
        let directions = Self::directions(settings, grid, rays);
        LightSources::new(settings, grid, directions.iter().map(|light| light.to_light), rays)
    }

    /// Looks light up in these layers of the volumes.
    pub fn set_light_grids(&mut self, grids: [Option<ValueGrid>; 2]) {
        self.sources.iter_mut().for_each(|sources| sources.set_grids(grids));
    }

    /// Lights the surfaces of labels.
    pub fn set_surfaces(&mut self) {
        self.sources.iter_mut().for_each(LightSources::set_surfaces);
    }

    /// Lights samples that lie on surfaces.
    pub fn set_solid(&mut self) {
        self.sources.iter_mut().for_each(LightSources::set_solid);
    }

    /// The light volumes that samples look up, if any.
    pub fn sources(&self) -> Option<&LightSources> {
        self.sources.as_ref()
    }

    /// Kernel argument, in the axes of `frame`.
    pub fn params(&self, frame: AxisFrame) -> LightParams {
        let Shading { ambient, diffuse, specular, power, .. } = self.shading;
        let lights = self.shading.lights.as_slice();
        let narrow = |color: [f64; 3]| color.map(|c| c as f32);
        let strength = |share: f64, light: &Light| (share * light.strength) as f32;
        let [direction, half_way] = self.directions[0].local(frame);
        let further = std::array::from_fn(|i| {
            let Some((light, directions)) = lights.get(i + 1).zip(self.directions.get(i + 1)) else { return [0.0; 8] };
            let [[u, v, a], [half_u, half_v, half_a]] = directions.local(frame);
            [u, v, a, half_u, half_v, half_a, strength(diffuse, light), strength(specular, light)]
        });
        let (least_thinned, rises) = self.gradient_opacity.map(|opacity| opacity.rises()).unwrap_or_default();
        LightParams {
            shading: i32::from(self.needs_gradients),
            direction,
            half_way,
            ambient: ambient as f32,
            diffuse: strength(diffuse, &lights[0]),
            specular: strength(specular, &lights[0]),
            power: power as f32,
            more_lights: lights.len() as i32 - 1,
            lights: further,
            colors: std::array::from_fn(|i| lights.get(i).map_or([0.0; 3], |light| narrow(light.color))),
            ambient_color: narrow(self.shading.ambient_color),
            unshaded_color: narrow(self.shading.unshaded_color()),
            thinned: i32::from(self.gradient_opacity.is_some()),
            least_thinned: least_thinned as f32,
            rises: rises.map(|rise| rise.map(|number| number.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32)),
            cue: self.depth_cue.map_or([0.0; 3], |plane| frame.local(plane.slope).as_vec3().to_array()),
            cue_at_origin: self.depth_cue.map_or(0.0, |plane| plane.at_origin as f32),
            cue_strength: self.depth_cue.map_or(0.0, |plane| plane.cue.strength as f32),
            cue_color: self.depth_cue.map_or([0.0; 3], |plane| plane.cue.color.map(|c| c as f32)),
            light_volume: self
                .sources
                .as_ref()
                .map_or(LightVolumeParams::NONE, |sources| sources.params(&self.shading, frame, self.to_eye)),
        }
    }
}
