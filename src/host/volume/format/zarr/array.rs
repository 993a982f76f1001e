//! Array metadata of Zarr version 2 (`.zarray`) and 3 (`zarr.json`).

use super::codec::Codec;
use super::shards::{Shards, sizes};
use super::store::Store;
use crate::error::Error;
use crate::volume::format::COMPLEX;
use crate::volume::format::conventions::{self, Attributes, Packed};
use crate::volume::{Endian, ScalarType};
use base64::Engine;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Limit of axes.
const MOST_AXES: usize = 8;
/// Bytes that a chunk may have even if its array has fewer.
const LARGE: usize = 256 << 20;

/// An array and the encoding of its chunks.
pub(super) struct Array {
    pub store: Arc<dyn Store>,
    folder: PathBuf,
    pub shape: Vec<usize>,
    /// Shape of a chunk.
    pub chunks: Vec<usize>,
    /// If a file holds several chunks.
    pub shards: Option<Shards>,
    pub scalar: ScalarType,
    pub endian: Endian,
    pub codec: Codec,
    /// Bytes of a number in chunks that are not stored.
    pub fill: Vec<u8>,
    prefix: &'static str,
    separator: char,
    /// Names of the axes, if specified.
    pub names: Vec<String>,
    attributes: Value,
    /// The fill value as a number, where it stands for missing voxels.
    missing: Option<f64>,
}

impl Array {
    pub fn new(store: Arc<dyn Store>, folder: &Path, metadata: &Value, attributes: &Value) -> Result<Self, String> {
        let shape = sizes(&metadata["shape"], "shape")?;
        let second = metadata["zarr_format"] == 2;
        let (key, encoding) = (&metadata["chunk_key_encoding"], &metadata["chunk_key_encoding"]["configuration"]);
        let (chunks, separator, prefix) = if second {
            let separator = if metadata["dimension_separator"] == "/" { '/' } else { '.' };
            (sizes(&metadata["chunks"], "chunks")?, separator, "")
        } else {
            if metadata["chunk_grid"]["name"] != "regular" {
                return Err(format!("its chunks are a {} grid: expected a regular one", metadata["chunk_grid"]["name"]));
            }
            let plain = key["name"] == "v2";
            let separator = match encoding["separator"].as_str() {
                Some(".") => '.',
                Some("/") => '/',
                _ if plain => '.',
                _ => '/',
            };
            let chunks = sizes(&metadata["chunk_grid"]["configuration"]["chunk_shape"], "chunk_shape")?;
            (chunks, separator, if plain { "" } else { "c" })
        };
        if chunks.len() != shape.len() || !(1..=MOST_AXES).contains(&shape.len()) {
            return Err(format!("it has {} axes, but its chunks have {}", shape.len(), chunks.len()));
        }
        let (scalar, codec, endian, shards) = if second {
            let (scalar, endian) = dtype(&metadata["dtype"])?;
            (scalar, Codec::from_version_2(metadata, shape.len())?, endian, None)
        } else {
            let (codec, endian, shards) = Codec::from_version_3(&metadata["codecs"], &chunks)?;
            (data_type(&metadata["data_type"])?, codec, endian, shards)
        };
        let chunks = shards.as_ref().map_or(chunks, |shards| shards.chunk.clone());
        let bytes = |sizes: &[usize]| sizes.iter().fold(scalar.bytes(), |n, &size| n.saturating_mul(size));
        // Arrays that grow have chunks for more than there is yet.
        if bytes(&chunks) > isize::MAX as usize / 32 || bytes(&chunks) > bytes(&shape).saturating_mul(2).max(LARGE) {
            return Err(format!("its chunks of {chunks:?} numbers are too large for its shape, {shape:?}"));
        }
        let fill = fill(&metadata["fill_value"], scalar, endian)?;
        let names = if second { &attributes["_ARRAY_DIMENSIONS"] } else { &metadata["dimension_names"] };
        let names = names.as_array().filter(|names| names.len() == shape.len());
        let names = names.map(|names| names.iter().map(|name| name.as_str().unwrap_or_default().to_owned()).collect());
        let names: Vec<String> = names.unwrap_or_default();
        // xarray stores `_FillValue` as the fill value of arrays of version 2, and names their axes.
        let missing = if second && !names.is_empty() { float(&metadata["fill_value"]) } else { None };
        let (folder, attributes) = (folder.into(), attributes.clone());
        Ok(Self {
            store,
            folder,
            shape,
            chunks,
            shards,
            scalar,
            endian,
            codec,
            fill,
            prefix,
            separator,
            names,
            attributes,
            missing,
        })
    }

