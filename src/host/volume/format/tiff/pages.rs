//! The pages of a file, and decoding of some of them, one at a time.

use super::chunks::{self, LIMIT};
use super::directory::{Reader, failed};
use super::page::Page;
use crate::error::Error;
use crate::volume::format::parts::Parts;
use std::io;
use std::path::{Path, PathBuf};

/// Tags of reduced versions of other pages.
const NEW_SUBFILE_TYPE: u16 = 254;
const SUBFILE_TYPE: u16 = 255;

/// A page of a file, by the offset of its directory.
#[derive(Clone)]
pub(super) struct Place {
    pub file: PathBuf,
    pub directory: u64,
}

/// Offsets of all pages that are slices, without previews.
///
/// # Errors
/// If a page differs from the first.
pub(super) fn slices(path: &Path, reader: &mut Reader, directories: &[u64], first: &Page) -> Result<Vec<u64>, Error> {
    let mut found = Vec::new();
    for (index, &at) in directories.iter().enumerate() {
        let directory = reader.directory(at).map_err(|e| failed(path, &e))?;
        let mut number = |tag| reader.whole(&directory, tag).map_err(|e| failed(path, &e));
        if index > 0 && (number(NEW_SUBFILE_TYPE)?.unwrap_or(0) & 1 == 1 || number(SUBFILE_TYPE)? == Some(2)) {
            continue;
        }
        check_like(path, reader, &format!("page {index}"), at, first)?;
        found.push(at);
    }
    Ok(found)
}

/// Rejects a page, called `name`, that does not belong to the slices of the first one.
pub(super) fn check_like(path: &Path, reader: &mut Reader, name: &str, at: u64, first: &Page) -> Result<(), Error> {
    let directory = reader.directory(at).map_err(|e| failed(path, &e))?;
    let page = Page::read(path, reader, &directory)?;
    if page.is_like(first) {
        return Ok(());
    }
    let problem = if page.palette != first.palette && !page.palette.is_empty() && !first.palette.is_empty() {
        format!("{name} has another palette than the first, so that equal numbers mean different colours: save its pages as RGB")
    } else {
        format!("{name} has {page}, but the first has {first}: save pages of the same kind in a separate file")
    };
    Err(Error::volume(path, problem))
}

/// A sequence of pages, of which one sample is read.
pub(super) struct Pages {
    places: Vec<Place>,
    sample: usize,
    /// Bytes per page.
    each: u64,
    most: u64,
    /// The file of the most recently read page.
    current: Option<(PathBuf, Reader)>,
}

impl Pages {
    /// `page`: the properties of each.
    pub fn new(places: Vec<Place>, sample: usize, page: &Page) -> Result<Self, Error> {
        let mut packed = 0u64;
        let mut last = None;
        for Place { file, .. } in &places {
            if last != Some(file) {
                packed = packed.saturating_add(std::fs::metadata(file).map_err(|e| Error::read(file, e))?.len());
                last = Some(file);
            }
        }
        let each = page.bytes();
        let most = each.saturating_mul(places.len() as u64).min(packed.saturating_mul(LIMIT));
        Ok(Self { places, sample, each, most, current: None })
    }
}

impl Parts for Pages {
    fn most(&self) -> u64 {
        self.most
    }

    fn whole(&self) -> u64 {
        self.each.saturating_mul(self.places.len() as u64)
    }

    fn each(&self) -> u64 {
        self.each
    }

    fn part(&mut self, index: usize) -> io::Result<Vec<u8>> {
        let Place { file, directory } = self.places[index].clone();
        let mut reader = match self.current.take().filter(|(current, _)| *current == file) {
            Some((_, reader)) => reader,
            None => Reader::new(&file).map_err(|e| io::Error::other(e.to_string()))?,
        };
        let directory = reader.directory(directory)?;
        let page = Page::read(&file, &mut reader, &directory).map_err(|e| io::Error::other(e.to_string()))?;
        let numbers = chunks::sample(&mut reader, &directory, &page, self.sample)?;
        self.current = Some((file, reader));
        Ok(numbers)
    }
}
