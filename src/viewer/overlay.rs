//! Settings of a look over those of a program that has no options to make them of.

use super::look::Look;
use crate::error::Error;
use crate::image::Background;
use crate::layers::Kernel;
use crate::settings::{Classification, Layered, Light, Lights, Quality, Settings, Shading, Shadows};

/// Settings, and their look. What a page does not change stays as in these settings: the coefficients of the shading, for example.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlay {
    base: Settings,
    own: Look,
}

impl Overlay {
    /// The quality `standard`, which is the default, becomes a look that is refined at rest. `iso` and `dims`: see [`Look::of`].
    pub fn new(base: Settings, background: Background, iso: f64, dims: [usize; 3]) -> Self {
        let mut own = Look::of(&base, background, iso, dims);
        if let Some((quality, kernel)) = base.layered().and_then(preset) {
            own.quality = Some(quality).filter(|&quality| quality != Quality::Standard);
            own.kernel = kernel;
        }
        Self { base, own }
    }

    /// The look of the settings.
    pub fn look(&self) -> &Look {
        &self.own
    }

    /// The settings of another look; of the own one, they are the own ones. `quality` replaces that of the look.
    ///
    /// # Errors
    /// For lights that [`Lights::new`] refuses.
    pub fn settings(&self, look: &Look, quality: Option<Quality>) -> Result<Settings, Error> {
        let Self { base, own } = self;
        let mut settings = *base;
        if let Some(layered) = base.layered() {
            settings.algorithm = self.layered(layered, look, quality).into();
        }
        settings.blend = look.blend.at(look.iso);
        if look.gradient != own.gradient {
            settings.gradient = look.gradient.as_ref().and_then(|name| name.parse().ok());
        }
        let studio = look.drawn_studio();
        settings.studio = studio.map(|studio| studio.over(base.studio.unwrap_or_default(), look.light_space()));
        // Elsewhere the page offers neither.
        let is_lit = look.shading && studio.is_none() && !look.blend.gathers_values();
        let shadows = || Shadows { strength: look.shadow_strength, ..base.shadows.unwrap_or_default() };
        settings.shadows = (look.shadows && is_lit).then(shadows);
        settings.ambient_occlusion = (look.ambient_occlusion && is_lit).then(|| base.ambient_occlusion.unwrap_or_default());
        let of_lights = |look: &Look| (look.lights.clone(), look.lights_follow, look.shadows);
        let is_own_look = settings.look() == base.look();
        settings.shading = match base.shading.filter(|_| is_own_look) {
            _ if !look.shading && studio.is_none() => None,
            Some(shading) if of_lights(look) == of_lights(own) => Some(shading),
            shading => {
                Some(Shading { lights: lights(look)?, ..shading.unwrap_or_else(|| Shading::default_of(settings.look(), false)) })
            }
        };
        if look.crop != own.crop {
            settings.clipping.crop = look.crop_box();
        }
        if look.clips != own.clips {
            settings.clipping = settings.clipping.with_planes(look.planes());
        }
        look.with_plain(settings)
    }

    fn layered(&self, base: Layered, look: &Look, quality: Option<Quality>) -> Layered {
        let quality = quality.or(look.quality);
        let layered = match (quality, preset(base)) {
            (None, _) => base,
            (Some(quality), Some(_)) => Layered { layer_axis: base.layer_axis, ..quality.layered() },
            (Some(quality), None) => chosen(base, quality.layered()),
        };
        let kernel = match look.kernel {
            Some(kernel) => Some(kernel),
            // The page took the kernel back.
            None if self.own.kernel.is_some() && quality.is_none() => {
                preset(base).and_then(|(quality, _)| kernel_of(quality.layered()))
            }
            None => None,
        };
        match kernel {
            Some(kernel) => Layered { classification: layered.classification.with_kernel(kernel), ..layered },
            None => layered,
        }
    }
}

/// The preset that layers have, and their kernel if it is not that of the preset. `None` for other options of layers.
fn preset(layered: Layered) -> Option<(Quality, Option<Kernel>)> {
    let kernel = kernel_of(layered);
    Quality::ALL.into_iter().find_map(|quality| {
        let preset = Layered { layer_axis: layered.layer_axis, ..quality.layered() };
        let classification = kernel.map_or(preset.classification, |kernel| preset.classification.with_kernel(kernel));
        let is_other = kernel_of(preset) != kernel;
        (Layered { classification, ..preset } == layered).then(|| (quality, kernel.filter(|_| is_other)))
    })
}

/// A preset with the options that differ from the default: these were chosen one by one.
fn chosen(layered: Layered, preset: Layered) -> Layered {
    fn pick<T: PartialEq>(own: T, default: T, preset: T) -> T {
        if own == default { preset } else { own }
    }
    let default = Layered::default();
    Layered {
        layer_axis: layered.layer_axis,
        evaluation: pick(layered.evaluation, default.evaluation, preset.evaluation),
        classification: pick(layered.classification, default.classification, preset.classification),
        footprints: pick(layered.footprints, default.footprints, preset.footprints),
        adapts_to_opacity: layered.adapts_to_opacity,
    }
}

