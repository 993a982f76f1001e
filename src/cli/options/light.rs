//! Options for lights, shadows and ambient occlusion.

use crate::camera::Up;
use crate::cli::values::Reach;
use crate::cli::{names, parse};
use crate::settings::{
    AmbientOcclusion, Light, LightGrid, LightSpace, Lights, Look, Settings, Shading, Shadows, Sky, Studio, Tone,
};
use clap::Args;
use glam::DVec3;

#[derive(Args, Clone)]
#[command(next_help_heading = "Light")]
pub(in crate::cli) struct LightOptions {
    /// How the picture is lit: plain, by the options of shading and shadows, or studio, by a sky and lights whose light scatters in the volume
    #[arg(long, value_name = "NAME", value_parser = names::of::<Look>())]
    pub(super) look: Option<Look>,
    /// Light from all around in the studio: one colour, or those above and below, with a strength (1)
    #[arg(long, value_parser = parse::sky, value_name = "COLOR[,COLOR][:S]")]
    pub(super) sky: Option<Sky>,
    /// Where up is for the sky of the studio [default: that of the volume (--up) with --sky, upwards in the picture without]
    #[arg(long, value_parser = parse::vector, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(super) sky_up: Option<DVec3>,
    /// Factor of the light that scatters again in the studio, 0 to 1 [default: 0.95]
    #[arg(long, value_parser = parse::number(Studio::SCATTERING), value_name = "F", allow_hyphen_values = true)]
    pub(super) scattering: Option<f64>,
    /// Exposure of the studio in stops, for pictures of 8 and 16 bits [default: 0]
    #[arg(long, value_parser = parse::number(Studio::EXPOSURE), value_name = "STOPS", allow_hyphen_values = true)]
    pub(super) exposure: Option<f64>,
    /// Curve of bright colours of the studio, for pictures of 8 and 16 bits [default: shoulder]
    #[arg(long, value_name = "NAME", value_parser = names::of::<Tone>())]
    pub(super) tone: Option<Tone>,
    /// Gradient shading
    #[arg(long, value_parser = parse::switch, value_name = "on|off")]
    pub(super) shading: Option<bool>,
    /// Light from a direction, or from the camera, with strength S (1), angular diameter (0) and colour (white). Repeatable, up to 4
    /// [default: camera; with shadows -1,1,1 in camera space; in the studio a key light and a rim light beside the camera]
    #[arg(long, value_parser = parse::light, value_name = "X,Y,Z[:S[:DEGREES]][:COLOR]", allow_hyphen_values = true)]
    pub(super) light: Vec<Light>,
    /// Colour of the ambient light: white, grey, #rrggbb or R,G,B [default: white]
    #[arg(long, value_parser = parse::color, value_name = "COLOR")]
    pub(super) ambient_color: Option<[f64; 3]>,
    /// Axes of --light and --sky-up: world, or camera (right, up, towards the viewer), in which lights move with the camera
    /// [default: world]
    #[arg(long, value_name = "NAME", value_parser = names::of::<LightSpace>())]
    pub(super) light_space: Option<LightSpace>,
    /// Shadows of the lights
    #[arg(long, value_parser = parse::switch, value_name = "on|off")]
    pub(super) shadows: Option<bool>,
    /// Share of the shadows, 0 to 1 [default: 1]
    #[arg(long, value_parser = parse::number(Shadows::STRENGTH), value_name = "SHARE", allow_hyphen_values = true)]
    pub(super) shadow_strength: Option<f64>,
    /// Factor of the light in shadows, at most full light; 1 is physically exact, and dark [default: 4]
    #[arg(long, value_parser = parse::number(Shadows::FORGIVENESS), value_name = "F", allow_hyphen_values = true)]
    pub(super) shadow_forgiveness: Option<f64>,
    /// Dim the ambient light where little of the surroundings is open
    #[arg(long, value_parser = parse::switch, value_name = "on|off")]
    pub(super) ambient_occlusion: Option<bool>,
    /// World distance over which ambient occlusion decreases to 1/e [default: inf]
    #[arg(long, value_parser = parse::reach, value_name = "inf|LENGTH", allow_hyphen_values = true)]
    pub(super) ao_reach: Option<Reach>,
    /// Resolution of shadows, ambient occlusion and scattered light; quarter is half for shadows [default: full]
    #[arg(long, value_name = "NAME", value_parser = names::of::<LightGrid>())]
    pub(super) light_grid: Option<LightGrid>,
}

