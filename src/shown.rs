//! Volumes of colours and of labels as pictures show them: what the command and pages of the viewer have in common.

use crate::annotation::{Legend, LegendEntry};
use crate::device::Device;
use crate::error::Error;
use crate::framing::Framing;
use crate::renderer::{Channel, ColorOpacity, LabelColors, UploadedColors, UploadedVolume};
use crate::settings::FieldKind;
use crate::transfer::TransferFunction;
use crate::volume::{Description, Grid, Label, LabelChange, LabelLayer, LabelTable, Labels, Volume, VoxelType};

/// What a picture shows instead of values.
pub enum Shown {
    /// Red, green and blue, and possibly alpha.
    Components(Vec<Volume<'static>>, ColorOpacity),
    /// Vectors and their norms: the direction is the colour, and the norm makes the opacity.
    Vectors {
        /// The three components.
        components: Vec<Volume<'static>>,
        /// Norms of the vectors.
        norms: Box<Volume<'static>>,
    },
    /// Labels.
    Labels(IndexedLabels),
}

/// Labels, and of each layer the volume of indices ([`LabelLayer::indices`](crate::volume::LabelLayer::indices)). Clones share the voxels.
#[derive(Clone)]
pub struct IndexedLabels {
    labels: Labels,
    indices: Vec<Volume<'static>>,
}

/// Opacities of components without alpha, by their share of the full intensity: by luminance, or by the difference from the background. The
/// noise of a background stays transparent.
const OPACITIES: [(f64, f64); 4] = [(0.0, 0.0), (0.08, 0.0), (0.5, 0.3), (1.0, 0.3)];

impl IndexedLabels {
    /// Labels with the volumes of their indices.
    ///
    /// # Errors
    /// If memory or the temporary folder is too small.
    pub fn new(labels: Labels) -> Result<Self, Error> {
        let indices = labels.layers().iter().map(|layer| layer.indices(None)).collect::<Result<_, _>>()?;
        Ok(Self { labels, indices })
    }

    /// The labels.
    pub fn labels(&self) -> &Labels {
        &self.labels
    }

    /// The labels after further changes.
    ///
    /// # Errors
    /// As [`Labels::change`].
    pub fn changed(mut self, changes: &[LabelChange]) -> Result<Self, Error> {
        changes.iter().try_for_each(|change| self.labels.change(change))?;
        Ok(self)
    }

    /// The labels where they colour a scan.
    ///
    /// # Errors
    /// As [`Labels::over`].
    pub fn over(self, scan: &Description) -> Result<Self, Error> {
        let labels = self.labels.over(scan)?;
        let placed = |(layer, indices): (&LabelLayer, Volume<'static>)| indices.with_grid(layer.grid().clone());
        let indices = labels.layers().iter().zip(self.indices).map(placed).collect::<Result<_, _>>()?;
        Ok(Self { labels, indices })
    }

    /// Opacities of the visible labels of each layer, ascending.
    fn opacities(&self, tables: &[LabelTable]) -> Vec<Vec<f64>> {
        let of_layer = |palette: Vec<[f64; 4]>| {
            let mut opacities: Vec<f64> = palette.iter().map(|entry| entry[3]).filter(|&opacity| opacity > 0.0).collect();
            opacities.sort_by(f64::total_cmp);
            opacities.dedup();
            opacities
        };
        self.palettes(tables).into_iter().map(of_layer).collect()
    }

    /// Channels of the visible labels beside other fields: one for each opacity of each layer, whose volumes of indices were uploaded.
    ///
    /// # Errors
    /// As [`UploadedColors::from_labels`] and [`Channel::from_colors`].
    pub fn channels(&self, uploaded: &[UploadedVolume], tables: &[LabelTable]) -> Result<Vec<Channel>, Error> {
        let mut channels = Vec::new();
        for ((indices, palette), opacities) in uploaded.iter().zip(self.palettes(tables)).zip(self.opacities(tables)) {
            for opacity in opacities {
                let own = |&entry: &[f64; 4]| if entry[3] == opacity { entry } else { [0.0; 4] };
                let entries: Vec<[f64; 4]> = palette.iter().map(own).collect();
                let colors = UploadedColors::from_labels(&[(indices, &entries)], self.labels.surfaces())?;
                channels.push(Channel::from_colors(&colors)?);
            }
        }
        Ok(channels)
    }

    /// The layers with the volumes of their indices.
    pub fn layers(&self) -> impl Iterator<Item = (&LabelLayer, &Volume<'static>)> {
        self.labels.layers().iter().zip(&self.indices)
    }

    /// The colours of a scan in labels with these tables ([`Labels::changed_tables`]).
    ///
    /// # Errors
    /// As [`LabelColors::new`].
    pub fn over_scan(&self, device: &Device, tables: &[LabelTable]) -> Result<LabelColors, Error> {
        let palettes = self.palettes(tables);
        let layers: Vec<_> = self.indices.iter().zip(palettes.iter().map(Vec::as_slice)).collect();
        LabelColors::new(device, &layers)
    }

    /// Colours and opacities of the indices of each layer.
    pub fn palettes(&self, tables: &[LabelTable]) -> Vec<Vec<[f64; 4]>> {
        self.labels.layers().iter().zip(tables).map(|(layer, table)| layer.palette_of(table)).collect()
    }

    /// Bounds of the voxels of visible labels.
    pub fn framing(&self, tables: &[LabelTable]) -> Framing {
        let layers = self.indices.iter().zip(self.palettes(tables)).map(|(indices, palette)| {
            visible(indices, palette.iter().enumerate().map(|(n, entry)| (n as f64, entry[3])).collect())
        });
        layers.reduce(Framing::joined).expect("labels have a layer")
    }
}

impl Shown {
    /// The volume that stands for all of them, for its grid and name.
    pub fn volume(&self) -> &Volume<'static> {
        match self {
            Self::Components(volumes, _) | Self::Labels(IndexedLabels { indices: volumes, .. }) => &volumes[0],
            Self::Vectors { norms, .. } => norms,
        }
    }

