//! All settings by name. Clients read them from here, and say here what was set.

use super::argument::{Argument, Stated};
use super::arguments::{of_algorithm, of_shading, shading_from};
use super::{
    Algorithm, AlgorithmOptions, Classification, Evaluation, LayerAxis, Layered, Light, LightGrid, LightSpace, Lights, Look,
    Number, Quality, Settings, Shading, Studio, Tone,
};
use crate::choice::{Choice, in_words};
use crate::error::Error;
use crate::layers::{Density, Kernel};
use crate::transfer::Extinction;

/// A setting: one argument of [`Settings::from_arguments`].
///
/// ```
/// use layersplat::settings::{Argument, Setting, Settings};
///
/// let stop = Setting::named("early_termination").unwrap();
/// assert_eq!(stop.get(&Settings::default()), Argument::Switch(true));
/// let settings = Settings::from_arguments([("early_termination", Argument::Switch(false))])?;
/// assert!(!settings.early_termination);
/// # Ok::<(), layersplat::Error>(())
/// ```
pub struct Setting {
    /// Name of the argument. Options of the command have `-` for `_`.
    pub name: &'static str,
    /// What it does, in a line.
    pub help: &'static str,
    /// What values it takes.
    pub kind: Kind,
    /// The option of the command, if clients make their options and controls of this description alone: a plain setting.
    pub option: Option<&'static str>,
    get: fn(&Settings) -> Argument,
    set: fn(&mut Draft, &'static str, &Argument) -> Result<(), Error>,
}

/// What values a setting takes.
#[derive(Clone, Copy)]
pub enum Kind {
    /// On or off.
    Switch,
    /// One of these names.
    Choice(fn() -> Vec<&'static str>),
    /// A number, or nothing.
    Number(Number),
    /// A whole number.
    Whole,
    /// Several values: see [`Settings::from_arguments`].
    Structure,
}

impl Kind {
    const fn choice<T: Choice>() -> Self {
        Kind::Choice(|| T::ALL.iter().map(|choice| choice.name()).collect())
    }
}

/// Settings, while arguments are read. Arguments whose meaning depends on others wait for them.
#[derive(Default)]
struct Draft {
    settings: Settings,
    algorithm: Algorithm,
    quality: Quality,
    samples_per_layer: Option<u32>,
    density: Option<u32>,
    options: AlgorithmOptions,
    look: Look,
    studio: Studio,
    shading: Option<Argument>,
    has_lights: bool,
    light_space: LightSpace,
    /// Names of the arguments that were read.
    given: Vec<&'static str>,
}

/// A setting whose field has all of its value.
macro_rules! field {
    ($name:literal, $help:literal, $kind:expr, $option:expr, $($field:ident).+) => {
        Setting {
            name: $name,
            help: $help,
            kind: $kind,
            option: $option,
            get: |settings| settings.$($field).+.argument(),
            set: |draft, name, argument| {
                draft.settings.$($field).+ = argument.value(name)?;
                Ok(())
            },
        }
    };
}

/// A setting of the algorithm.
macro_rules! of_algorithm {
    ($name:literal, $help:literal, $kind:expr, $($field:ident).+) => {
        Setting {
            name: $name,
            help: $help,
            kind: $kind,
            option: None,
            get: |settings| {
                let found = of_algorithm(settings.algorithm).into_iter().find(|(name, _)| *name == $name);
                found.map_or(Argument::Nothing, |(_, argument)| argument)
            },
            set: |draft, name, argument| {
                draft.$($field).+ = argument.value(name)?;
                Ok(())
            },
        }
    };
}

/// A setting of the studio.
macro_rules! of_studio {
    ($name:literal, $help:literal, $kind:expr, $field:ident) => {
        Setting {
            name: $name,
            help: $help,
            kind: $kind,
            option: None,
            get: |settings| match settings.studio {
                Some(studio) if studio.$field != Studio::default().$field => studio.$field.argument(),
                _ => Argument::Nothing,
            },
            set: |draft, name, argument| {
                draft.studio.$field = argument.value(name)?;
                Ok(())
            },
        }
    };
}

/// The shading that settings have if nothing is given.
fn default_shading(settings: &Settings) -> Shading {
    Shading::default_of(settings.look(), settings.shadows.is_some())
}

impl Setting {
    /// All settings.
    #[rustfmt::skip]
    pub const ALL: [Self; 29] = [
        of_algorithm!("algorithm", "Rendering algorithm", Kind::choice::<Algorithm>(), algorithm),
        of_algorithm!("quality", "Preset of layered rendering", Kind::choice::<Quality>(), quality),
        of_algorithm!("kernel", "Reconstruction kernel", Kind::choice::<Kernel>(), options.kernel),
        of_algorithm!("samples_per_layer", "Samples per layer", Kind::Whole, samples_per_layer),
        of_algorithm!("density", "Samples per voxel of the lattice", Kind::Whole, density),
        of_algorithm!("layer_axis", "Axis of the layers", Kind::choice::<LayerAxis>(), options.layer_axis),
        of_algorithm!("step", "Step of slicing or ray casting", Kind::Number(Algorithm::STEP), options.step),
        of_algorithm!("sheet_distance", "Distance between sheets", Kind::Number(Algorithm::SHEET_DISTANCE), options.sheet_distance),
        field!("blend", "How values along a ray combine", Kind::Structure, None, blend),
        Setting {
            name: "shading",
            help: "Gradient shading",
            kind: Kind::Structure,
            option: None,
            get: |settings| of_shading(settings.shading, default_shading(settings)),
            set: |draft, name, argument| {
                argument.value::<Option<Shading>>(name)?;
                draft.shading = Some(argument.clone());
                draft.has_lights = matches!(argument, Argument::Fields(fields) if fields.iter().any(|(key, _)| key == "light"));
                Ok(())
            },
        },
        Setting {
            name: "light_space",
            help: "Axes of directions of lights",
            kind: Kind::choice::<LightSpace>(),
            option: None,
            get: |settings| {
                let default = default_shading(settings).lights;
                let lights = settings.shading.map(|shading| shading.lights).filter(|&lights| lights != default);
                let follows = |lights: Lights| lights.as_slice().iter().any(|light| light.space == LightSpace::Camera);
                (if lights.is_some_and(follows) { LightSpace::Camera } else { LightSpace::World }).argument()
            },
            set: |draft, name, argument| {
                draft.light_space = argument.value(name)?;
                Ok(())
            },
        },
        Setting {
            name: "look",
            help: "How the picture is lit",
            kind: Kind::choice::<Look>(),
            option: None,
            get: |settings| settings.look().argument(),
            set: |draft, name, argument| {
                draft.look = argument.value(name)?;
                Ok(())
            },
        },
        of_studio!("sky", "Light from all around", Kind::Structure, sky),
        of_studio!("scattering", "Factor of the light that scatters again", Kind::Number(Studio::SCATTERING), scattering),
        of_studio!("exposure", "Exposure of pictures of 8 and 16 bits in stops", Kind::Number(Studio::EXPOSURE), exposure),
        of_studio!("tone", "Curve of bright colours", Kind::choice::<Tone>(), tone),
        field!("shadows", "Shadows of the lights", Kind::Structure, None, shadows),
        field!("ambient_occlusion", "Dim the ambient light where little of the surroundings is open", Kind::Structure, None, ambient_occlusion),
        field!("light_grid", "Resolution of shadows and ambient occlusion", Kind::choice::<LightGrid>(), None, light_grid),
        field!("gradient", "Estimation of gradients", Kind::Structure, None, gradient),
        field!("gradient_opacity", "Opacity factors at gradient magnitudes", Kind::Structure, None, gradient_opacity),
        field!("depth_cue", "Fade colours with their distance", Kind::Structure, None, depth_cue),
        field!("crop", "Show only this box", Kind::Structure, None, clipping.crop),
        field!("planes", "Show only the sides of planes that their normals point to", Kind::Structure, None, clipping.planes),
        field!("unit_distance", "Thickness in world units at which the given opacity applies [default: the smallest spacing, of the finest level]",
            Kind::Number(Settings::UNIT_DISTANCE), Some("unit-distance"), unit_distance),
        field!("extinction", "How opacity grows with the length of a ray segment", Kind::choice::<Extinction>(), Some("extinction"), extinction),
        field!("early_termination", "Stop tiles once all their rays are opaque", Kind::Switch, Some("early-termination"), early_termination),
        field!("gamma", "Raise colours to 1/N in pictures of 8 and 16 bits, 0.2 to 5; above 1 brightens; .exr and .npy stay linear [default: 1]",
            Kind::Number(Settings::GAMMA), Some("gamma"), gamma),
        field!("pixel_aspect", "Width of a pixel in heights of a pixel", Kind::Number(Settings::PIXEL_ASPECT), None, pixel_aspect),
    ];

