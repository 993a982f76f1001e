//! Volumes of colours and of labels.

use super::options::{LabelOptions, TransferOptions, VolumeOptions};
use super::parse;
use super::scene::SceneOptions;
use super::values::Component;
use crate::error::Error;
use crate::layers::Kernel;
use crate::renderer::{ColorOpacity, vector_norms};
use crate::shown::{IndexedLabels, Shown};
use crate::viewport::Viewport;
use crate::volume::{ChannelDescription, Volume, VoxelType, Voxels};
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
        let first = options.open_component(&Component::Number(0), Some(size))?;
        let count = first.contents().channels;
        if count != 3 {
            let problem = format!("direction needs 3 components, and {} has {count}: omit it", first.name());
            return Err(Error::Settings { field: "colors", problem });
        }
        let others = (1..count).map(|number| options.open_component(&Component::Number(number), Some(size)));
        let components = std::iter::once(Ok(first)).chain(others).collect::<Result<Vec<_>, _>>()?;
        let norms = Box::new(vector_norms(&components)?);
        Ok(Shown::Vectors { components, norms })
    }

    fn open_colors(&self, options: &VolumeOptions, size: Viewport) -> Result<Shown, Error> {
        let first = options.open_component(&Component::Number(0), Some(size))?;
        let count = first.contents().channels;
        if count < 3 {
            let problem = format!("direct needs 3 or 4 components, and {} has {count}: omit it", first.name());
            return Err(Error::Settings { field: "colors", problem });
        }
        let described = options.channel_descriptions(Some(size))?;
        let alpha = Alpha::of(&described);
        if self.color_opacity == Some(ColorOpacity::Alpha) && alpha.is_none() {
            let problem = format!("alpha is a fourth component, and {} has none: choose another", first.name());
            return Err(Error::Settings { field: "color_opacity", problem });
        }
        let others = (1..3).chain(alpha.map(|alpha| alpha.number));
        let others = others.map(|number| options.open_component(&Component::Number(number), Some(size)));
        let mut components = std::iter::once(Ok(first)).chain(others).collect::<Result<Vec<_>, _>>()?;
        if alpha.is_some_and(|alpha| alpha.is_associated) {
            let divided = components[..3].iter().map(|color| divided(color, &components[3])).collect::<Result<Vec<_>, _>>()?;
            components.splice(..3, divided);
        }
        let default = if alpha.is_some() { ColorOpacity::Alpha } else { ColorOpacity::Luminance };
        Ok(Shown::Components(components, self.color_opacity.unwrap_or(default)))
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
            if channels.name_fields() {
                let problem = "are not drawn together with labels: omit them, or draw the scan in the colours of the labels, as \
                               `render SCAN --label-colors LABELS`";
                return refuse("channels", problem);
            }
            reject_beside_labels(transfer, volume, labels)?;
            if channels.change_fields() {
                return refuse("field", INSTEAD_OF_VALUES);
            }
        }
        Shown::Components(_, ColorOpacity::Alpha) => {
            if let Some(field) = transfer.given().next() {
                let problem =
                    "is for values; colours have the opacity of their alpha: omit it, or choose --color-opacity luminance";
                return refuse(field, problem);
            }
        }
        Shown::Components(..) => {
            if let Some(field) = transfer.given().find(|name| ["preset", "palette"].contains(name)) {
                let problem =
                    "is for values; the opacity of colours is that of --opacity, --tent or --transfer: choose one of these";
                return refuse(field, problem);
            }
        }
        Shown::Vectors { .. } => {}
    }
    if volume.has_background_value() {
        return refuse("background_value", NOTHING_AROUND);
    }
    if let Some(Kernel::CatmullRom | Kernel::BSpline) = options.quality.given_kernel() {
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

/// The component that is an opacity.
#[derive(Clone, Copy)]
struct Alpha {
    number: usize,
    /// Whether the colours are multiplied by it.
    is_associated: bool,
}

impl Alpha {
    /// The one that the file names so, else the fourth component of four.
    fn of(channels: &[ChannelDescription]) -> Option<Self> {
        let named = |name: &str| channels.iter().position(|channel| channel.name.as_deref() == Some(name));
        let are_named = channels.iter().take(3).all(|channel| channel.name.is_some());
        let fourth = || (channels.len() == 4 && !are_named).then_some(3);
        let straight = named("alpha").or_else(fourth).map(|number| Self { number, is_associated: false });
        straight.or_else(|| Some(Self { number: named(ChannelDescription::ASSOCIATED_ALPHA)?, is_associated: true }))
    }
}

/// A colour by which an opacity has been multiplied, divided by it. Both have one type.
fn divided(color: &Volume, alpha: &Volume) -> Result<Volume<'static>, Error> {
    let full = match color.voxel_type() {
        VoxelType::Uint8 => f64::from(u8::MAX),
        VoxelType::Uint16 => f64::from(u16::MAX),
        VoxelType::Int8 | VoxelType::Int16 | VoxelType::Float32 => 1.0,
    };
    let count = color.grid().voxel_count();
    let all = |value: &(dyn Fn(usize) -> f64 + Sync)| (0..count).map(value).collect::<Vec<f64>>();
    let straight = color.look(all).into_iter().zip(alpha.look(all));
    let straight = straight.map(|(color, alpha)| if alpha > 0.0 { (color / alpha * full).min(full) } else { 0.0 });
    let voxels = match color.voxel_type() {
        VoxelType::Uint8 => Voxels::Uint8(straight.map(|value| value.round() as u8).collect()),
        VoxelType::Uint16 => Voxels::Uint16(straight.map(|value| value.round() as u16).collect()),
        _ => Voxels::Float32(straight.map(|value| value as f32).collect()),
    };
    Volume::new(color.name(), color.grid().clone(), voxels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::Grid;
    use glam::DVec3;

    fn named(names: &[&str]) -> Vec<ChannelDescription> {
        let name = |name: &&str| Some(name.to_string()).filter(|name| !name.is_empty());
        names.iter().map(|one| ChannelDescription { name: name(one), ..ChannelDescription::default() }).collect()
    }

    #[test]
    fn only_what_is_an_opacity_is_one() {
        let alpha = |names: &[&str]| Alpha::of(&named(names)).map(|alpha| (alpha.number, alpha.is_associated));
        assert_eq!(alpha(&["red", "green", "blue", "alpha"]), Some((3, false)));
        assert_eq!(alpha(&["red", "green", "blue", "", "associated alpha"]), Some((4, true)));
        assert_eq!((alpha(&["", "", "", ""]), alpha(&["", "", "", "", ""])), (Some((3, false)), None));
        assert_eq!((alpha(&["red", "green", "blue", ""]), alpha(&["red", "green", "blue"])), (None, None));
    }

    #[test]
    fn colours_are_divided_by_the_opacity_that_they_were_multiplied_by() {
        let volume = |values: Vec<u8>| Volume::new("v", Grid::new([4, 1, 1], DVec3::ONE).unwrap(), values).unwrap();
        let found = divided(&volume(vec![50, 0, 255, 9]), &volume(vec![100, 0, 255, 3])).unwrap();
        assert_eq!([0, 1, 2, 3].map(|i| found.value(i)), [128.0, 0.0, 255.0, 255.0]);
    }
}
