//! VisIt's brick of values, `.bov`: a header file and a raw file.

use super::bytes::{Bytes, Gzip, Packed, Plain};
use super::keyed::Keyed;
use super::load::{self, Header, Opened, upright};
use super::{Format, Found, OpenOptions, numbered};
use crate::error::Error;
use crate::volume::{Contents, Endian, ScalarType};
use glam::DVec3;
use std::fs::File;

/// VisIt's brick of values.
pub(super) struct Bov;

impl Format for Bov {
    fn recognises(&self, file: &Found, _options: &OpenOptions) -> bool {
        let has = |word: &[u8]| file.start.windows(word.len()).any(|bytes| bytes == word);
        has(b"DATA_FILE") && (has(b"DATA_SIZE") || file.ends_with(&[".bov"]))
    }

    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error> {
        let path = file.path;
        let fields = Keyed::read(path, ':', "")?;
        let sizes: Vec<usize> = fields.numbers(&["DATA_SIZE"], 3)?.ok_or_else(|| fields.wrong("its header has no DATA_SIZE"))?;
        let dims = [sizes[0], sizes[1], sizes[2]];
        let scalar = scalar(&fields)?;
        let channels = fields.number("DATA_COMPONENTS")?.unwrap_or(1usize);
        let grid = load::grid(path, dims, place(&fields, dims)?, options)?;
        let mut contents = Contents { states_spacing: fields.get(&["BRICK_SIZE"]).is_some(), ..Contents::default() };
        let channel = contents.choose_channel(path, options, channels)?;
        let big = fields.get(&["DATA_ENDIAN"]).is_some_and(|order| order.eq_ignore_ascii_case("big"));
        let endian = if big { Endian::Big } else { Endian::Little };
        let name = fields.need("DATA_FILE")?;
        if name.contains('%') {
            return Err(fields.wrong(format!("its DATA_FILE, {name}, names several bricks: use a header with a single file")));
        }
        let first = fields.number::<u64>("BYTE_OFFSET")?.unwrap_or(0);
        let voxels = numbered::beside(path, name, options)?;
        let failed = |e| Error::read(&voxels, e);
        let bytes: Box<dyn Bytes> = if Found::look(&voxels)?.unpacked.is_some() {
            Box::new(Packed::<Gzip>::new(&voxels, 0, first).map_err(failed)?)
        } else {
            Box::new(Plain::new(File::open(&voxels).map_err(failed)?, first).map_err(failed)?)
        };
        let header =
            Header { endian, ..Header::new(grid, scalar) }.with_channels_inside(channel, channels).with_contents(contents);
        Ok(Opened { header, bytes, exact: false })
    }
}

fn scalar(fields: &Keyed) -> Result<ScalarType, Error> {
    let name = fields.need("DATA_FORMAT")?;
    match name.to_ascii_uppercase().as_str() {
        "BYTE" | "BYTES" => Ok(ScalarType::Uint8),
        "SHORT" | "SHORTS" => Ok(ScalarType::Int16),
        "INT" | "INTS" => Ok(ScalarType::Int32),
        "FLOAT" | "FLOATS" | "REAL" => Ok(ScalarType::Float32),
        "DOUBLE" | "DOUBLES" => Ok(ScalarType::Float64),
        _ => Err(fields.wrong(format!("its DATA_FORMAT is {name}: expected BYTE, SHORT, INT, FLOAT or DOUBLE"))),
    }
}

/// Placement of the brick. Node-centred voxels lie on its faces, zone-centred ones half a spacing inside.
fn place(fields: &Keyed, dims: [usize; 3]) -> Result<glam::DAffine3, Error> {
    let vector = |key: &str| {
        Ok::<_, Error>(fields.numbers::<f64>(&[key], 3)?.map(|numbers| DVec3::new(numbers[0], numbers[1], numbers[2])))
    };
    let origin = vector("BRICK_ORIGIN")?.unwrap_or(DVec3::ZERO);
    let Some(size) = vector("BRICK_SIZE")? else { return Ok(upright(DVec3::ONE, origin)) };
    let nodal = fields.get(&["CENTERING"]).is_some_and(|centring| centring.eq_ignore_ascii_case("nodal"));
    let steps = dims.map(|n| if nodal { n.saturating_sub(1).max(1) } else { n.max(1) } as f64);
    let spacing = size / DVec3::from_array(steps);
    Ok(upright(spacing, if nodal { origin } else { origin + spacing / 2.0 }))
}
