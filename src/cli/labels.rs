//! The list of labels of `layersplat info`.

use super::numbers::{hex_color, shortened};
use crate::volume::{Label, LabelLayer, Labels};
use serde::Serialize;

/// A label that voxels have.
#[derive(Serialize)]
pub(super) struct LabelReport {
    /// Labels of different layers may overlap.
    layer: usize,
    id: u32,
    name: Option<String>,
    color: [f64; 3],
    opacity: f64,
    visible: bool,
    voxels: u64,
    /// In cubic world units.
    volume: f64,
}

impl LabelReport {
    /// All labels that voxels have, by layer and id.
    pub fn all(labels: &Labels) -> Vec<Self> {
        let of_layer = |(layer, found): (usize, &LabelLayer)| {
            let report = |label: &Label| Self {
                layer,
                id: label.id,
                name: label.name.clone(),
                color: label.color,
                opacity: label.opacity,
                visible: label.visible,
                voxels: found.voxels_of(label.id),
                volume: found.volume_of(label.id),
            };
            found.present().map(report).collect::<Vec<_>>()
        };
        labels.layers().iter().enumerate().flat_map(of_layer).collect()
    }

    fn line(&self, with_layer: bool) -> String {
        let color = hex_color(self.color);
        let layer = if with_layer { format!("{:>5} ", self.layer) } else { String::new() };
        let hidden = if self.visible { "" } else { " (hidden)" };
        let (voxels, volume, opacity) = (self.voxels, shortened(self.volume), shortened(self.opacity));
        let name = self.name.as_deref().unwrap_or("-");
        format!("{layer}{:>10} {voxels:>12} {volume:>14} {color} {opacity:>7} {name}{hidden}", self.id)
    }
}

/// A heading, and a line for each label.
pub(super) fn lines(reports: &[LabelReport]) -> Vec<String> {
    let with_layer = reports.iter().any(|report| report.layer > 0);
    let layer = if with_layer { "layer " } else { "" };
    let heading = format!("{layer}{:>10} {:>12} {:>14} {:7} {:>7} name", "label", "voxels", "volume", "color", "opacity");
    [heading].into_iter().chain(reports.iter().map(|report| report.line(with_layer))).collect()
}
