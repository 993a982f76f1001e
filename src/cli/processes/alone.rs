//! A single process, for builds without MPI. Mirrors the interface of `several`.

use crate::camera::Camera;
use crate::cli::options::VolumeOptions;
use crate::error::Error;
use crate::image::Frame;
use crate::renderer::SeenVolume;
use crate::settings::Settings;
use crate::viewport::Viewport;
use crate::volume::Volume;
use clap::Args;
use std::process::ExitCode;

/// No options: there is one process.
#[derive(Args, Clone)]
pub(in crate::cli) struct TeamOptions {}

/// This process.
#[derive(Clone)]
pub(in crate::cli) struct Processes;

impl Processes {
    /// # Errors
    /// [`Error::Settings`] if MPI started several processes, because each of them would do all of the work.
    pub fn start() -> Result<Self, Error> {
        match super::started().filter(|&count| count > 1) {
            None => Ok(Self),
            Some(count) => {
                let problem = format!(
                    "MPI started {count} processes, but this layersplat is built without MPI: build it with --features mpi, or start it \
                     without mpirun"
                );
                Err(Error::Settings { field: "mpi", problem })
            }
        }
    }

    /// A run with a single process.
    pub fn alone() -> Self {
        Self
    }

    pub fn fail(self, message: &str, _: &Error, code: u8) -> ExitCode {
        eprintln!("layersplat: {message}");
        ExitCode::from(code)
    }

    pub fn leads(&self) -> bool {
        true
    }

    pub fn leads_team(&self) -> bool {
        true
    }

    pub fn counts(&self) -> Option<(usize, usize)> {
        None
    }

    pub fn make_teams(&self, _: &TeamOptions, _: &VolumeOptions, _: Viewport, _: usize) -> Result<(), Error> {
        Ok(())
    }

    pub fn in_turn(&self, mut work: impl FnMut() -> Result<(), Error>) -> Result<(), Error> {
        work()
    }

    pub fn agree<T>(&self, result: Result<T, Error>) -> Result<T, Error> {
        result
    }

    pub fn open(&self, options: &VolumeOptions, size: Option<Viewport>, memory: Option<u64>) -> Result<Volume<'static>, Error> {
        options.open(size, memory)
    }

    pub fn check_views(&self, _: SeenVolume, _: &[Camera], _: Viewport, _: &Settings) -> Result<(), Error> {
        Ok(())
    }

    pub fn owns(&self, _: usize) -> bool {
        true
    }

    pub fn collect(&self, _: usize, frame: Option<Frame>, _: Viewport) -> Option<Frame> {
        frame
    }

    pub fn gather(&self, numbers: Vec<f64>) -> Vec<f64> {
        numbers
    }

    pub fn broadcast(&self, read: impl FnOnce() -> Result<Vec<u8>, Error>) -> Result<Vec<u8>, Error> {
        read()
    }

    pub fn wait(&self) {}
}
