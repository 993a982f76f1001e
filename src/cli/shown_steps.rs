//! Colours and labels in time.

use super::scene::SceneOptions;
use crate::annotation::Legend;
use crate::error::Error;
use crate::settings::FieldKind;
use crate::shown::{IndexedLabels, Shown, legend_of_all};
use crate::volume::{Label, LabelTable, Labels, OpenOptions, Sequence};
use std::collections::BTreeMap;
use tracing::subscriber::{NoSubscriber, with_default};

/// The steps of a sequence as colours or labels, which are read one by one.
pub(super) struct ShownSteps<'a> {
    scene: &'a SceneOptions,
    sequence: Sequence,
    /// The labels of all steps; `None` for colours.
    labels: Option<LabelsInTime>,
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
    pub fn new(scene: &'a SceneOptions, sequence: Sequence, kind: FieldKind) -> Result<Self, Error> {
        let mut steps = Self { scene, sequence, labels: None };
        if kind == FieldKind::Labels {
            steps.labels = Some(steps.labels_of_all()?);
        }
        Ok(steps)
    }

    /// Step `n`.
    ///
    /// # Errors
    /// Those of reading it.
    pub fn step(&self, n: usize) -> Result<Shown, Error> {
        let (file, frame) = self.sequence.source(n).expect("a step of the sequence");
        let volume = self.scene.volume.at(file, frame);
        let open = || match &self.labels {
            None => self.scene.colors.open_colors(&volume, self.scene.camera.size),
            Some(all) => {
                let labels = self.scene.labels.open_step(file, &self.options(n)?, all.table.as_ref())?;
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
        self.labels.as_ref().map(|all| legend_of_all(all.present.iter()))
    }

    fn options(&self, n: usize) -> Result<OpenOptions, Error> {
        let (file, frame) = self.sequence.source(n).expect("a step of the sequence");
        self.scene.volume.at(file, frame).opening(Some(self.scene.camera.size))
    }

    fn labels_of_all(&self) -> Result<LabelsInTime, Error> {
        let (mut all, mut ids, mut last) = (BTreeMap::new(), Vec::new(), None);
        for n in 0..self.sequence.len() {
            let (file, _) = self.sequence.source(n).expect("a step of the sequence");
            let open = || self.scene.labels.open_unchanged(file, &self.options(n)?);
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
        let changed = self.scene.labels.changed_step(last, table.as_ref())?;
        let known = |id: &u32| changed.layers().iter().find_map(|layer| layer.table().get(*id)).cloned();
        let present = ids.iter().filter_map(known).collect();
        Ok(LabelsInTime { table, present })
    }
}