    /// What its numbers mean by the CF conventions, as xarray writes them.
    pub fn packed(&self) -> Result<Packed, Error> {
        conventions::packed(self.scalar, self, self.missing)
    }

    /// Unit of its numbers; empty if not specified.
    pub fn unit(&self) -> String {
        self.text("units").unwrap_or_default()
    }

    /// File of a chunk, and the chunk's number in it.
    pub fn file(&self, place: &[usize]) -> (PathBuf, usize) {
        let ones = vec![1; place.len()];
        let counts = self.shards.as_ref().map_or(&ones, |shards| &shards.counts);
        let numbers: Vec<String> = place.iter().zip(counts).map(|(place, count)| (place / count).to_string()).collect();
        let number = place.iter().zip(counts).fold(0, |n, (place, count)| n * count + place % count);
        let numbers = numbers.join(&self.separator.to_string());
        let name = if self.prefix.is_empty() { numbers } else { format!("{}{}{numbers}", self.prefix, self.separator) };
        (self.folder.join(name), number)
    }

    /// Bytes of a decoded chunk.
    pub fn chunk_bytes(&self) -> usize {
        self.chunks.iter().product::<usize>() * self.scalar.bytes()
    }

    /// What messages name.
    pub fn folder(&self) -> &Path {
        &self.folder
    }
}

impl Attributes for Array {
    fn numbers(&self, name: &str) -> Option<(Vec<f64>, bool)> {
        let value = self.attributes.get(name)?;
        let list: Vec<&Value> = value.as_array().map_or(vec![value], |values| values.iter().collect());
        let numbers: Option<Vec<f64>> = list.iter().map(|number| float(number)).collect();
        Some((numbers?, list.iter().any(|number| number.is_f64())))
    }

    fn text(&self, name: &str) -> Option<String> {
        self.attributes.get(name)?.as_str().map(Into::into)
    }
}

/// A number in JSON. Floats may be text: names of what JSON lacks, or the 64 bits in base64, as xarray writes fill values.
fn float(metadata: &Value) -> Option<f64> {
    match metadata.as_str() {
        None => metadata.as_f64(),
        Some("NaN") => Some(f64::NAN),
        Some("Infinity") => Some(f64::INFINITY),
        Some("-Infinity") => Some(f64::NEG_INFINITY),
        Some(text) => {
            let bytes = base64::engine::general_purpose::STANDARD.decode(text).ok()?;
            bytes.try_into().ok().map(f64::from_le_bytes)
        }
    }
}

fn dtype(metadata: &Value) -> Result<(ScalarType, Endian), String> {
    let wrong = || format!("its numbers are {metadata}: expected integers or floats; convert it");
    let text = metadata.as_str().ok_or_else(wrong)?;
    let (order, kind) = text.split_at_checked(1).ok_or_else(wrong)?;
    let bits = kind.get(1..).and_then(|bytes| bytes.parse::<usize>().ok()).ok_or_else(wrong)?.saturating_mul(8);
    let name = match kind.as_bytes()[0] {
        b'i' => format!("int{bits}"),
        b'u' => format!("uint{bits}"),
        b'b' if bits == 8 => "uint8".into(),
        b'f' => format!("float{bits}"),
        b'c' => return Err(format!("its numbers are {metadata}: {COMPLEX}")),
        _ => return Err(wrong()),
    };
    let endian = if order == ">" { Endian::Big } else { Endian::Little };
    name.parse().map(|scalar| (scalar, endian)).map_err(|_| wrong())
}