    /// All of it on other grids.
    ///
    /// # Errors
    /// Those of `place`.
    pub fn placed(self, place: impl Fn(&Grid) -> Result<Grid, Error>) -> Result<Self, Error> {
        let placed = |volume: Volume<'static>| {
            let grid = place(volume.grid())?;
            volume.with_grid(grid)
        };
        let all = |volumes: Vec<Volume<'static>>| volumes.into_iter().map(placed).collect::<Result<Vec<_>, Error>>();
        Ok(match self {
            Self::Components(components, opacity) => Self::Components(all(components)?, opacity),
            Self::Vectors { components, norms } => {
                Self::Vectors { components: all(components)?, norms: Box::new(placed(*norms)?) }
            }
            Self::Labels(IndexedLabels { labels, indices }) => {
                Self::Labels(IndexedLabels { labels: labels.placed(&place)?, indices: all(indices)? })
            }
        })
    }

    /// Bytes of a field that is drawn beside others on the device: extinctions and colours.
    pub(crate) fn voxel_bytes(&self) -> u64 {
        8 * self.volume().grid().voxel_count() as u64
    }

    /// What a renderer draws of it.
    pub fn kind(&self) -> FieldKind {
        match self {
            Self::Components(..) | Self::Vectors { .. } => FieldKind::Colors,
            Self::Labels(..) => FieldKind::Labels,
        }
    }

    /// Opacities of luminance or of the distance from the background, unless options choose others; `None` for vectors, whose norms have the
    /// transfer function of values.
    pub fn opacities(&self) -> Option<TransferFunction> {
        if matches!(self, Self::Vectors { .. }) {
            return None;
        }
        let full = match self.volume().voxel_type() {
            VoxelType::Uint8 => 255.0,
            VoxelType::Uint16 => 65535.0,
            _ => 1.0,
        };
        let opacities = OPACITIES.map(|(share, opacity)| (share * full, opacity)).to_vec();
        Some(TransferFunction::new("colors", vec![(0.0, [1.0; 3])], opacities).expect("values that ascend"))
    }

    /// The tables of all layers after changes; none for colours.
    ///
    /// # Errors
    /// For changes of labels that there are not.
    pub fn tables(&self, changes: &[LabelChange]) -> Result<Vec<LabelTable>, Error> {
        match self {
            Self::Components(..) | Self::Vectors { .. } => Ok(Vec::new()),
            Self::Labels(all) => all.labels.changed_tables(changes),
        }
    }

    /// Bounds of what shows, as far as voxels tell it. `transfer`: opacities of values. `tables`: those of [`tables`](Self::tables).
    pub fn framing(&self, transfer: &TransferFunction, tables: &[LabelTable]) -> Framing {
        match self {
            Self::Components(components, ColorOpacity::Alpha) => {
                let (_, largest) = components[3].range();
                visible(&components[3], vec![(0.0, 0.0), (largest.max(f64::MIN_POSITIVE), 1.0)])
            }
            Self::Components(components, _) => Framing::whole(&components[0]),
            Self::Vectors { norms, .. } => Framing::visible(norms, transfer, None),
            Self::Labels(all) => all.framing(tables),
        }
    }

