//! VTK XML files (<https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>): the data set, its pieces, and their arrays.

use super::arrays::Array;
use super::blocks::{self, Method};
use super::encoded;
use crate::error::Error;
use crate::volume::format::bytes::{Bytes, Held, Plain};
use crate::volume::format::text;
use crate::volume::{Endian, ScalarType};
use quick_xml::events::{BytesStart, Event};
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;
use std::str::FromStr;

/// Limit of the bytes parsed as XML.
const LARGEST: u64 = 1 << 32;
/// Limit of pieces.
const MOST_PIECES: usize = 1 << 16;

/// Location of the numbers of an array.
pub(crate) enum Place {
    /// Text in this byte range of the file.
    Text(Range<u64>),
    /// Base64 data from this byte.
    Inline(u64),
    /// Offset in the appended data, after the underscore.
    Appended(u64),
}

impl Place {
    /// Whether the numbers are text.
    pub fn is_text(&self) -> bool {
        matches!(self, Place::Text(_))
    }
}

/// Attributes of a tag.
#[derive(Default)]
pub(crate) struct Attributes(Vec<(String, String)>);

impl Attributes {
    fn new(tag: &BytesStart) -> Self {
        let attributes = tag.attributes().filter_map(Result::ok);
        let text = |value: Option<_>, key: &[u8]| Some((String::from_utf8_lossy(key).into_owned(), value?));
        let pairs = attributes.filter_map(|a| text(a.unescape_value().ok().map(|v| v.into_owned()), a.key.as_ref()));
        Self(pairs.collect())
    }

    fn get(&self, name: &str) -> Option<&str> {
        self.0.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }
}

/// Attributes and arrays of a piece.
pub(crate) struct Piece {
    pub attributes: Attributes,
    /// Arrays of points and cells.
    pub arrays: Vec<Array<Place>>,
    /// Other arrays, with the tag that they are in: `Points`, `Polys`.
    pub geometry: Vec<(String, Array<Place>)>,
}

/// Content of the file before its appended data.
pub(crate) struct Document<'a> {
    pub path: &'a Path,
    /// Kind of the data set: `ImageData`, `PolyData`.
    pub kind: String,
    pub endian: Endian,
    /// Bytes per count before data.
    count: usize,
    method: Option<Method>,
    /// Attributes of the tag of the data set.
    pub attributes: Attributes,
    pub pieces: Vec<Piece>,
    /// Arrays of the whole data set.
    pub fields: Vec<Array<Place>>,
    /// Byte after the underscore, and whether the appended data are base64.
    appended: Option<(u64, bool)>,
}