    /// The setting with this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        const { &Setting::ALL }.iter().find(|setting| setting.name == name)
    }

    /// The plain settings.
    pub fn plain() -> impl Iterator<Item = &'static Self> {
        const { &Setting::ALL }.iter().filter(|setting| setting.option.is_some())
    }

    /// The value that settings have. Nothing, if it is the default of the algorithm.
    pub fn get(&self, settings: &Settings) -> Argument {
        (self.get)(settings)
    }
}

impl Settings {
    /// The arguments that make equal settings, without those that are the default. Layers that no argument describes are those of the
    /// quality that resembles them.
    pub fn arguments(&self) -> Vec<(&'static str, Argument)> {
        let default = Settings::default();
        let own = Setting::ALL.iter().map(|setting| (setting.name, setting.get(self), setting.get(&default)));
        own.filter(|(_, own, default)| own != default).map(|(name, own, _)| (name, own)).collect()
    }

    /// The settings that arguments state. [`Argument::Nothing`] is the default.
    ///
    /// # Errors
    /// [`Error::Argument`], [`Error::UnknownName`], [`Error::Settings`] or [`Error::OutOfRange`], which name the argument.
    pub fn from_arguments<Name: AsRef<str>>(arguments: impl IntoIterator<Item = (Name, Argument)>) -> Result<Self, Error> {
        let mut draft = Draft::default();
        for (name, argument) in arguments {
            let name = name.as_ref();
            let setting = Setting::named(name).ok_or_else(|| unknown(name, Setting::ALL.iter()))?;
            if argument != Argument::Nothing {
                (setting.set)(&mut draft, setting.name, &argument)?;
                draft.given.push(setting.name);
            }
        }
        draft.settings()
    }

