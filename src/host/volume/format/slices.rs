//! Volumes with one file per slice: all slices of a folder, or those that match a pattern.

use super::bytes::Joined;
use super::load::{self, Header, Opened};
use super::names::Numbered;
use super::{OpenOptions, listed, open_one};
use crate::error::Error;
use crate::url;
use crate::volume::ChannelDescription;
use std::path::{Path, PathBuf};

/// Extensions of slice files.
const ENDINGS: [&str; 3] = ["png", "tif", "tiff"];

pub(super) const UNKNOWN: &str =
    "the folder holds no numbered .png or .tif slices, DICOM series or other known volume: give a file";

/// Slice files of a folder, or of a pattern, sorted by number. `None` if the path is a file or a folder without slices.
pub(super) fn files(path: &Path) -> Result<Option<Vec<PathBuf>>, Error> {
    if path.is_dir() {
        let mut files = listed(path)?;
        files.retain(|file| ending(file).is_some_and(|ending| ENDINGS.contains(&ending.as_str())));
        let Some(first) = files.first().and_then(|file| ending(file)) else { return Ok(None) };
        if files.iter().any(|file| ending(file).as_ref() != Some(&first)) {
            return Err(Error::volume(path, "the folder holds slices of several kinds: select one kind with NAME%d.EXTENSION"));
        }
        files.sort_by_key(|file| numbered(file));
        #[cfg(feature = "tiff")]
        if is_one_image(&files) {
            files.truncate(1);
        }
        return Ok(Some(files));
    }
    matching(path)
}

/// Files that match a pattern with one `%d` or `%03d`, sorted by number. `None` if the path is none.
pub(super) fn matching(path: &Path) -> Result<Option<Vec<PathBuf>>, Error> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let Some((before, after)) = name.split_once('%').filter(|_| !path.exists() && !url::is_url(path)) else { return Ok(None) };
    let Some((width, after)) = after.split_once('d').filter(|(width, _)| width.bytes().all(|c| c.is_ascii_digit())) else {
        return Ok(None);
    };
    let digits = |file: &PathBuf| {
        let name = file.file_name()?.to_str()?;
        let digits = name.strip_prefix(before)?.strip_suffix(after)?;
        // %03d matches three digits, or more without a leading 0.
        let padded = !width.starts_with('0') || width.parse() == Ok(digits.len()) || !digits.starts_with('0');
        digits.parse::<u64>().ok().filter(|_| padded)
    };
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut files = listed(folder)?;
    files.retain(|file| digits(file).is_some());
    files.sort_by_key(digits);
    if files.is_empty() {
        return Err(Error::volume(path, "no files match %d"));
    }
    Ok(Some(files))
}

/// Whether the first file has all others: OME-XML that places the planes of an image in several files.
#[cfg(feature = "tiff")]
fn is_one_image(files: &[PathBuf]) -> bool {
    let [first, others @ ..] = files else { return false };
    let names = if others.is_empty() { Default::default() } else { super::tiff::files_of_image(first) };
    let is_of_it = |file: &PathBuf| file.file_name().is_some_and(|name| names.contains(&*name.to_string_lossy()));
    !others.is_empty() && others.iter().all(is_of_it)
}

fn ending(file: &Path) -> Option<String> {
    Some(file.extension()?.to_str()?.to_ascii_lowercase())
}

/// Sort key of a name: its text parts and the numbers between them.
fn numbered(file: &Path) -> Vec<(String, u128)> {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let mut parts = Vec::new();
    let mut rest = &name[..];
    while !rest.is_empty() {
        let (text, behind) = rest.split_at(rest.find(|c: char| c.is_ascii_digit()).unwrap_or(rest.len()));
        let (digits, behind) = behind.split_at(behind.find(|c: char| !c.is_ascii_digit()).unwrap_or(behind.len()));
        parts.push((text.to_owned(), digits.parse().unwrap_or(0)));
        rest = behind;
    }
    parts
}

/// Opens a volume of slices, of a channel and a time if their names number these.
pub(super) fn open(path: &Path, files: Vec<PathBuf>, options: &OpenOptions) -> Result<Opened, Error> {
    if let ([file], true) = (&files[..], path.is_dir()) {
        return open_one(file, options);
    }
    let Some(numbered) = numbered_in(path, &files)? else { return stacked(path, files, options) };
    let first = open_one(&numbered.slices(0, 0)[0], &OpenOptions { frame: Some(0), channel: Some(0), ..options.clone() })?.header;
    let (channels, times) = (numbered.channels.len(), numbered.times);
    if channels == 1 && numbered.slices(0, 0).len() == 1 && first.grid.dims()[2] == 1 {
        tracing::warn!("{}: names number the times of one slice: times are shown as slices along z", path.display());
        return stacked(path, files, options);
    }
    // Each file may have several of both, too.
    let (inside, frames) = (first.contents.channels, first.contents.frames);
    let mut contents = first.contents;
    contents.are_colors &= channels == 1;
    let frame = contents.choose_frame(path, options, times.saturating_mul(frames))?;
    let channel = contents.choose_channel(path, options, channels.saturating_mul(inside))?;
    let options = OpenOptions { frame: Some(frame % frames), channel: Some(channel % inside), ..options.clone() };
    let mut opened = match numbered.slices(frame / frames, channel / inside) {
        [file] => open_one(file, &options)?,
        several => stacked(path, several.into(), &options)?,
    };
    opened.header.contents = contents;
    Ok(opened)
}

