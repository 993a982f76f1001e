//! Sequences of volumes in time.

use crate::argument::{Argument, extract};
use crate::calls::abandonable;
use crate::errors::{Failure, Result};
use crate::volume::{Volume, opening};
use crate::warned::{warn, warned};
use layersplat::volume::{Playback as OurPlayback, Sequence as Ours};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

/// Volumes of one shape and type in the order of time: the frames of a file, or of several files. Made by VolumeSequence.open.
///
/// It has a length; sequence[n] reads a step as a Volume, also with n < 0. Iterating (for volume in sequence) reads each step on another
/// thread while the one before is in use. Renderer.set_volume shows a step.
#[pyclass(frozen, module = "layersplat")]
pub struct VolumeSequence(Ours);

/// A path, or a list of paths.
fn sources(paths: &Bound<PyAny>) -> Result<Vec<PathBuf>> {
    match paths.extract::<PathBuf>() {
        Ok(path) => Ok(vec![path]),
        Err(_) => paths.extract().map_err(|error| {
            crate::argument::refused("paths", paths, error, "a path, or a list of paths: strings or pathlib.Path")
        }),
    }
}

fn no_step(n: impl std::fmt::Display, steps: usize) -> Failure {
    PyIndexError::new_err(format!("step {n} is not in the sequence, whose steps are 0 to {}", steps - 1)).into()
}

#[pymethods]
impl VolumeSequence {
    /// Opens the frames of a file with a time axis, of a .pvd of ParaView, of the files that match NAME%d.EXT, or of a list of paths, one after
    /// the other. Only headers are read; a step is read when it is asked for.
    ///
    /// The other arguments are those of Volume.open, and hold for all steps. Raises InvalidFile if steps differ in shape or type.
    #[staticmethod]
    #[pyo3(signature = (
        paths, *, dims = None, voxel_type = None, spacing = None, endian = None, header_bytes = None, background = None, channel = None,
        array = None, series = None, level = None,
    ))]
    #[allow(clippy::too_many_arguments)] // Python passes them by keyword.
    fn open(
        paths: &Bound<PyAny>,
        dims: Option<Argument<[usize; 3]>>,
        voxel_type: Option<Argument<String>>,
        spacing: Option<Argument<[f64; 3]>>,
        endian: Option<Argument<String>>,
        header_bytes: Option<Argument<u64>>,
        background: Option<Argument<f64>>,
        channel: Option<Argument<usize>>,
        array: Option<Argument<String>>,
        series: Option<Argument<String>>,
        level: Option<Argument<usize>>,
    ) -> Result<Self> {
        extract!(background);
        let (py, sources) = (paths.py(), sources(paths)?);
        let options = opening(dims, voxel_type, spacing, endian, header_bytes, None, channel, array, series, level)?;
        let (sequence, warnings) = warned(py, move || Ok(Ours::open(&sources, &options)?))?;
        warn(py, warnings)?;
        Ok(Self(match background {
            Some(value) => sequence.with_background(value),
            None => sequence,
        }))
    }

    fn __len__(&self) -> usize {
        self.0.len()
    }

    /// Reads a step.
    fn __getitem__(&self, py: Python, n: Argument<isize>) -> Result<Volume> {
        extract!(n);
        let steps = self.0.len();
        let step = if n < 0 { n.checked_add_unsigned(steps) } else { Some(n) };
        let step = step.and_then(|step| usize::try_from(step).ok()).filter(|&step| step < steps);
        let (step, sequence) = (step.ok_or_else(|| no_step(n, steps))?, self.0.clone());
        let (volume, warnings) = warned(py, move || Ok(sequence.step(step)?))?;
        warn(py, warnings)?;
        Ok(Volume::from_library(volume))
    }

    fn __iter__(&self) -> Result<Playback> {
        self.play(None)
    }

    /// Iterates over steps in any order, by default all: each is read on another thread while the one before is in use.
    ///
    /// steps: numbers of steps from 0 on, for example range(0, len(sequence), 2).
    #[pyo3(signature = (steps = None))]
    fn play(&self, steps: Option<Argument<Vec<usize>>>) -> Result<Playback> {
        extract!(steps);
        let count = self.0.len();
        let steps = steps.unwrap_or_else(|| (0..count).collect());
        if let Some(step) = steps.iter().find(|&&step| step >= count) {
            return Err(no_step(step, count));
        }
        Ok(Playback(Arc::new(Mutex::new(self.0.play(steps)))))
    }

    /// A Volume with the values of all steps, or of 16 from the first to the last, for transfer functions and ranges of values. It is not to be
    /// drawn: its voxels are a sample of those of the steps, one step after the other.
    fn overview(&self, py: Python) -> Result<Volume> {
        let sequence = self.0.clone();
        Ok(Volume::from_library(abandonable(py, move || Ok(sequence.overview()?))?))
    }

    fn __repr__(&self) -> String {
        let name = self.0.source(0).map_or_else(String::new, |(path, _)| path.display().to_string());
        format!("<layersplat.VolumeSequence of {} steps from {name}>", self.0.len())
    }
}

/// An iterator over steps of a VolumeSequence, which are read ahead. Made by VolumeSequence.play.
#[pyclass(frozen, module = "layersplat")]
pub struct Playback(Arc<Mutex<OurPlayback>>);

#[pymethods]
impl Playback {
    fn __iter__(slf: PyRef<'_, Self>) -> PyRef<'_, Self> {
        slf
    }

    /// The next step, once it is read. If it cannot be read, its error is raised, and the next call returns the step after it.
    fn __next__(&self, py: Python) -> Result<Option<Volume>> {
        let shared = self.0.clone();
        let next = abandonable(py, move || {
            let refused = |_| Failure::Panicked("layersplat panicked in this playback before: make another".into());
            Ok(shared.lock().map_err(refused)?.next().transpose()?)
        })?;
        Ok(next.map(Volume::from_library))
    }
}
