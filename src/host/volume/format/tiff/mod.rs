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
use ome::Ome;
use page::{Packing, Page};
use pages::{Pages, Place};
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
            let is_all = document.page.is_rgb && document.page.samples == count;
            return Ok(if is_all { channels::of_samples(&document.page) } else { Vec::new() });
        }
        if document.layout.channels != count {
            // Its pages are slices.
            return Ok(Vec::new());
        }
        document.channels()
    }

    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error> {
        let document = Document::read(file.path, options)?;
        let Document { path, ref page, ref layout, .. } = document;
        let dims = [page.width, page.height, layout.slices];
        let grid = load::grid(path, dims, upright(layout.spacing, DVec3::ZERO), options)?;
        let mut contents = Contents { states_spacing: layout.states_spacing, ..Contents::default() };
        let frame = contents.choose_frame(path, options, layout.frames)?;
        let channel = contents.choose_channel(path, options, layout.channels.saturating_mul(page.samples))?;
        contents.frame_spacing = layout.frame_spacing.clone();
        let (channel, sample) = (channel / page.samples, channel % page.samples);
        let header = Header::new(grid, page.scalar).with_contents(contents);
        if document.is_contiguous {
            return document.in_place(header, frame, channel, sample);
        }
        let wanted = (0..layout.slices).map(|slice| document.place(slice, frame, channel));
        let wanted = wanted.collect::<Result<Vec<Place>, Error>>()?;
        let bytes = Kept::new(Pages::new(wanted, sample, page)?);
        Ok(Opened { header, bytes: Box::new(bytes), exact: false })
    }
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
    /// The page of each plane, in the order of the layout; `None` if the file has none.
    places: Vec<Option<Place>>,
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
            return Self::of_ome(path, reader, description, &directories, options);
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
        let places = pages::slices(path, &mut reader, &directories[..own], &page)?;
        if own < directories.len() {
            let (pages, rest) = (own, directories.len() - own);
            tracing::warn!("{}: using its first image, of {pages} pages; {rest} pages of others follow", path.display());
        }
        let layout = match declared {
            Some(layout) if is_contiguous || layout.pages() == places.len() => layout,
            Some(layout) if layout.kind == Kind::Shaped => {
                let (pages, found) = (layout.pages(), places.len());
                return Err(wrong(format!("its description declares {pages} pages, and it has {found}: it is truncated")));
            }
            Some(layout) => {
                let (pages, found) = (layout.pages(), places.len());
                if pages > 1 {
                    tracing::warn!("{}: it declares {pages} images, and has {found}: they are slices", path.display());
                }
                let Layout { kind, spacing, states_spacing, frame_spacing, .. } = layout;
                Layout { kind, spacing, states_spacing, frame_spacing, ..Layout::plain(found) }
            }
            None => Layout::plain(places.len()),
        };
        let places = places.into_iter().map(Some).collect();
        Ok(Self { path, reader, description, first, page, layout, places, image: None, is_contiguous })
    }

    fn of_ome(
        path: &'a Path,
        mut reader: Reader,
        description: String,
        directories: &[u64],
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
        let mut others: std::collections::BTreeMap<String, (Reader, Vec<u64>)> = Default::default();
        let mut places = Vec::new();
        for plane in planes {
            let Some((file, index)) = plane else {
                places.push(None);
                continue;
            };
            let Some(name) = file else {
                places.push(directories.get(index).map(|&directory| Place { file: path.into(), directory }));
                continue;
            };
            let file = beside(path, &name, options)?;
            if !others.contains_key(&name) {
                let mut reader = Reader::new(&file)?;
                let directories = reader.directories().map_err(|e| failed(&file, &e))?;
                others.insert(name.clone(), (reader, directories));
            }
            let directory = others.get(&name).and_then(|(_, directories)| directories.get(index).copied());
            places.push(directory.map(|directory| Place { file, directory }));
        }
        for place in places.iter().flatten() {
            let name = place.file.file_name().unwrap_or_default().to_string_lossy();
            let reader = others.get_mut(name.as_ref()).map_or(&mut reader, |(reader, _)| reader);
            pages::check_like(&place.file, reader, "a page of the image", place.directory, &page)?;
        }
        let image = Some(ome.images.swap_remove(chosen));
        Ok(Self { path, reader, description, first, page, layout, places, image, is_contiguous: false })
    }

    /// The page of a plane.
    fn place(&self, slice: usize, frame: usize, channel: usize) -> Result<Place, Error> {
        let found = self.places.get(self.layout.page(slice, frame, channel)).cloned().flatten();
        found.ok_or_else(|| {
            let problem = format!(
                "it has no page for slice {slice} of frame {frame} and channel {channel}, which its description declares: it is incomplete"
            );
            Error::volume(self.path, problem)
        })
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
        let is_plain = page.packing == Packing::None && page.bits % 8 == 0 && !page.lowest_first;
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
    if options.alone {
        return Err(Error::volume(path, format!("its OME-XML names another file, {name}: use a file that has all pages")));
    }
    if Path::new(name).file_name().is_none_or(|last| last != name) {
        return Err(Error::volume(path, format!("its OME-XML names {name}, which is not a file of the same folder")));
    }
    let file = numbered::beside(path, name);
    if !file.is_file() {
        let problem = format!("its OME-XML names the file {name}, which is missing: put it into the same folder");
        return Err(Error::volume(path, problem));
    }
    Ok(file)
}
