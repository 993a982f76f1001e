//! Legacy VTK files, text or big-endian binary data (<https://docs.vtk.org/en/latest/vtk_file_formats/vtk_legacy_file_format.html>): their
//! lines, and the arrays of points and cells.

use super::arrays::Array;
use crate::error::Error;
use crate::volume::format::text;
use crate::volume::{Endian, ScalarType};
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;

/// Type name of colours: bytes in binary files, fractions of 1 in text files.
const COLOURS: &str = "colours";

/// Converts fractions of 1 to bytes.
fn colours(shares: &[u8]) -> Vec<u8> {
    let (shares, _) = shares.as_chunks::<4>();
    shares.iter().map(|&share| (f32::from_ne_bytes(share) * 255.0).round() as u8).collect()
}

fn scalar(name: &str) -> Option<ScalarType> {
    Some(match name.to_ascii_lowercase().as_str() {
        "unsigned_char" | COLOURS => ScalarType::Uint8,
        "char" | "signed_char" => ScalarType::Int8,
        "unsigned_short" => ScalarType::Uint16,
        "short" => ScalarType::Int16,
        "unsigned_int" => ScalarType::Uint32,
        "int" | "vtkidtype" => ScalarType::Int32,
        "unsigned_long" | "vtktypeuint64" => ScalarType::Uint64,
        "long" | "vtktypeint64" => ScalarType::Int64,
        "float" => ScalarType::Float32,
        "double" => ScalarType::Float64,
        _ => return None,
    })
}

/// Scans a file section by section and skips the numbers.
pub(crate) struct Scanner<'a> {
    path: &'a Path,
    reader: BufReader<File>,
    at: u64,
    len: u64,
    /// Version of the format.
    pub version: f64,
    pub title: String,
    /// Whether numbers are text.
    pub is_text: bool,
    /// Strings of the whole data set: name, and the first of each.
    pub strings: Vec<(String, String)>,
}

/// Longest line in bytes.
const LONGEST: usize = 1 << 16;

impl<'a> Scanner<'a> {
    /// Opens a file and reads the version, the title and, behind blank lines, the coding.
    pub fn open(path: &'a Path) -> Result<Self, Error> {
        let failed = |e| Error::read(path, e);
        let file = File::open(path).map_err(failed)?;
        let len = file.metadata().map_err(failed)?.len();
        let (reader, title, strings) = (BufReader::new(file), String::new(), Vec::new());
        let mut scanner = Self { path, reader, at: 0, len, version: 0.0, title, is_text: false, strings };
        let first = scanner.line()?.unwrap_or_default();
        scanner.version = first.split_whitespace().last().and_then(|word| word.parse().ok()).unwrap_or(0.0);
        scanner.title = scanner.line()?.unwrap_or_default();
        let coding = scanner.words()?.unwrap_or_default().join(" ");
        match coding.to_ascii_uppercase().as_str() {
            "ASCII" => scanner.is_text = true,
            "BINARY" => {}
            _ => return Err(scanner.wrong(format!("its third line is '{coding}': expected ASCII or BINARY"))),
        }
        Ok(scanner)
    }

    /// The next line; `None` at the end of the file.
    pub fn line(&mut self) -> Result<Option<String>, Error> {
        let mut line = Vec::new();
        let mut limited = Read::take(&mut self.reader, LONGEST as u64);
        let read = limited.read_until(b'\n', &mut line).map_err(|e| Error::read(self.path, e))?;
        self.at += read as u64;
        if read == LONGEST {
            return Err(self.wrong(format!("the line at byte {} is too long", self.at)));
        }
        Ok((read > 0).then(|| String::from_utf8_lossy(&line).trim().to_owned()))
    }

    /// Words of the next non-empty line.
    pub fn words(&mut self) -> Result<Option<Vec<String>>, Error> {
        while let Some(line) = self.line()? {
            if !line.is_empty() {
                return Ok(Some(line.split_whitespace().map(String::from).collect()));
            }
        }
        Ok(None)
    }

