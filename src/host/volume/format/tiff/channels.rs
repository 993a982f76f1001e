//! Names, colours and windows of channels: ImageJ's tags (IJMetadata) and OME-XML.

use super::layout::Layout;
use super::pages::Reader;
use crate::error::Error;
use crate::volume::ChannelDescription;
use std::path::Path;
use tiff::tags::{ByteOrder, Tag};

/// Numbers of bytes of the parts of [`DATA`]: of its header, and of what the header lists.
const COUNTS: Tag = Tag::Unknown(50838);
const DATA: Tag = Tag::Unknown(50839);
/// First number of the header of [`DATA`].
const MARK: u32 = u32::from_be_bytes(*b"IJIJ");
/// Bytes of a colour table: 256 of red, of green and of blue.
const TABLE: usize = 768;

/// The channels of a file.
pub(super) fn described(
    path: &Path,
    reader: &mut Reader,
    description: &str,
    layout: &Layout,
) -> Result<Vec<ChannelDescription>, Error> {
    if !layout.imagej {
        return Ok(ome(description, layout.channels));
    }
    let is_big = matches!(reader.byte_order(), ByteOrder::BigEndian);
    let counts = reader.find_tag_unsigned_vec::<u64>(COUNTS).ok().flatten().unwrap_or_default();
    let data = reader.get_tag_u8_vec(DATA).unwrap_or_default();
    let parts = Parts::new(&data, &counts, is_big).map_err(|problem| Error::volume(path, problem))?;
    imagej(&parts, description, layout).map_err(|problem| Error::volume(path, problem))
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

/// The channels of OME-XML, in the order of the file.
fn ome(description: &str, count: usize) -> Vec<ChannelDescription> {
    let pixels = ["<Pixels ", "<OME:Pixels "].iter().find_map(|start| description.split_once(start));
    let Some((_, rest)) = pixels else { return Vec::new() };
    let rest = ["</Pixels>", "</OME:Pixels>"].iter().find_map(|end| rest.split_once(end)).map_or(rest, |(inside, _)| inside);
    let tags = rest.split("Channel ").skip(1).filter_map(|rest| rest.split_once('>')).map(|(tag, _)| format!(" {tag}"));
    tags.take(count).map(|tag| channel(&tag)).collect()
}

fn channel(tag: &str) -> ChannelDescription {
    let value = |key: &str| {
        let rest = tag.split_once(&format!(" {key}="))?.1;
        let quote = rest.chars().next().filter(|c| ['"', '\''].contains(c))?;
        let text = rest[1..].split_once(quote)?.0;
        let plain = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&apos;", "'"), ("&amp;", "&")];
        Some(plain.iter().fold(text.to_owned(), |text, (escaped, plain)| text.replace(escaped, plain)))
    };
    let name = ["Name", "Fluor"].into_iter().filter_map(value).find(|name| !name.trim().is_empty());
    // Red, green, blue and alpha in the bytes of a signed number. -1, white, is the default that many writers state.
    let color = value("Color").and_then(|text| text.parse::<i32>().ok()).filter(|&color| color != -1);
    let color = color.map(|color| [24, 16, 8].map(|shift| f64::from(color as u32 >> shift & 255) / 255.0));
    ChannelDescription { name, color, ..ChannelDescription::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_of_ome_have_names_and_colours() {
        let text = "<OME><Image><Pixels ID='a' SizeC='3'><Channel ID=\"c0\" Name=\"DAPI &amp; &lt;x&gt;\" Color=\"16711935\"/>\
                    <OME:Channel ID='c1' Color='-1' Fluor='GFP'><LightPath/></OME:Channel><Channel ID='c2' Color='-16776961'/></Pixels>";
        let found = ome(text, 3);
        let names: Vec<_> = found.iter().map(|channel| channel.name.as_deref()).collect();
        assert_eq!(names, [Some("DAPI & <x>"), Some("GFP"), None]);
        let colors: Vec<_> = found.iter().map(|channel| channel.color).collect();
        assert_eq!(colors, [Some([0.0, 1.0, 0.0]), None, Some([1.0, 0.0, 0.0])]);
        assert_eq!((ome(text, 2).len(), ome("", 3).len()), (2, 0));
    }

    #[test]
    fn damaged_metadata_are_refused() {
        let header = [MARK, u32::from_be_bytes(*b"luts"), 1].map(u32::to_be_bytes).concat();
        let data = [&header[..], &[7; 768]].concat();
        let layout = Layout::new("ImageJ=1.5\nimages=1\n", 1, None);
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
