//! Shading, lights, shadows and ambient occlusion.

use super::{Light, Settings, flag};
use crate::boundary::Failure;
use crate::choices::chosen;
use layersplat::glam::DVec3;
use layersplat::settings::{self, AmbientOcclusion, LightSpace, Lights, Look, Shading, Shadows, Sky, Studio};

impl Settings {
    pub(super) fn shading(&self) -> Result<Option<Shading>, Failure> {
        let Self { ambient, ambient_color, diffuse, .. } = *self;
        let (specular, power) = match chosen::<Look>(self.look)? {
            Look::Plain => (self.specular, self.power),
            Look::Studio => (self.studio_specular, self.studio_power),
        };
        let lights = self.lights()?;
        Ok(flag("lit", self.lit)?.then_some(Shading { ambient, ambient_color, diffuse, specular, power, lights }))
    }

    pub(super) fn studio(&self) -> Result<Option<Studio>, Failure> {
        let Self { sky_top: top, sky_bottom: bottom, sky_strength: strength, scattering, exposure, .. } = *self;
        let space = if self.light_count == 0 { LightSpace::Camera } else { self.light_space()? };
        let sky = Sky { top, bottom, strength, ..Sky::default().up_in(space) };
        let studio = Studio { sky, scattering, tone: chosen(self.tone)?, exposure };
        Ok((chosen::<Look>(self.look)? == Look::Studio).then_some(studio))
    }

    fn light_space(&self) -> Result<LightSpace, Failure> {
        Ok(if flag("lights_in_camera_space", self.lights_in_camera_space)? { LightSpace::Camera } else { LightSpace::World })
    }

    pub(super) fn shadows(&self) -> Result<Option<Shadows>, Failure> {
        let Self { shadow_strength: strength, shadow_forgiveness: forgiveness, .. } = *self;
        Ok(flag("shadows", self.shadows)?.then_some(Shadows { strength, forgiveness }))
    }

    pub(super) fn ambient_occlusion(&self) -> Result<Option<AmbientOcclusion>, Failure> {
        let reach = Some(self.ao_reach).filter(|&reach| reach != 0.0 && reach != f64::INFINITY);
        let occlusion = AmbientOcclusion { reach, gain: self.ao_gain };
        Ok(flag("ambient_occlusion", self.ambient_occlusion)?.then_some(occlusion))
    }

    fn lights(&self) -> Result<Lights, Failure> {
        let Some(lights) = usize::try_from(self.light_count).ok().and_then(|count| self.lights.get(..count)) else {
            return Err(Failure::invalid(format!("light_count is {}: expected 0 to {}", self.light_count, self.lights.len())));
        };
        let space = self.light_space()?;
        let light = |((&Light { direction, strength }, &angle), &color): ((&Light, &f64), &[f64; 3])| {
            let direction = Some(DVec3::from_array(direction)).filter(|&direction| direction != DVec3::ZERO);
            // A light at the camera has no direction whose axes could matter.
            let space = direction.map_or(LightSpace::World, |_| space);
            settings::Light { direction, space, strength, angle, color }
        };
        let lights: Vec<_> = lights.iter().zip(&self.light_angles).zip(&self.light_colors).map(light).collect();
        let default = || Shading::default_of(chosen(self.look).unwrap_or_default(), self.shadows == 1).lights;
        Ok(if lights.is_empty() { default() } else { Lights::new(&lights)? })
    }
}
