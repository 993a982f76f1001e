//! Sequences in time: the step that a page shows, and the next one, which is read while this one is drawn.

use super::drawn::CurrentLook;
use super::scene::SharedScene;
use crate::error::Error;
use crate::framing::Framing;
use crate::settings::{Blend, CropBox, Settings};
use crate::volume::{Grid, Playback, Sequence, Volume};

impl SharedScene {
    /// The sequence, if there is one.
    fn sequence(&self) -> Option<&Sequence> {
        self.opening.time.as_ref().map(|time| &time.sequence)
    }

    /// Number of steps, 1 for a volume that is no sequence.
    pub(super) fn steps(&self) -> usize {
        self.sequence().map_or(1, Sequence::len)
    }

    /// Reads a step.
    ///
    /// # Errors
    /// Those of [`Sequence::step`].
    pub(super) fn step(&self, step: usize) -> Result<Volume<'static>, Error> {
        self.check_step(step)?;
        match self.sequence().filter(|_| step > 0) {
            Some(sequence) => sequence.step(step),
            // The first step is at hand.
            None => Ok(self.opening.volume.clone()),
        }
    }

    /// Checks the number of a step.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if there is no such step.
    pub(super) fn check_step(&self, step: usize) -> Result<(), Error> {
        if step < self.steps() {
            return Ok(());
        }
        Err(Error::OutOfRange { name: "frame", value: step.to_string(), expected: "a frame that the volume has, from 0" })
    }

    /// Starts to read steps in this order.
    pub(super) fn play(&self, order: Vec<usize>) -> Option<Playback> {
        self.sequence().map(|sequence| sequence.play(order))
    }

    /// A volume with the values of all steps, for histograms and transfer functions.
    pub(super) fn values(&self) -> &Volume<'static> {
        self.opening.time.as_ref().map_or(&self.opening.volume, |time| &time.overview)
    }

    /// Bounds of what is visible, in any sampled step of a sequence.
    ///
    /// # Errors
    /// Those of reading a step.
    pub(super) fn framing(&self, settings: &Settings, now: CurrentLook) -> Result<Framing, Error> {
        let transfer = &now.transfers[0];
        let cropped = |framing: Framing, grid: &Grid| match settings.clipping.crop {
            Some(CropBox { lowest, highest }) => framing.cropped(grid, lowest, highest),
            None => framing,
        };
        if let Some(framing) = self.framing_of_fields(settings, now)? {
            return Ok(cropped(framing, self.opening.volume.grid()));
        }
        let of = |volume: &Volume| {
            let framing = match settings.blend {
                Blend::Composite => Framing::visible(volume, transfer, settings.unit_distance),
                Blend::Iso(value) => Framing::iso(volume, value),
                _ => Framing::whole(volume),
            };
            cropped(framing, volume.grid())
        };
        let Some(sequence) = self.sequence() else { return Ok(of(&self.opening.volume)) };
        let mut shown: Option<Framing> = None;
        for step in sequence.play(sequence.sampled_steps()) {
            let framing = of(&step?);
            shown = Some(shown.map_or(framing.clone(), |shown| shown.joined(framing)));
        }
        Ok(shown.expect("a sequence has a step"))
    }
}

/// The step that a page shows.
pub(super) struct Moment {
    step: usize,
    volume: Volume<'static>,
    /// A step that is being read ahead.
    next: Option<(usize, Playback)>,
}

impl Moment {
    /// The first step.
    pub fn new(scene: &SharedScene) -> Self {
        Self { step: 0, volume: scene.opening.volume.clone(), next: None }
    }

    pub fn step(&self) -> usize {
        self.step
    }

    pub fn volume(&self) -> &Volume<'static> {
        &self.volume
    }

    /// Goes to another step. If it is next to the last one, the one that follows in the same direction is read from now on, from the end to the
    /// start, too.
    ///
    /// # Errors
    /// Those of reading the step; the moment stays.
    pub fn go(&mut self, scene: &SharedScene, to: usize) -> Result<(), Error> {
        self.volume = match self.next.take() {
            Some((step, mut read)) if step == to => read.next().expect("one step is read")?,
            _ => scene.step(to)?,
        };
        let from = std::mem::replace(&mut self.step, to);
        self.next = following(from, to, scene.steps()).and_then(|next| Some((next, scene.play(vec![next])?)));
        Ok(())
    }
}

/// The step after `to` if `from` was its neighbour, on a circle of `steps`.
fn following(from: usize, to: usize, steps: usize) -> Option<usize> {
    let (after, before) = ((to + 1) % steps, (to + steps - 1) % steps);
    let next = match from {
        from if from == before => after,
        from if from == after => before,
        _ => return None,
    };
    (next != to).then_some(next)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_step_that_follows_is_in_the_same_direction() {
        let found = [(0, 1, 5), (4, 0, 5), (3, 4, 5), (3, 2, 5), (1, 0, 5), (0, 1, 2), (1, 0, 2), (0, 2, 5), (4, 1, 5)];
        let expected = [Some(2), Some(1), Some(0), Some(1), Some(4), Some(0), Some(1), None, None];
        assert_eq!(found.map(|(from, to, steps)| following(from, to, steps)), expected);
    }
}