impl<'a> Document<'a> {
    pub fn read(path: &'a Path) -> Result<Self, Error> {
        let file = File::open(path).map_err(|e| Error::read(path, e))?;
        let mut document = Self {
            path,
            kind: String::new(),
            endian: Endian::Little,
            count: 4,
            method: None,
            attributes: Attributes::default(),
            pieces: Vec::new(),
            fields: Vec::new(),
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
                Event::Text(words) => document.text(&scope, words.len() as u64),
                Event::End(tag) => document.close_tag(tag.local_name().as_ref(), &mut scope),
                Event::Eof => return Ok(document),
                _ => {}
            }
        }
    }

    fn open_tag(&mut self, tag: &BytesStart, scope: &mut Scope, behind: u64, empty: bool) -> Result<(), Error> {
        match tag.local_name().as_ref() {
            // Keys about an array.
            _ if scope.is_in_array => Ok(()),
            b"VTKFile" => self.file(tag),
            b"Piece" if self.pieces.len() == MOST_PIECES => Err(self.wrong("it has too many pieces")),
            b"Piece" => {
                self.pieces.push(Piece { attributes: Attributes::new(tag), arrays: Vec::new(), geometry: Vec::new() });
                Ok(())
            }
            b"DataArray" => self.data_array(tag, scope, behind, empty),
            // Strings, of which only those of the whole data set are read.
            b"Array" if scope.section.name == "FieldData" => self.data_array(tag, scope, behind, empty),
            name if name == self.kind.as_bytes() => {
                self.attributes = Attributes::new(tag);
                Ok(())
            }
            name if !empty => {
                scope.section = Section::new(tag, name);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Ends an array or a section.
    fn close_tag(&mut self, name: &[u8], scope: &mut Scope) {
        if matches!(name, b"DataArray" | b"Array") {
            scope.is_in_array = false;
        } else if !scope.is_in_array {
            scope.section = Section::default();
        }
    }

    /// The text that follows the tag of an array has its numbers.
    fn text(&mut self, scope: &Scope, length: u64) {
        if let (Some(Place::Text(range)), true) = (self.last(&scope.section), scope.is_in_array) {
            range.end = range.end.max(range.start + length * u64::from(range.is_empty()));
        }
    }

    /// The place of the array of a section that was declared last.
    fn last(&mut self, section: &Section) -> Option<&mut Place> {
        let piece = self.pieces.last_mut();
        match section.name.as_str() {
            "FieldData" => self.fields.last_mut().map(|array| &mut array.place),
            "PointData" | "CellData" => Some(&mut piece?.arrays.last_mut()?.place),
            _ => Some(&mut piece?.geometry.last_mut()?.1.place),
        }
    }

    fn data_array(&mut self, tag: &BytesStart, scope: &mut Scope, behind: u64, empty: bool) -> Result<(), Error> {
        if scope.section.name.is_empty() {
            return Ok(());
        }
        let array = self.array(tag, &scope.section, behind)?;
        scope.is_in_array = !empty;
        match (scope.section.name.as_str(), self.pieces.last_mut()) {
            ("FieldData", _) => self.fields.push(array),
            ("PointData" | "CellData", Some(piece)) => piece.arrays.push(array),
            (name, Some(piece)) => piece.geometry.push((name.into(), array)),
            _ => scope.is_in_array = false,
        }
        Ok(())
    }

    fn file(&mut self, tag: &BytesStart) -> Result<(), Error> {
        self.kind = attribute(tag, "type").unwrap_or_default();
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

    fn array(&self, tag: &BytesStart, section: &Section, behind: u64) -> Result<Array<Place>, Error> {
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
        let active = section.scalars.as_ref() == Some(&name);
        let are_normals = section.normals.as_ref() == Some(&name);
        let is_vector = are_normals || section.vectors.as_ref() == Some(&name);
        let cell_data = section.name == "CellData";
        Ok(Array { name, type_name, components, cell_data, active, is_vector, are_normals, are_colors: false, place })
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

    /// Type of the numbers of an array, and their byte order.
    pub fn numbers_of(&self, array: &Array<Place>) -> Result<(ScalarType, Endian), Error> {
        let scalar = ScalarType::from_str(&array.type_name.to_ascii_lowercase());
        let scalar = scalar.map_err(|_| self.wrong(format!("its array {} is of type {}", array.name, array.type_name)))?;
        Ok((scalar, if array.place.is_text() { Endian::NATIVE } else { self.endian }))
    }

    /// Data of an array of `count` numbers.
    pub fn bytes(&self, array: &Array<Place>, count: u64, scalar: ScalarType) -> Result<Box<dyn Bytes>, Error> {
        let failed = |e| Error::read(self.path, e);
        let file = File::open(self.path).map_err(failed)?;
        let coded = |at: u64| encoded::Coded { path: self.path, at, count: self.count, endian: self.endian };
        let wanted = count.saturating_mul(scalar.bytes() as u64);
        match (&array.place, self.appended) {
            (Place::Text(range), _) => {
                let text = text::read_range(self.path, file, range.clone())?;
                Ok(Box::new(Held(text::numbers(self.path, &text, count, scalar)?)))
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

    /// Parses an attribute as `N` numbers.
    pub fn numbers<T: FromStr, const N: usize>(&self, attributes: &Attributes, name: &str) -> Result<Option<[T; N]>, Error> {
        let Some(text) = attributes.get(name) else { return Ok(None) };
        let numbers: Option<Vec<T>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
        let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
        numbers.map(Some).ok_or_else(|| self.wrong(format!("its {name}, '{text}', is not {N} numbers")))
    }

    pub fn wrong(&self, problem: impl Into<String>) -> Error {
        Error::volume(self.path, problem)
    }
}

/// A tag around arrays, and what it says about them.
#[derive(Default)]
struct Section {
    name: String,
    /// Name of the active array.
    scalars: Option<String>,
    /// Names of vectors.
    vectors: Option<String>,
    normals: Option<String>,
}

impl Section {
    fn new(tag: &BytesStart, name: &[u8]) -> Self {
        let [scalars, vectors, normals] = ["Scalars", "Vectors", "Normals"].map(|kind| attribute(tag, kind));
        Self { name: String::from_utf8_lossy(name).into_owned(), scalars, vectors, normals }
    }
}

/// State of the enclosing tags.
#[derive(Default)]
struct Scope {
    section: Section,
    /// Whether an array of the section has begun, and not ended.
    is_in_array: bool,
}

pub(super) fn attribute(tag: &BytesStart, name: &str) -> Option<String> {
    let found = tag.try_get_attribute(name).ok()??;
    let value = found.unescape_value().ok()?;
    Some(value.into_owned())
}
