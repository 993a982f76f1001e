//! Volumes of colours and of labels.

use super::options::{LabelOptions, TransferOptions, VolumeOptions};
use super::parse;
use super::scene::SceneOptions;
use super::shown_steps::{ShownSteps, open_colors, vectors_of};
use super::values::{Colors, Component};
use crate::error::Error;
use crate::layers::Kernel;
use crate::renderer::ColorOpacity;
use crate::settings::FieldKind;
use crate::shown::{IndexedLabels, Shown};
use crate::viewport::Viewport;
use crate::volume::Sequence;
use clap::Args;

/// Components as colours.
#[derive(Args)]
#[command(next_help_heading = "Channels")]
pub(super) struct ColorOptions {
    /// Draw components of the file as colours: direct, as red, green, blue and possibly opacity; direction, as vectors whose direction is the colour and whose norm, by the transfer function, the opacity; none [default: direct if the file says that they are colours, else none]
    #[arg(long, value_name = "HOW", conflicts_with_all = ["channels", "channel", "labels", "label", "label_colors", "label_surfaces", "mask"])]
    colors: Option<Colors>,
    /// Opacity of colours: alpha, luminance (then by --opacity), or a colour that is transparent, as white [default: alpha if there is one, else luminance]
    #[arg(long, value_name = "FROM", value_parser = parse::color_opacity, requires = "colors")]
    color_opacity: Option<ColorOpacity>,
}

impl ColorOptions {
    /// Whether options say how components are drawn as colours.
    #[cfg(feature = "viewer")]
    pub fn are_given(&self) -> bool {
        self.colors.is_some()
    }

    /// How components are drawn as colours: as options say, or directly if the file says that they are colours and no option chooses else.
    fn chosen(&self, options: &SceneOptions) -> Option<Colors> {
        let SceneOptions { volume, channels, labels, camera, .. } = options;
        let direct = || !channels.choose_components() && !labels.is_given() && volume.declares_colors(camera.size);
        self.colors.or_else(|| direct().then_some(Colors::Direct))
    }

    /// Opens the components of the volume's file, or its labels; `None` if its values are shown.
    pub fn open(&self, scene: &SceneOptions) -> Result<Option<Shown>, Error> {
        let (volume, size) = (&scene.volume, scene.camera.size);
        match self.chosen(scene) {
            Some(Colors::Direct) => return open_colors(volume, size, self.color_opacity).map(Some),
            Some(Colors::Direction) => return self.open_vectors(volume, size).map(Some),
            // The command line parser accepts this beside options that exclude --colors.
            Some(Colors::None) | None if self.color_opacity.is_some() => {
                let problem = "is the opacity of colours: add --colors direct, or omit it".into();
                return Err(Error::Settings { field: "color_opacity", problem });
            }
            Some(Colors::None) => return Ok(None),
            None => {}
        }
        let labels = volume.labels(&scene.labels, size)?;
        labels.map(|labels| IndexedLabels::new(labels).map(Shown::Labels)).transpose()
    }

    /// What the steps of a sequence show instead of values: colours or labels; `None` if they show values.
    ///
    /// # Errors
    /// [`Error::Settings`] for the directions of vectors.
    pub fn kind_in_time(&self, scene: &SceneOptions) -> Result<Option<FieldKind>, Error> {
        let are_labels =
            || scene.labels.is_given() || !scene.channels.choose_components() && scene.volume.declares_labels(scene.camera.size);
        let kind = match self.chosen(scene) {
            Some(Colors::Direct) => Ok(Some(FieldKind::Colors)),
            Some(Colors::Direction) => {
                let problem = "plays values, colours and labels: directions of vectors are drawn at one moment, by --frame; omit one of both";
                Err(Error::Settings { field: "time", problem: problem.into() })
            }
            None if are_labels() => Ok(Some(FieldKind::Labels)),
            Some(Colors::None) | None => Ok(None),
        }?;
        if kind.is_some() && scene.channels.are_given() {
            let problem = "are not played beside colours or labels: omit them, choose one component by --channel N, or draw one moment by --frame";
            return refuse("channels", problem).map(|()| None);
        }
        Ok(kind)
    }

