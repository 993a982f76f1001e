//! What a page is told first.

use super::drawn::{Drawn, PageField};
use super::first::{First, Opening};
use super::look::Look;
use super::look_fields::is_name;
use super::page_light::PageStudio;
use super::replies::{NamedTransfer, Reply};
use super::scene::SharedScene;
use super::slices;
use crate::framing::Side;
use crate::image::Background;
use crate::layers::{GradientEstimator, Kernel};
use crate::renderer::ColorOpacity;
use crate::settings::{self, Blend, Kind, Method, Quality, Setting, Settings, Studio};
use crate::shown::{Shown, name_of};
use crate::transfer::TransferFunction;
use crate::volume::{Label, LabelLayer, Statistics};
use serde_json::{Map, Value, json};
use std::collections::HashMap;

/// Most labels that a page lists.
const MOST_LABELS: usize = 4096;

impl SharedScene {
    /// The first message to a page, JSON.
    pub fn hello(&self, first: &First) -> String {
        let Opening { volume, orientation, .. } = &self.opening;
        let First { camera, camera_is_given, look, transfer, .. } = first;
        let (grid, frame) = (volume.grid(), self.frame());
        let values = self.values();
        let statistics = &self.statistics()[0];
        let sides = Side::ALL.map(|side| {
            let orbit = orientation.side(side);
            json!({ "name": side.name(), "seen_from": orientation.seen_from(orbit), "azimuth": orbit.azimuth, "elevation": orbit.elevation })
        });
        let is_layered = self.host.settings(look, None).is_ok_and(|settings| settings.layered().is_some());
        let presets = TransferFunction::presets().map(|(name, shows)| {
            let colors = TransferFunction::preset(name, values).map_or_else(|_| Vec::new(), |preset| strip(&preset));
            json!({ "name": name, "shows": shows, "colors": colors })
        });
        let maps = TransferFunction::names().map(|name| json!({ "name": name, "colors": self.preview(name) }));
        json!({
            "type": "hello",
            "version": env!("CARGO_PKG_VERSION"),
            "volume": {
                "name": volume.name(), "dims": grid.dims(), "spacing": grid.spacing().to_array(), "centre": grid.centre().to_array(),
                "diagonal": grid.diagonal(), "voxel_type": volume.voxel_type().to_string(), "length_units": self.length_units(),
                "origin": grid.origin().to_array(), "direction": grid.direction().to_cols_array(),
            },
            "frame": { "right": frame.right().to_array(), "up": frame.up().to_array(), "to_eye": frame.to_eye().to_array() },
            "sides": sides,
            "histogram": histogram(statistics),
            "channels": self.channels_described(first),
            "labels": self.labels_described(),
            "unavailable": self.unavailable(look),
            "choices": {
                "blend": Blend::ALL.map(Blend::name), "quality": Quality::ALL.map(Quality::name),
                "kernel": Kernel::OF_LAYERS.map(Kernel::name), "gradient": GradientEstimator::ALL.map(|gradient| gradient.to_string()),
            },
            "studio": studio_described(),
            "settings": Setting::plain().map(described).collect::<Vec<_>>(),
            "camera": camera, "camera_is_given": camera_is_given, "look": look,
            "transfer": NamedTransfer::from(transfer),
            "palettes": TransferFunction::palette_colors().map(|(name, colors)| json!({ "name": name, "colors": colors })).collect::<Vec<_>>(),
            "presets": presets.collect::<Vec<_>>(),
            "maps": maps.collect::<Vec<_>>(),
            "slices": slices::described(grid, values),
            "steps": self.steps(),
            "is_layered": is_layered,
            "notes": self.opening.notes,
            "scene": self.number,
            "opens_volumes": self.host.opens_volumes(),
            "offered": self.host.offered(),
        })
        .to_string()
    }

    /// The message to a page that shows these from now on, JSON.
    pub fn given(&self, now: &First) -> String {
        let First { camera, look, transfer, others, .. } = now;
        let others = others.iter().map(NamedTransfer::from).collect();
        serde_json::to_string(&Reply::Given { camera: *camera, look, transfer: transfer.into(), others })
            .expect("replies are plain data")
    }

    /// Statistics of each field.
    fn statistics(&self) -> &[Statistics] {
        let others = || self.opening.drawn.fields().iter().skip(1).map(|field| field.volume.statistics());
        self.statistics.get_or_init(|| std::iter::once(self.values().statistics()).chain(others()).collect())
    }

    /// The fields, if there are several.
    fn channels_described(&self, first: &First) -> Vec<Value> {
        let fields = self.opening.drawn.fields().iter().zip(self.statistics()).zip(first.transfers());
        let described = |((field, statistics), transfer): ((&PageField, &Statistics), TransferFunction)| json!({ "name": field.name, "histogram": histogram(statistics), "transfer": NamedTransfer::from(&transfer) });
        fields.map(described).collect()
    }

