//! NRRD, attached and detached (<https://teem.sourceforge.net/nrrd/format.html>).

mod axes;
mod data;
mod fields;
mod segments;

use super::load::{Header, Opened};
use super::{Format, Found, OpenOptions};
use crate::error::Error;
use crate::volume::labels::Declared;
use crate::volume::{Endian, ScalarType};
use fields::Fields;

/// NRRD.
pub(super) struct Nrrd;

impl Format for Nrrd {
    fn recognises(&self, file: &Found, _options: &OpenOptions) -> bool {
        file.start.starts_with(b"NRRD000")
    }

    fn labels(&self, file: &Found, options: &OpenOptions) -> Result<Option<Declared>, Error> {
        let fields = Fields::read(file.path)?;
        if !segments::are_declared(&fields) {
            return Ok(None);
        }
        let any = OpenOptions { frame: Some(0), channel: Some(0), ..options.clone() };
        let place = axes::Axes::from_fields(&fields)?.place(&fields, file.path, scalar(&fields)?, &any)?;
        segments::layers(&fields, place.contents.channels).map(|layers| Some(Declared { layers }))
    }

    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error> {
        let path = file.path;
        let fields = Fields::read(path)?;
        let scalar = scalar(&fields)?;
        let axes = axes::Axes::from_fields(&fields)?;
        let grid = axes.grid(path, &fields, options)?;
        let axes::Place { first, strides, component_stride, mut contents } = axes.place(&fields, path, scalar, options)?;
        let endian = match (fields.get("endian").map(str::to_ascii_lowercase).as_deref(), scalar.bytes()) {
            (Some("little"), _) | (None, 1) => Endian::Little,
            (Some("big"), _) => Endian::Big,
            (None, _) if !fields.is_binary() => Endian::NATIVE,
            (other, _) => {
                let found = other.unwrap_or("missing");
                return Err(fields.wrong(format!("its endian is {found}: expected little or big for multi-byte types")));
            }
        };
        contents.are_colors = are_colors(&fields, contents.channels);
        let endian = if fields.is_text() { Endian::NATIVE } else { endian };
        let bytes = data::bytes(path, options, &fields, &axes, scalar)?;
        let header = Header { endian, first, strides, contents, ..Header::new(grid, scalar) };
        Ok(Opened { header: header.with_magnitude(component_stride), bytes, exact: false })
    }
}

/// Whether the components of a voxel are those of a colour.
fn are_colors(fields: &Fields, components: usize) -> bool {
    let kinds = fields.get("kinds").unwrap_or_default().to_ascii_lowercase();
    kinds.split_whitespace().any(|kind| [(3, "rgb-color"), (4, "rgba-color")].contains(&(components, kind)))
}

/// Scalar type by any of its names.
fn scalar(fields: &Fields) -> Result<ScalarType, Error> {
    let name = fields.need("type")?;
    match name {
        "signed char" | "int8" | "int8_t" => Ok(ScalarType::Int8),
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Ok(ScalarType::Uint8),
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => Ok(ScalarType::Int16),
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Ok(ScalarType::Uint16),
        "int" | "signed int" | "int32" | "int32_t" => Ok(ScalarType::Int32),
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Ok(ScalarType::Uint32),
        "longlong" | "long long" | "long long int" | "signed long long" | "signed long long int" | "int64" | "int64_t" => {
            Ok(ScalarType::Int64)
        }
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => Ok(ScalarType::Uint64),
        "half" | "float16" => Ok(ScalarType::Float16),
        "float" | "float32" => Ok(ScalarType::Float32),
        "double" | "float64" => Ok(ScalarType::Float64),
        _ => Err(fields.wrong(format!("its type is '{name}': expected int8 to double; blocks are not supported"))),
    }
}
