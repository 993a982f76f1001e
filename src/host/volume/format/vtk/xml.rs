//! VTK XML image data, `.vti`.

use super::arrays::{self, Array, Image};
use super::document::{Document, Place};
use super::pieces::{self, Extent, Piece};
use crate::error::Error;
use crate::volume::ScalarType;
use crate::volume::format::bytes::Held;
use crate::volume::format::load::Opened;
use crate::volume::format::{Format, Found, OpenOptions};
use glam::{DAffine3, DMat3, DVec3};

/// VTK XML image data.
pub(in crate::volume::format) struct Xml;

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
        if document.kind != "ImageData" {
            return Err(document.wrong(format!(
                "it holds {}: expected ImageData; resample it, or give one of its files if it is a parallel format",
                document.kind
            )));
        }
        let extents = document.pieces.iter().map(|piece| extent(&document, piece)).collect::<Result<Vec<Extent>, Error>>()?;
        let whole = pieces::union(extents.iter().copied()).ok_or_else(|| document.wrong("it has no piece of ImageData"))?;
        let array = arrays::chosen(path, &document.pieces[0].arrays, options)?;
        let (scalar, endian) = document.numbers_of(array)?;
        let image = &image(&document, whole)?;
        let header = array.header(path, image, scalar, endian, options)?;
        let bytes = match document.pieces.len() {
            1 => document.bytes(array, array.numbers(image), scalar)?,
            _ => {
                let pieces = document.pieces.iter().zip(&extents);
                let bytes = pieces.map(|(piece, extent)| piece_of(&document, &piece.arrays, *extent, array, scalar));
                Box::new(Held(pieces::joined(path, array, (image, whole), scalar.bytes(), bytes)?))
            }
        };
        Ok(Opened { header, bytes, exact: false })
    }
}

/// The extent of a piece, which has points.
fn extent(document: &Document, piece: &super::document::Piece) -> Result<Extent, Error> {
    let extent = document.numbers(&piece.attributes, "Extent")?;
    let extent = extent.ok_or_else(|| document.wrong("its piece has no Extent"))?;
    image(document, extent).map(|_| extent)
}

/// Placement of the points of an extent.
fn image(document: &Document, extent: Extent) -> Result<Image, Error> {
    let points = |i: usize| usize::try_from(i64::from(extent[2 * i + 1]) - i64::from(extent[2 * i]) + 1).ok().filter(|&n| n > 0);
    let (Some(x), Some(y), Some(z)) = (points(0), points(1), points(2)) else {
        return Err(document.wrong(format!("its extent, {extent:?}, has no points")));
    };
    let vector = |name: &str| document.numbers::<f64, 3>(&document.attributes, name);
    let (origin, spacing) = (vector("Origin")?.unwrap_or([0.0; 3]), vector("Spacing")?.unwrap_or([1.0; 3]));
    let first = DVec3::new(extent[0].into(), extent[2].into(), extent[4].into());
    // Row-major in the file.
    let direction = document.numbers(&document.attributes, "Direction")?;
    let direction = direction.map_or(DMat3::IDENTITY, |rows: [f64; 9]| DMat3::from_cols_array(&rows).transpose());
    let matrix3 = direction * DMat3::from_diagonal(DVec3::from_array(spacing));
    let translation = DVec3::from_array(origin) + matrix3 * first;
    Ok(Image { points: [x, y, z], index_to_world: DAffine3 { matrix3, translation } })
}

/// The numbers of `array` in one of several pieces.
fn piece_of(
    document: &Document,
    arrays: &[Array<Place>],
    extent: Extent,
    array: &Array<Place>,
    scalar: ScalarType,
) -> Result<Piece, Error> {
    let own = arrays.iter().find(|own| own.is_like(array) && own.place.is_text() == array.place.is_text());
    let own =
        own.ok_or_else(|| document.wrong(format!("one of its pieces lacks the array {} of the first piece", array.name)))?;
    let numbers = own.numbers(&image(document, extent)?);
    Ok(Piece { extent, bytes: document.bytes(own, numbers, scalar)? })
}