    /// Reads all sections. `geometry` reads those that are no arrays of points or cells, and whose keyword, in capitals, and words it is given;
    /// it returns whether it knows them.
    pub fn arrays(
        &mut self,
        mut geometry: impl FnMut(&mut Self, &str, &[String]) -> Result<bool, Error>,
    ) -> Result<Vec<Array<Range<u64>>>, Error> {
        // Whether the current section holds cell data, and its number of tuples.
        let mut part: Option<(bool, u64)> = None;
        let mut arrays = Vec::new();
        while let Some(words) = self.words()? {
            let keyword = words[0].to_ascii_uppercase();
            match keyword.as_str() {
                "POINT_DATA" | "CELL_DATA" => part = Some((keyword == "CELL_DATA", self.number(&words, 1)?)),
                "METADATA" => while self.line()?.is_some_and(|line| !line.is_empty()) {},
                "LOOKUP_TABLE" => {
                    let numbers = self.number::<u64>(&words, 2)?.saturating_mul(4);
                    self.skip("unsigned_char", numbers)?;
                }
                "FIELD" => {
                    for _ in 0..self.number::<u32>(&words, 2)? {
                        let Some(head) = self.words()? else { break };
                        arrays.extend(self.field(&head, part)?);
                    }
                }
                keyword if geometry(self, keyword, &words)? => {}
                keyword => {
                    let Some((cell_data, tuples)) = part else {
                        return Err(self.wrong(format!("expected dimensions or data, found '{}'", words[0])));
                    };
                    let mut array = self.attribute(keyword, &words, cell_data)?;
                    array.place = self.skip(&array.type_name, tuples.saturating_mul(array.components as u64))?;
                    arrays.extend((array.components > 0).then_some(array));
                }
            }
        }
        Ok(arrays)
    }

    /// Reads an array of a field, if it belongs to the points or cells of the section around it.
    fn field(&mut self, head: &[String], part: Option<(bool, u64)>) -> Result<Option<Array<Range<u64>>>, Error> {
        if head[0].eq_ignore_ascii_case("METADATA") {
            return Err(self.wrong("one of its fields has METADATA instead of an array"));
        }
        let (components, tuples) = (self.number(head, 1)?, self.number::<u64>(head, 2)?);
        let (name, numbers) = (decoded(&head[0]), tuples.saturating_mul(components as u64));
        if word(head, 3).eq_ignore_ascii_case("string") {
            let first = self.skip_strings(numbers)?;
            self.metadata()?;
            self.strings.extend(part.is_none().then_some((name, first)));
            return Ok(None);
        }
        let place = self.skip(word(head, 3), numbers)?;
        self.metadata()?;
        let array = Array {
            name,
            type_name: word(head, 3).into(),
            components,
            cell_data: part.is_some_and(|(cell_data, _)| cell_data),
            active: false,
            is_vector: false,
            are_normals: false,
            are_colors: false,
            place,
        };
        // Field data outside both sections describe the whole dataset, such as a time.
        Ok(Some(array).filter(|_| part.is_some_and(|(_, count)| count == tuples && components > 0)))
    }

    /// Skips strings, and returns the first.
    fn skip_strings(&mut self, count: u64) -> Result<String, Error> {
        let mut first = None;
        for n in 0..count {
            let Some(string) = (if self.is_text { self.line()? } else { self.binary_string()? }) else {
                return Err(self.wrong(format!("it lacks {} of {count} strings: it is truncated", count - n)));
            };
            first.get_or_insert(string);
        }
        Ok(decoded(&first.unwrap_or_default()))
    }

    /// A string behind its length, whose first two bits tell how many bytes the length has; `None` at the end of the file.
    fn binary_string(&mut self) -> Result<Option<String>, Error> {
        let mut length = [0; 8];
        let mut read = |bytes: &mut [u8]| self.reader.read_exact(bytes).ok();
        let Some(()) = read(&mut length[..1]) else { return Ok(None) };
        let count = [8, 4, 2, 1][usize::from(length[0] >> 6)];
        let Some(()) = read(&mut length[1..count]) else { return Ok(None) };
        length[0] &= 0x3f;
        let length = length[..count].iter().fold(0, |n, byte| n << 8 | u64::from(*byte));
        let start = self.at + count as u64;
        if length > self.len.saturating_sub(start).min(LONGEST as u64) {
            return Ok(None);
        }
        let mut bytes = vec![0; length as usize];
        let Ok(()) = self.reader.read_exact(&mut bytes) else { return Ok(None) };
        self.at = start + length;
        Ok(Some(String::from_utf8_lossy(&bytes).into_owned()))
    }

    /// Type of the numbers of an array, and their byte order.
    pub fn numbers_of(&self, array: &Array<Range<u64>>) -> Result<(ScalarType, Endian), Error> {
        let scalar = scalar(&array.type_name)
            .ok_or_else(|| self.wrong(format!("its array {} is of type {}: expected numbers", array.name, array.type_name)))?;
        Ok((scalar, if self.is_text { Endian::NATIVE } else { Endian::Big }))
    }

    /// The numbers of an array that are text.
    pub fn parsed(&self, array: &Array<Range<u64>>, count: u64, scalar: ScalarType) -> Result<Vec<u8>, Error> {
        let file = File::open(self.path).map_err(|e| Error::read(self.path, e))?;
        let text = text::read_range(self.path, file, array.place.clone())?;
        let numbers = |scalar| text::numbers(self.path, &text, count, scalar);
        Ok(if array.type_name == COLOURS { colours(&numbers(ScalarType::Float32)?) } else { numbers(scalar)? })
    }

