//! Structured points, as text or big-endian binary data (<https://docs.vtk.org/en/latest/vtk_file_formats/vtk_legacy_file_format.html>).

use super::arrays::{self, Array, Image};
use crate::error::Error;
use crate::volume::format::bytes::{Bytes, Held, Plain};
use crate::volume::format::load::{Opened, upright};
use crate::volume::format::{Format, Found, OpenOptions, text};
use crate::volume::{Endian, ScalarType};
use glam::DVec3;
use std::fs::File;
use std::io::{BufRead, BufReader, Seek, SeekFrom};
use std::path::Path;

/// Legacy VTK files.
pub(in crate::volume::format) struct Legacy;

impl Format for Legacy {
    fn recognises(&self, file: &Found, _options: &OpenOptions) -> bool {
        file.start.starts_with(b"# vtk DataFile Version")
    }

    fn chooses(&self) -> &'static [&'static str] {
        &["array"]
    }

    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error> {
        let path = file.path;
        let mut scanner = Scanner::open(path)?;
        let is_text = scanner.start()?;
        let (image, arrays) = scanner.sections(is_text)?;
        let array = arrays::chosen(path, &arrays, options)?;
        let scalar = scalar(&array.type_name).ok_or_else(|| {
            Error::volume(path, format!("its array {} is of type {}: expected numbers", array.name, array.type_name))
        })?;
        let endian = if is_text { Endian::NATIVE } else { Endian::Big };
        let header = array.header(path, &image, scalar, endian, options)?;
        let failed = |e| Error::read(path, e);
        let file = File::open(path).map_err(failed)?;
        let bytes: Box<dyn Bytes> = if is_text {
            let text = text::read_from(path, file, array.place)?;
            let numbers = |scalar| text::numbers(path, &text, array.numbers(&image), scalar);
            Box::new(Held(if array.type_name == COLOURS { colours(&numbers(ScalarType::Float32)?) } else { numbers(scalar)? }))
        } else {
            Box::new(Plain::new(file, array.place).map_err(failed)?)
        };
        Ok(Opened { header, bytes, exact: false })
    }
}

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
struct Scanner<'a> {
    path: &'a Path,
    reader: BufReader<File>,
    at: u64,
    len: u64,
}

/// Longest line in bytes.
const LONGEST: usize = 1 << 16;

impl<'a> Scanner<'a> {
    fn open(path: &'a Path) -> Result<Self, Error> {
        let failed = |e| Error::read(path, e);
        let file = File::open(path).map_err(failed)?;
        let len = file.metadata().map_err(failed)?.len();
        Ok(Self { path, reader: BufReader::new(file), at: 0, len })
    }

    /// The next line; `None` at the end of the file.
    fn line(&mut self) -> Result<Option<String>, Error> {
        let mut line = Vec::new();
        let mut limited = std::io::Read::take(&mut self.reader, LONGEST as u64);
        let read = limited.read_until(b'\n', &mut line).map_err(|e| Error::read(self.path, e))?;
        self.at += read as u64;
        if read == LONGEST {
            return Err(self.wrong(format!("the line at byte {} is too long", self.at)));
        }
        Ok((read > 0).then(|| String::from_utf8_lossy(&line).trim().to_owned()))
    }

    /// Words of the next non-empty line.
    fn words(&mut self) -> Result<Option<Vec<String>>, Error> {
        while let Some(line) = self.line()? {
            if !line.is_empty() {
                return Ok(Some(line.split_whitespace().map(String::from).collect()));
            }
        }
        Ok(None)
    }

    /// Reads the version, the title and, behind blank lines, the coding. Returns whether numbers are text.
    fn start(&mut self) -> Result<bool, Error> {
        self.line()?;
        self.line()?;
        let coding = self.words()?.unwrap_or_default().join(" ");
        match coding.to_ascii_uppercase().as_str() {
            "ASCII" => Ok(true),
            "BINARY" => Ok(false),
            _ => Err(self.wrong(format!("its third line is '{coding}': expected ASCII or BINARY"))),
        }
    }

