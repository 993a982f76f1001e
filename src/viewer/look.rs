//! What the page can change besides the camera and the transfer function.

use super::look_fields::{PageChannel, PageLabels};
use super::page_light::{PageLight, PageStudio};
use crate::annotation::{Annotations, Legend};
use crate::camera::Camera;
use crate::choice::by_name;
use crate::error::Error;
use crate::image::Background;
use crate::layers::{GradientEstimator, Kernel};
use crate::settings::{
    Argument, Blend, ClipPlane, Clipping, CropBox, Light, LightSpace, Lights, Quality, Setting, Settings, Shadows, Studio,
};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Longest name and value of a plain setting.
const LONGEST_PLAIN: usize = 60;

/// The look of a picture. Names and ranges are those of the command's options.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Look {
    /// Quality of pictures at rest and saved ones; `None`: refined up to `high`.
    pub quality: Option<Quality>,
    /// Reconstruction kernel; `None`: by quality.
    pub kernel: Option<Kernel>,
    /// Blend mode, without the value of an iso-surface.
    #[serde(with = "by_name")]
    pub blend: Blend,
    /// Value of the iso-surface.
    pub iso: f64,
    /// Whether samples are lit.
    pub shading: bool,
    /// Lights; none: the default of the settings.
    pub lights: Vec<PageLight>,
    /// Whether lights, and the sky of the studio, move with the camera.
    pub lights_follow: bool,
    /// The studio; `None`: the plain look.
    pub studio: Option<PageStudio>,
    /// Shadows of the lights.
    pub shadows: bool,
    /// Share of the shadows, 0 … 1.
    pub shadow_strength: f64,
    /// Ambient occlusion.
    pub ambient_occlusion: bool,
    /// Colour `#rrggbb`, or `transparent`.
    pub background: String,
    /// Box in voxels: the lowest and the highest corner.
    pub crop: Option<[[f64; 3]; 2]>,
    /// Clip planes in world units: a point and a normal each.
    pub clips: Vec<[f64; 6]>,
    /// Estimation of gradients by its name on the command line; `None`: by algorithm.
    pub gradient: Option<String>,
    /// Plain settings that are not the default.
    pub plain: BTreeMap<String, Argument>,
    /// A colour bar, in parallel projections with a scale bar, over the picture.
    pub legend: bool,
    /// The bounding box.
    pub bounding_box: bool,
    /// The world axes.
    pub axes: bool,
    /// Step of a sequence, from 0; 0 for other volumes.
    pub frame: usize,
    /// How each of several fields is shown; none for one field.
    pub channels: Vec<PageChannel>,
    /// Changes of labels.
    pub labels: PageLabels,
}

impl Look {
    /// The look of settings. `iso` is the value that an iso-surface begins with, if there is none yet. Open sides of a crop box end with the
    /// field of a volume of `dims` voxels.
    pub fn of(settings: &Settings, background: Background, iso: f64, dims: [usize; 3]) -> Self {
        let lights = settings.shading.map_or_else(Lights::default, |shading| shading.lights);
        let is_default = lights == Lights::default() && settings.studio.is_none();
        let lights: &[Light] = if is_default { &[] } else { lights.as_slice() };
        let is_at_camera = |light: &Light| light.space == LightSpace::Camera || light.direction.is_none();
        let iso = if let Blend::Iso(value) = settings.blend { value } else { iso };
        let (least, most) = (DVec3::NEG_ONE, DVec3::from_array(dims.map(|n| n as f64)));
        let ends = |CropBox { lowest, highest }: CropBox| [lowest.max(least).to_array(), highest.min(most).to_array()];
        let crop = settings.clipping.crop.map(ends);
        let clip = |plane: &ClipPlane| {
            let ([x, y, z], [nx, ny, nz]) = (plane.point.to_array(), plane.normal.to_array());
            [x, y, z, nx, ny, nz]
        };
        Self {
            quality: None,
            kernel: None,
            blend: settings.blend.at(0.0),
            iso,
            shading: settings.shading.is_some(),
            lights: lights.iter().map(PageLight::of).collect(),
            lights_follow: settings.studio.map_or_else(
                || lights.iter().all(is_at_camera),
                |studio| studio.sky.space == LightSpace::Camera && lights.iter().all(is_at_camera),
            ),
            studio: settings.studio.as_ref().map(PageStudio::of),
            shadows: settings.shadows.is_some(),
            shadow_strength: settings.shadows.map_or(1.0, |shadows| shadows.strength),
            ambient_occlusion: settings.ambient_occlusion.is_some(),
            background: name_of(background),
            crop,
            clips: settings.clipping.planes.iter().flatten().map(clip).collect(),
            gradient: settings.gradient.map(|gradient| gradient.to_string()),
            plain: plain_of(settings),
            legend: false,
            bounding_box: false,
            axes: false,
            frame: 0,
            channels: Vec::new(),
            labels: PageLabels::default(),
        }
    }

