//! What a renderer draws, and which settings go with it: asked before a frame, so that programs need no list of their own.

use super::colors::color_settings;
use super::label_colors::check_tinted;
use crate::error::Error;
use crate::settings::{Algorithm, Blend, Classification, Evaluation, Layered, Settings};

/// What a renderer draws.
///
/// ```
/// use layersplat::renderer::FieldKind;
/// use layersplat::{Settings, settings::Blend};
///
/// let maximum = Settings { blend: Blend::Maximum, ..Settings::default() };
/// assert!(FieldKind::One.check(&maximum).is_ok() && FieldKind::Colors.check(&maximum).is_err());
/// assert!(FieldKind::Several.check(&Settings::default()).is_ok());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldKind {
    /// The values of one field.
    One,
    /// The values of one field in the colours of labels ([`Renderer::set_label_colors`](super::Renderer::set_label_colors)).
    LabelColors,
    /// Several fields ([`Renderer::from_channels`](super::Renderer::from_channels)).
    Several,
    /// Colours ([`Renderer::from_colors`](super::Renderer::from_colors)).
    Colors,
    /// Labels, which are drawn as colours.
    Labels,
}

impl FieldKind {
    /// Fails for settings with which no view is drawn.
    ///
    /// # Errors
    /// [`Error::Settings`], as of the frame.
    pub fn check(self, settings: &Settings) -> Result<(), Error> {
        match self {
            Self::One => Ok(()),
            Self::LabelColors => check_label_colors(settings),
            Self::Several => check_several(settings),
            Self::Colors => color_settings(*settings, false).map(drop),
            Self::Labels => color_settings(*settings, true).map(drop),
        }
    }

    /// Fails where slices show no values.
    ///
    /// # Errors
    /// [`Error::Settings`].
    pub fn check_slices(self) -> Result<(), Error> {
        match self {
            Self::One => Ok(()),
            Self::LabelColors => refuse_label_colors("slices do not show them: omit them"),
            Self::Several => refuse("slices show one channel: show one alone"),
            Self::Colors | Self::Labels => refuse("slices show single values, which colours and labels do not have"),
        }
    }
}

fn refuse(problem: &str) -> Result<(), Error> {
    Err(Error::Settings { field: "channels", problem: problem.into() })
}

fn refuse_label_colors(problem: &str) -> Result<(), Error> {
    Err(Error::Settings { field: "label_colors", problem: problem.into() })
}

/// What the passes of a field in the colours of labels refuse.
fn check_label_colors(settings: &Settings) -> Result<(), Error> {
    check_tinted(settings)?;
    match settings.algorithm {
        Algorithm::Layered(Layered { evaluation: Evaluation::Direct, .. }) => {
            refuse_label_colors("layers per pixel do not show them: omit them, or choose layers on a lattice or ray casting")
        }
        Algorithm::Layered(Layered { classification: Classification::Post(_), .. }) => {
            refuse_label_colors("splatted layers do not show them: omit them, or choose pre-integrated layers or ray casting")
        }
        Algorithm::Layered(_) | Algorithm::Raycast { .. } => Ok(()),
        _ => refuse_label_colors("this algorithm does not show them: omit them, or choose pre-integrated layers or ray casting"),
    }
}

