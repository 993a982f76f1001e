//! Volumes of colours and of labels.

use super::options::{LabelOptions, VolumeOptions};
use super::parse;
use super::scene::SceneOptions;
use crate::error::Error;
use crate::layers::Kernel;
use crate::renderer::{ColorOpacity, vector_norms};
use crate::shown::{IndexedLabels, Shown};
use crate::viewport::Viewport;
use clap::{Args, ValueEnum};

/// Components as colours.
#[derive(Args)]
#[command(next_help_heading = "Channels")]
pub(super) struct ColorOptions {
    /// Draw components of the file as colours: direct, as red, green, blue and possibly opacity; direction, as vectors whose direction is the colour and whose norm, by the transfer function, the opacity
    #[arg(long, value_name = "HOW", conflicts_with_all = ["channels", "channel", "with", "scene", "labels", "label", "label_colors", "label_surfaces", "mask", "field"])]
    colors: Option<Colors>,
    /// Opacity of colours: alpha, luminance (then by --opacity), or a colour that is transparent, as white [default: alpha if there is one, else luminance]
    #[arg(long, value_name = "FROM", value_parser = color_opacity, requires = "colors")]
    color_opacity: Option<ColorOpacity>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Colors {
    Direct,
    Direction,
}

/// Parses `alpha`, `luminance` or a colour.
fn color_opacity(text: &str) -> Result<ColorOpacity, String> {
    match text {
        "alpha" => Ok(ColorOpacity::Alpha),
        "luminance" => Ok(ColorOpacity::Luminance),
        color => parse::color(color)
            .map(ColorOpacity::FromBackground)
            .map_err(|problem| format!("expected alpha, luminance or a colour: {problem}")),
    }
}

impl ColorOptions {
    /// Whether components are used as colours.
    pub fn are_given(&self) -> bool {
        self.colors.is_some()
    }

    /// Opens the components of the volume's file, or its labels; `None` if its values are shown.
    pub fn open(&self, options: &VolumeOptions, labels: &LabelOptions, size: Viewport) -> Result<Option<Shown>, Error> {
        let Some(colors) = self.colors else {
            // The command line parser accepts this beside options that exclude --colors.
            if self.color_opacity.is_some() {
                let problem = "is the opacity of colours: add --colors direct, or omit it".into();
                return Err(Error::Settings { field: "color_opacity", problem });
            }
            let Some(labels) = options.labels(labels, size)? else { return Ok(None) };
            return Ok(Some(Shown::Labels(IndexedLabels::new(labels)?)));
        };
        match colors {
            Colors::Direct => self.open_colors(options, size),
            Colors::Direction => self.open_vectors(options, size),
        }
        .map(Some)
    }

    fn open_vectors(&self, options: &VolumeOptions, size: Viewport) -> Result<Shown, Error> {
        if self.color_opacity.is_some() {
            let problem = "direction takes opacities of the norm by the transfer function: omit it".into();
            return Err(Error::Settings { field: "color_opacity", problem });
        }
        let first = options.open_component(0, Some(size))?;
        let count = first.contents().channels;
        if count != 3 {
            let problem = format!("direction needs 3 components, and {} has {count}: omit it", first.name());
            return Err(Error::Settings { field: "colors", problem });
        }
        let others = (1..count).map(|number| options.open_component(number, Some(size)));
        let components = std::iter::once(Ok(first)).chain(others).collect::<Result<Vec<_>, _>>()?;
        let norms = Box::new(vector_norms(&components)?);
        Ok(Shown::Vectors { components, norms })
    }

    fn open_colors(&self, options: &VolumeOptions, size: Viewport) -> Result<Shown, Error> {
        let first = options.open_component(0, Some(size))?;
        let count = first.contents().channels;
        if count < 3 {
            let problem = format!("direct needs 3 or 4 components, and {} has {count}: omit it", first.name());
            return Err(Error::Settings { field: "colors", problem });
        }
        let used = count.min(4);
        if self.color_opacity == Some(ColorOpacity::Alpha) && used < 4 {
            let problem = format!("alpha is a fourth component, and {} has {count}: choose another", first.name());
            return Err(Error::Settings { field: "color_opacity", problem });
        }
        let others = (1..used).map(|number| options.open_component(number, Some(size)));
        let components = std::iter::once(Ok(first)).chain(others).collect::<Result<Vec<_>, _>>()?;
        let default = if used == 4 { ColorOpacity::Alpha } else { ColorOpacity::Luminance };
        Ok(Shown::Components(components, self.color_opacity.unwrap_or(default)))
    }
}

/// Rejects options for values, which colours and labels do not have.
///
/// # Errors
/// [`Error::Settings`] with the name of the option and what serves instead.
pub(super) fn reject_value_options(shown: &Shown, options: &SceneOptions) -> Result<(), Error> {
    let refuse = |field, problem: &str| Err(Error::Settings { field, problem: problem.into() });
    let instead = match shown {
        Shown::Labels(_) => {
            if options.channels.name_fields() {
                let problem = "are not drawn together with labels: omit them, or draw the scan in the colours of the labels, as \
                               `render SCAN --label-colors LABELS`";
                return refuse("channels", problem);
            }
            if options.labels.has_mask() {
                return refuse("mask", "hides values, and labels are drawn: choose labels with --label IDS:only");
            }
            "labels have the colours and opacities of their table: change these with --label IDS:CHANGES"
        }
        Shown::Components(_, ColorOpacity::Alpha) => {
            "colours have the opacity of their alpha: omit it, or choose --color-opacity luminance"
        }
        Shown::Components(..) => "the opacity of colours is that of --opacity, --tent or --transfer: choose one of these",
        Shown::Vectors { .. } => "",
    };
    let has_values = matches!(shown, Shown::Vectors { .. });
    let has_opacities =
        has_values || matches!(shown, Shown::Components(_, ColorOpacity::Luminance | ColorOpacity::FromBackground(_)));
    let transfer = &options.transfer;
    let given = [
        ("preset", transfer.preset.is_some() && !has_values),
        ("palette", transfer.palette.is_some() && !has_values),
        ("transfer", transfer.transfer.is_some() && !has_opacities),
        ("transfer_range", transfer.transfer_range.is_some() && !has_opacities),
        ("window", transfer.window.is_some() && !has_opacities),
        ("opacity", transfer.opacity.is_some() && !has_opacities),
        ("tent", !transfer.tent.is_empty() && !has_opacities),
        ("field", options.channels.change_fields()),
    ];
    if let Some((field, _)) = given.into_iter().find(|(_, is_given)| *is_given) {
        return Err(Error::Settings { field, problem: format!("is for values; {instead}") });
    }
    if options.volume.has_background_value() {
        return refuse("background_value", "is for values; there is nothing around colours and labels: omit it");
    }
    if let Some(Kernel::CatmullRom | Kernel::BSpline) = options.quality.given_kernel() {
        let problem = "would make negative extinctions of colours and labels: choose cubic, linear or gaussian, or omit it";
        return refuse("kernel", problem);
    }
    Ok(())
}