    /// Settings with the plain ones of the look.
    ///
    /// # Errors
    /// For names and values that no plain setting has.
    pub(super) fn with_plain(&self, settings: Settings) -> Result<Settings, Error> {
        let default = Settings::default();
        let reset = Setting::plain().map(|setting| (setting.name, setting.get(&default)));
        let reset: Vec<_> = reset.filter(|(name, _)| !self.plain.contains_key(*name)).collect();
        let own = self.plain.iter().map(|(name, argument)| (name.as_str(), argument));
        settings.with_plain(reset.iter().map(|(name, argument)| (*name, argument)).chain(own))
    }

    /// The studio, where it is drawn: maximum, minimum and average are not lit.
    pub fn drawn_studio(&self) -> Option<PageStudio> {
        self.studio.filter(|_| !self.blend.gathers_values())
    }

    /// Whether the lights are those that a studio has by default, which move with the camera.
    pub fn has_light_of_studio(&self) -> bool {
        let own = Studio::SHADING.lights;
        self.studio.is_some()
            && self.lights_follow
            && self
                .lights
                .iter()
                .map(PageLight::light)
                .eq(own.as_slice().iter().map(|light| Light { space: LightSpace::World, ..*light }))
    }

    /// Whether directions are along the axes of the camera, so that lights and sky move with it.
    pub(crate) fn is_lit_from_camera(&self) -> bool {
        self.lights_follow && (self.studio.is_some() || self.lights.iter().any(|light| light.direction.is_some()))
    }

    /// Axes of the directions of lights and sky.
    pub(super) fn light_space(&self) -> LightSpace {
        if self.lights_follow { LightSpace::Camera } else { LightSpace::World }
    }

    /// The look whose lights and sky stay in the world where `camera` sees them.
    ///
    /// # Errors
    /// If the camera is invalid.
    pub fn with_light_in_world(mut self, camera: &Camera) -> Result<Self, Error> {
        if self.lights_follow {
            let basis = camera.basis()?;
            let directions = self.lights.iter_mut().filter_map(|light| light.direction.as_mut());
            let directions = directions.chain(self.studio.iter_mut().map(|studio| &mut studio.sky_up));
            directions.for_each(|direction| *direction = basis.in_world((*direction).into()).to_array());
            self.lights_follow = false;
        }
        Ok(self)
    }

    /// Annotations over the whole picture. `length_units`: the unit of length, if it is known. `list`: in place of the colour bar.
    pub(super) fn annotations(&self, length_units: Option<&str>, list: Option<Legend>) -> Annotations {
        let &Self { legend, bounding_box, axes, .. } = self;
        let length_units = length_units.map(str::to_owned);
        Annotations { legend, list, bounding_box, axes, length_units, ..Annotations::default() }
    }

    /// The crop box.
    pub(super) fn crop_box(&self) -> Option<CropBox> {
        self.crop.map(|[lowest, highest]| CropBox { lowest: lowest.into(), highest: highest.into() })
    }

    /// The clip planes.
    pub(super) fn planes(&self) -> impl Iterator<Item = ClipPlane> {
        let plane = |&[x, y, z, nx, ny, nz]: &[f64; 6]| ClipPlane { point: DVec3::new(x, y, z), normal: DVec3::new(nx, ny, nz) };
        self.clips.iter().map(plane)
    }

    /// Checks what the page can send wrong. Combinations are checked when settings are made.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for numbers outside their ranges, too many lights or planes, or an unknown colour.
    pub fn check(&self) -> Result<(), Error> {
        let refuse = |name, value: String, expected| Err(Error::OutOfRange { name, value, expected });
        if !self.lights.is_empty() {
            let lights: Vec<Light> = self.lights.iter().take(Lights::MOST + 1).map(PageLight::light).collect();
            Lights::new(&lights)?;
        }
        if self.clips.len() > Clipping::MAX_PLANES {
            return refuse("clipping", format!("{} planes", self.clips.len()), "at most 6 clip planes");
        }
        Clipping { crop: self.crop_box(), ..Clipping::default() }.with_planes(self.planes()).check()?;
        Shadows { strength: self.shadow_strength, ..Shadows::default() }.check()?;
        self.studio.map_or(Ok(()), |studio| studio.over(Studio::default(), LightSpace::World).check())?;
        Blend::Iso(self.iso).check()?;
        if let Some(gradient) = &self.gradient
            && gradient.parse::<GradientEstimator>().is_err()
        {
            let value = gradient.chars().take(20).collect();
            return refuse("gradient", value, "central, sobel, gaussian:SIGMA with SIGMA from 0.3 to 2, or own");
        }
        for (name, argument) in &self.plain {
            let words = format!("{name} {argument}");
            if words.len() > LONGEST_PLAIN {
                return refuse("look", words.chars().take(20).collect(), "names and values of settings");
            }
        }
        self.with_plain(Settings::default())?.check()?;
        self.check_fields()?;
        self.background().map(|_| ())
    }

