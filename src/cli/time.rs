//! Sequences in time: `rotate --time`.

use super::channels::{FieldSteps, PlayedField};
use super::keys::Keys;
use super::processes::Processes;
use super::scene::SceneOptions;
use super::shown_steps::ShownSteps;
use super::values::Component;
use crate::error::Error;
use crate::settings::FieldKind;
use crate::shown::Shown;
use crate::volume::{Playback, Sequence, Volume};
use clap::Args;
use std::path::PathBuf;

/// Selection of a sequence.
#[derive(Args)]
pub(super) struct TimeOptions {
    /// Further volumes of a sequence in time, in its order
    #[arg(value_name = "VOLUME", help_heading = "Volume")]
    more: Vec<PathBuf>,
    /// Let time run, over the frames of a file or several files; see below
    #[arg(long, help_heading = "Volume")]
    time: bool,
}

impl TimeOptions {
    /// Opens the sequence, if `--time` or the frames of keys ask for one.
    ///
    /// # Errors
    /// [`Error::Settings`] for options that conflict, [`Error::Volume`] if there is a single step, and those of [`Sequence::open`].
    pub fn sequence<'a>(
        &self,
        scene: &'a SceneOptions,
        keys: Option<&Keys>,
        processes: &Processes,
    ) -> Result<Option<Timed<'a>>, Error> {
        let wrong = |problem: &str| Err(Error::Settings { field: "time", problem: problem.into() });
        match (self.time, keys.is_some_and(Keys::have_frames)) {
            (false, false) if self.more.is_empty() => return Ok(None),
            (false, false) => return wrong("is needed for several volumes, which are the steps of a sequence: add it"),
            (true, true) => return wrong("and the frames of key cameras conflict: omit one of them"),
            _ if processes.counts().is_some() => {
                return wrong("plays a sequence in one process only: start layersplat without mpirun");
            }
            _ => {}
        }
        let kind = scene.colors.kind_in_time(scene)?;
        let of_colors = || kind.map(|_| Component::Number(0)).filter(|_| kind == Some(FieldKind::Colors));
        let (size, component) = (scene.camera.size, scene.channels.first_component().or_else(of_colors));
        let sequence = scene.volume.sequence(&self.more, component.as_ref(), Some(size), scene.bounds.memory)?;
        if sequence.len() == 1 {
            let problem = "it has one volume, and a sequence has several: name a file with a time axis, or several files";
            return Err(Error::volume(&scene.volume.volume, problem));
        }
        let others = scene.channels.steps(&scene.volume, &self.more, size, sequence.len())?;
        let sequence = scene.labels.masked_steps(sequence, scene.volume.placement())?;
        let shown = kind.map(|kind| scene.colors.steps(scene, &sequence, kind)).transpose()?;
        Ok(Some(Timed { sequence, others, shown }))
    }
}

/// A sequence, and the fields that are drawn together with it.
pub(super) struct Timed<'a> {
    pub sequence: Sequence,
    pub others: Vec<FieldSteps>,
    /// Colours or labels that its steps show instead of values.
    pub shown: Option<ShownSteps<'a>>,
}

/// A sequence, and the step that each picture shows.
pub(super) struct Moments<'a> {
    timed: Timed<'a>,
    steps: Vec<usize>,
}

impl<'a> Moments<'a> {
    /// Takes the steps from the frames of keys, or spreads them evenly over `count` pictures.
    pub fn new(timed: Timed<'a>, keys: Option<&Keys>, count: u32) -> Result<Self, Error> {
        let all = timed.sequence.len();
        let steps = match keys.filter(|keys| keys.have_frames()) {
            Some(keys) => keys.steps(count, all)?,
            None => spread(count, all),
        };
        Ok(Self { timed, steps })
    }

    pub fn timed(&self) -> &Timed<'a> {
        &self.timed
    }

    /// Starts to read the steps. Step 0 is that of the scene.
    pub fn play(&self) -> Played<'_> {
        let mut order = self.steps.clone();
        order.dedup();
        let first = usize::from(order[0] == 0);
        let order = order.split_off(first);
        let Timed { sequence, others, shown } = &self.timed;
        let others = others.iter().map(|field| field.play(&order)).collect();
        let first = match shown {
            Some(shown) => PlayedFirst::Shown(shown),
            None => PlayedFirst::Values(sequence.play(order)),
        };
        Played { steps: &self.steps, shown: 0, others, first }
    }
}

/// The steps of a film while it is made.
pub(super) struct Played<'a> {
    steps: &'a [usize],
    shown: usize,
    first: PlayedFirst<'a>,
    others: Vec<PlayedField<'a>>,
}

/// What is read for each step.
enum PlayedFirst<'a> {
    Values(Playback),
    Shown(&'a ShownSteps<'a>),
}

/// What another step shows.
pub(super) enum FirstOfStep {
    Values(Box<Volume<'static>>),
    Shown(Shown),
}

/// The volumes of another step.
pub(super) struct NextStep {
    pub first: FirstOfStep,
    /// Of each field beside the first, unless it stays as it is.
    pub others: Vec<Option<Volume<'static>>>,
}

impl Played<'_> {
    /// The step that picture `n` shows, unless it is that of the picture before. To be called for each picture in order.
    pub fn change(&mut self, n: usize) -> Result<Option<NextStep>, Error> {
        if std::mem::replace(&mut self.shown, self.steps[n]) == self.steps[n] {
            return Ok(None);
        }
        let first = match &mut self.first {
            PlayedFirst::Values(playback) => {
                FirstOfStep::Values(Box::new(playback.next().expect("a step is read for every change")?))
            }
            PlayedFirst::Shown(shown) => FirstOfStep::Shown(shown.step(self.steps[n])?),
        };
        let others = self.others.iter_mut().map(|field| field.next().transpose()).collect::<Result<_, _>>()?;
        Ok(Some(NextStep { first, others }))
    }
}

/// The step of each of `count` pictures: the nearest to its place between the first step and the last.
fn spread(count: u32, steps: usize) -> Vec<usize> {
    let (last, intervals) = (steps as u64 - 1, u64::from(count.max(2)) - 1);
    (0..u64::from(count)).map(|n| ((2 * n * last + intervals) / (2 * intervals)) as usize).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_spread_from_the_first_to_the_last() {
        assert_eq!(spread(4, 4), [0, 1, 2, 3]);
        assert_eq!(spread(5, 3), [0, 1, 1, 2, 2]);
        assert_eq!(spread(3, 9), [0, 4, 8]);
        assert_eq!((spread(1, 9), spread(2, 9)), (vec![0], vec![0, 8]));
        for (count, steps) in [(100_000, 7), (7, 100_000)] {
            let spread = spread(count, steps);
            assert!(spread.is_sorted() && spread[0] == 0 && spread[count as usize - 1] == steps - 1);
        }
    }
}