fn data_type(metadata: &Value) -> Result<ScalarType, String> {
    let wrong = || format!("its data_type is {metadata}: expected integers or floats; convert it");
    let name = metadata.as_str().ok_or_else(wrong)?;
    if name.starts_with("complex") {
        return Err(format!("its data_type is {metadata}: {COMPLEX}"));
    }
    if name == "bool" { Ok(ScalarType::Uint8) } else { name.parse().map_err(|_| wrong()) }
}

/// Bytes of the fill value; 0 if not specified. `0x…` are the bits of a float.
fn fill(metadata: &Value, scalar: ScalarType, endian: Endian) -> Result<Vec<u8>, String> {
    let is_float = matches!(scalar, ScalarType::Float16 | ScalarType::Float32 | ScalarType::Float64);
    let hexadecimal = metadata.as_str().and_then(|text| text.strip_prefix("0x")).filter(|_| is_float);
    let bits = if metadata.is_null() {
        Some(0)
    } else if let Some(digits) = hexadecimal {
        u64::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 2 * scalar.bytes())
    } else {
        match scalar {
            ScalarType::Float16 => float(metadata).map(|value| u64::from(half::f16::from_f64(value).to_bits())),
            ScalarType::Float32 => float(metadata).map(|value| u64::from((value as f32).to_bits())),
            ScalarType::Float64 => float(metadata).map(f64::to_bits),
            _ => whole(metadata, 8 * scalar.bytes() as u32),
        }
    };
    let bits = bits.ok_or_else(|| format!("its fill_value is {metadata}: expected a number of its type, {scalar}"))?;
    let mut bytes = bits.to_le_bytes()[..scalar.bytes()].to_vec();
    if endian == Endian::Big {
        bytes.reverse();
    }
    Ok(bytes)
}

/// A whole number of so many bits, with or without a sign; some programs write it as a float.
fn whole(metadata: &Value, bits: u32) -> Option<u64> {
    let is_whole = |value: &f64| value.fract() == 0.0 && value.abs() < 2f64.powi(64);
    let number = metadata
        .as_i64()
        .map(i128::from)
        .or(metadata.as_u64().map(i128::from))
        .or(metadata.as_bool().map(i128::from))
        .or(metadata.as_f64().filter(is_whole).map(|value| value as i128))?;
    (-(1 << (bits - 1))..1 << bits).contains(&number).then_some(number as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn fill_values_are_read_or_refused() {
        for (value, scalar, expected) in [
            (json!(null), ScalarType::Uint16, &[0, 0][..]),
            (json!(7.0), ScalarType::Uint8, &[7]),
            (json!(true), ScalarType::Uint8, &[1]),
            (json!(-2), ScalarType::Int16, &[0xfe, 0xff]),
            (json!(5), ScalarType::Float32, &[0, 0, 0xa0, 0x40]),
            (json!("0x40a00000"), ScalarType::Float32, &[0, 0, 0xa0, 0x40]),
            (json!("0x7e01"), ScalarType::Float16, &[1, 0x7e]),
            (json!("-Infinity"), ScalarType::Float32, &[0, 0, 0x80, 0xff]),
        ] {
            assert_eq!(fill(&value, scalar, Endian::Little).as_deref(), Ok(expected), "{value}");
        }
        assert_eq!(fill(&json!(1), ScalarType::Uint16, Endian::Big).as_deref(), Ok(&[0, 1][..]));
        for (value, scalar) in [
            (json!(7.5), ScalarType::Uint8),
            (json!(256), ScalarType::Uint8),
            (json!("0x07"), ScalarType::Uint8),
            (json!("0x40a0"), ScalarType::Float32),
            (json!("seven"), ScalarType::Float64),
            (json!([0]), ScalarType::Int32),
        ] {
            let problem = fill(&value, scalar, Endian::Little).unwrap_err();
            assert!(problem.contains("its fill_value is"), "{problem}");
        }
    }
}