    /// The background.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for unknown colours.
    pub fn background(&self) -> Result<Background, Error> {
        let name = &self.background;
        let is_known = name == "transparent" || (name.len() == 7 && name.starts_with('#'));
        let parsed = name.parse().ok().filter(|_| is_known);
        let value = || name.chars().take(20).collect();
        parsed.ok_or_else(|| Error::OutOfRange { name: "background", value: value(), expected: "transparent or #rrggbb" })
    }
}

fn plain_of(settings: &Settings) -> BTreeMap<String, Argument> {
    let default = Settings::default();
    let own = Setting::plain().map(|setting| (setting, setting.get(settings)));
    own.filter(|(setting, own)| *own != setting.get(&default)).map(|(setting, own)| (setting.name.into(), own)).collect()
}

/// `transparent`, or the nearest colour in 8 bits as `#rrggbb`.
fn name_of(background: Background) -> String {
    match background {
        Background::Transparent => "transparent".into(),
        Background::Color(color) => {
            let [r, g, b] = color.map(|c| (c * 255.0).round() as u8);
            format!("#{r:02x}{g:02x}{b:02x}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::WHITE;

    #[test]
    fn the_default_look_is_that_of_the_default_settings() {
        let look = Look::of(&Settings::default(), Background::BLACK, 7.0, [4; 3]);
        assert!(look.lights.is_empty() && look.shading && !look.shadows && look.iso == 7.0);
        assert_eq!(look.background, "#000000");
        look.check().unwrap();
        let text = serde_json::to_string(&look).unwrap();
        assert_eq!(serde_json::from_str::<Look>(&text).unwrap(), look);
    }

    #[test]
    fn bad_looks_are_refused() {
        let good = Look::of(&Settings::default(), Background::BLACK, 0.0, [4; 3]);
        let light = PageLight { direction: Some([0.0; 3]), strength: 1.0, angle: 0.0, color: WHITE };
        let studio = PageStudio::of(&Studio::default());
        let fine = PageLight { direction: None, ..light };
        let plain = |name: &str, argument: Argument| BTreeMap::from([(name.to_owned(), argument)]);
        for (what, bad) in [
            ("a direction of 0", Look { lights: vec![light], ..good.clone() }),
            ("five lights", Look { lights: vec![fine; 5], ..good.clone() }),
            ("a colour beyond 1", Look { lights: vec![PageLight { color: [2.0, 0.0, 0.0], ..fine }], ..good.clone() }),
            ("a strong light", Look { lights: vec![PageLight { strength: 1e9, ..fine }], ..good.clone() }),
            ("seven planes", Look { clips: vec![[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]; 7], ..good.clone() }),
            ("no normal", Look { clips: vec![[0.0; 6]], ..good.clone() }),
            ("an empty box", Look { crop: Some([[0.0; 3], [1.0, 0.0, 1.0]]), ..good.clone() }),
            ("no up", Look { studio: Some(PageStudio { sky_up: [0.0; 3], ..studio }), ..good.clone() }),
            ("scattering", Look { studio: Some(PageStudio { scattering: 2.0, ..studio }), ..good.clone() }),
            ("exposure", Look { studio: Some(PageStudio { exposure: f64::NAN, ..studio }), ..good.clone() }),
            ("strength", Look { shadow_strength: 1.1, ..good.clone() }),
            ("iso", Look { iso: f64::NAN, ..good.clone() }),
            ("gradient", Look { gradient: Some("gaussian:9".into()), ..good.clone() }),
            ("long gradient", Look { gradient: Some("x".repeat(1 << 16)), ..good.clone() }),
            ("an unknown setting", Look { plain: plain("blur", Argument::Switch(true)), ..good.clone() }),
            ("a setting that is not plain", Look { plain: plain("quality", Argument::Name("high".into())), ..good.clone() }),
            ("gamma", Look { plain: plain("gamma", Argument::Number(9.0)), ..good.clone() }),
            ("no number", Look { plain: plain("gamma", Argument::Name("x".repeat(1 << 16))), ..good.clone() }),
            ("colour", Look { background: "pink".into(), ..good.clone() }),
            ("long colour", Look { background: "x".repeat(1 << 16), ..good.clone() }),
        ] {
            let message = bad.check().expect_err(what).to_string();
            assert!(message.len() < 200, "{what}: {message}");
        }
    }
}
