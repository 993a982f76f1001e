//! Sequences of volumes in time.

mod ahead;
mod along;
mod overview;

use super::format::{self, OpenOptions};
use super::labels::Mask;
use super::{Grid, Labels, ScalarType, Volume, builtin};
use crate::error::Error;
use ahead::Ahead;
pub use along::steps_along;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Volumes of one size and type in the order of time: the frames of a file with a time axis, of several files, one after the other, of the
/// files that ParaView's `.pvd` names (feature `vtk`), or of those that match a name with `%d` in place of the number.
/// Opening a sequence reads headers only; a step is read when it is asked for.
///
/// ```
/// use layersplat::volume::{OpenOptions, Sequence};
///
/// let sequence = Sequence::open(&["builtin:hydrogen@16", "builtin:gyroid@16"], &OpenOptions::default())?;
/// assert_eq!(sequence.len(), 2);
/// // Step 1 is read while step 0 is in use.
/// for (n, volume) in sequence.play(vec![0, 1]).enumerate() {
///     assert_eq!(volume?.name(), sequence.step(n)?.name());
/// }
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Sequence {
    steps: Vec<Step>,
    options: OpenOptions,
    background: Option<f64>,
    mask: Option<Arc<Mask>>,
}

/// Where a step is.
#[derive(Clone, Debug)]
struct Step {
    path: PathBuf,
    /// Frame of the file; `None` for built-in volumes, which have no frames.
    frame: Option<usize>,
}

/// What all steps have in common: numbers of voxels and the type of their stored numbers.
type Layout = ([usize; 3], ScalarType);

impl Sequence {
    /// Opens the frames of all `sources`, each of them as for [`Volume::open`].
    ///
    /// # Errors
    /// Those of [`Volume::open`] that headers show; [`Error::Volume`] if steps differ in size or type; [`Error::Settings`] if there are no
    /// sources, or `options` select a frame.
    pub fn open(sources: &[impl AsRef<Path>], options: &OpenOptions) -> Result<Self, Error> {
        if options.frame.is_some() {
            let problem = "selects one volume, but a sequence has them all: omit it".into();
            return Err(Error::Settings { field: "frame", problem });
        }
        let mut options = options.clone();
        let mut steps: Vec<Step> = Vec::new();
        let mut first: Option<Layout> = None;
        let sources: Result<Vec<_>, Error> = sources.iter().map(|source| format::collected(source.as_ref(), &options)).collect();
        for source in sources?.concat() {
            let (layout, frames, channel) = layout(&source, &options)?;
            // What is chosen by default is chosen for all steps, so that a warning does not come with each.
            options.channel = options.channel.or(channel);
            let first = *first.get_or_insert(layout);
            if layout != first {
                let ([this, that], n, start) = ([layout, first].map(describe), steps.len(), steps[0].path.display());
                let problem = format!(
                    "step {n} of the sequence has {this}, but step 0, {start}, has {that}: convert the file, or leave it out"
                );
                return Err(Error::volume(&source, problem));
            }
            match frames {
                None => steps.push(Step { path: source, frame: None }),
                Some(frames) => steps.extend((0..frames).map(|frame| Step { path: source.clone(), frame: Some(frame) })),
            }
        }
        if steps.is_empty() {
            return Err(Error::Settings {
                field: "steps",
                problem: "are none: name a file with a time axis, or several files".into(),
            });
        }
        Ok(Self { steps, options, background: None, mask: None })
    }

    /// Sets the background of all steps; see [`Description::with_background`](super::Description::with_background).
    pub fn with_background(self, value: f64) -> Self {
        Self { background: Some(value), ..self }
    }

    /// Shows of all steps only what lies within visible labels ([`Volume::masked`]). Steps are masked when they are read.
    ///
    /// # Errors
    /// If memory is too small for the labels.
    pub fn with_mask(self, mask: &Labels) -> Result<Self, Error> {
        Ok(Self { mask: Some(Arc::new(Mask::new(mask)?)), ..self })
    }