fn kernel_of(layered: Layered) -> Option<Kernel> {
    match layered.classification {
        Classification::Preintegrated { kernel, .. } => Some(kernel),
        Classification::Post(_) => None,
    }
}

/// The lights of a look; without any, the default with or without shadows.
fn lights(look: &Look) -> Result<Lights, Error> {
    if look.lights.is_empty() {
        return Ok(Lights::default_with(look.shadows));
    }
    let lights: Vec<Light> = look.lights.iter().map(|light| Light { space: look.light_space(), ..light.light() }).collect();
    Lights::new(&lights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, Orbit};
    use crate::layers::{Density, GradientEstimator};
    use crate::settings::{
        self, AmbientOcclusion, Argument, Blend, ClipPlane, Clipping, CropBox, DepthCue, Evaluation, LightGrid, LightSpace,
        Studio,
    };
    use crate::viewer::{PageLight, PageStudio};
    use crate::viewport::Viewport;
    use glam::DVec3;

    fn overlay(base: Settings) -> Overlay {
        Overlay::new(base, Background::BLACK, 90.0, [8; 3])
    }

    /// Settings of all kinds become a look, and the look becomes the same settings, bit for bit.
    #[test]
    fn the_own_look_has_the_own_settings() {
        let layered = |change: fn(&mut Layered)| {
            let mut layered = Layered::default();
            change(&mut layered);
            Settings::from(layered)
        };
        let lit = Settings::default();
        let light = Light { strength: 0.3, ..Light::towards(DVec3::new(0.1, -0.30000000000000004, 1e-7)) };
        let of_lights = |lights| Some(Shading { specular: 0.123, lights, ..Shading::default() });
        let crop = CropBox { lowest: DVec3::splat(-5.0), highest: DVec3::new(1.0 / 3.0, 99.0, 4.0) };
        let clip = ClipPlane { point: DVec3::ONE, normal: DVec3::new(0.0, -2.0, 1e-3) };
        let aside = Orbit { azimuth: 40.0, elevation: 20.0, roll: 3.0 };
        let aside = Camera::fit_parallel(DVec3::ZERO, 2.0, Viewport { width: 8, height: 8 }, aside);
        let all = [
            layered(|l| l.evaluation = Evaluation::Lattice(Density::Fixed(3))),
            layered(|l| l.classification = l.classification.with_kernel(Kernel::CatmullRom)),
            layered(|l| l.classification = Quality::Standard.splatted()),
            Settings { blend: Blend::Iso(-12.3456789012345), unit_distance: Some(0.7), ..lit },
            Settings { blend: Blend::Maximum, shading: None, depth_cue: Some(DepthCue::default()), ..lit },
            Settings { shading: of_lights(Lights::new(&[light, Light::AT_CAMERA]).unwrap()), ..lit },
            Settings {
                shading: of_lights(Lights::BESIDE_CAMERA),
                shadows: Some(Shadows { strength: 0.4, forgiveness: 9.0 }),
                ..lit
            },
            Settings {
                ambient_occlusion: Some(AmbientOcclusion { gain: 7.0, ..Default::default() }),
                light_grid: LightGrid::Half,
                ..lit
            },
            Settings { clipping: Clipping { crop: Some(crop), ..Default::default() }.with_planes([clip; 2]), ..lit },
            lit.with_look(settings::Look::Studio),
            Settings { light_grid: LightGrid::Half, ..lit.with_look(settings::Look::Studio) }
                .with_light_in_world(&aside)
                .unwrap(),
            Settings::from(crate::settings::Algorithm::Slicing { step: 0.25 }),
        ];
        for base in Quality::ALL.map(Quality::settings).into_iter().chain(all) {
            let overlay = overlay(base);
            assert_eq!(overlay.settings(overlay.look(), None).unwrap(), base);
            overlay.look().check().unwrap();
        }
    }

    #[test]
    fn a_look_changes_what_it_says_and_nothing_else() {
        let base = Settings {
            shading: Some(Shading { power: 50.0, ..Shading::default() }),
            unit_distance: Some(3.0),
            ..Settings::default()
        };
        let overlay = overlay(base);
        let own = overlay.look().clone();
        let settings = |look: &Look| overlay.settings(look, None).unwrap();
        let light = PageLight { direction: Some([0.0, 0.0, 1.0]), strength: 0.5, angle: 3.0, color: [1.0; 3] };
        let lit =
            settings(&Look { lights: vec![light], lights_follow: true, shadows: true, shadow_strength: 0.5, ..own.clone() });
        let shading = lit.shading.unwrap();
        assert_eq!((shading.power, shading.lights.as_slice()[0].space, lit.unit_distance), (50.0, LightSpace::Camera, Some(3.0)));
        assert_eq!(lit.shadows, Some(Shadows { strength: 0.5, ..Shadows::default() }));
        assert_eq!(settings(&Look { shadows: true, ..own.clone() }).shading.unwrap().lights, Lights::BESIDE_CAMERA);
        let gradient = |name: &str| settings(&Look { gradient: Some(name.into()), ..own.clone() }).gradient;
        assert_eq!(gradient("central"), Some(GradientEstimator::Central));
        // Shadows need what shows them.
        let flat = settings(&Look { blend: Blend::Maximum, shadows: true, ambient_occlusion: true, ..own.clone() });
        assert_eq!((flat.shadows, flat.ambient_occlusion, flat.blend), (None, None, Blend::Maximum));
        let cut =
            settings(&Look { crop: Some([[0.0; 3], [4.0; 3]]), clips: vec![[1.0, 2.0, 3.0, 0.0, 0.0, 1.0]], ..own.clone() });
        assert_eq!(cut.clipping.crop, Some(CropBox { lowest: DVec3::ZERO, highest: DVec3::splat(4.0) }));
        assert_eq!(cut.clipping.planes[0].unwrap().point, DVec3::new(1.0, 2.0, 3.0));
        let plain = [("gamma".to_owned(), Argument::Number(2.0)), ("early_termination".to_owned(), Argument::Switch(false))];
        let plain = settings(&Look { plain: plain.into(), ..own.clone() });
        // What the page takes back is the default.
        assert_eq!((plain.gamma, plain.early_termination, plain.unit_distance), (2.0, false, None));
        assert_eq!(settings(&Look { shading: false, ..own }).shading, None);
    }

    /// The studio that a page chooses, and that it leaves again.
    #[test]
    fn the_look_is_chosen_with_its_light() {
        let plain = overlay(Settings { shadows: Some(Shadows::default()), ..Settings::default() });
        let studio = overlay(Settings::default().with_look(settings::Look::Studio));
        let to_studio = Look { studio: studio.look().studio, lights: studio.look().lights.clone(), ..plain.look().clone() };
        assert_eq!(plain.settings(&to_studio, None).unwrap(), Settings::default().with_look(settings::Look::Studio));
        let own = PageStudio { sky_up: [0.0, 0.0, 2.0], scattering: 0.5, exposure: 1.0 };
        let changed = Look { studio: Some(own), lights_follow: false, ..to_studio.clone() };
        let drawn = plain.settings(&changed, None).unwrap().studio.unwrap();
        assert_eq!(
            (drawn.sky.up, drawn.sky.space, drawn.scattering, drawn.exposure),
            (DVec3::Z * 2.0, LightSpace::World, 0.5, 1.0)
        );
        assert_eq!(drawn.sky.top, Studio::default().sky.top);
        // Other blend modes have the plain look, and so has what leaves the studio.
        assert_eq!(plain.settings(&Look { blend: Blend::Maximum, ..to_studio }, None).unwrap().studio, None);
        let left = Look { studio: None, lights: Vec::new(), ..studio.look().clone() };
        assert_eq!(studio.settings(&left, None).unwrap(), Settings::default());
    }

    #[test]
    fn qualities_replace_presets_and_keep_what_was_chosen() {
        let kernel = |settings: Settings| kernel_of(settings.layered().unwrap());
        for quality in Quality::ALL {
            let plain = overlay(Settings::default());
            assert_eq!(plain.settings(plain.look(), Some(quality)).unwrap(), quality.settings());
        }
        let high = overlay(Quality::High.settings());
        assert_eq!(high.look().quality, Some(Quality::High));
        // A kernel of its own stays, until the page takes it back.
        let base = Layered {
            classification: Quality::High.layered().classification.with_kernel(Kernel::Linear),
            ..Quality::High.layered()
        };
        let linear = overlay(base.into());
        assert_eq!((linear.look().quality, linear.look().kernel), (Some(Quality::High), Some(Kernel::Linear)));
        assert_eq!(kernel(linear.settings(linear.look(), Some(Quality::Draft)).unwrap()), Some(Kernel::Linear));
        let back = Look { kernel: None, ..linear.look().clone() };
        assert_eq!(linear.settings(&back, None).unwrap(), Quality::High.settings());
        // A density that is of no preset.
        let dense = Layered { evaluation: Evaluation::Lattice(Density::Fixed(5)), ..Layered::default() };
        let dense = overlay(dense.into());
        let draft = dense.settings(dense.look(), Some(Quality::High)).unwrap().layered().unwrap();
        assert_eq!((draft.evaluation, kernel_of(draft)), (Evaluation::Lattice(Density::Fixed(5)), Some(Kernel::BSpline)));
    }
}
