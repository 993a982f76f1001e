//! Names, colours and windows of channels: ImageJ's tags (IJMetadata), and samples of colours.

use super::directory::{Reader, failed};
use super::layout::Layout;
use super::page::{Extra, Page};
use crate::error::Error;
use crate::volume::ChannelDescription;
use std::path::Path;

/// Numbers of bytes of the parts of [`DATA`]: of its header, and of what the header lists.
const COUNTS: u16 = 50838;
const DATA: u16 = 50839;
/// First number of the header of [`DATA`].
const MARK: u32 = u32::from_be_bytes(*b"IJIJ");
/// Bytes of a colour table: 256 of red, of green and of blue.
const TABLE: usize = 768;

/// The channels of an ImageJ file whose first directory is at `first`.
pub(super) fn of_imagej(
    path: &Path,
    reader: &mut Reader,
    first: u64,
    description: &str,
    layout: &Layout,
) -> Result<Vec<ChannelDescription>, Error> {
    let read = |reader: &mut Reader| {
        let directory = reader.directory(first)?;
        Ok((reader.numbers(&directory, COUNTS)?, reader.bytes(&directory, DATA)?))
    };
    let (counts, data) = read(reader).map_err(|e| failed(path, &e))?;
    let parts = Parts::new(&data, &counts, reader.big_endian).map_err(|problem| Error::volume(path, problem))?;
    imagej(&parts, description, layout).map_err(|problem| Error::volume(path, problem))
}

/// The samples of colours: red, green, blue, and what the file says of the others.
pub(super) fn of_samples(page: &Page) -> Vec<ChannelDescription> {
    let further = page.extra.iter().skip(page.extra.len().saturating_sub(page.samples - 3));
    let named = |name: &str| ChannelDescription { name: Some(name.into()), active: false, ..ChannelDescription::default() };
    let further = further.map(|extra| match extra {
        Extra::Alpha => named("alpha"),
        Extra::AssociatedAlpha => named(ChannelDescription::ASSOCIATED_ALPHA),
        Extra::Unspecified => ChannelDescription::default(),
    });
    ChannelDescription::of_components(3).into_iter().chain(further).collect()
}

/// Parts of ImageJ's metadata.
#[derive(Default)]
struct Parts<'a> {
    parts: Vec<(u32, &'a [u8])>,
    is_big: bool,
}

impl<'a> Parts<'a> {
    fn new(data: &'a [u8], counts: &[u64], is_big: bool) -> Result<Self, String> {
        let Some((&first, counts)) = counts.split_first() else { return Ok(Self::default()) };
        let damaged = || String::from("its ImageJ metadata (tag 50839) are truncated or damaged: save it again with ImageJ");
        let whole = |n: u64| usize::try_from(n).map_err(|_| damaged());
        let (header, mut rest) = data.split_at_checked(whole(first)?).ok_or_else(damaged)?;
        let numbers: Vec<u32> = header.chunks_exact(4).map(|bytes| number(bytes, is_big) as u32).collect();
        let (Some(&MARK), true) = (numbers.first(), numbers.len() % 2 == 1) else { return Err(damaged()) };
        let (mut parts, mut counts) = (Vec::new(), counts.iter());
        for entry in numbers[1..].chunks_exact(2) {
            for _ in 0..entry[1] {
                let count = counts.next().ok_or_else(damaged)?;
                let (part, after) = rest.split_at_checked(whole(*count)?).ok_or_else(damaged)?;
                parts.push((entry[0], part));
                rest = after;
            }
        }
        Ok(Self { parts, is_big })
    }

    fn of(&self, kind: &[u8; 4]) -> impl Iterator<Item = &'a [u8]> {
        let kind = u32::from_be_bytes(*kind);
        self.parts.iter().filter(move |(k, _)| *k == kind).map(|(_, part)| *part)
    }
}

/// An unsigned integer of up to eight bytes.
fn number(bytes: &[u8], is_big: bool) -> u64 {
    let next = |n: u64, byte: &u8| n << 8 | u64::from(*byte);
    if is_big { bytes.iter().fold(0, next) } else { bytes.iter().rev().fold(0, next) }
}

fn imagej(parts: &Parts, description: &str, layout: &Layout) -> Result<Vec<ChannelDescription>, String> {
    let tables: Vec<&[u8]> = parts.of(b"luts").collect();
    if let Some(table) = tables.iter().find(|table| table.len() != TABLE) {
        return Err(format!("its ImageJ metadata have a colour table of {} bytes: expected {TABLE}", table.len()));
    }
    let ranges: Vec<f64> = parts
        .of(b"rang")
        .flat_map(|part| part.chunks_exact(8))
        .map(|bytes| f64::from_bits(number(bytes, parts.is_big)))
        .collect();
    let names: Vec<&[u8]> = parts.of(b"labl").collect();
    let value =
        |key: &str| description.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('=')?.trim().parse::<f64>().ok());
    let whole = value("min").zip(value("max")).filter(|_| layout.channels == 1);
    let channel = |n: usize| {
        let window = ranges.get(2 * n).zip(ranges.get(2 * n + 1)).map(|(lo, hi)| (*lo, *hi)).or(whole);
        ChannelDescription {
            name: names.get(layout.page(0, 0, n)).and_then(|name| text(name, parts.is_big)),
            // The brightest entry.
            color: tables.get(n).map(|table| [255, 511, 767].map(|at| f64::from(table[at]) / 255.0)),
            window: window.filter(|(lo, hi)| lo < hi && lo.is_finite() && hi.is_finite()),
            active: true,
        }
    };
    Ok((0..layout.channels).map(channel).collect())
}

/// The first line of a text in UTF-16.
fn text(bytes: &[u8], is_big: bool) -> Option<String> {
    let units: Vec<u16> = bytes.chunks_exact(2).map(|unit| number(unit, is_big) as u16).collect();
    let text = String::from_utf16_lossy(&units);
    text.lines().next().map(str::trim).filter(|line| !line.is_empty()).map(Into::into)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damaged_metadata_are_refused() {
        let header = [MARK, u32::from_be_bytes(*b"luts"), 1].map(u32::to_be_bytes).concat();
        let data = [&header[..], &[7; 768]].concat();
        let layout = Layout::imagej("ImageJ=1.5\nimages=1\n", 1, None);
        let of = |data: &[u8], counts: &[u64]| Parts::new(data, counts, true).and_then(|parts| imagej(&parts, "", &layout));
        assert_eq!(of(&data, &[12, 768]).unwrap()[0].color, Some([7.0 / 255.0; 3]));
        assert_eq!(of(&[], &[]).unwrap(), [ChannelDescription::default()]);
        assert!(of(&data, &[12, 767]).unwrap_err().contains("a colour table of 767 bytes: expected 768"));
        for counts in [&[12, 769][..], &[12], &[8, 768], &[13, 1 << 60], &[u64::MAX]] {
            assert!(of(&data, counts).unwrap_err().contains("truncated or damaged"), "{counts:?}");
        }
        assert!(Parts::new(&data, &[12, 768], false).is_err());
    }
}