/// What the names of the slices of a folder number.
fn numbered_in(path: &Path, files: &[PathBuf]) -> Result<Option<Numbered>, Error> {
    if !path.is_dir() {
        return Ok(None);
    }
    Numbered::new(files).map_err(|problem| Error::volume(path, problem))
}

/// Names of the `count` channels that the names of slices number; `None` if they number none.
pub(super) fn channels(path: &Path, files: &[PathBuf], count: usize) -> Result<Option<Vec<ChannelDescription>>, Error> {
    let numbered = numbered_in(path, files)?.filter(|numbered| numbered.channels.len() > 1 && numbered.channels.len() == count);
    let described = |name| ChannelDescription { name, ..ChannelDescription::default() };
    Ok(numbered.map(|numbered| numbered.channels.into_iter().map(described).collect()))
}

/// Opens slices, which must have the same layout.
fn stacked(path: &Path, files: Vec<PathBuf>, options: &OpenOptions) -> Result<Opened, Error> {
    let first = open_one(&files[0], options)?.header;
    let [x, y, z] = first.grid.dims();
    if z != 1 {
        return Err(Error::volume(
            &files[0],
            format!("it holds {z} slices, but so do other files here: give one of these files"),
        ));
    }
    let (each, count) = (first.end(), files.len());
    let grid = load::grid(path, [x, y, count], first.grid.index_to_world(), options)?;
    let strides = [first.strides[0], first.strides[1], each];
    let header = Header { grid, strides, ..first.clone() };
    // Resolve the defaults once, so that only the first slice warns.
    let options = OpenOptions { frame: options.frame.or(Some(0)), channel: options.channel.or(Some(0)), ..options.clone() };
    let first_file = files[0].clone();
    let slice = move |file: &Path| {
        let opened = open_one(file, &options)?;
        if opened.header.contents.palette != first.contents.palette {
            let problem = format!(
                "its palette differs from that of {}, so that equal numbers mean different colours: save the slices as RGB or grey",
                first_file.display()
            );
            return Err(Error::volume(file, problem));
        }
        if !alike(&opened.header, &first) {
            let (this, that) = (describe(&opened.header), describe(&first));
            let problem = format!("it has {this}, but {} has {that}: slices must be alike", first_file.display());
            return Err(Error::volume(file, problem));
        }
        Ok(opened.bytes)
    };
    Ok(Opened { header, bytes: Box::new(Joined::new(files, each, slice)?), exact: false })
}

/// Describes the layout of a slice.
fn describe(header: &Header) -> String {
    let ([x, y, z], scalar) = (header.grid.dims(), header.scalar);
    let slices = if z > 1 { format!("{z} slices of ") } else { String::new() };
    let channels = match header.contents.channels {
        0 | 1 => String::new(),
        channels => format!(" with {channels} channels"),
    };
    format!("{slices}{x}x{y} pixels of {scalar}{channels}")
}

fn alike(a: &Header, b: &Header) -> bool {
    let layout = |h: &Header| (h.grid.dims(), h.scalar, h.endian, h.first, [h.strides[0], h.strides[1]]);
    layout(a) == layout(b) && a.rescale == b.rescale && a.contents.channels == b.contents.channels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_sorted_by_their_numbers() {
        let mut names = ["b1.png", "a10.png", "a9.png", "a9b2.png", "a9b10.png"].map(PathBuf::from);
        names.sort_by_key(|name| numbered(name));
        assert_eq!(names, ["a9.png", "a9b2.png", "a9b10.png", "a10.png", "b1.png"].map(PathBuf::from));
    }

    #[test]
    fn patterns_find_the_files_that_there_are() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["s1.tif", "s01.tif", "s002.tif", "s0010.tif", "s1000.tif", "sx.tif", "s003.png"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let found = |pattern: &str| {
            let files = files(&folder.path().join(pattern)).unwrap().unwrap();
            files.iter().map(|file| file.file_name().unwrap().to_string_lossy().into_owned()).collect::<Vec<_>>()
        };
        assert_eq!(found("s%03d.tif"), ["s1.tif", "s002.tif", "s1000.tif"]);
        assert_eq!(found("s%03d.png"), ["s003.png"]);
        assert!(files(&folder.path().join("t%d.tif")).is_err());
        assert!(files(folder.path()).unwrap_err().to_string().contains("several kinds"));
    }
}
