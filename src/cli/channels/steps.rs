//! Fields beside the first one, in time.

use super::transform::FieldTransform;
use super::{ChannelOptions, Components, FieldSpec};
use crate::cli::options::VolumeOptions;
use crate::cli::values::Component;
use crate::error::Error;
use crate::viewport::Viewport;
use crate::volume::{Playback, Sequence, Volume};
use std::path::PathBuf;

/// A field beside the first one: a step for each of the first, or one for all.
pub(in crate::cli) struct FieldSteps {
    sequence: Sequence,
    transform: FieldTransform,
}

impl ChannelOptions {
    /// The steps of the fields beside the first one, whose sequence has `count` steps. `more`: further files of the sequence.
    ///
    /// # Errors
    /// [`Error::Settings`] for scenes, and for fields with other numbers of steps; errors of files.
    pub fn steps(
        &self,
        options: &VolumeOptions,
        more: &[PathBuf],
        size: Viewport,
        count: usize,
    ) -> Result<Vec<FieldSteps>, Error> {
        let refuse = |problem: String| Err(Error::Settings { field: "time", problem });
        if self.has_scene() {
            return refuse("plays no scene file: name its fields with --channels and --with".into());
        }
        let mut fields = Vec::new();
        if let Some(components) = &self.channels {
            let listed = match components {
                Components::All => (0..options.channel_descriptions(Some(size))?.len()).map(Component::Number).collect(),
                Components::Listed(listed) => listed.clone(),
            };
            for component in listed.iter().skip(1) {
                let sequence = options.sequence(more, Some(component), Some(size), None)?;
                fields.push(FieldSteps { sequence, transform: FieldSpec::default().transform()? });
            }
        }
        for spec in &self.with {
            fields.push(FieldSteps { sequence: spec.sequence(options.placement())?, transform: spec.transform()? });
        }
        match fields.iter().map(|field| field.sequence.len()).find(|&own| own != 1 && own != count) {
            Some(own) => refuse(format!("plays {count} steps, and a field beside the first has {own}: choose one of its frames")),
            None => Ok(fields),
        }
    }
}

impl FieldSteps {
    /// A step.
    pub fn step(&self, n: usize) -> Result<Volume<'static>, Error> {
        self.transform.applied_to(self.sequence.step(if self.is_still() { 0 } else { n })?)
    }

    /// A volume with the values of all steps.
    pub fn overview(&self) -> Result<Volume<'static>, Error> {
        self.sequence.overview()
    }

    fn is_still(&self) -> bool {
        self.sequence.len() == 1
    }

    /// Starts to read the steps in `order`, which begins after the first.
    pub fn play(&self, order: &[usize]) -> PlayedField<'_> {
        PlayedField { field: self, playback: (!self.is_still()).then(|| self.sequence.play(order.to_vec())) }
    }
}

/// A field while a film is made.
pub(in crate::cli) struct PlayedField<'a> {
    field: &'a FieldSteps,
    /// `None` if it has one step.
    playback: Option<Playback>,
}

impl PlayedField<'_> {
    /// The next step, unless the field stays as it is.
    pub fn next(&mut self) -> Option<Result<Volume<'static>, Error>> {
        let step = self.playback.as_mut()?.next().expect("a step is read for every change");
        Some(step.and_then(|volume| self.field.transform.applied_to(volume)))
    }
}
