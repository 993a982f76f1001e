//! Volumes of colours and of labels.

use super::options::{LabelOptions, VolumeOptions};
use super::parse;
use crate::annotation::{Legend, LegendEntry};
use crate::device::Device;
use crate::error::Error;
use crate::framing::Framing;
use crate::renderer::{ColorOpacity, UploadedColors, UploadedVolume, vector_norms};
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Labels, Volume};
use clap::{Args, ValueEnum};

/// Components as colours.
#[derive(Args)]
#[command(next_help_heading = "Channels")]
pub(super) struct ColorOptions {
    /// Draw components of the file as colours: direct, as red, green, blue and possibly opacity; direction, as vectors whose direction is the colour and whose norm, by the transfer function, the opacity
    #[arg(long, value_name = "HOW", conflicts_with_all = ["channels", "channel", "with", "scene", "labels", "label"])]
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

/// What a picture shows instead of values.
pub(super) enum Shown {
    Components(Vec<Volume<'static>>, ColorOpacity),
    Vectors { components: Vec<Volume<'static>>, norms: Box<Volume<'static>> },
    Labels(Labels, Vec<Volume<'static>>),
}

/// Opacities of components without alpha, by their share of the full intensity: by luminance, or by the difference from the background. The
/// noise of a background stays transparent.
const OPACITIES: [(f64, f64); 4] = [(0.0, 0.0), (0.08, 0.0), (0.5, 0.3), (1.0, 0.3)];

impl ColorOptions {
    /// Opens the components of the volume's file, or its labels; `None` if its values are shown.
    pub fn open(&self, options: &VolumeOptions, labels: &LabelOptions, size: Viewport) -> Result<Option<Shown>, Error> {
        let Some(colors) = self.colors else {
            let Some(labels) = options.labels(labels, size)? else { return Ok(None) };
            let indices = labels.layers().iter().map(|layer| layer.indices(None)).collect::<Result<_, _>>()?;
            return Ok(Some(Shown::Labels(labels, indices)));
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

impl Shown {
    /// The volume that stands for all of them, for its grid and name.
    pub fn volume(&self) -> &Volume<'static> {
        match self {
            Self::Components(components, _) => &components[0],
            Self::Vectors { norms, .. } => norms,
            Self::Labels(_, indices) => &indices[0],
        }
    }

    /// Opacities of luminance or of the distance from the background, unless options choose others; `None` if values have opacities.
    pub fn opacities(&self) -> Option<TransferFunction> {
        if matches!(self, Self::Vectors { .. }) {
            return None;
        }
        let full = match self.volume().voxel_type() {
            crate::volume::VoxelType::Uint8 => 255.0,
            crate::volume::VoxelType::Uint16 => 65535.0,
            _ => 1.0,
        };
        let opacities = OPACITIES.map(|(share, opacity)| (share * full, opacity)).to_vec();
        Some(TransferFunction::new("colors", vec![(0.0, [1.0; 3])], opacities).expect("values that ascend"))
    }

    /// Bounds of what shows, as far as voxels tell it. `transfer`: opacities of values.
    pub fn framing(&self, transfer: &TransferFunction) -> Framing {
        let visible = |volume: &Volume, opacities: Vec<(f64, f64)>| {
            let transfer = TransferFunction::new("visible", vec![(0.0, [1.0; 3])], opacities).expect("values that ascend");
            Framing::visible(volume, &transfer, None)
        };
        match self {
            Self::Components(components, ColorOpacity::Alpha) => {
                let (_, largest) = components[3].range();
                visible(&components[3], vec![(0.0, 0.0), (largest.max(f64::MIN_POSITIVE), 1.0)])
            }
            Self::Components(components, _) => Framing::whole(&components[0]),
            Self::Vectors { norms, .. } => Framing::visible(norms, transfer, None),
            Self::Labels(labels, indices) => {
                let layers = labels.layers().iter().zip(indices).map(|(layer, indices)| {
                    let points = layer.palette().iter().enumerate().map(|(n, entry)| (n as f64, entry[3])).collect();
                    visible(indices, points)
                });
                layers.reduce(Framing::joined).unwrap_or_else(|| Framing::whole(self.volume()))
            }
        }
    }

    /// Names and colours of the visible labels, or of the directions.
    pub fn legend(&self) -> Option<Legend> {
        if let Self::Vectors { .. } = self {
            let axes = [("x", [1.0, 0.0, 0.0]), ("y", [0.0, 1.0, 0.0]), ("z", [0.0, 0.0, 1.0])];
            let entries = axes.map(|(name, color)| LegendEntry { name: name.into(), color }).into();
            return Some(Legend { entries });
        }
        let Self::Labels(labels, _) = self else { return None };
        let visible = labels.layers().iter().flat_map(|layer| layer.present()).filter(|label| label.drawn_opacity() > 0.0);
        let entry = |label: &crate::volume::Label| {
            let name = label.name.clone().unwrap_or_else(|| format!("label {}", label.id));
            LegendEntry { name, color: label.color }
        };
        Some(Legend { entries: visible.map(entry).collect() })
    }

    /// The colours on a device.
    pub fn upload(&self, device: &Device, transfer: &TransferFunction) -> Result<UploadedColors, Error> {
        match self {
            Self::Components(components, opacity) => UploadedColors::new(device, components, *opacity, transfer),
            Self::Vectors { components, .. } => UploadedColors::from_vectors(device, components, transfer),
            Self::Labels(labels, indices) => {
                let uploaded = indices.iter().map(|volume| UploadedVolume::new(device, volume)).collect::<Result<Vec<_>, _>>()?;
                let palettes: Vec<_> = labels.layers().iter().map(|layer| layer.palette()).collect();
                let layers: Vec<(&UploadedVolume, &[[f64; 4]])> =
                    uploaded.iter().zip(palettes.iter().map(Vec::as_slice)).collect();
                UploadedColors::from_labels(&layers)
            }
        }
    }
}
