//! Several fields, colours and labels: what pages draw of a scene, and the options that say how a page shows them.

use crate::annotation::LegendEntry;
use crate::cli::channels;
use crate::cli::scene::OpenedScene;
use crate::error::Error;
use crate::settings::FieldKind;
use crate::viewer::{Drawn, IndexedLabels, Look, PageChannel, PageField};

/// How the fields of a page are shown at first.
#[derive(Clone)]
pub(super) struct FirstFields {
    kind: FieldKind,
    channels: Vec<PageChannel>,
}

impl FirstFields {
    pub fn new(kind: FieldKind, look: &Look) -> Self {
        Self { kind, channels: look.channels.clone() }
    }

    /// Whether a transfer function is part of the picture.
    pub fn have_transfer(&self) -> bool {
        self.kind != FieldKind::Labels
    }

    /// What a program in Python with a single volume leaves out.
    pub fn missing_in_python(&self) -> Option<&'static str> {
        match self.kind {
            FieldKind::One | FieldKind::LabelColors => None,
            FieldKind::Several | FieldKind::Mixed => {
                Some("all fields but the first, factors and visibilities: see layersplat.Channel")
            }
            FieldKind::Colors => Some("colours: see layersplat.Colors"),
            FieldKind::Labels => Some("labels: see layersplat.Labels"),
        }
    }

    /// The options of a look. `others`: files with the transfer functions of all fields but the first.
    pub fn words(&self, look: &Look, others: &[String]) -> Vec<String> {
        // A given colour changes those that other fields get by default.
        let is_recolored = look.channels.iter().zip(&self.channels).any(|(now, first)| now.color != first.color);
        let fields = look.channels.iter().zip(&self.channels).enumerate().filter_map(|(n, (now, first))| {
            let transfer = n.checked_sub(1).and_then(|n| others.get(n)).map(|name| format!("transfer={name}"));
            let factor = (now.factor != first.factor).then(|| format!("factor={}", now.factor));
            let visible = (now.visible != first.visible).then(|| format!("visible={}", if now.visible { "on" } else { "off" }));
            let color = is_recolored.then(|| format!("color={}", now.color));
            let keys: Vec<String> = [transfer, factor, visible, color].into_iter().flatten().collect();
            (!keys.is_empty()).then(|| ["--field".to_owned(), format!("{n},{}", keys.join(","))])
        });
        let labels = look.labels.words().into_iter().map(|word| ["--label".to_owned(), word]);
        fields.chain(labels).flatten().collect()
    }
}

/// What pages draw of a scene, and how its fields are shown at first.
///
/// # Errors
/// [`Error::Settings`] for the colours of labels over what is not one volume; if memory or the temporary folder is too small.
pub(super) fn drawn_of(scene: &mut OpenedScene) -> Result<(Drawn, Vec<PageChannel>), Error> {
    if let Some(labels) = scene.label_colors.take() {
        if scene.has_channels() {
            let problem = "are those of one volume of values, and several fields are given: omit one of both".into();
            return Err(Error::Settings { field: "label_colors", problem });
        }
        return Ok((Drawn::LabelColors(IndexedLabels::new(labels)?), Vec::new()));
    }
    if !scene.has_channels() {
        return Ok((scene.shown.take().map_or(Drawn::One, Drawn::Shown), Vec::new()));
    }
    let (volume, transfer) = (scene.volume.clone(), scene.transfer.clone());
    let first = channels::Field { volume, transfer, look: scene.look, shown: scene.shown.take() };
    let fields = std::iter::once(first).chain(std::mem::take(&mut scene.others)).zip(&scene.entries);
    let described = |(field, entry): (channels::Field, &LegendEntry)| {
        let channels::Field { volume, shown, transfer, look } = field;
        let channels::FieldLook { factor, visible, iso, gradient_opacity } = look;
        let color = entry.colors.iter().flatten().map(|c| format!("{:02x}", (c * 255.0).round() as u8)).collect::<String>();
        let field = PageField { name: entry.name.clone(), volume, shown, transfer, iso, gradient_opacity };
        (field, PageChannel { visible, factor, color: format!("#{color}") })
    };
    let (fields, channels) = fields.map(described).unzip();
    Ok((Drawn::Several(fields), channels))
}
