//! Headers of PLY files.

use crate::volume::{Endian, ScalarType};
use std::fmt;

/// Longest line of a header in bytes.
const LONGEST: usize = 1 << 16;

/// How numbers are written.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Coding {
    Text,
    Binary(Endian),
}

impl fmt::Display for Coding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Coding::Text => "text",
            Coding::Binary(Endian::Little) => "binary, little endian",
            Coding::Binary(Endian::Big) => "binary, big endian",
        })
    }
}

/// A number of each entry, or a list of numbers behind their count.
pub(super) struct Property {
    pub name: String,
    pub scalar: ScalarType,
    /// Type of the count.
    pub list: Option<ScalarType>,
}

/// A kind of entries: vertices, faces.
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

pub(super) struct Header {
    pub coding: Coding,
    pub comments: Vec<String>,
    pub elements: Vec<Element>,
    /// Bytes before the first entry.
    pub first: usize,
}

impl Header {
    /// Parses the start of a file.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(bytes: &[u8]) -> Result<Self, String> {
        let end: &[u8] = match bytes.get(3..5) {
            Some(b"\r\n") => b"\r\n",
            Some([b'\r', _]) => b"\r",
            _ => b"\n",
        };
        let (mut at, mut coding) = (0, None);
        let mut header = Header { coding: Coding::Text, comments: Vec::new(), elements: Vec::new(), first: 0 };
        for n in 0.. {
            let rest = &bytes[at..];
            let length = rest.windows(end.len()).take(LONGEST).position(|part| part == end);
            let Some(length) = length else {
                return Err(match rest.len() {
                    ..LONGEST => "it ends before end_header: it is truncated".into(),
                    _ => format!("line {n} of its header is too long: it is damaged"),
                });
            };
            at += length + end.len();
            let line = String::from_utf8_lossy(&rest[..length]);
            let words: Vec<&str> = line.split_whitespace().collect();
            match words.as_slice() {
                ["ply"] if n == 0 => {}
                _ if n == 0 => return Err("it does not begin with 'ply': it is no PLY file".into()),
                [] => {}
                ["format", name, ..] => {
                    coding = Some(match *name {
                        "ascii" => Coding::Text,
                        "binary_little_endian" => Coding::Binary(Endian::Little),
                        "binary_big_endian" => Coding::Binary(Endian::Big),
                        _ => return Err(format!("its format is '{name}': expected ascii or binary")),
                    });
                }
                ["comment" | "obj_info", ..] => {
                    header.comments.push(line.trim().split_once(' ').map_or(String::new(), |(_, text)| text.trim().into()));
                }
                ["element", name, count] => {
                    let wrong = |_| format!("line {n} of its header declares '{count}' of {name}: expected a count");
                    let count = count.parse().map_err(wrong)?;
                    header.elements.push(Element { name: (*name).into(), count, properties: Vec::new() });
                }
                ["property", kinds @ .., name] => {
                    let property = property(kinds, name)
                        .ok_or_else(|| format!("line {n} of its header, '{}', declares no type", line.trim()))?;
                    let element = header.elements.last_mut();
                    element.ok_or_else(|| format!("its property {name} belongs to no element"))?.properties.push(property);
                }
                ["end_header"] => {
                    let coding = coding.ok_or("its header has no format")?;
                    return Ok(Header { coding, first: at, ..header });
                }
                [word, ..] => {
                    let word: String = word.chars().take(40).collect();
                    return Err(format!("line {n} of its header begins with '{word}': it is damaged"));
                }
            }
        }
        Err("its header does not end".into())
    }
}

fn property(kinds: &[&str], name: &str) -> Option<Property> {
    let (scalar, list) = match kinds {
        ["list", count, scalar] => (scalar, Some(scalar_of(count)?)),
        [scalar] => (scalar, None),
        _ => return None,
    };
    Some(Property { name: name.into(), scalar: scalar_of(scalar)?, list })
}

fn scalar_of(name: &str) -> Option<ScalarType> {
    Some(match name {
        "char" => ScalarType::Int8,
        "uchar" => ScalarType::Uint8,
        "short" => ScalarType::Int16,
        "ushort" => ScalarType::Uint16,
        "int" => ScalarType::Int32,
        "uint" => ScalarType::Uint32,
        "float" => ScalarType::Float32,
        "double" => ScalarType::Float64,
        other => other.parse().ok()?,
    })
}