    /// The steps of a sequence of colours or labels.
    ///
    /// # Errors
    /// As [`ShownSteps::new`].
    pub fn steps<'a>(&self, scene: &'a SceneOptions, sequence: &Sequence, kind: FieldKind) -> Result<ShownSteps<'a>, Error> {
        let SceneOptions { volume, labels, camera, .. } = scene;
        ShownSteps::new(volume, labels, camera.size, self.color_opacity, sequence.clone(), kind)
    }

    fn open_vectors(&self, options: &VolumeOptions, size: Viewport) -> Result<Shown, Error> {
        if self.color_opacity.is_some() {
            let problem = "direction takes opacities of the norm by the transfer function: omit it".into();
            return Err(Error::Settings { field: "color_opacity", problem });
        }
        vectors_of(|number| options.open_component(&Component::Number(number), Some(size)))
    }
}

/// Rejects options for values, which colours and labels do not have.
///
/// # Errors
/// [`Error::Settings`] with the name of the option and what serves instead.
pub(super) fn reject_value_options(shown: &Shown, options: &SceneOptions) -> Result<(), Error> {
    let SceneOptions { volume, transfer, labels, channels, .. } = options;
    match shown {
        Shown::Labels(_) => {
            if channels.choose_components() {
                let problem = "are components of values, and the file holds labels: omit them";
                return refuse("channels", problem);
            }
            reject_beside_labels(transfer, volume, labels)?;
            if channels.change_fields() && !channels.name_fields() {
                return refuse("field", INSTEAD_OF_VALUES);
            }
        }
        Shown::Components(_, ColorOpacity::Alpha) => {
            if let Some(field) = transfer.given().next() {
                let problem = "is for values; colours have the opacity of their alpha: omit it, or choose --color-opacity luminance, or one \
                     component by --channel N";
                return refuse(field, problem);
            }
        }
        Shown::Components(..) => {
            if let Some(field) = transfer.given().find(|name| ["preset", "palette"].contains(name)) {
                let problem = "is for values; the opacity of colours is that of --opacity, --tent or --transfer: choose one of these, or one \
                     component by --channel N";
                return refuse(field, problem);
            }
        }
        Shown::Vectors { .. } => {}
    }
    if volume.has_background_value() {
        return refuse("background_value", NOTHING_AROUND);
    }
    let is_alone = !channels.name_fields();
    if let Some(Kernel::CatmullRom | Kernel::BSpline) = options.quality.given_kernel().filter(|_| is_alone) {
        let problem = "would make negative extinctions of colours and labels: choose cubic, linear or gaussian, or omit it";
        return refuse("kernel", problem);
    }
    Ok(())
}

/// Why options for values do not apply to labels.
const INSTEAD_OF_VALUES: &str =
    "is for values; labels have the colours and opacities of their table: change these with --label IDS:CHANGES";
/// Why a background value does not apply.
const NOTHING_AROUND: &str = "is for values; there is nothing around colours and labels: omit it";

/// Rejects options for values beside labels, in pictures and slices.
///
/// # Errors
/// As [`reject_value_options`].
pub(super) fn reject_beside_labels(
    transfer: &TransferOptions,
    volume: &VolumeOptions,
    labels: &LabelOptions,
) -> Result<(), Error> {
    if labels.has_mask() {
        return refuse("mask", "hides values, and labels are drawn: choose labels with --label IDS:only");
    }
    if volume.has_background_value() {
        return refuse("background_value", NOTHING_AROUND);
    }
    transfer.given().next().map_or(Ok(()), |field| refuse(field, INSTEAD_OF_VALUES))
}

fn refuse(field: &'static str, problem: &str) -> Result<(), Error> {
    Err(Error::Settings { field, problem: problem.into() })
}
