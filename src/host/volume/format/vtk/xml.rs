//! VTK XML image data, `.vti` (<https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>).

use super::arrays::{self, Array, Image};
use super::blocks::{self, Method};
use super::encoded;
use super::pieces::{self, Extent, Piece};
use crate::error::Error;
use crate::volume::format::bytes::{Bytes, Held, Plain};
use crate::volume::format::load::Opened;
use crate::volume::format::{Format, Found, OpenOptions, text};
use crate::volume::{Endian, ScalarType};
use glam::{DAffine3, DMat3, DVec3};
use quick_xml::events::{BytesStart, Event};
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;
use std::str::FromStr;

/// VTK XML image data.
pub(in crate::volume::format) struct Xml;

/// Limit of the bytes parsed as XML.
const LARGEST: u64 = 1 << 32;
/// Limit of pieces.
const MOST_PIECES: usize = 1 << 16;

impl Format for Xml {
    fn recognises(&self, file: &Found, _options: &OpenOptions) -> bool {
        file.start.windows(8).any(|bytes| bytes == b"<VTKFile")
    }

    fn chooses(&self) -> &'static [&'static str] {
        &["array"]
    }

    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error> {
        let path = file.path;
        let document = Document::read(path)?;
        let first = document.pieces.first().ok_or_else(|| document.wrong("it has no piece of ImageData"))?;
        let array = arrays::chosen(path, &first.arrays, options)?;
        let scalar = ScalarType::from_str(&array.type_name.to_ascii_lowercase());
        let scalar = scalar.map_err(|_| document.wrong(format!("its array {} is of type {}", array.name, array.type_name)))?;
        let endian = if matches!(array.place, Place::Text(_)) { Endian::NATIVE } else { document.endian };
        let whole = pieces::union(document.pieces.iter().map(|piece| piece.extent)).unwrap_or(first.extent);
        let image = &document.image(whole)?;
        let header = array.header(path, image, scalar, endian, options)?;
        let bytes = match document.pieces.len() {
            1 => document.bytes(array, image, scalar)?,
            _ => {
                let bytes = document.pieces.iter().map(|piece| document.piece_of(piece, array, scalar));
                Box::new(Held(pieces::joined(path, array, (image, whole), scalar.bytes(), bytes)?))
            }
        };
        Ok(Opened { header, bytes, exact: false })
    }
}

/// Location of the numbers of an array.
enum Place {
    /// Text in this byte range of the file.
    Text(Range<u64>),
    /// Base64 data from this byte.
    Inline(u64),
    /// Offset in the appended data, after the underscore.
    Appended(u64),
}

/// Extent and arrays of a piece.
struct Declared {
    extent: Extent,
    arrays: Vec<Array<Place>>,
}

/// Placement of the image.
#[derive(Default)]
struct Lies {
    origin: Option<DVec3>,
    spacing: Option<DVec3>,
    direction: Option<[f64; 9]>,
}

/// Content of the file before its appended data.
struct Document<'a> {
    path: &'a Path,
    endian: Endian,
    /// Bytes per count before data.
    count: usize,
    method: Option<Method>,
    lies: Lies,
    pieces: Vec<Declared>,
    /// Byte after the underscore, and whether the appended data are base64.
    appended: Option<(u64, bool)>,
}

impl<'a> Document<'a> {
    fn read(path: &'a Path) -> Result<Self, Error> {
        let file = File::open(path).map_err(|e| Error::read(path, e))?;
        let mut document = Self {
            path,
            endian: Endian::Little,
            count: 4,
            method: None,
            lies: Lies::default(),
            pieces: Vec::new(),
            appended: None,
        };
        let mut reader = quick_xml::Reader::from_reader(BufReader::new(file).take(LARGEST));
        let mut scope = Scope::default();
        let mut buffer = Vec::new();
        loop {
            buffer.clear();
            let event = reader.read_event_into(&mut buffer).map_err(|e| document.wrong(format!("its XML is damaged: {e}")))?;
            match event {
                Event::Start(tag) if tag.local_name().as_ref() == b"AppendedData" => {
                    let coding = attribute(&tag, "encoding");
                    document.append(reader.buffer_position(), coding.as_deref() == Some("base64"))?;
                    return Ok(document);
                }
                Event::Start(tag) => document.open_tag(&tag, &mut scope, reader.buffer_position(), false)?,
                Event::Empty(tag) => document.open_tag(&tag, &mut scope, reader.buffer_position(), true)?,
                Event::Text(words) => scope.text_length = words.len() as u64,
                Event::End(tag) => match tag.local_name().as_ref() {
                    b"PointData" | b"CellData" => scope.marked = None,
                    b"DataArray" => {
                        let last = document.pieces.last_mut().and_then(|piece| piece.arrays.last_mut());
                        if let Some(Place::Text(range)) = last.filter(|_| scope.marked.is_some()).map(|a| &mut a.place) {
                            range.end = range.start + scope.text_length;
                        }
                    }
                    _ => {}
                },
                Event::Eof => return Ok(document),
                _ => {}
            }
        }
    }

