//! The header of a classic file: dimensions, attributes and variables.

use crate::error::Error;
use crate::volume::Endian;
use crate::volume::ScalarType;
use crate::volume::format::conventions::Attributes;
use crate::volume::wide::Numbers;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

const DIMENSIONS: u32 = 10;
const VARIABLES: u32 = 11;
const ATTRIBUTES: u32 = 12;
/// Type of text.
const CHAR: u32 = 2;
/// Longest attribute whose values are kept, in bytes.
const LONGEST: u64 = 1 << 20;

/// A parsed header.
pub(super) struct Dataset {
    pub dimensions: Vec<Dimension>,
    pub variables: Vec<Variable>,
    /// Bytes from a record to the next one.
    pub record: u64,
}

/// A dimension.
pub(super) struct Dimension {
    pub name: String,
    pub len: u64,
    /// Whether its positions are records.
    pub is_record: bool,
}

/// A variable.
pub(super) struct Variable {
    pub name: String,
    /// Indices of its dimensions, slowest first.
    pub dimensions: Vec<usize>,
    attributes: Vec<Attribute>,
    /// `None` for text.
    pub scalar: Option<ScalarType>,
    pub first: u64,
}

struct Attribute {
    name: String,
    /// `None` for text.
    scalar: Option<ScalarType>,
    values: Vec<u8>,
}

impl Attributes for Variable {
    fn numbers(&self, name: &str) -> Option<(Vec<f64>, bool)> {
        let attribute = self.attributes.iter().find(|attribute| attribute.name == name)?;
        let scalar = attribute.scalar.filter(|_| !attribute.values.is_empty())?;
        let numbers = Numbers { bytes: &attribute.values, scalar, endian: Endian::Big, missing: None };
        let is_float = matches!(scalar, ScalarType::Float32 | ScalarType::Float64);
        Some(((0..numbers.count()).map(|n| numbers.stored(n)).collect(), is_float))
    }

    fn text(&self, name: &str) -> Option<String> {
        let attribute = self.attributes.iter().find(|attribute| attribute.name == name && attribute.scalar.is_none())?;
        Some(String::from_utf8_lossy(&attribute.values).trim_end_matches('\0').trim().to_owned())
    }
}

impl Dataset {
    /// Reads the header of a file.
    ///
    /// # Errors
    /// [`Error::Read`]; [`Error::Volume`] for a header that is damaged.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let parsed = || {
            let file = File::open(path)?;
            let len = file.metadata()?.len();
            Reader { file: BufReader::new(file), len, at: 0, wide: false }.dataset()
        };
        parsed().map_err(|e: io::Error| match e.kind() {
            io::ErrorKind::InvalidData | io::ErrorKind::UnexpectedEof => {
                Error::volume(path, format!("its header is truncated or damaged: {e}"))
            }
            _ => Error::read(path, e),
        })
    }

    /// Positions along the axes of a variable.
    pub fn shape(&self, variable: &Variable) -> Vec<u64> {
        variable.dimensions.iter().map(|&dimension| self.dimensions[dimension].len).collect()
    }

    /// Bytes from a position to the next along each axis of a variable.
    pub fn strides(&self, variable: &Variable) -> Vec<u64> {
        let mut strides = vec![0; variable.dimensions.len()];
        let mut bytes = variable.scalar.map_or(1, ScalarType::bytes) as u64;
        for (stride, &dimension) in strides.iter_mut().zip(&variable.dimensions).rev() {
            let Dimension { len, is_record, .. } = self.dimensions[dimension];
            *stride = if is_record { self.record } else { bytes };
            bytes = bytes.saturating_mul(len);
        }
        strides
    }
}

struct Reader {
    file: BufReader<File>,
    len: u64,
    at: u64,
    /// Whether sizes have eight bytes.
    wide: bool,
}

impl Reader {
    fn dataset(mut self) -> io::Result<Dataset> {
        let version = self.bytes(4)?[3];
        self.wide = version == 5;
        // Files that were not closed state no number.
        let declared = self.size()?;
        let is_stated = declared != if self.wide { u64::MAX } else { u64::from(u32::MAX) };
        let dimensions = self.list(DIMENSIONS, |reader| {
            let (name, len) = (reader.name()?, reader.size()?);
            Ok(Dimension { name, len, is_record: len == 0 })
        })?;
        self.list(ATTRIBUTES, Self::attribute)?;
        let variables = self.list(VARIABLES, |reader| reader.variable(version, &dimensions))?;
        let mut dataset = Dataset { dimensions, variables, record: 0 };
        let of_records =
            |variable: &&Variable| variable.dimensions.first().is_some_and(|&dimension| dataset.dimensions[dimension].is_record);
        // Of one record, the positions of the only variable follow each other without gaps.
        let sizes: Vec<u64> =
            dataset.variables.iter().filter(of_records).map(|variable| dataset.record_bytes(variable)).collect();
        let record = match sizes[..] {
            [only] => only,
            _ => sizes.iter().fold(0, |sum: u64, size| sum.saturating_add(size.next_multiple_of(4))),
        };
        let first = dataset.variables.iter().filter(of_records).map(|variable| variable.first).min();
        let fits = first.filter(|_| record > 0).map_or(0, |first| self.len.saturating_sub(first) / record.max(1));
        dataset.record = record;
        for dimension in dataset.dimensions.iter_mut().filter(|dimension| dimension.is_record) {
            dimension.len = if is_stated { declared } else { fits };
        }
        Ok(dataset)
    }

