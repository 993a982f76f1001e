//! TIFF with slices as pages, including ImageJ and OME files, and arrays of tifffile.

mod channels;
mod chunks;
mod directory;
mod layout;
mod ome;
mod page;
mod pages;

use super::bytes::{Bytes, Plain};
use super::load::{self, Header, Opened, upright};
use super::parts::Kept;
use super::{Format, Found, OpenOptions, choice, numbered};
use crate::error::Error;
use crate::files;
use crate::volume::{ChannelDescription, Contents, Endian};
use directory::{Reader, failed};
use glam::DVec3;
use layout::{Kind, Layout};
use ome::{Ome, PlanePage};
use page::{Packing, Page};
use pages::{Pages, Place};
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::path::Path;

/// TIFF.
pub(super) struct Tiff;

/// Tags: text, and the resolution along x and y.
const DESCRIPTION: u16 = 270;
const RESOLUTION: [u16; 2] = [282, 283];
/// Largest description in a file of its own, in bytes.
const LARGEST_COMPANION: u64 = 1 << 28;

impl Format for Tiff {
    fn recognises(&self, file: &Found, _options: &OpenOptions) -> bool {
        [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"].iter().any(|mark| file.start.starts_with(*mark))
    }

    fn chooses(&self) -> &'static [&'static str] {
        &["array"]
    }

    fn channels(&self, file: &Found, options: &OpenOptions, count: usize) -> Result<Vec<ChannelDescription>, Error> {
        let mut document = Document::read(file.path, options)?;
        if document.page.samples > 1 {
            let are_colors = document.are_colors() && document.page.samples == count;
            return Ok(if are_colors { channels::of_samples(&document.page) } else { Vec::new() });
        }
        if document.layout.channels != count {
            // Its pages are slices.
            return Ok(Vec::new());
        }
        document.channels()
    }

    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error> {
        let mut document = Document::read(file.path, options)?;
        let Document { path, ref page, ref layout, .. } = document;
        let dims = [page.width, page.height, layout.slices];
        let grid = load::grid(path, dims, upright(layout.spacing, DVec3::ZERO), options)?;
        let mut contents =
            Contents { states_spacing: layout.states_spacing, length_unit: layout.length_unit.clone(), ..Contents::default() };
        let frame = contents.choose_frame(path, options, layout.frames)?;
        let channel = contents.choose_channel(path, options, layout.channels.saturating_mul(page.samples))?;
        contents.frame_spacing = layout.frame_spacing.clone();
        contents.palette = page.colors();
        contents.are_colors = document.are_colors();
        let (channel, sample) = (channel / page.samples, channel % page.samples);
        let header = Header::new(grid, page.scalar).with_contents(contents);
        if document.is_contiguous {
            return document.in_place(header, frame, channel, sample);
        }
        let wanted = (0..layout.slices).map(|slice| layout.page(slice, frame, channel)).collect::<Vec<_>>();
        let wanted = wanted.into_iter().map(|plane| document.place(plane, options)).collect::<Result<Vec<Place>, Error>>()?;
        let bytes = Kept::new(Pages::new(wanted, sample, &document.page)?);
        Ok(Opened { header, bytes: Box::new(bytes), exact: false })
    }
}

/// Names of the other files in which OME-XML places planes of a file's image; none if the file is no such one.
pub(super) fn files_of_image(path: &Path) -> BTreeSet<String> {
    let found = Document::read(path, &OpenOptions::default());
    found.map_or_else(|_| BTreeSet::new(), |found| found.planes.into_iter().flatten().filter_map(|(file, _)| file).collect())
}

/// A file whose tags have been read.
struct Document<'a> {
    path: &'a Path,
    reader: Reader,
    /// Text of the first page.
    description: String,
    /// Offset of the first directory.
    first: u64,
    page: Page,
    layout: Layout,
    /// Offsets of the pages to which planes refer.
    directories: Vec<u64>,
    /// The page of each plane, in the order of the layout; `None` if the description names none.
    planes: Vec<Option<PlanePage>>,
    /// Other files with pages, and the offsets of these.
    others: BTreeMap<String, (Reader, Vec<u64>)>,
    /// The chosen image of OME-XML.
    image: Option<ome::Image>,
    /// Whether one page is followed by the numbers of all others without gaps.
    is_contiguous: bool,
}