    fn open_tag(&mut self, tag: &BytesStart, scope: &mut Scope, behind: u64, empty: bool) -> Result<(), Error> {
        scope.text_length = 0;
        match tag.local_name().as_ref() {
            b"VTKFile" => self.file(tag),
            b"ImageData" => {
                let direction = self.numbers(tag, "Direction")?;
                self.lies = Lies { origin: self.vector(tag, "Origin")?, spacing: self.vector(tag, "Spacing")?, direction };
                Ok(())
            }
            b"Piece" if self.pieces.len() == MOST_PIECES => Err(self.wrong("it has too many pieces")),
            b"Piece" => {
                let extent = self.numbers(tag, "Extent")?.ok_or_else(|| self.wrong("its piece has no Extent"))?;
                self.image(extent)?;
                self.pieces.push(Declared { extent, arrays: Vec::new() });
                Ok(())
            }
            name @ (b"PointData" | b"CellData") if !empty => {
                scope.marked = Some(Marked::new(tag, name == b"CellData"));
                Ok(())
            }
            b"DataArray" => {
                if let Some(marked) = &scope.marked {
                    let array = self.array(tag, marked, behind)?;
                    if let Some(piece) = self.pieces.last_mut() {
                        piece.arrays.push(array);
                    }
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn file(&mut self, tag: &BytesStart) -> Result<(), Error> {
        let kind = attribute(tag, "type").unwrap_or_default();
        if kind != "ImageData" {
            return Err(self.wrong(format!(
                "it holds {kind}: expected ImageData; resample it, or give one of its files if it is a \
                                    parallel format"
            )));
        }
        self.endian = if attribute(tag, "byte_order").as_deref() == Some("BigEndian") { Endian::Big } else { Endian::Little };
        self.count = if attribute(tag, "header_type").as_deref() == Some("UInt64") { 8 } else { 4 };
        self.method = match attribute(tag, "compressor").as_deref() {
            None | Some("") => None,
            Some("vtkZLibDataCompressor") => Some(Method::Zlib),
            Some("vtkLZ4DataCompressor") => Some(Method::Lz4),
            Some(other) => return Err(self.wrong(format!("it is compressed with {other}: use zlib, lz4 or no compression"))),
        };
        Ok(())
    }

    /// Placement of the points of an extent.
    fn image(&self, extent: Extent) -> Result<Image, Error> {
        let points =
            |i: usize| usize::try_from(i64::from(extent[2 * i + 1]) - i64::from(extent[2 * i]) + 1).ok().filter(|&n| n > 0);
        let (Some(x), Some(y), Some(z)) = (points(0), points(1), points(2)) else {
            return Err(self.wrong(format!("its extent, {extent:?}, has no points")));
        };
        let Lies { origin, spacing, direction } = self.lies;
        let first = DVec3::new(extent[0].into(), extent[2].into(), extent[4].into());
        // Row-major in the file.
        let direction = direction.map_or(DMat3::IDENTITY, |rows: [f64; 9]| DMat3::from_cols_array(&rows).transpose());
        let matrix3 = direction * DMat3::from_diagonal(spacing.unwrap_or(DVec3::ONE));
        let translation = origin.unwrap_or(DVec3::ZERO) + matrix3 * first;
        Ok(Image { points: [x, y, z], index_to_world: DAffine3 { matrix3, translation } })
    }

    /// The numbers of `array` in one of several pieces.
    fn piece_of(&self, piece: &Declared, array: &Array<Place>, scalar: ScalarType) -> Result<Piece, Error> {
        let is_text = |array: &Array<Place>| matches!(array.place, Place::Text(_));
        let alike = |own: &&Array<Place>| {
            let (a, b) = (own, array);
            (&a.name, a.cell_data, a.components, &a.type_name) == (&b.name, b.cell_data, b.components, &b.type_name)
                && is_text(a) == is_text(b)
        };
        let own = piece.arrays.iter().find(alike);
        let own =
            own.ok_or_else(|| self.wrong(format!("one of its pieces lacks the array {} of the first piece", array.name)))?;
        Ok(Piece { extent: piece.extent, bytes: self.bytes(own, &self.image(piece.extent)?, scalar)? })
    }

    fn array(&self, tag: &BytesStart, marked: &Marked, behind: u64) -> Result<Array<Place>, Error> {
        let name = attribute(tag, "Name").unwrap_or_default();
        let number = |key: &str, missing: u64| match attribute(tag, key) {
            Some(text) => text.trim().parse().map_err(|_| self.wrong(format!("{key} of its array {name} is '{text}'"))),
            None => Ok(missing),
        };
        let components = number("NumberOfComponents", 1)?;
        let components = usize::try_from(components).ok().filter(|n| (1..=1 << 20).contains(n));
        let components = components.ok_or_else(|| self.wrong(format!("its array {name} has no components, or too many")))?;
        let place = match attribute(tag, "format").as_deref() {
            Some("appended") => Place::Appended(number("offset", 0)?),
            Some("binary") => Place::Inline(behind),
            _ => Place::Text(behind..behind),
        };
        let type_name = attribute(tag, "type").unwrap_or_default();
        let (active, is_vector) = (marked.scalars.as_ref() == Some(&name), marked.vectors.contains(&name));
        Ok(Array { name, type_name, components, cell_data: marked.cell_data, active, is_vector, are_colors: false, place })
    }

    /// Records the start of the appended data, whose tag ends before byte `behind`.
    fn append(&mut self, behind: u64, coded: bool) -> Result<(), Error> {
        let failed = |e| Error::read(self.path, e);
        let mut file = File::open(self.path).map_err(failed)?;
        file.seek(SeekFrom::Start(behind)).map_err(failed)?;
        let blanks = BufReader::new(file).take(1 << 10).skip_until(b'_').map_err(failed)?;
        self.appended = Some((behind + blanks as u64, coded));
        Ok(())
    }

    /// Data of an array.
    fn bytes(&self, array: &Array<Place>, image: &Image, scalar: ScalarType) -> Result<Box<dyn Bytes>, Error> {
        let failed = |e| Error::read(self.path, e);
        let file = File::open(self.path).map_err(failed)?;
        let coded = |at: u64| encoded::Coded { path: self.path, at, count: self.count, endian: self.endian };
        let wanted = array.bytes(image, scalar);
        match (&array.place, self.appended) {
            (Place::Text(range), _) => {
                let text = text::read_range(self.path, file, range.clone())?;
                Ok(Box::new(Held(text::numbers(self.path, &text, array.numbers(image), scalar)?)))
            }
            (Place::Appended(_), None) => Err(self.wrong("it has no appended data: it is truncated")),
            (Place::Inline(at), _) => self.decoded(&coded(*at), wanted),
            (Place::Appended(offset), Some((start, true))) => self.decoded(&coded(start.saturating_add(*offset)), wanted),
            (Place::Appended(offset), Some((start, false))) => {
                let mut counts = Plain::new(file, start.saturating_add(*offset)).map_err(failed)?;
                if let Some(method) = self.method {
                    return blocks::unpacked(self.path, Box::new(counts), self.count, self.endian, method);
                }
                let mut declared = [0; 8];
                let found = counts.read(0, &mut declared[..self.count]).map_err(failed)?;
                let declared = blocks::number(&declared[..found], self.endian);
                self.compare(declared, wanted)?;
                let file = File::open(self.path).map_err(failed)?;
                let first = start.saturating_add(*offset).saturating_add(self.count as u64);
                Ok(Box::new(Plain::new(file, first).map_err(failed)?))
            }
        }
    }

    fn decoded(&self, coded: &encoded::Coded, wanted: u64) -> Result<Box<dyn Bytes>, Error> {
        match self.method {
            Some(method) => {
                let bytes = Held(coded.blocks()?);
                blocks::unpacked(self.path, Box::new(bytes), self.count, self.endian, method)
            }
            None => {
                let (declared, bytes) = coded.plain()?;
                self.compare(declared, wanted)?;
                Ok(Box::new(Held(bytes)))
            }
        }
    }

    fn compare(&self, declared: u64, wanted: u64) -> Result<(), Error> {
        if declared >= wanted {
            return Ok(());
        }
        Err(self.wrong(format!("an array has {declared} bytes, expected {wanted}: it is damaged")))
    }

    fn vector(&self, tag: &BytesStart, name: &str) -> Result<Option<DVec3>, Error> {
        Ok(self.numbers::<f64, 3>(tag, name)?.map(DVec3::from_array))
    }

    /// Parses an attribute as `N` numbers.
    fn numbers<T: FromStr, const N: usize>(&self, tag: &BytesStart, name: &str) -> Result<Option<[T; N]>, Error> {
        let Some(text) = attribute(tag, name) else { return Ok(None) };
        let numbers: Option<Vec<T>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
        let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
        numbers.map(Some).ok_or_else(|| self.wrong(format!("its {name}, '{text}', is not {N} numbers")))
    }

    fn wrong(&self, problem: impl Into<String>) -> Error {
        Error::volume(self.path, problem)
    }
}

/// What PointData or CellData say about their arrays.
struct Marked {
    cell_data: bool,
    /// Name of the active array.
    scalars: Option<String>,
    /// Names of vectors and normals.
    vectors: Vec<String>,
}

impl Marked {
    fn new(tag: &BytesStart, cell_data: bool) -> Self {
        let vectors = ["Vectors", "Normals"].iter().filter_map(|kind| attribute(tag, kind)).collect();
        Self { cell_data, scalars: attribute(tag, "Scalars"), vectors }
    }
}

/// State of the enclosing tags.
#[derive(Default)]
struct Scope {
    /// The enclosing PointData or CellData.
    marked: Option<Marked>,
    /// Bytes of the last text node.
    text_length: u64,
}

pub(super) fn attribute(tag: &BytesStart, name: &str) -> Option<String> {
    let found = tag.try_get_attribute(name).ok()??;
    let value = found.unescape_value().ok()?;
    Some(value.into_owned())
}