    fn variable(&mut self, version: u8, dimensions: &[Dimension]) -> io::Result<Variable> {
        let (name, count) = (self.name()?, self.size()?);
        let mut own = Vec::new();
        for _ in 0..self.checked(count)? {
            let index = self.size()? as usize;
            let known = dimensions.get(index).ok_or_else(|| damaged(format!("'{name}' has a dimension that there is not")))?;
            if known.is_record && !own.is_empty() {
                return Err(damaged(format!("'{name}' has records along a faster axis")));
            }
            own.push(index);
        }
        let attributes = self.list(ATTRIBUTES, Self::attribute)?;
        let scalar = self.scalar()?;
        self.size()?;
        let first = if version == 1 { u64::from(self.word()?) } else { self.long()? };
        Ok(Variable { name, dimensions: own, attributes, scalar, first })
    }

    fn attribute(&mut self) -> io::Result<Attribute> {
        let (name, scalar, count) = (self.name()?, self.scalar()?, self.size()?);
        let bytes = count.saturating_mul(scalar.map_or(1, ScalarType::bytes) as u64);
        let values = if bytes <= LONGEST { self.bytes(bytes)? } else { self.skip(bytes)? };
        self.skip(bytes.wrapping_neg() % 4)?;
        Ok(Attribute { name, scalar, values })
    }

    /// A list of this kind, which may be absent.
    fn list<T>(&mut self, kind: u32, mut item: impl FnMut(&mut Self) -> io::Result<T>) -> io::Result<Vec<T>> {
        let (found, count) = (self.word()?, self.size()?);
        if !(found == kind || found == 0 && count == 0) {
            return Err(damaged(format!("a list of kind {found} where one of kind {kind} is expected")));
        }
        let mut all = Vec::new();
        for _ in 0..self.checked(count)? {
            all.push(item(self)?);
        }
        Ok(all)
    }

    /// The type of numbers; `None` for text.
    fn scalar(&mut self) -> io::Result<Option<ScalarType>> {
        use ScalarType::*;
        Ok(Some(match self.word()? {
            1 => Int8,
            CHAR => return Ok(None),
            3 => Int16,
            4 => Int32,
            5 => Float32,
            6 => Float64,
            7 => Uint8,
            8 => Uint16,
            9 => Uint32,
            10 => Int64,
            11 => Uint64,
            other => return Err(damaged(format!("the type {other}"))),
        }))
    }

    fn name(&mut self) -> io::Result<String> {
        let len = self.size()?;
        let bytes = self.bytes(len)?;
        self.skip(len.wrapping_neg() % 4)?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }

    fn size(&mut self) -> io::Result<u64> {
        if self.wide { self.long() } else { self.word().map(u64::from) }
    }

    fn word(&mut self) -> io::Result<u32> {
        let mut bytes = [0; 4];
        self.file.read_exact(&mut bytes)?;
        self.at += 4;
        Ok(u32::from_be_bytes(bytes))
    }

    fn long(&mut self) -> io::Result<u64> {
        Ok(u64::from(self.word()?) << 32 | u64::from(self.word()?))
    }

    /// A number of bytes or items that the file can hold.
    fn checked(&self, count: u64) -> io::Result<u64> {
        if count <= self.len.saturating_sub(self.at) { Ok(count) } else { Err(io::ErrorKind::UnexpectedEof.into()) }
    }

    fn bytes(&mut self, len: u64) -> io::Result<Vec<u8>> {
        let mut bytes = vec![0; self.checked(len)? as usize];
        self.file.read_exact(&mut bytes)?;
        self.at += len;
        Ok(bytes)
    }

    /// Passes over bytes.
    fn skip(&mut self, len: u64) -> io::Result<Vec<u8>> {
        self.at += self.checked(len)?;
        self.file.seek(SeekFrom::Start(self.at))?;
        Ok(Vec::new())
    }
}

impl Dataset {
    /// Bytes of one record of a variable.
    fn record_bytes(&self, variable: &Variable) -> u64 {
        let inside = variable.dimensions.iter().skip(1).map(|&dimension| self.dimensions[dimension].len);
        inside.fold(variable.scalar.map_or(1, ScalarType::bytes) as u64, u64::saturating_mul)
    }
}

fn damaged(problem: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, problem)
}