impl LightOptions {
    /// Settings with these options applied.
    ///
    /// # Errors
    /// [`crate::Error::Settings`] for options without effect.
    pub fn apply(&self, settings: Settings) -> Result<Settings, crate::Error> {
        let refuse = |field, problem: &str| Err(crate::Error::Settings { field, problem: problem.into() });
        let settings = settings.with_look(self.look.unwrap_or(settings.look()));
        self.check_look(settings.look())?;
        let shadows = self.shadows.unwrap_or(false);
        let occlusion = self.ambient_occlusion.unwrap_or(false);
        if !shadows && self.shadow_strength.is_some() {
            return refuse("shadow_strength", "shadows are off: omit it, or enable shadows");
        }
        if !shadows && self.shadow_forgiveness.is_some() {
            return refuse("shadow_forgiveness", "shadows are off: omit it, or enable shadows");
        }
        if !occlusion && self.ao_reach.is_some() {
            return refuse("ao_reach", "ambient occlusion is off: omit it, or enable ambient occlusion");
        }
        if !(shadows || occlusion || settings.studio.is_some()) && self.light_grid.is_some() {
            return refuse("light_grid", "shadows and ambient occlusion are off: omit it, or enable one of them");
        }
        let own = Shadows::default();
        Ok(Settings {
            shading: self.shading(&settings)?,
            studio: settings.studio.map(|studio| self.studio(studio)),
            shadows: shadows.then(|| Shadows {
                strength: self.shadow_strength.unwrap_or(own.strength),
                forgiveness: self.shadow_forgiveness.unwrap_or(own.forgiveness),
            }),
            ambient_occlusion: occlusion
                .then(|| AmbientOcclusion { reach: self.ao_reach.and_then(|reach| reach.0), ..AmbientOcclusion::default() }),
            light_grid: self.light_grid.unwrap_or(settings.light_grid),
            ..settings
        })
    }

    /// Settings whose sky has up where the volume has it, if a sky was given in the world, and not where up is in it.
    pub fn with_sky_of(&self, mut settings: Settings, up: Up) -> Settings {
        if let (Some(_), None, Some(Studio { sky, .. })) = (self.sky, self.sky_up, &mut settings.studio)
            && sky.space == LightSpace::World
        {
            sky.up = up.direction();
        }
        settings
    }

    /// Whether the caller wants lights that move with the camera.
    pub fn moves_with_camera(&self) -> bool {
        self.light_space == Some(LightSpace::Camera)
    }

    /// Rejects options of the other look.
    fn check_look(&self, look: Look) -> Result<(), crate::Error> {
        let of_studio = [
            ("sky", self.sky.is_some()),
            ("sky_up", self.sky_up.is_some()),
            ("scattering", self.scattering.is_some()),
            ("exposure", self.exposure.is_some()),
            ("tone", self.tone.is_some()),
        ];
        let of_plain = [
            ("shading", self.shading.is_some()),
            ("ambient_color", self.ambient_color.is_some()),
            ("shadows", self.shadows.is_some()),
            ("ambient_occlusion", self.ambient_occlusion.is_some()),
        ];
        let (others, problem) = match look {
            Look::Plain => (&of_studio[..], "belongs to the studio: omit it, or choose the look studio"),
            Look::Studio => (&of_plain[..], "belongs to the plain look, and the studio has light of its own: omit it"),
        };
        match others.iter().find(|(_, is_given)| *is_given) {
            Some((field, _)) => Err(crate::Error::Settings { field, problem: problem.into() }),
            None => Ok(()),
        }
    }

    fn studio(&self, own: Studio) -> Studio {
        let space = self.light_space.unwrap_or_default();
        let sky = self.sky.map_or(own.sky, |sky| sky.up_in(space));
        let sky = self.sky_up.map_or(sky, |up| Sky { up, space, ..sky });
        Studio {
            sky,
            scattering: self.scattering.unwrap_or(own.scattering),
            tone: self.tone.unwrap_or(own.tone),
            exposure: self.exposure.unwrap_or(own.exposure),
        }
    }

    /// The preset's shading with the options applied.
    fn shading(&self, settings: &Settings) -> Result<Option<Shading>, crate::Error> {
        let shading = self.shading.map_or(settings.shading, |on| on.then(Shading::default));
        let Some(shading) = shading else {
            let refuse = |field, problem: &str| Err(crate::Error::Settings { field, problem: problem.into() });
            return match (&self.light[..], self.ambient_color) {
                ([], None) => Ok(None),
                ([], _) => refuse("ambient_color", "shading is off: omit the colour, or enable shading"),
                _ => refuse("light", "shading is off: omit the light, or enable shading"),
            };
        };
        let lights = match &self.light[..] {
            [] => Shading::default_of(settings.look(), self.shadows == Some(true)).lights,
            given => Lights::new(&given.iter().map(|&light| self.placed(light)).collect::<Vec<_>>())?,
        };
        Ok(Some(Shading { lights, ambient_color: self.ambient_color.unwrap_or(shading.ambient_color), ..shading }))
    }

    fn placed(&self, light: Light) -> Light {
        let space = self.light_space.unwrap_or_default();
        if light.direction.is_some() { Light { space, ..light } } else { light }
    }
}