    /// The sequence of step `n` alone.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if there is no such step.
    #[doc(hidden)]
    pub fn only(mut self, n: usize) -> Result<Self, Error> {
        if n >= self.len() {
            let expected = "the number of a frame, from 0";
            return Err(Error::OutOfRange { name: "frame", value: n.to_string(), expected });
        }
        self.steps = vec![self.steps.swap_remove(n)];
        Ok(self)
    }

    /// Number of steps, at least 1.
    #[allow(clippy::len_without_is_empty)] // There is at least one.
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// File of step `n`, if there is such a step, and its frame of this file. Built-in volumes have no frames.
    pub fn source(&self, n: usize) -> Option<(&Path, Option<usize>)> {
        self.steps.get(n).map(|step| (step.path.as_path(), step.frame))
    }

    /// Reads step `n`. Its range is its own.
    ///
    /// # Errors
    /// Those of [`Volume::open`] and [`Volume::masked`]; [`Error::OutOfRange`] if the sequence has no such step.
    pub fn step(&self, n: usize) -> Result<Volume<'static>, Error> {
        let expected = "the number of a step of the sequence, from 0";
        let step = self.steps.get(n).ok_or_else(|| Error::OutOfRange { name: "step", value: n.to_string(), expected })?;
        let volume = Volume::open(&step.path, &OpenOptions { frame: step.frame, ..self.options.clone() })?;
        let volume = match self.background {
            Some(value) => volume.with_background(value)?,
            None => volume,
        };
        match &self.mask {
            Some(mask) => mask.applied_to(&volume),
            None => Ok(volume),
        }
    }

    /// Reads the steps in `order` on another thread, each while the caller uses the one before. At most two are in memory, besides those
    /// that the caller keeps.
    pub fn play(&self, order: Vec<usize>) -> Playback {
        let sequence = self.clone();
        Playback { ahead: Ahead::new(order, move |n| sequence.step(n)) }
    }
}

/// Steps of a [`Sequence`] that are read ahead. Dropping it waits for the step that is being read.
///
/// ```
/// use layersplat::volume::{OpenOptions, Sequence};
///
/// let sequence = Sequence::open(&["builtin:cube@4", "builtin:gyroid@4"], &OpenOptions::default())?;
/// let names: Result<Vec<String>, _> = sequence.play(vec![1, 0]).map(|step| Ok(step?.name().to_owned())).collect();
/// assert_eq!(names?, ["builtin:gyroid@4", "builtin:cube@4"]);
/// # Ok::<(), layersplat::Error>(())
/// ```
pub struct Playback {
    ahead: Ahead<Result<Volume<'static>, Error>>,
}

impl Iterator for Playback {
    type Item = Result<Volume<'static>, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        self.ahead.next()
    }
}

/// Layout of a source, its number of frames unless it is built in, and the channel that is read of several.
fn layout(source: &Path, options: &OpenOptions) -> Result<(Layout, Option<usize>, Option<usize>), Error> {
    if let Some(name) = source.to_str().and_then(|name| name.strip_prefix("builtin:")) {
        let (_, grid, _) = builtin::sampled(name, options)?;
        return Ok(((grid.dims(), ScalarType::Uint8), None, None));
    }
    let of_frame = |frame, channel| format::header(source, &OpenOptions { frame: Some(frame), channel, ..options.clone() });
    let header = of_frame(0, options.channel)?;
    let channel = Some(header.contents.channel).filter(|_| header.contents.channels > 1 && !header.contents.magnitude);
    // The last frame shows whether the file is long enough for all of them.
    if header.contents.frames > 1 {
        of_frame(header.contents.frames - 1, options.channel.or(channel))?;
    }
    Ok(((header.grid.dims(), header.scalar), Some(header.contents.frames), channel))
}

fn describe(([x, y, z], scalar): Layout) -> String {
    format!("{x}x{y}x{z} voxels of {scalar}")
}

#[cfg(test)]
mod tests;