    /// Names and colours of the visible labels, or of the axes along which vectors point. `tables`: those of [`tables`](Self::tables).
    pub fn legend(&self, tables: &[LabelTable]) -> Option<Legend> {
        if let Self::Vectors { .. } = self {
            let axes = [("x", [1.0, 0.0, 0.0]), ("y", [0.0, 1.0, 0.0]), ("z", [0.0, 0.0, 1.0])];
            let entries = axes.map(|(name, color)| LegendEntry::new(name, color)).into();
            return Some(Legend { entries });
        }
        self.labels().map(|labels| legend_of(labels, tables))
    }

    /// The labels, if it is some.
    pub fn labels(&self) -> Option<&Labels> {
        if let Self::Labels(all) = self { Some(&all.labels) } else { None }
    }

    /// The voxels on a device: of components, or of the indices of each layer; none for vectors, whose colours are made on the host.
    ///
    /// # Errors
    /// Insufficient memory of the device.
    pub fn upload(&self, device: &Device) -> Result<Vec<UploadedVolume>, Error> {
        match self {
            Self::Components(volumes, _) | Self::Labels(IndexedLabels { indices: volumes, .. }) => {
                volumes.iter().map(|volume| UploadedVolume::new(device, volume)).collect()
            }
            Self::Vectors { .. } => Ok(Vec::new()),
        }
    }

    /// The colours of voxels that were [uploaded](Self::upload). `tables`: those of [`tables`](Self::tables).
    ///
    /// # Errors
    /// Insufficient memory of the device, and components that are no colours.
    pub fn colors(
        &self,
        device: &Device,
        uploaded: &[UploadedVolume],
        transfer: &TransferFunction,
        tables: &[LabelTable],
    ) -> Result<UploadedColors, Error> {
        match self {
            Self::Components(_, opacity) => UploadedColors::from_components(uploaded, *opacity, transfer),
            Self::Vectors { components, .. } => UploadedColors::from_vectors(device, components, transfer),
            Self::Labels(all) => {
                let palettes = all.palettes(tables);
                let layers: Vec<(&UploadedVolume, &[[f64; 4]])> =
                    uploaded.iter().zip(palettes.iter().map(Vec::as_slice)).collect();
                UploadedColors::from_labels(&layers, all.labels.surfaces())
            }
        }
    }
}

impl Shown {
    /// Number of channels that draw it beside other fields: one, and of labels one for each layer and opacity. `tables`: those of
    /// [`tables`](Self::tables).
    pub fn channel_count(&self, tables: &[LabelTable]) -> usize {
        match self {
            Self::Components(..) | Self::Vectors { .. } => 1,
            Self::Labels(all) => all.opacities(tables).iter().map(Vec::len).sum(),
        }
    }

    /// These channels, of voxels that were [uploaded](Self::upload).
    ///
    /// # Errors
    /// As [`colors`](Self::colors) and [`Channel::from_colors`].
    pub fn channels(
        &self,
        device: &Device,
        uploaded: &[UploadedVolume],
        transfer: &TransferFunction,
        tables: &[LabelTable],
    ) -> Result<Vec<Channel>, Error> {
        match self {
            Self::Components(..) | Self::Vectors { .. } => {
                Ok(vec![Channel::from_colors(&self.colors(device, uploaded, transfer, tables)?)?])
            }
            Self::Labels(all) => all.channels(uploaded, tables),
        }
    }
}

/// Bounds of the voxels of a volume that have opacity.
fn visible(volume: &Volume, opacities: Vec<(f64, f64)>) -> Framing {
    let transfer = TransferFunction::new("visible", vec![(0.0, [1.0; 3])], opacities).expect("values that ascend");
    Framing::visible(volume, &transfer, None)
}

/// Names and colours of the visible labels with the tables of their layers.
pub(crate) fn legend_of(labels: &Labels, tables: &[LabelTable]) -> Legend {
    legend_of_all(labels.layers().iter().zip(tables).flat_map(|(layer, table)| layer.present_in(table)))
}

/// Names and colours of those labels that are visible.
pub(crate) fn legend_of_all<'a>(labels: impl Iterator<Item = &'a Label>) -> Legend {
    let entry = |label: &Label| LegendEntry::new(name_of(label), label.color);
    Legend { entries: labels.filter(|label| label.drawn_opacity() > 0.0).map(entry).collect() }
}

/// The name of a label, or its number.
pub(crate) fn name_of(label: &Label) -> String {
    label.name.clone().unwrap_or_else(|| format!("label {}", label.id))
}
