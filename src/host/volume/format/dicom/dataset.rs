//! DICOM data sets: elements before the pixels, and the location of the pixels.

use super::beginning::{self, Encoding, START};
use crate::error::Error;
use crate::memory;
use crate::volume::format::bytes;
use dicom_core::dictionary::{DataDictionary, DataDictionaryEntry};
use dicom_core::header::DataElementHeader;
use dicom_core::{PrimitiveValue, Tag, VR};
use dicom_dictionary_std::{StandardDataDictionary, tags};
use dicom_encoding::TransferSyntaxIndex;
use dicom_parser::StatefulDecode;
use dicom_parser::dataset::LazyDataToken;
use dicom_parser::dataset::lazy_read::LazyDataSetReader;
use dicom_transfer_syntax_registry::TransferSyntaxRegistry;
use flate2::bufread::DeflateDecoder;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;

/// Longest value that is kept, in bytes. Offsets of many slices are the longest ones needed.
const LONGEST: u64 = 1 << 20;
/// Limits of nested sequences and of their items; images have fewer.
const DEEPEST: usize = 64;
const MOST_ITEMS: usize = 1 << 20;
/// Largest compression ratio of deflate.
const LIMIT: u64 = 1032;
/// Bytes inflated at a time.
const PIECE: usize = 1 << 20;

const DEFLATED: &str = "1.2.840.10008.1.2.1.99";
/// Longest sequence of unknown representation, in bytes.
const LONGEST_SEQUENCE: u64 = 1 << 28;

/// Elements and sequences, by tag.
#[derive(Default)]
pub(super) struct Dataset {
    values: BTreeMap<Tag, PrimitiveValue>,
    sequences: BTreeMap<Tag, Vec<Dataset>>,
}

impl Dataset {
    /// All numbers of an element; empty if it is missing or holds no numbers.
    pub fn numbers(&self, tag: Tag) -> Vec<f64> {
        self.values.get(&tag).and_then(|value| value.to_multi_float64().ok()).unwrap_or_default()
    }

    pub fn number(&self, tag: Tag) -> Option<f64> {
        self.numbers(tag).first().copied().filter(|number| number.is_finite())
    }

    pub fn whole(&self, tag: Tag) -> Option<usize> {
        self.values.get(&tag)?.to_int().ok()
    }

    pub fn text(&self, tag: Tag) -> Option<String> {
        let text = self.values.get(&tag)?.to_str();
        Some(text.trim_matches(['\0', ' ']).to_owned()).filter(|text| !text.is_empty())
    }

    /// Item `index` of a sequence.
    pub fn item(&self, sequence: Tag, index: usize) -> Option<&Self> {
        self.sequences.get(&sequence)?.get(index)
    }
}

/// Location of the pixels in a source.
#[derive(Clone, Copy)]
pub(super) struct PixelData {
    /// `PIXEL_DATA`, or one of the float variants.
    pub tag: Tag,
    pub at: u64,
    /// Number of bytes, if uncompressed.
    pub len: Option<u64>,
    /// Whether the elements are 16-bit words, which a big-endian file swaps.
    pub words: bool,
}

/// A file, or its inflated content.
#[derive(Clone)]
pub(super) enum Source {
    File(std::path::PathBuf),
    Inflated(Arc<[u8]>),
}

/// A seekable reader.
pub(super) trait Reading: Read + Seek {}
impl<T: Read + Seek> Reading for T {}

impl Source {
    pub fn open(&self) -> io::Result<Box<dyn Reading>> {
        Ok(match self {
            Self::File(path) => Box::new(BufReader::new(File::open(path)?)),
            Self::Inflated(bytes) => Box::new(Cursor::new(bytes.clone())),
        })
    }

    pub fn len(&self) -> io::Result<u64> {
        Ok(match self {
            Self::File(path) => std::fs::metadata(path)?.len(),
            Self::Inflated(bytes) => bytes.len() as u64,
        })
    }
}