    /// Parses the header of an array such as `SCALARS name type [components]`.
    fn attribute(&mut self, keyword: &str, words: &[String], cell_data: bool) -> Result<Array<Range<u64>>, Error> {
        let components = match keyword {
            "SCALARS" if words.len() > 3 => self.number(words, 3)?,
            "SCALARS" => 1,
            "VECTORS" | "NORMALS" => 3,
            "TENSORS" => 9,
            "TENSORS6" => 6,
            "COLOR_SCALARS" | "TEXTURE_COORDINATES" => self.number(words, 2)?,
            _ => return Err(self.wrong(format!("expected an array, found '{}': it is damaged", words[0]))),
        };
        let type_name = match keyword {
            "COLOR_SCALARS" => COLOURS,
            "TEXTURE_COORDINATES" => word(words, 3),
            _ => word(words, 2),
        };
        let active = keyword == "SCALARS";
        if active {
            // The lookup table is optional.
            let at = self.at;
            if !self.words()?.is_some_and(|words| words[0].eq_ignore_ascii_case("LOOKUP_TABLE")) {
                self.go_to(at)?;
            }
        }
        let (name, are_normals) = (decoded(word(words, 1)), keyword == "NORMALS");
        let (is_vector, are_colors) = (are_normals || keyword == "VECTORS", keyword == "COLOR_SCALARS");
        let type_name = type_name.into();
        Ok(Array { name, type_name, components, cell_data, active, is_vector, are_normals, are_colors, place: self.at..self.at })
    }

    /// Skips VTK's optional metadata after an array.
    fn metadata(&mut self) -> Result<(), Error> {
        let at = self.at;
        match self.words()? {
            Some(words) if words[0].eq_ignore_ascii_case("METADATA") => {
                while self.line()?.is_some_and(|line| !line.is_empty()) {}
                Ok(())
            }
            _ => self.go_to(at),
        }
    }

    fn go_to(&mut self, at: u64) -> Result<(), Error> {
        self.at = at;
        self.reader.seek(SeekFrom::Start(at)).map(|_| ()).map_err(|e| Error::read(self.path, e))
    }

    /// Skips `numbers` numbers, and returns their place.
    pub fn skip(&mut self, type_name: &str, numbers: u64) -> Result<Range<u64>, Error> {
        let start = self.at;
        if self.is_text {
            self.skip_words(numbers)?;
            return Ok(start..self.at);
        }
        let size = scalar(type_name).map(ScalarType::bytes);
        let size = size.ok_or_else(|| self.wrong(format!("it has an array of type '{type_name}': expected numbers")))?;
        let end = self.at.saturating_add(numbers.saturating_mul(size as u64));
        if end > self.len {
            return Err(self.wrong(format!(
                "{numbers} numbers of {type_name} at byte {} extend beyond its end: it is truncated or damaged",
                self.at
            )));
        }
        self.go_to(end)?;
        Ok(start..end)
    }

    fn skip_words(&mut self, count: u64) -> Result<(), Error> {
        let (mut left, mut within) = (count, false);
        while left > 0 {
            let bytes = self.reader.fill_buf().map_err(|e| Error::read(self.path, e))?;
            if bytes.is_empty() {
                return if within && left == 1 {
                    Ok(())
                } else {
                    Err(self.wrong(format!("its text lacks {left} numbers: it is truncated")))
                };
            }
            let mut used = 0;
            for byte in bytes {
                let blank = byte.is_ascii_whitespace();
                left -= u64::from(within && blank);
                within = !blank;
                if left == 0 {
                    break;
                }
                used += 1;
            }
            self.at += used as u64;
            self.reader.consume(used);
        }
        Ok(())
    }

    pub(super) fn three<T: std::str::FromStr + Copy>(&self, words: &[String]) -> Result<[T; 3], Error> {
        Ok([self.number(words, 1)?, self.number(words, 2)?, self.number(words, 3)?])
    }

    pub fn number<T: std::str::FromStr>(&self, words: &[String], at: usize) -> Result<T, Error> {
        word(words, at).parse().map_err(|_| self.wrong(format!("word {at} of '{}' is not a valid number", words.join(" "))))
    }

    pub fn wrong(&self, problem: impl Into<String>) -> Error {
        Error::volume(self.path, problem)
    }
}

pub(super) fn word(words: &[String], at: usize) -> &str {
    words.get(at).map_or("", String::as_str)
}

/// Decodes percent-encoded names.
fn decoded(name: &str) -> String {
    let mut parts = name.split('%');
    let mut bytes = parts.next().unwrap_or_default().as_bytes().to_vec();
    for part in parts {
        match part.get(..2).and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                bytes.extend(&part.as_bytes()[2..]);
            }
            None => bytes.extend([b"%", part.as_bytes()].concat()),
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
