//! What a program that shows pages knows, and what it is asked.

use super::first::Opening;
use super::look::Look;
use super::page_camera::PageCamera;
use super::requests::SavedFormat;
use crate::error::Error;
use crate::settings::{Quality, Settings};
use crate::viewport::Viewport;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What the program that shows the page knows: its options, and how they are written.
pub trait Host: Send + Sync {
    /// The settings of a look, with the program's own options. `quality` replaces that of the look.
    ///
    /// # Errors
    /// If the look does not go with the options.
    fn settings(&self, look: &Look, quality: Option<Quality>) -> Result<Settings, Error>;

    /// Whether [`require_checked`](Self::require_checked) returns at once.
    fn is_checked(&self, _camera: &crate::Camera, _size: Viewport, _settings: &Settings) -> bool {
        true
    }

    /// Fails if the device may not draw such pictures. May take seconds for the first picture of a kind.
    ///
    /// # Errors
    /// If the device check failed.
    fn require_checked(&self, camera: &crate::Camera, size: Viewport, settings: &Settings) -> Result<(), Error>;

    /// The command that makes a picture.
    fn command_line(&self, wanted: &Wanted) -> String;

    /// The same picture as a program in Python.
    fn python(&self, wanted: &Wanted) -> String;

    /// The command that makes a film, if the program has one.
    fn film_command_line(&self, _: &FilmWanted) -> Option<String> {
        None
    }

    /// Whether the page may open other volumes.
    fn opens_volumes(&self) -> bool {
        false
    }

    /// Volumes that the page may open by name.
    fn offered(&self) -> Vec<Offered> {
        Vec::new()
    }

    /// Opens another volume, with the program's options that go with any volume.
    ///
    /// # Errors
    /// If it is not offered or cannot be read.
    fn open(&self, _: &Source) -> Result<(Opening, Box<dyn Host>), Error> {
        Err(Error::Settings { field: "page", problem: "this program shows a single volume".into() })
    }

    /// Whether programs of usual frames are built in the background, with the first page.
    fn builds_ahead(&self) -> bool {
        true
    }

    /// A sentence for an error, with what the user can do.
    fn sentence(&self, error: &Error) -> String {
        error.to_string()
    }
}

/// A picture whose command is asked for.
#[derive(Clone, Copy)]
pub struct Wanted<'a> {
    /// Its look, with a quality.
    pub look: &'a Look,
    /// Its camera.
    pub camera: &'a PageCamera,
    /// The same camera in the world.
    pub view: crate::Camera,
    /// Its size.
    pub size: Viewport,
    /// N × N samples per pixel.
    pub samples: u32,
    /// Format of the file.
    pub format: SavedFormat,
    /// Name of the transfer function's file.
    pub transfer: &'a str,
    /// Names of the files with those of the other fields.
    pub others: &'a [String],
    /// Unit of length, if it is known.
    pub length_units: Option<&'a str>,
}

/// A film whose command is asked for.
#[derive(Clone, Copy)]
pub struct FilmWanted<'a> {
    /// Its look, with a quality.
    pub look: &'a Look,
    /// Size of its pictures.
    pub size: Viewport,
    /// N × N samples per pixel.
    pub samples: u32,
    /// Pictures per second.
    pub rate: u32,
    /// Name of the film's file.
    pub output: &'a str,
    /// Name of the file with the key cameras.
    pub keys: &'a str,
    /// Name of the transfer function's file.
    pub transfer: &'a str,
    /// Names of the files with those of the other fields.
    pub others: &'a [String],
    /// Unit of length, if it is known.
    pub length_units: Option<&'a str>,
}

/// A volume that the page may open.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Offered {
    /// Its name, without folders.
    pub name: String,
    /// Whether it is built in.
    pub is_builtin: bool,
}

/// What is opened.
#[derive(Clone, Copy, Debug)]
pub enum Source<'a> {
    /// One of the offered volumes, by its name.
    Offered(&'a str),
    /// A temporary file, which exists as long as its volume.
    File(&'a Path, RawLayout),
}

/// How a raw file holds its voxels, as far as its name does not say it.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct RawLayout {
    /// Whether the most significant byte of a number comes first.
    pub big_endian: bool,
    /// Bytes before the first voxel.
    pub header_bytes: u64,
}
