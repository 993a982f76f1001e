//! Series of DICOM images (<https://www.dicomstandard.org>): a folder of them, one of its files, or one file of many frames.

mod dataset;
mod image;
mod packed;
mod pixels;
mod place;

use super::load::{self, Header, Opened};
use super::{Format, Found, OpenOptions, choice, listed};
use crate::error::Error;
use crate::volume::{Rescale, ScalarType};
use image::Image;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The format.
pub(super) struct Dicom;

impl Format for Dicom {
    fn recognises(&self, file: &Found, _options: &OpenOptions) -> bool {
        if file.folder { files(file.path).is_ok_and(|files| !files.is_empty()) } else { dataset::is_start(&file.start) }
    }

    fn chooses(&self) -> &'static [&'static str] {
        &["series"]
    }

    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error> {
        let path = file.path;
        let images = if file.folder { series(path, options)? } else { series_of(path, options)? };
        check_alike(&images)?;
        let (shape, kind) = (images[0].shape, images[0].kind);
        let stack = place::stack(path, &images, options)?;
        let channel = choice::chosen(path, "channel", options.channel, shape.channels)?;
        let dims = [shape.columns, shape.rows, stack.slices.len()];
        let grid = load::grid(path, dims, stack.index_to_world, options)?;
        let scales: BTreeSet<[u64; 2]> = stack.slices.iter().map(|&(image, frame)| scale(&images[image], frame)).collect();
        let floats = matches!(kind.scalar, ScalarType::Float32 | ScalarType::Float64);
        let one = scales.len() == 1 || floats;
        let (image, frame) = stack.slices[0];
        let (slope, intercept) = (images[image].frames[frame].slope, images[image].frames[frame].intercept);
        let header = if one {
            let rescale = Rescale::new(slope, intercept).map_err(|e| Error::volume(path, e.to_string()))?;
            Header { rescale, ..Header::new(grid, kind.scalar) }
        } else {
            tracing::info!("{}: every slice has a scale of its own: values become floats", path.display());
            Header::new(grid, ScalarType::Float32)
        };
        let bytes = pixels::Pixels::new(images, stack.slices, channel, !one).map_err(|e| unreadable(path, e))?;
        Ok(Opened { header, bytes: Box::new(bytes), exact: false })
    }
}

fn unreadable(path: &Path, e: std::io::Error) -> Error {
    match e.kind() {
        std::io::ErrorKind::UnexpectedEof | std::io::ErrorKind::InvalidData => {
            Error::volume(path, format!("its pixels are truncated or damaged: {e}"))
        }
        _ => Error::read(path, e),
    }
}

fn scale(image: &Image, frame: usize) -> [u64; 2] {
    [image.frames[frame].slope.to_bits(), image.frames[frame].intercept.to_bits()]
}

/// All of a folder that have the format's mark.
fn files(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let mut files = listed(folder)?;
    files.retain(|file| Found::look(file).is_ok_and(|found| dataset::is_start(&found.start)));
    files.sort();
    Ok(files)
}

/// The images among files; each but once, for copies are common.
fn images(files: &[PathBuf]) -> Result<Vec<Image>, Error> {
    let (mut found, mut seen) = (Vec::new(), BTreeSet::new());
    for file in files {
        let Some(image) = Image::new(file, dataset::read(file)?)? else { continue };
        if image.identifier.clone().is_none_or(|identifier| seen.insert(identifier)) {
            found.push(image);
        } else {
            tracing::warn!("{}: it is a copy of another file: left out", file.display());
        }
    }
    Ok(found)
}

/// The one series of a folder, or the one that is wanted.
fn series(folder: &Path, options: &OpenOptions) -> Result<Vec<Image>, Error> {
    let mut images = images(&files(folder)?)?;
    let identifiers: BTreeSet<String> = images.iter().map(|image| image.series.clone()).collect();
    let names = || {
        let of = |identifier: &String| images.iter().filter(|image| image.series == *identifier).collect::<Vec<_>>();
        identifiers.iter().map(|identifier| named(&of(identifier))).collect::<Vec<_>>().join(", ")
    };
    let is_called = |image: &Image, name: &str| {
        image.series == name || [&image.number, &image.description].into_iter().flatten().any(|other| other == name)
    };
    let found: BTreeSet<String> = match &options.series {
        Some(name) => images.iter().filter(|image| is_called(image, name)).map(|image| image.series.clone()).collect(),
        None => identifiers.clone(),
    };
    let problem = match (&options.series, found.len()) {
        _ if images.is_empty() => {
            return Err(Error::volume(folder, "its DICOM files have no pixels: give the folder of a series of images"));
        }
        (_, 1) => {
            images.retain(|image| found.contains(&image.series));
            return Ok(images);
        }
        (Some(name), 0) => format!("'{name}' is not in {}, whose series are {}", folder.display(), names()),
        (Some(name), _) => format!("several series of {} are called '{name}': {}", folder.display(), names()),
        (None, several) => format!("{} has {several} series: {}; choose one", folder.display(), names()),
    };
    Err(Error::Settings { field: "series", problem })
}

/// How a series is called in a message.
fn named(images: &[&Image]) -> String {
    let first = images[0];
    let [number, description] = [&first.number, &first.description].map(|text| text.clone().unwrap_or_default());
    let frames: usize = images.iter().map(|image| image.frames.len()).sum();
    format!("{number} '{description}' ({frames} slices, {})", first.series)
}

/// The series that a file is of, in its folder; a file of several frames alone.
fn series_of(path: &Path, options: &OpenOptions) -> Result<Vec<Image>, Error> {
    let no_pixels = || Error::volume(path, "it is a DICOM file without pixels: give an image of a series, or their folder");
    let image = Image::new(path, dataset::read(path)?)?.ok_or_else(no_pixels)?;
    if image.frames.len() > 1 || image.series.is_empty() {
        return Ok(vec![image]);
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let wanted = OpenOptions { series: Some(options.series.clone().unwrap_or(image.series)), ..OpenOptions::default() };
    series(folder, &wanted)
}

/// Slices of one volume have one size and type.
fn check_alike(images: &[Image]) -> Result<(), Error> {
    let layout = |image: &Image| {
        let shape = image.shape;
        (shape.columns, shape.rows, shape.channels, image.kind.scalar)
    };
    match images.iter().find(|image| layout(image) != layout(&images[0])) {
        Some(other) => {
            let problem = format!("it differs from {} in size or type: slices must be alike", images[0].path.display());
            Err(Error::volume(&other.path, problem))
        }
        None => Ok(()),
    }
}
