//! DICOM image series (<https://www.dicomstandard.org>): a folder, one of its files, or a multi-frame file. Segmentations, too.

mod beginning;
mod dataset;
mod image;
mod packed;
mod pixels;
mod place;
mod segments;

use super::load::{self, Header, Opened};
use super::parts::Kept;
use super::{Format, Found, OpenOptions, listed};
use crate::error::Error;
use crate::volume::labels::Declared;
use crate::volume::{ChannelDescription, Contents, Rescale, ScalarType};
use dicom_dictionary_std::tags;
use image::Image;
use segments::Segmentation;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// DICOM.
pub(super) struct Dicom;

impl Format for Dicom {
    fn recognises(&self, file: &Found, _options: &OpenOptions) -> bool {
        if file.folder { files(file.path).is_ok_and(|files| !files.is_empty()) } else { beginning::is_start(&file.start) }
    }

    fn chooses(&self) -> &'static [&'static str] {
        &["series"]
    }

    fn labels(&self, file: &Found, options: &OpenOptions) -> Result<Option<Declared>, Error> {
        let found = segmentation(file, options)?;
        let tables = found.and_then(|segmentation| segmentation.tables()).transpose()?;
        Ok(tables.map(|layers| Declared { layers }))
    }

    fn channels(&self, file: &Found, options: &OpenOptions, _: usize) -> Result<Vec<ChannelDescription>, Error> {
        let names = segmentation(file, options)?.map_or(Vec::new(), |segmentation| segmentation.names());
        Ok(names.into_iter().map(|name| ChannelDescription { name, ..ChannelDescription::default() }).collect())
    }

    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error> {
        if let Some(segmentation) = segmentation(file, options)? {
            return open_segments(file.path, segmentation, options);
        }
        let path = file.path;
        let images = images(candidates(file, options)?)?;
        check_alike(&images)?;
        let (shape, kind) = (images[0].shape, images[0].kind);
        let stack = place::stack(path, &images, options)?;
        let mut contents = stack.contents;
        let channel = contents.choose_channel(path, options, shape.channels)?;
        contents.are_colors = kind.are_colors;
        contents.palette = images[0].palette.clone();
        let dims = [shape.columns, shape.rows, stack.slices.len()];
        let grid = load::grid_of_patient(path, dims, stack.index_to_world, stack.is_anatomical, options)?;
        let scales: BTreeSet<[u64; 2]> = stack.slices.iter().map(|&(image, frame)| scale(&images[image], frame)).collect();
        let floats = matches!(kind.scalar, ScalarType::Float32 | ScalarType::Float64);
        let one = scales.len() == 1 || floats;
        let (image, frame) = stack.slices[0];
        let (slope, intercept) = (images[image].frames[frame].slope, images[image].frames[frame].intercept);
        let header = if one {
            let rescale = Rescale::new(slope, intercept).map_err(|e| Error::volume(path, e.to_string()))?;
            Header { rescale, ..Header::new(grid, kind.scalar) }
        } else {
            tracing::info!("{}: slices have different rescaling: converting values to floats", path.display());
            Header::new(grid, ScalarType::Float32)
        };
        let bytes = pixels::Pixels::new(images, stack.slices, channel, !one).map(Kept::new).map_err(|e| unreadable(path, e))?;
        Ok(Opened { header: header.with_contents(contents), bytes: Box::new(bytes), exact: false })
    }
}

/// The segmentation that a file or a folder has, if that is what is chosen.
fn segmentation(file: &Found, options: &OpenOptions) -> Result<Option<Segmentation>, Error> {
    let begins = |path: &PathBuf| Found::look(path).is_ok_and(|found| segments::may_begin(&found.start));
    // Reading the headers of a folder takes long.
    if !(segments::may_begin(&file.start) || file.folder && files(file.path)?.iter().any(begins)) {
        return Ok(None);
    }
    let mut found = candidates(file, options)?;
    let is_one = |candidate: &Candidate| Segmentation::is_in(&candidate.found.dataset);
    match (found.pop(), found.is_empty()) {
        (Some(last), true) if is_one(&last) => Segmentation::new(&last.path, last.found, options).map(Some),
        (Some(last), false) if is_one(&last) => {
            let problem = format!("it has {} segmentations of one series: give one of its files", found.len() + 1);
            Err(Error::volume(file.path, problem))
        }
        _ => Ok(None),
    }
}