impl<'a> Document<'a> {
    fn read(path: &'a Path, options: &OpenOptions) -> Result<Self, Error> {
        let mut reader = Reader::new(path)?;
        let wrong = |problem: String| Error::volume(path, problem);
        let directories = reader.directories().map_err(|e| failed(path, &e))?;
        let first = directories[0];
        let directory = reader.directory(first).map_err(|e| failed(path, &e))?;
        let description = reader.text(&directory, DESCRIPTION).map_err(|e| failed(path, &e))?;
        if Ome::is_one(&description) {
            return Self::of_ome(path, reader, description, directories, options);
        }
        if options.array.is_some() {
            let problem = format!("{} has one image, without names: omit it", path.display());
            return Err(Error::Settings { field: "array", problem });
        }
        let page = Page::read(path, &mut reader, &directory)?;
        let resolution = RESOLUTION.map(|tag| reader.quotient(&directory, tag).ok().flatten());
        let pixels_per_unit = resolution[0].zip(resolution[1]).map(|(x, y)| [x, y]);
        let sizes = match (page.planar, page.samples) {
            (_, 1) => vec![page.height, page.width],
            (true, samples) => vec![samples, page.height, page.width],
            (false, samples) => vec![page.height, page.width, samples],
        };
        let declared = if description.starts_with("ImageJ=") {
            Some(Layout::imagej(&description, page.samples, pixels_per_unit))
        } else {
            Layout::shaped(&description, &sizes)
        };
        // Large files of ImageJ, and truncated ones of tifffile, have one directory.
        let several = declared.as_ref().is_some_and(|layout| layout.pages() > 1);
        let is_contiguous = several && directories.len() == 1;
        // Further images of tifffile follow those of the first one.
        let own = match &declared {
            Some(layout) if layout.kind == Kind::Shaped && layout.pages() < directories.len() => layout.pages(),
            _ => directories.len(),
        };
        let found = pages::slices(path, &mut reader, &directories[..own], &page)?;
        if own < directories.len() {
            let (pages, rest) = (own, directories.len() - own);
            tracing::warn!("{}: using its first image, of {pages} pages; {rest} pages of others follow", path.display());
        }
        let layout = match declared {
            Some(layout) if is_contiguous || layout.pages() == found.len() => layout,
            Some(layout) if layout.kind == Kind::Shaped => {
                let (pages, found) = (layout.pages(), found.len());
                return Err(wrong(format!("its description declares {pages} pages, and it has {found}: it is truncated")));
            }
            Some(layout) => {
                let (pages, found) = (layout.pages(), found.len());
                if pages > 1 {
                    tracing::warn!("{}: it declares {pages} images, and has {found}: they are slices", path.display());
                }
                let Layout { kind, spacing, states_spacing, frame_spacing, .. } = layout;
                Layout { kind, spacing, states_spacing, frame_spacing, ..Layout::plain(found) }
            }
            None => Layout::plain(found.len()),
        };
        let planes = (0..found.len()).map(|page| Some((None, page))).collect();
        let (directories, others) = (found, BTreeMap::new());
        Ok(Self { path, reader, description, first, page, layout, directories, planes, others, image: None, is_contiguous })
    }

    fn of_ome(
        path: &'a Path,
        mut reader: Reader,
        description: String,
        directories: Vec<u64>,
        options: &OpenOptions,
    ) -> Result<Self, Error> {
        let wrong = |problem: String| Error::volume(path, problem);
        let mut ome = Ome::parse(&description).map_err(wrong)?;
        if let Some(elsewhere) = ome.elsewhere.take() {
            let companion = beside(path, &elsewhere, options)?;
            let uuid = ome.uuid;
            ome = Ome::parse(&files::read_text(&companion, LARGEST_COMPANION)?).map_err(|e| Error::volume(&companion, e))?;
            ome.uuid = uuid;
        }
        let names: Vec<&str> = ome.images.iter().map(|image| image.name.as_str()).collect();
        if names.is_empty() {
            return Err(wrong("its OME-XML has no image".into()));
        }
        let chosen = choice::named(path, options.array.as_deref(), &names, names[0])?.unwrap_or(0);
        let own = path.file_name().unwrap_or_default().to_string_lossy();
        let page_at = |reader: &mut Reader, at: u64| {
            let directory = reader.directory(at).map_err(|e| failed(path, &e))?;
            Page::read(path, reader, &directory)
        };
        let page = page_at(&mut reader, directories[0])?;
        let layout = ome.images[chosen].layout(page.samples);
        let planes = ome.planes(&ome.images[chosen], &layout, &own, directories.len()).map_err(wrong)?;
        // Pages of several images may differ in size.
        let own_pages = planes.iter().flatten().filter(|(file, _)| file.is_none());
        let first = own_pages.filter_map(|(_, index)| directories.get(*index)).next().copied().unwrap_or(directories[0]);
        let page = page_at(&mut reader, first)?;
        let image = Some(ome.images.swap_remove(chosen));
        let others = BTreeMap::new();
        Ok(Self { path, reader, description, first, page, layout, directories, planes, others, image, is_contiguous: false })
    }