/// A file parsed up to its pixels.
pub(super) struct Found {
    pub dataset: Dataset,
    /// `None` if the file is not an image.
    pub pixels: Option<PixelData>,
    pub source: Source,
    /// UID of the transfer syntax of the pixels.
    pub syntax: String,
    pub encoding: Encoding,
}

/// Reads all elements before the pixels.
pub(super) fn read(path: &Path) -> Result<Found, Error> {
    let damaged = |what: String| Error::volume(path, format!("its header is truncated or damaged: {what}"));
    let failed = |e: io::Error| match e.kind() {
        io::ErrorKind::UnexpectedEof | io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput => damaged(e.to_string()),
        _ => Error::read(path, e),
    };
    let mut file = BufReader::new(File::open(path).map_err(failed)?);
    let (syntax, behind) = beginning::meta(&mut file).map_err(failed)?;
    let (source, start) = if syntax.as_deref() == Some(DEFLATED) {
        (Source::Inflated(inflated(path, file, behind)?), 0)
    } else {
        (Source::File(path.into()), behind)
    };
    let mut from = source.open().map_err(failed)?;
    let mut first = Vec::new();
    from.seek(SeekFrom::Start(start)).map_err(failed)?;
    from.by_ref().take(START as u64).read_to_end(&mut first).map_err(failed)?;
    let declared = syntax.as_deref().map(Encoding::of_syntax);
    let encoding = Encoding::of_elements(&first, declared);
    let encoding = encoding.ok_or_else(|| damaged("it has no transfer syntax, and its first elements tell none".into()))?;
    from.seek(SeekFrom::Start(start)).map_err(failed)?;
    let end = source.len().map_err(failed)?;
    let (dataset, pixels) = parsed(from, end, encoding).map_err(damaged)?;
    // The pixels of a file that states another encoding than it has are encoded as its elements.
    let is_plain = declared.is_none_or(|declared| syntax.as_deref() == Some(declared.syntax()));
    let syntax = syntax.filter(|_| !is_plain).unwrap_or_else(|| encoding.syntax().into());
    Ok(Found { dataset, pixels, source, syntax, encoding })
}

/// Inflates the data after byte `start`, as far as memory allows.
fn inflated(path: &Path, mut file: BufReader<File>, start: u64) -> Result<Arc<[u8]>, Error> {
    let failed = |e: io::Error| Error::volume(path, format!("its compressed data are truncated or damaged: {e}"));
    let packed = file.get_ref().metadata().map_err(|e| Error::read(path, e))?.len();
    file.seek(SeekFrom::Start(start)).map_err(|e| Error::read(path, e))?;
    let mut decoder = DeflateDecoder::new(file.take(packed)).take(packed.saturating_mul(LIMIT));
    let mut all = Vec::new();
    loop {
        let before = all.len();
        memory::require(&path.display().to_string(), 2 * (before + PIECE) as u64)?;
        all.resize(before + PIECE, 0);
        let found = bytes::fill(&mut decoder, &mut all[before..]).map_err(failed)?;
        all.truncate(before + found);
        if found < PIECE {
            return Ok(all.into());
        }
    }
}

/// An open sequence or item during parsing.
enum Open {
    Sequence(Tag, Vec<Dataset>),
    Item(Dataset),
}