    /// The labels that voxels have, as they are shown at first. Of very many, those with most voxels.
    fn labels_described(&self) -> Vec<Value> {
        let Some(labels) = self.opening.drawn.labels() else { return Vec::new() };
        let layers = labels.layers().iter();
        let mut all: Vec<(&LabelLayer, &Label)> =
            layers.flat_map(|layer| layer.present().map(move |label| (layer, label))).collect();
        if all.len() > MOST_LABELS {
            all.sort_by_key(|(layer, label)| std::cmp::Reverse(layer.voxels_of(label.id)));
            all.truncate(MOST_LABELS);
        }
        let mut layers_of: HashMap<u32, usize> = HashMap::new();
        all.iter().for_each(|(_, label)| *layers_of.entry(label.id).or_default() += 1);
        let is_shared = |label: &Label| layers_of[&label.id] > 1;
        let described = |(found, label): (&LabelLayer, &Label)| {
            let name = label.name.as_ref().filter(|name| is_shared(label) && is_name(name));
            json!({
                "key": name.cloned().unwrap_or_else(|| label.id.to_string()), "id": label.id, "name": name_of(label),
                "color": label.color, "visible": label.visible, "voxels": found.voxels_of(label.id),
            })
        };
        all.into_iter().map(described).collect()
    }

    /// What the page cannot do with these fields, by name, and why.
    fn unavailable(&self, look: &Look) -> Map<String, Value> {
        let kind = self.kind();
        let plain = Look { shadows: false, ambient_occlusion: false, studio: None, shading: true, ..look.clone() };
        let plain = Look { blend: Blend::Composite, ..plain };
        // What does not go with the options of the program is said when it is chosen.
        let check = |look: Look| self.host.settings(&look, None).map_or(Ok(()), |settings| kind.check(&settings));
        let blends = Blend::ALL.into_iter().filter(|&blend| blend != Blend::Composite);
        let blends = blends.map(|blend| (blend.name(), check(Look { blend, ..plain.clone() })));
        let paper = Look { quality: Some(Quality::Paper), kernel: None, ..plain.clone() };
        let curve = match &self.opening.drawn {
            Drawn::Shown(Shown::Labels(..)) => Some("Labels have colours and opacities of their own: see the list of labels."),
            Drawn::Shown(Shown::Components(_, ColorOpacity::Alpha)) => Some("The opacity is the alpha of the file."),
            _ => None,
        };
        let checked = [
            ("shadows", check(Look { shadows: true, ..plain.clone() })),
            ("ambient-occlusion", check(Look { ambient_occlusion: true, ..plain.clone() })),
            ("studio", check(Look { studio: Some(PageStudio::of(&Studio::default())), ..plain.clone() })),
            ("slices", kind.check_method(Method::Slices, Blend::Composite)),
            ("paper", check(paper)),
        ];
        let refused = checked.into_iter().chain(blends);
        let refused = refused.filter_map(|(name, checked)| Some((name.to_owned(), self.host.sentence(&checked.err()?).into())));
        refused.chain(curve.map(|sentence| ("curve".to_owned(), sentence.into()))).collect()
    }

    /// Colours of a map.
    fn preview(&self, name: &str) -> Vec<[f64; 3]> {
        TransferFunction::builtin(name, self.values()).map_or_else(|_| Vec::new(), |map| strip(&map))
    }
}

/// The studio that a page begins with, and its lights, along the axes of the camera.
fn studio_described() -> Value {
    let studio = Settings::default().with_look(settings::Look::Studio);
    let Look { studio, lights, .. } = Look::of(&studio, Background::BLACK, 0.0, [1; 3]);
    let ranges = [("scattering", Studio::SCATTERING), ("exposure", Studio::EXPOSURE)];
    let ranges: Map<String, Value> = ranges.into_iter().map(|(name, number)| (name.into(), json!(number.range()))).collect();
    json!({ "look": studio, "lights": lights, "ranges": ranges })
}

/// What a control of a setting needs.
fn described(setting: &Setting) -> Value {
    let (names, range) = match setting.kind {
        Kind::Choice(names) => (Some(names()), None),
        Kind::Number(number) => (None, Some(number.range())),
        _ => (None, None),
    };
    let default = setting.get(&Settings::default());
    json!({ "name": setting.name, "help": setting.help, "default": default, "names": names, "range": range })
}

fn histogram(statistics: &Statistics) -> Value {
    json!({ "lowest": statistics.min, "highest": statistics.max, "counts": statistics.histogram })
}

/// Colours of a transfer function at even distances.
fn strip(transfer: &TransferFunction) -> Vec<[f64; 3]> {
    /// Enough for a strip on the page.
    const COLORS: usize = 12;
    let (lo, hi) = transfer.range();
    let at = |n: usize| transfer.color(lo + (hi - lo) * n as f64 / (COLORS - 1) as f64);
    (0..COLORS).map(|n| at(n).map(|c| (c * 1e3).round() / 1e3)).collect()
}