    fn sections(&mut self, is_text: bool) -> Result<(Image, Vec<Array<u64>>), Error> {
        let (mut points, mut spacing, mut origin) = (None, DVec3::ONE, DVec3::ZERO);
        // Whether the current section holds cell data, and its number of tuples.
        let mut part: Option<(bool, u64)> = None;
        let mut arrays: Vec<Array<u64>> = Vec::new();
        while let Some(words) = self.words()? {
            let keyword = words[0].to_ascii_uppercase();
            match keyword.as_str() {
                "DATASET" if word(&words, 1).eq_ignore_ascii_case("STRUCTURED_POINTS") => {}
                "DATASET" => {
                    return Err(self.wrong(format!("it holds {}: expected STRUCTURED_POINTS; resample it", word(&words, 1))));
                }
                "DIMENSIONS" => points = Some(self.three::<usize>(&words)?),
                "SPACING" | "ASPECT_RATIO" => spacing = DVec3::from_array(self.three(&words)?),
                "ORIGIN" => origin = DVec3::from_array(self.three(&words)?),
                "POINT_DATA" | "CELL_DATA" => part = Some((keyword == "CELL_DATA", self.number(&words, 1)?)),
                "METADATA" => while self.line()?.is_some_and(|line| !line.is_empty()) {},
                "LOOKUP_TABLE" => self.skip(is_text, "unsigned_char", self.number::<u64>(&words, 2)?.saturating_mul(4))?,
                "FIELD" => {
                    for _ in 0..self.number::<u32>(&words, 2)? {
                        let Some(head) = self.words()? else { break };
                        if head[0].eq_ignore_ascii_case("METADATA") {
                            return Err(self.wrong("one of its fields has METADATA instead of an array"));
                        }
                        let (components, tuples) = (self.number(&head, 1)?, self.number::<u64>(&head, 2)?);
                        let array = Array {
                            name: decoded(&head[0]),
                            type_name: word(&head, 3).into(),
                            components,
                            cell_data: part.is_some_and(|(cell_data, _)| cell_data),
                            active: false,
                            is_vector: false,
                            are_colors: false,
                            place: self.at,
                        };
                        let numbers = tuples.saturating_mul(components as u64);
                        self.skip(is_text, word(&head, 3), numbers)?;
                        self.metadata()?;
                        // Field data outside both sections describe the whole dataset, such as a time.
                        arrays.extend(part.is_some_and(|(_, count)| count == tuples && components > 0).then_some(array));
                    }
                }
                _ => {
                    let Some((cell_data, tuples)) = part else {
                        return Err(self.wrong(format!("expected dimensions or data, found '{}'", words[0])));
                    };
                    let array = self.attribute(&keyword, &words, cell_data)?;
                    self.skip(is_text, &array.type_name, tuples.saturating_mul(array.components as u64))?;
                    arrays.extend((array.components > 0).then_some(array));
                }
            }
        }
        let points = points.filter(|points| !points.contains(&0));
        let points = points.ok_or_else(|| self.wrong("it has no DIMENSIONS, or one of them is 0"))?;
        Ok((Image { points, index_to_world: upright(spacing, origin) }, arrays))
    }

    /// Parses the header of an array such as `SCALARS name type [components]`.
    fn attribute(&mut self, keyword: &str, words: &[String], cell_data: bool) -> Result<Array<u64>, Error> {
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
        let (name, is_vector) = (decoded(word(words, 1)), matches!(keyword, "VECTORS" | "NORMALS"));
        let (type_name, are_colors) = (type_name.into(), keyword == "COLOR_SCALARS");
        Ok(Array { name, type_name, components, cell_data, active, is_vector, are_colors, place: self.at })
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

    /// Skips `numbers` numbers.
    fn skip(&mut self, is_text: bool, type_name: &str, numbers: u64) -> Result<(), Error> {
        if is_text {
            return self.skip_words(numbers);
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
        self.go_to(end)
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

    fn three<T: std::str::FromStr + Copy>(&self, words: &[String]) -> Result<[T; 3], Error> {
        Ok([self.number(words, 1)?, self.number(words, 2)?, self.number(words, 3)?])
    }

    fn number<T: std::str::FromStr>(&self, words: &[String], at: usize) -> Result<T, Error> {
        word(words, at).parse().map_err(|_| self.wrong(format!("word {at} of '{}' is not a valid number", words.join(" "))))
    }

    fn wrong(&self, problem: impl Into<String>) -> Error {
        Error::volume(self.path, problem)
    }
}

fn word(words: &[String], at: usize) -> &str {
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