/// Parses the elements before the pixels. Values longer than the file are rejected before they are read.
fn parsed(from: Box<dyn Reading>, end: u64, encoding: Encoding) -> Result<(Dataset, Option<PixelData>), String> {
    let known = TransferSyntaxRegistry.get(encoding.syntax()).ok_or("its transfer syntax is unknown")?;
    let mut reader = LazyDataSetReader::new_with_ts(from, known).map_err(|e| e.to_string())?;
    let (mut open, mut items) = (vec![Open::Item(Dataset::default())], 0);
    let mut pixels = None;
    while let Some(token) = reader.advance() {
        match token.map_err(|e| e.to_string())? {
            LazyDataToken::PixelSequenceStart | LazyDataToken::SequenceStart { tag: tags::PIXEL_DATA, .. } if open.len() == 1 => {
                let at = reader.into_decoder().position();
                pixels = Some(PixelData { tag: tags::PIXEL_DATA, at, len: None, words: false });
                break;
            }
            LazyDataToken::SequenceStart { tag, .. } => open.push(Open::Sequence(tag, Vec::new())),
            LazyDataToken::ItemStart { .. } => {
                items += 1;
                open.push(Open::Item(Dataset::default()));
            }
            LazyDataToken::ItemEnd | LazyDataToken::SequenceEnd => close(&mut open),
            LazyDataToken::LazyValue { header, decoder } => {
                let (at, len) = (decoder.position(), u64::from(header.len.0));
                if is_pixels(header.tag) && open.len() == 1 {
                    pixels = Some(PixelData { tag: header.tag, at, len: Some(len), words: header.vr == VR::OW });
                    break;
                }
                if at.saturating_add(len) > end {
                    return Err(format!("element {} is {len} bytes long", header.tag));
                }
                let header = DataElementHeader { vr: representation(&header), ..header };
                if header.vr == VR::SQ && len <= LONGEST_SEQUENCE {
                    let mut items = sequence_head(header.tag, header.len.0);
                    decoder.read_to_vec(header.len.0, &mut items).map_err(|e| e.to_string())?;
                    let end = items.len() as u64;
                    let (found, _) = parsed(Box::new(Cursor::new(items)), end, Encoding::Implicit)?;
                    if let Some(Open::Item(item)) = open.last_mut() {
                        item.sequences.extend(found.sequences);
                    }
                } else if len > LONGEST || !is_wanted(header.tag) {
                    decoder.skip_bytes(header.len.0).map_err(|e| e.to_string())?;
                } else {
                    let value = decoder.read_value_preserved(&header).map_err(|e| e.to_string())?;
                    if let Some(Open::Item(item)) = open.last_mut() {
                        item.values.insert(header.tag, value);
                    }
                }
            }
            token => token.skip().map_err(|e| e.to_string())?,
        }
        if open.len() > DEEPEST || items > MOST_ITEMS {
            return Err(format!("it has {items} items with a nesting depth of {}: too many for an image", open.len()));
        }
    }
    match open.swap_remove(0) {
        Open::Item(dataset) => Ok((dataset, pixels)),
        Open::Sequence(..) => Err("it begins within a sequence".into()),
    }
}

/// Representation of a value. Attributes of the standard whose representation a file leaves unknown (UN), as archives write, or as bytes have
/// that of the dictionary.
fn representation(header: &DataElementHeader) -> VR {
    let known = || StandardDataDictionary.by_tag(header.tag).map(|entry| entry.vr().relaxed());
    match header.vr {
        VR::UN | VR::OB => known().unwrap_or(header.vr),
        vr => vr,
    }
}

/// Tag and length before the items of a sequence. Those of unknown representation are implicit, whatever the file is.
fn sequence_head(tag: Tag, len: u32) -> Vec<u8> {
    [&tag.0.to_le_bytes()[..], &tag.1.to_le_bytes(), &len.to_le_bytes()].concat()
}

/// Closes the innermost item or sequence.
fn close(open: &mut Vec<Open>) {
    if open.len() < 2 {
        return;
    }
    match (open.pop(), open.last_mut()) {
        (Some(Open::Item(item)), Some(Open::Sequence(_, items))) => items.push(item),
        (Some(Open::Sequence(tag, items)), Some(Open::Item(parent))) => {
            parent.sequences.insert(tag, items);
        }
        _ => {}
    }
}

fn is_pixels(tag: Tag) -> bool {
    [tags::PIXEL_DATA, tags::FLOAT_PIXEL_DATA, tags::DOUBLE_FLOAT_PIXEL_DATA].contains(&tag)
}

/// Whether an element may describe a volume; private elements and patient data do not.
fn is_wanted(tag: Tag) -> bool {
    matches!(tag.0, 0x0008 | 0x0018 | 0x0020 | 0x0028 | 0x0062 | 0x3004)
}
