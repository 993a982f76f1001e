//! TIFF with slices as pages, including ImageJ and OME files.

mod channels;
mod directory;
mod layout;
mod pages;

use super::bytes::{Bytes, Plain};
use super::load::{self, Header, Opened, upright};
use super::parts::Kept;
use super::{Format, Found, OpenOptions};
use crate::error::Error;
use crate::volume::{ChannelDescription, Contents, Endian};
use glam::DVec3;
use layout::Layout;
use pages::{Page, Pages};
use std::fs::File;

/// TIFF.
pub(super) struct Tiff;

impl Format for Tiff {
    fn recognises(&self, file: &Found, _options: &OpenOptions) -> bool {
        [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"].iter().any(|mark| file.start.starts_with(*mark))
    }

    fn channels(&self, file: &Found, _: &OpenOptions, count: usize) -> Result<Vec<ChannelDescription>, Error> {
        let mut reader = pages::decoder(file.path)?;
        let page = Page::read(file.path, &mut reader)?;
        if page.samples > 1 {
            return Ok(if page.samples == count { ChannelDescription::of_components(count) } else { Vec::new() });
        }
        let description = pages::description(&mut reader);
        let layout = Layout::new(&description, page.samples, page.pixels_per_unit);
        if layout.channels != count {
            // Its pages are slices.
            return Ok(Vec::new());
        }
        channels::described(file.path, &mut reader, &description, &layout)
    }

    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error> {
        let path = file.path;
        let mut reader = pages::decoder(path)?;
        let page = Page::read(path, &mut reader)?;
        let description = pages::description(&mut reader);
        let layout = Layout::new(&description, page.samples, page.pixels_per_unit);
        // Large ImageJ files have one directory; the pages follow the first one without gaps.
        let (offset, big_endian) = (page.in_place, page.big_endian);
        let indices = pages::slices(path, &mut reader, &page)?;
        let contiguous = layout.imagej && indices.len() == 1 && layout.pages() > 1;
        let layout =
            if contiguous { layout } else { layout.with_pages(indices.len()).map_err(|problem| Error::volume(path, problem))? };
        let dims = [page.width, page.height, layout.slices];
        let grid = load::grid(path, dims, upright(layout.spacing, DVec3::ZERO), options)?;
        let mut contents = Contents { states_spacing: layout.states_spacing, ..Contents::default() };
        let frame = contents.choose_frame(path, options, layout.frames)?;
        let channel = contents.choose_channel(path, options, layout.channels.saturating_mul(page.samples))?;
        contents.frame_spacing = layout.frame_spacing.clone();
        let (channel, sample) = (channel / page.samples, channel % page.samples);
        let endian = if contiguous && big_endian { Endian::Big } else { Endian::NATIVE };
        let header = Header { endian, ..Header::new(grid, page.scalar) };
        let mut header = if page.planar { header } else { header.with_channels_inside(sample, page.samples) };
        // Each page holds all samples, interleaved or planar.
        header.strides[2] = page.bytes();
        if page.planar {
            header.first = (page.bytes() / page.samples as u64).saturating_mul(sample as u64);
        }
        let bytes: Box<dyn Bytes> = if contiguous {
            let offset = offset.ok_or_else(|| Error::volume(path, "its pages are missing or compressed: save it again"))?;
            let endian = if big_endian { Endian::Big } else { Endian::Little };
            header.endian = endian;
            let each = page.bytes();
            header.first = header.first.saturating_add(each.saturating_mul(layout.page(0, frame, channel) as u64));
            header.strides[2] = each.saturating_mul(layout.page(1, 0, 0) as u64);
            Box::new(Plain::new(File::open(path).map_err(|e| Error::read(path, e))?, offset).map_err(|e| Error::read(path, e))?)
        } else {
            let wanted = (0..layout.slices).map(|slice| indices[layout.page(slice, frame, channel)]).collect();
            Box::new(Kept::new(Pages::new(path, wanted, page.bytes())?))
        };
        Ok(Opened { header: header.with_contents(contents), bytes, exact: false })
    }
}