/// What the passes of several fields refuse.
fn check_several(settings: &Settings) -> Result<(), Error> {
    match settings.algorithm {
        Algorithm::Layered(Layered { evaluation: Evaluation::Direct, .. }) => {
            refuse("layers per pixel show one channel: show one alone, or choose layers on a lattice or ray casting")
        }
        Algorithm::Layered(Layered { classification: Classification::Post(_), .. })
            if matches!(settings.blend, Blend::Iso(_)) =>
        {
            refuse("splatted layers have no surfaces: choose pre-integrated layers")
        }
        Algorithm::Layered(_) => Ok(()),
        Algorithm::Raycast { .. } if settings.blend == Blend::Composite => Ok(()),
        Algorithm::Raycast { .. } => refuse("rays of this blend mode show one channel: choose layers"),
        _ => refuse("this algorithm shows one channel: choose pre-integrated layers or ray casting"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Channel, LabelColors, Renderer, UploadedVolume};
    use super::*;
    use crate::camera::{Camera, Orbit};
    use crate::device::{Device, DeviceChoice};
    use crate::layers::{Correction, Kernel};
    use crate::settings::{AmbientOcclusion, Quality, Shadows};
    use crate::transfer::TransferFunction;
    use crate::viewport::Viewport;
    use crate::volume::{OpenOptions, Volume};

    const SIZE: Viewport = Viewport { width: 8, height: 8 };

    /// Settings of all passes.
    fn all_settings() -> Vec<Settings> {
        let default = Settings::default();
        let rays = Algorithm::Raycast { kernel: Kernel::Linear, step: 0.5 };
        let post = Layered { classification: Classification::Post(Correction::SubLayers(2)), ..Layered::default() };
        vec![
            default,
            Quality::Draft.settings(),
            Quality::Paper.settings(),
            Settings { shadows: Some(Shadows::default()), ..default },
            Settings { ambient_occlusion: Some(AmbientOcclusion::default()), ..default },
            Settings { blend: Blend::Maximum, ..default },
            Settings { blend: Blend::Iso(60.0), ..default },
            Settings::from(post),
            Settings { blend: Blend::Maximum, ..Settings::from(post) },
            Settings { blend: Blend::Iso(60.0), ..Settings::from(post) },
            Settings::from(rays),
            Settings { blend: Blend::Average, ..Settings::from(rays) },
            Settings { blend: Blend::Iso(60.0), ..Settings::from(rays) },
            Settings::from(Algorithm::Slicing { step: 0.5 }),
            Settings::from(Algorithm::ViewSheets { sheet_distance: 1.0 }),
        ]
    }

    /// A frame is drawn if, and only if, its settings pass.
    fn check_frames(renderer: &mut Renderer, kind: FieldKind) {
        let camera = Camera::fit_parallel(renderer.grid().centre(), renderer.grid().diagonal(), SIZE, Orbit::default());
        let all = all_settings();
        let mut refused = 0;
        for settings in &all {
            let passes = kind.check(settings).is_ok();
            refused += usize::from(!passes);
            assert_eq!(renderer.render(&camera, SIZE, settings).is_ok(), passes, "{settings:?}");
        }
        assert!((1..all.len()).contains(&refused), "{refused}");
    }

    fn uploaded(device: &Device, name: &str) -> (UploadedVolume, TransferFunction) {
        let volume = Volume::open(name, &OpenOptions::default()).unwrap();
        (UploadedVolume::new(device, &volume).unwrap(), TransferFunction::automatic(&volume))
    }

    #[test]
    fn several_fields_are_drawn_with_settings_that_pass() {
        let device = Device::open(&DeviceChoice::Default).unwrap();
        let channel = |name: &str| {
            let (volume, transfer) = uploaded(&device, name);
            Channel::new(&volume, &transfer)
        };
        let mut renderer = Renderer::from_channels(&[channel("builtin:hydrogen@8"), channel("builtin:gyroid@8")]).unwrap();
        check_frames(&mut renderer, FieldKind::Several);
    }

    #[test]
    fn colors_of_labels_are_drawn_with_settings_that_pass() {
        let (volume, transfer) = uploaded(&Device::open(&DeviceChoice::Default).unwrap(), "builtin:hydrogen@8");
        let mut renderer = Renderer::from_uploaded(&volume, &transfer).unwrap();
        let ids = Volume::new("ids", volume.description().grid().clone(), vec![1u8; 512]).unwrap();
        let entries = [[0.0; 4], [1.0, 0.0, 0.0, 1.0]];
        renderer.set_label_colors(Some(&LabelColors::new(renderer.device(), &[(&ids, &entries)]).unwrap())).unwrap();
        check_frames(&mut renderer, FieldKind::LabelColors);
    }
}