    /// The page of a plane.
    fn place(&mut self, plane: usize, options: &OpenOptions) -> Result<Place, Error> {
        let path = self.path;
        let incomplete = || {
            let problem = format!("its description declares a plane {plane} that has no page: it is incomplete");
            Error::volume(path, problem)
        };
        let (file, index) = self.planes.get(plane).cloned().flatten().ok_or_else(incomplete)?;
        let Some(name) = file else {
            let directory = self.directories.get(index).copied().ok_or_else(incomplete)?;
            if self.image.is_some() {
                pages::check_like(path, &mut self.reader, &format!("page {index}"), directory, &self.page)?;
            }
            return Ok(Place { file: path.into(), directory });
        };
        let file = beside(path, &name, options)?;
        let (reader, directories) = match self.others.entry(name) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => {
                let mut reader = Reader::new(&file)?;
                let directories = reader.directories().map_err(|e| failed(&file, &e))?;
                entry.insert((reader, directories))
            }
        };
        let directory = directories.get(index).copied().ok_or_else(incomplete)?;
        pages::check_like(&file, reader, &format!("page {index}"), directory, &self.page)?;
        Ok(Place { file, directory })
    }

    /// Whether the channels are the samples of colours.
    fn are_colors(&self) -> bool {
        self.page.is_rgb && self.layout.channels == 1
    }

    /// Names, colours and windows of the channels.
    fn channels(&mut self) -> Result<Vec<ChannelDescription>, Error> {
        match (&self.image, self.layout.kind) {
            (Some(image), _) => Ok(image.descriptions(self.layout.channels)),
            (None, Kind::ImageJ) => channels::of_imagej(self.path, &mut self.reader, self.first, &self.description, &self.layout),
            _ => Ok(Vec::new()),
        }
    }

    /// Numbers of all pages behind those of the first one.
    fn in_place(mut self, mut header: Header, frame: usize, channel: usize, sample: usize) -> Result<Opened, Error> {
        let Self { path, ref page, ref layout, .. } = self;
        let offsets = self.reader.directory(self.first).and_then(|directory| self.reader.numbers(&directory, 273));
        let offset = offsets.map_err(|e| failed(path, &e))?.first().copied();
        let is_plain = page.packing == Packing::None && page.bits.is_multiple_of(8) && !page.lowest_first;
        let offset = offset.filter(|_| is_plain);
        let offset = offset.ok_or_else(|| Error::volume(path, "its pages are missing or compressed: save it again"))?;
        let each = page.bytes().saturating_mul(page.samples as u64);
        let inside = if page.planar { 1 } else { page.samples as u64 };
        let apart = if page.planar { page.bytes() } else { page.scalar.bytes() as u64 };
        header.endian = if self.reader.big_endian { Endian::Big } else { Endian::Little };
        header.strides = header.strides.map(|stride| stride.saturating_mul(inside));
        header.strides[2] = each.saturating_mul(layout.page(1, 0, 0) as u64);
        header.first = each.saturating_mul(layout.page(0, frame, channel) as u64) + apart * sample as u64;
        let file = File::open(path).and_then(|file| Plain::new(file, offset));
        let bytes: Box<dyn Bytes> = Box::new(file.map_err(|e| Error::read(path, e))?);
        Ok(Opened { header, bytes, exact: false })
    }
}

/// A file that a description names, in the same folder.
fn beside(path: &Path, name: &str, options: &OpenOptions) -> Result<std::path::PathBuf, Error> {
    if Path::new(name).file_name().is_none_or(|last| last != name) {
        return Err(Error::volume(path, format!("its OME-XML names {name}, which is not a file of the same folder")));
    }
    let file = numbered::beside(path, name, options)?;
    if !file.is_file() {
        let problem = format!("its OME-XML names the file {name}, which is missing: put it into the same folder");
        return Err(Error::volume(path, problem));
    }
    Ok(file)
}