    /// These settings with other values of plain settings.
    ///
    /// # Errors
    /// As [`Settings::from_arguments`]; [`Error::UnknownName`] for settings that are not plain.
    pub fn with_plain<'a>(self, arguments: impl IntoIterator<Item = (&'a str, &'a Argument)>) -> Result<Self, Error> {
        let mut draft = Draft { settings: self, ..Draft::default() };
        for (name, argument) in arguments {
            let setting = Setting::plain().find(|setting| setting.name == name).ok_or_else(|| unknown(name, Setting::plain()))?;
            (setting.set)(&mut draft, setting.name, argument)?;
        }
        Ok(draft.settings)
    }
}

fn unknown<'a>(name: &str, known: impl Iterator<Item = &'a Setting>) -> Error {
    Error::UnknownName { what: "setting", name: name.into(), known: in_words(known.map(|setting| setting.name)) }
}

impl Draft {
    fn settings(mut self) -> Result<Settings, Error> {
        self.settings.algorithm = self.algorithm()?;
        self.settings.studio = (self.look == Look::Studio).then_some(self.studio);
        if let Some(name) = ["sky", "scattering", "exposure", "tone"].into_iter().find(|name| self.given.contains(name))
            && self.look == Look::Plain
        {
            let problem = "belongs to the studio: omit it, or choose the look studio";
            return Err(Error::Settings { field: name, problem: problem.into() });
        }
        let default = default_shading(&self.settings);
        self.settings.shading = match &self.shading {
            Some(argument) => shading_from(argument, default)?,
            None => Some(default),
        };
        if let Some(shading) = &mut self.settings.shading {
            // A light at the camera has no direction whose axes could matter.
            let space = |light: &Light| light.direction.map_or(LightSpace::World, |_| self.light_space);
            let placed: Vec<_> = shading.lights.as_slice().iter().map(|light| Light { space: space(light), ..*light }).collect();
            shading.lights = if self.has_lights { Lights::new(&placed)? } else { default.lights };
        }
        Ok(self.settings)
    }