fn open_segments(path: &Path, segmentation: Segmentation, options: &OpenOptions) -> Result<Opened, Error> {
    let mut contents = Contents { length_unit: Some("mm".into()), ..Contents::default() };
    let channel = contents.choose_channel(path, options, segmentation.count())?;
    let grid = load::grid_of_patient(path, segmentation.dims(), segmentation.index_to_world, true, options)?;
    if segmentation.is_fractional() {
        tracing::warn!(
            "{}: its segments are fractions of voxels: read as values from 0 to 1, a channel for each",
            path.display()
        );
    }
    let header = Header { rescale: segmentation.rescale, ..Header::new(grid, segmentation.scalar()) };
    let bytes = segmentation.voxels(channel).map(Kept::new).map_err(|e| unreadable(path, e))?;
    Ok(Opened { header: header.with_contents(contents), bytes: Box::new(bytes), exact: false })
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

/// All DICOM files of a folder.
fn files(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let mut files = listed(folder)?;
    files.retain(|file| Found::look(file).is_ok_and(|found| beginning::is_start(&found.start)));
    files.sort();
    Ok(files)
}

/// An image file and its series: identifier, number and description.
struct Candidate {
    path: PathBuf,
    found: dataset::Found,
    series: String,
    number: Option<String>,
    description: Option<String>,
}

impl Candidate {
    /// `None` if the file has no pixels.
    fn new(path: &Path) -> Result<Option<Self>, Error> {
        let found = dataset::read(path)?;
        if found.pixels.is_none() {
            return Ok(None);
        }
        let text = |tag| found.dataset.text(tag);
        let series = text(tags::SERIES_INSTANCE_UID).unwrap_or_default();
        let (number, description) = (text(tags::SERIES_NUMBER), text(tags::SERIES_DESCRIPTION));
        Ok(Some(Self { path: path.into(), found, series, number, description }))
    }

    fn is_called(&self, name: &str) -> bool {
        self.series == name || [&self.number, &self.description].into_iter().flatten().any(|other| other == name)
    }
}

/// The files of images that are opened.
fn candidates(file: &Found, options: &OpenOptions) -> Result<Vec<Candidate>, Error> {
    if file.folder { series(file.path, options.series.as_deref()) } else { series_of(file.path, options) }
}

/// Files of the selected series, or of the only series of a folder.
fn series(folder: &Path, wanted: Option<&str>) -> Result<Vec<Candidate>, Error> {
    let mut all = Vec::new();
    for file in files(folder)? {
        match Candidate::new(&file) {
            Ok(found) => all.extend(found),
            Err(e) => tracing::warn!("{e}: left out"),
        }
    }
    let identifiers =
        |all: &mut dyn Iterator<Item = &Candidate>| all.map(|file| file.series.clone()).collect::<BTreeSet<String>>();
    let found = identifiers(&mut all.iter().filter(|file| wanted.is_none_or(|name| file.is_called(name))));
    let names = || {
        let of = |identifier: &String| all.iter().filter(|file| file.series == *identifier).collect::<Vec<_>>();
        identifiers(&mut all.iter()).iter().map(|identifier| named(&of(identifier))).collect::<Vec<_>>().join(", ")
    };
    let problem = match (wanted, found.len()) {
        _ if all.is_empty() => {
            return Err(Error::volume(folder, "its DICOM files have no pixels: give the folder of a series of images"));
        }
        (_, 1) => {
            all.retain(|file| found.contains(&file.series));
            return Ok(all);
        }
        (Some(name), 0) => format!("'{name}' is not in {}, whose series are {}", folder.display(), names()),
        (Some(name), _) => format!("several series of {} are called '{name}': {}", folder.display(), names()),
        (None, several) => format!("{} has {several} series: {}; choose one", folder.display(), names()),
    };
    Err(Error::Settings { field: "series", problem })
}

/// Reads the images. Duplicates, which are common, are skipped.
fn images(files: Vec<Candidate>) -> Result<Vec<Image>, Error> {
    let (mut images, mut seen) = (Vec::new(), BTreeSet::new());
    for file in files {
        if file.found.dataset.text(tags::SOP_INSTANCE_UID).is_none_or(|identifier| seen.insert(identifier)) {
            images.push(Image::new(&file.path, file.found)?);
        } else {
            tracing::warn!("{}: duplicate of another file, ignored", file.path.display());
        }
    }
    Ok(images)
}

/// Describes a series in an error message.
fn named(files: &[&Candidate]) -> String {
    let first = files[0];
    let [number, description] = [&first.number, &first.description].map(|text| text.clone().unwrap_or_default());
    let slices: usize = files.iter().map(|file| image::frames_of(&file.found.dataset)).sum();
    format!("{number} '{description}' ({slices} slices, {})", first.series)
}

/// The files of the series of a file, from its folder. A file with several frames or segments is read alone.
fn series_of(path: &Path, options: &OpenOptions) -> Result<Vec<Candidate>, Error> {
    let no_pixels = || Error::volume(path, "it is a DICOM file without pixels: give an image of a series, or their folder");
    let file = Candidate::new(path)?.ok_or_else(no_pixels)?;
    let dataset = &file.found.dataset;
    if image::frames_of(dataset) > 1 || file.series.is_empty() || Segmentation::is_in(dataset) {
        if let Some(name) = options.series.as_deref().filter(|name| !file.is_called(name)) {
            let problem = format!("'{name}' is not in {}, whose series is {}", path.display(), named(&[&file]));
            return Err(Error::Settings { field: "series", problem });
        }
        return Ok(vec![file]);
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    series(folder, Some(options.series.as_deref().unwrap_or(&file.series)))
}

/// Rejects images that differ in size or type.
fn check_alike(images: &[Image]) -> Result<(), Error> {
    let layout = |image: &Image| {
        let shape = image.shape;
        (shape.columns, shape.rows, shape.channels, image.kind.scalar)
    };
    if let Some(other) = images.iter().find(|image| image.palette != images[0].palette) {
        let problem = format!("its palette differs from that of {}: convert the slices to RGB", images[0].path.display());
        return Err(Error::volume(&other.path, problem));
    }
    match images.iter().find(|image| layout(image) != layout(&images[0])) {
        Some(other) => {
            let problem = format!("it differs from {} in size or type: slices must be alike", images[0].path.display());
            Err(Error::volume(&other.path, problem))
        }
        None => Ok(()),
    }
}
