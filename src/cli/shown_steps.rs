//! Colours and labels in time.

use super::options::{LabelOptions, VolumeOptions};
use super::values::Component;
use crate::annotation::Legend;
use crate::error::Error;
use crate::renderer::{ColorOpacity, vector_norms};
use crate::settings::FieldKind;
use crate::shown::{IndexedLabels, Shown, legend_of_all};
use crate::viewport::Viewport;
use crate::volume::{ChannelDescription, ColorChannels, Label, LabelTable, Labels, Sequence, Volume};
use std::collections::BTreeMap;
use std::path::Path;
use tracing::subscriber::{NoSubscriber, with_default};

/// Opens the colours of a file. `opacity`: as the options choose it.
///
/// # Errors
/// [`Error::Settings`] for a file with fewer than three components, or without the alpha that is chosen; those of reading it.
pub(super) fn open_colors(volume: &VolumeOptions, size: Viewport, opacity: Option<ColorOpacity>) -> Result<Shown, Error> {
    let described = volume.channel_descriptions(Some(size))?;
    colors_of(&volume.volume, &described, opacity, |number| volume.open_component(&Component::Number(number), Some(size)))
}

/// The colours of a file with these channels. See [`open_colors`].
pub(super) fn colors_of(
    file: &Path,
    described: &[ChannelDescription],
    opacity: Option<ColorOpacity>,
    component: impl Fn(usize) -> Result<Volume<'static>, Error>,
) -> Result<Shown, Error> {
    let file = file.display();
    let channels = ColorChannels::of(described).ok_or_else(|| {
        let problem = format!("direct needs 3 or 4 components, and {file} has {}: omit it", described.len());
        Error::Settings { field: "colors", problem }
    })?;
    if opacity == Some(ColorOpacity::Alpha) && !channels.has_alpha() {
        let problem = format!("alpha is a fourth component, and {file} has none: choose another");
        return Err(Error::Settings { field: "color_opacity", problem });
    }
    let components = channels.numbers().iter().map(|&number| component(number)).collect::<Result<Vec<_>, _>>()?;
    let default = if channels.has_alpha() { ColorOpacity::Alpha } else { ColorOpacity::Luminance };
    Ok(Shown::Components(channels.straight(components)?, opacity.unwrap_or(default)))
}

/// The vectors of a file with these components.
///
/// # Errors
/// [`Error::Settings`] for other numbers of components than three; those of reading them.
pub(super) fn vectors_of(component: impl Fn(usize) -> Result<Volume<'static>, Error>) -> Result<Shown, Error> {
    let first = component(0)?;
    let count = first.contents().channels;
    if count != 3 {
        let problem = format!("direction needs 3 components, and {} has {count}: omit it", first.name());
        return Err(Error::Settings { field: "colors", problem });
    }
    let components = std::iter::once(Ok(first)).chain((1..count).map(component)).collect::<Result<Vec<_>, _>>()?;
    let norms = Box::new(vector_norms(&components)?);
    Ok(Shown::Vectors { components, norms })
}

/// The steps of a sequence as colours or labels, which are read one by one.
pub(super) struct ShownSteps<'a> {
    volume: &'a VolumeOptions,
    labels: &'a LabelOptions,
    size: Viewport,
    color_opacity: Option<ColorOpacity>,
    sequence: Sequence,
    /// The labels of all steps; `None` for colours.
    of_all: Option<LabelsInTime>,
}

struct LabelsInTime {
    /// Names and looks, unless layers have tables of their own.
    table: Option<LabelTable>,
    /// Names and looks of the labels that voxels have in any step, with all changes.
    present: Vec<Label>,
}

impl<'a> ShownSteps<'a> {
    /// The steps of `sequence`, of colours or labels. Of labels, all steps are read for the names that there are.
    ///
    /// # Errors
    /// Those of reading the steps, and of changes of labels that no step has.
    pub fn new(
        volume: &'a VolumeOptions,
        labels: &'a LabelOptions,
        size: Viewport,
        color_opacity: Option<ColorOpacity>,
        sequence: Sequence,
        kind: FieldKind,
    ) -> Result<Self, Error> {
        let mut steps = Self { volume, labels, size, color_opacity, sequence, of_all: None };
        if kind == FieldKind::Labels {
            steps.of_all = Some(steps.labels_of_all()?);
        }
        Ok(steps)
    }

    /// Step `n`.
    ///
    /// # Errors
    /// Those of reading it.
    pub fn step(&self, n: usize) -> Result<Shown, Error> {
        let volume = self.at(n);
        let open = || match &self.of_all {
            None => open_colors(&volume, self.size, self.color_opacity),
            Some(all) => {
                let options = volume.opening(Some(self.size))?;
                let labels = self.labels.open_step(&volume.volume, &options, all.table.as_ref())?;
                IndexedLabels::new(labels).map(Shown::Labels)
            }
        };
        // What the first step has said holds for all.
        if n == 0 { open() } else { with_default(NoSubscriber::default(), open) }
    }

    /// Steps by which pictures are framed.
    pub fn sampled(&self) -> Vec<usize> {
        self.sequence.sampled_steps()
    }

    /// Names and colours of the visible labels of all steps; `None` for colours.
    pub fn legend(&self) -> Option<Legend> {
        self.of_all.as_ref().map(|all| legend_of_all(all.present.iter()))
    }

    /// The file and the frame of step `n`.
    fn at(&self, n: usize) -> VolumeOptions {
        let (file, frame) = self.sequence.source(n).expect("a step of the sequence");
        self.volume.at(file, frame)
    }

    fn labels_of_all(&self) -> Result<LabelsInTime, Error> {
        let (mut all, mut ids, mut last) = (BTreeMap::new(), Vec::new(), None);
        for n in 0..self.sequence.len() {
            let volume = self.at(n);
            let open = || self.labels.open_unchanged(&volume.volume, &volume.opening(Some(self.size))?);
            let labels = if n == 0 { open() } else { with_default(NoSubscriber::default(), open) }?;
            for layer in labels.layers() {
                all.extend(layer.table().labels().iter().map(|label| (label.id, label.clone())));
                ids.extend(layer.present().map(|label| label.id));
            }
            last = Some(labels);
        }
        let last: Labels = last.expect("a sequence has a step");
        ids.sort_unstable();
        ids.dedup();
        let table = if last.layers().len() == 1 { Some(LabelTable::new(all.into_values())?) } else { None };
        let changed = self.labels.changed_step(last, table.as_ref())?;
        let known = |id: &u32| changed.layers().iter().find_map(|layer| layer.table().get(*id)).cloned();
        let present = ids.iter().filter_map(known).collect();
        Ok(LabelsInTime { table, present })
    }
}