    /// The algorithm with its options. Rejects options of other algorithms.
    fn algorithm(&self) -> Result<Algorithm, Error> {
        if let Algorithm::Layered(_) = self.algorithm {
            return Algorithm::from(self.layered()?).with(self.options);
        }
        let of_layers = ["quality", "samples_per_layer", "density"];
        self.algorithm.reject(&of_layers.map(|name| (name, self.given.contains(&name))))?;
        self.algorithm.with(self.options)
    }

    /// The options of the quality, overridden by explicit ones.
    fn layered(&self) -> Result<Layered, Error> {
        let refuse = |field, problem: &str| Err(Error::Settings { field, problem: problem.into() });
        let mut layered = self.quality.layered();
        match &mut layered.classification {
            Classification::Preintegrated { samples_per_layer, .. } => {
                *samples_per_layer = self.samples_per_layer.unwrap_or(*samples_per_layer);
                layered.adapts_to_opacity = self.samples_per_layer.is_none();
            }
            Classification::Post(_) => {
                if let Some(field) = ["kernel", "samples_per_layer"].into_iter().find(|name| self.given.contains(name)) {
                    return refuse(field, "this quality uses the paper's own: leave it out, or choose another quality");
                }
            }
        }
        match (self.density, layered.evaluation) {
            (None, _) => {}
            (Some(density), Evaluation::Lattice(_)) => layered.evaluation = Evaluation::Lattice(Density::Fixed(density)),
            (Some(_), Evaluation::Direct) => {
                return refuse("density", "this quality has no lattice: leave it out, or choose another quality");
            }
        }
        Ok(layered)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layers::GradientEstimator;
    use crate::settings::{AmbientOcclusion, Blend, ClipPlane, Clipping, CropBox, DepthCue, GradientOpacity, Shadows, Sky};
    use glam::DVec3;

    fn pick<T: Clone>(values: &[T], random: &mut u64) -> T {
        // Knuth's generator; its upper bits are good.
        *random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        values[(*random >> 33) as usize % values.len()].clone()
    }

    /// Settings of any kind. All fields are named: one that is new needs an argument.
    fn settings(random: &mut u64) -> Settings {
        let algorithm = match pick(&Algorithm::ALL, random) {
            Algorithm::Layered(_) => {
                let mut layered = pick(&Quality::ALL, random).layered();
                if let Classification::Preintegrated { kernel, samples_per_layer } = &mut layered.classification {
                    *kernel = pick(&Kernel::OF_LAYERS, random);
                    layered.adapts_to_opacity = pick(&[true, false], random);
                    *samples_per_layer = if layered.adapts_to_opacity { *samples_per_layer } else { pick(&[1, 2, 5], random) };
                    let density = Density::Fixed(pick(&[2, 3], random));
                    layered.evaluation = pick(&[layered.evaluation, Evaluation::Lattice(density)], random);
                }
                Layered { layer_axis: pick(LayerAxis::ALL, random), ..layered }.into()
            }
            Algorithm::Raycast { .. } => Algorithm::Raycast { kernel: pick(&Kernel::ALL, random), step: 0.3 },
            other => pick(&[other, other.along(LayerAxis::ALL[2])], random),
        };
        let (lit, own) = (Shading::default(), Shadows::default());
        let light = Light { strength: 1.0 / 3.0, angle: 7.0, ..Light::from_camera(DVec3::new(1.0, -1.0 / 3.0, 2.0)) };
        let tinted = Light { color: [0.1, 1.0 / 3.0, 1.0], ..light };
        let lights = [&[light][..], &[tinted, Light::AT_CAMERA], &[Light { angle: 0.0, ..light }; 4]];
        let lights = pick(&lights.map(|lights| Lights::new(lights).unwrap()), random);
        let shadows = pick(&[None, Some(own), Some(Shadows { strength: 1.0 / 7.0, forgiveness: 9.0 })], random);
        let half = Studio { scattering: 0.5, exposure: 1.5, tone: Tone::None, ..Studio::default() };
        let sky = Sky { top: [0.1, 1.0 / 3.0, 9.0], strength: 0.7, space: LightSpace::World, ..Sky::default() };
        let studio = pick(&[None, Some(Studio::default()), Some(half), Some(Studio { sky, ..half })], random);
        let look = studio.map_or(Look::Plain, |_| Look::Studio);
        let default_lights = Shading::default_of(look, shadows.is_some()).lights;
        let shadings = [
            None,
            Some(Shading { lights, ..lit }),
            Some(Shading { lights: default_lights, ..lit }),
            Some(Shading { ambient: 0.1, power: 3.5, ambient_color: [0.5, 0.25, 0.1], lights: default_lights, ..lit }),
            Some(Shading { diffuse: 1.0 / 3.0, specular: 9.0, lights, ..lit }),
        ];
        let crop = CropBox { lowest: DVec3::splat(f64::NEG_INFINITY), highest: DVec3::new(1.0 / 3.0, 4.0, 99.0) };
        let plane = ClipPlane { point: DVec3::ONE, normal: DVec3::new(0.0, -2.0, 1e-3) };
        let clipping = [Clipping::default(), Clipping { crop: Some(crop), ..Clipping::default() }.with_planes([plane; 3])];
        let edges = GradientOpacity::new(&[(0.1, 1.0), (1.0 / 3.0, 0.25), (7.0, 0.0)]).unwrap();
        let gradients: Vec<_> = GradientEstimator::ALL.into_iter().chain([GradientEstimator::Gaussian(0.7)]).map(Some).collect();
        Settings {
            algorithm,
            blend: pick(&Blend::ALL, random).at(1.0 / 3.0),
            clipping: pick(&clipping, random),
            extinction: pick(&Extinction::ALL, random),
            shading: pick(&shadings, random),
            studio,
            shadows,
            ambient_occlusion: pick(&[None, Some(AmbientOcclusion { reach: Some(1.0 / 3.0), gain: 7.0 })], random),
            light_grid: pick(&LightGrid::ALL, random),
            gradient: pick(&[&gradients[..], &[None]].concat(), random),
            gradient_opacity: pick(&[None, Some(edges)], random),
            depth_cue: pick(&[None, Some(DepthCue { strength: 0.3, color: [1.0, 0.5, 0.1] })], random),
            early_termination: pick(&[true, false], random),
            pixel_aspect: pick(&[1.0, 1.5], random),
            unit_distance: pick(&[None, Some(1.0 / 7.0)], random),
            gamma: pick(&[1.0, 2.2], random),
            // It verifies pictures, and changes none: no client has it.
            culling: true,
        }
    }

    #[test]
    fn arguments_make_equal_settings() {
        let (mut random, mut stated) = (1, Vec::new());
        for _ in 0..2000 {
            let settings = settings(&mut random);
            let arguments = settings.arguments();
            stated.extend(arguments.iter().map(|(name, _)| *name));
            assert_eq!(Settings::from_arguments(arguments.clone()).unwrap(), settings, "{arguments:?}");
            let again = arguments.into_iter().rev();
            assert_eq!(Settings::from_arguments(again).unwrap(), settings, "the order does not matter");
        }
        for setting in Setting::ALL {
            assert!(stated.contains(&setting.name), "{} is never stated", setting.name);
        }
        assert!(Settings::default().arguments().is_empty());
    }

    #[test]
    fn refusals_name_the_argument() {
        let fields = |key: &str, value: Argument| Argument::Fields(vec![(key.into(), value)]);
        let name = |name: &str| Argument::Name(name.into());
        for (setting, argument, words) in [
            ("early_termination", Argument::Number(3.0), "early_termination is 3: expected True or False"),
            ("shading", fields("power", name("x")), "shading['power'] is \"x\": expected a number"),
            ("shading", fields("shine", Argument::Number(1.0)), "unknown shading 'shine': use ambient, "),
            ("density", Argument::Number(-1.0), "density is -1: expected a whole number from 0 on"),
            ("crop", Argument::List(vec![]), "crop is []: expected two points, "),
            ("extinction", name("cubic"), "unknown extinction 'cubic': use exponential or linear"),
            ("blur", Argument::Switch(true), "unknown setting 'blur': use algorithm, quality, "),
        ] {
            let message = Settings::from_arguments([(setting, argument)]).unwrap_err().to_string();
            assert!(message.starts_with(words), "{message}");
        }
    }
}
