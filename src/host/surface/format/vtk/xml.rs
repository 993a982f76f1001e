//! PolyData in XML, `.vtp`.

use super::{Declared, KINDS, Stored, add_array};
use crate::error::Error;
use crate::memory;
use crate::surface::Space;
use crate::surface::format::SurfaceFile;
use crate::volume::ScalarType;
use crate::volume::vtk::arrays::Array;
use crate::volume::vtk::document::{Document, Piece, Place};
use std::path::Path;

pub(in crate::surface::format) fn read(path: &Path) -> Result<SurfaceFile, Error> {
    let document = Document::read(path)?;
    if document.kind != "PolyData" {
        let problem = format!("it holds {}: expected PolyData, or one of its files if it is a parallel format", document.kind);
        return Err(document.wrong(problem));
    }
    let mut file = SurfaceFile { format: "VTK PolyData, XML".into(), ..SurfaceFile::default() };
    file.space = space(&document);
    let count = |piece: &Piece, name: &str| document.numbers(&piece.attributes, name).map(|n| n.map_or(0u64, |[n]| n));
    // Pieces that have points: the others may lack arrays.
    let (mut number, mut pieces): (u32, Vec<(&Piece, [u64; 2])>) = (0, Vec::new());
    for piece in &document.pieces {
        let (points, first) = (count(piece, "NumberOfPoints")?, file.points.len());
        if points == 0 {
            continue;
        }
        let array = named(&document, piece, "Points", None)?;
        file.points.extend(stored(&document, array, points.saturating_mul(3))?.points());
        let before = number;
        for (kind, [tag, _]) in KINDS.iter().enumerate() {
            let cells = count(piece, &format!("NumberOf{tag}"))?;
            if cells > 0 {
                let wrong = |problem| document.wrong(problem);
                let ends = stored(&document, named(&document, piece, tag, Some("offsets"))?, cells)?.whole(0).map_err(wrong)?;
                let last = ends.last().map_or(0, |last| u64::from(*last));
                let connectivity = named(&document, piece, tag, Some("connectivity"))?;
                let points = stored(&document, connectivity, last)?.whole(first).map_err(wrong)?;
                number = Declared { ends, points }.add(kind, &mut file, number).map_err(wrong)?;
            }
        }
        pieces.push((piece, [points, u64::from(number - before)]));
    }
    if let Some((first, _)) = pieces.first() {
        for array in &first.arrays {
            add_array(&mut file, array, &joined(&document, &pieces, array)?);
        }
    }
    Ok(file)
}

/// An array of all pieces.
fn joined(document: &Document, pieces: &[(&Piece, [u64; 2])], array: &Array<Place>) -> Result<Stored, Error> {
    let mut all = Vec::new();
    for (piece, counts) in pieces {
        let own = piece.arrays.iter().find(|own| own.is_like(array) && own.place.is_text() == array.place.is_text());
        let own = own.ok_or_else(|| document.wrong(format!("one of its pieces lacks the array {} of the first", array.name)))?;
        let count = counts[usize::from(array.cell_data)].saturating_mul(array.components as u64);
        all.extend(stored(document, own, count)?.bytes);
    }
    let (scalar, endian) = document.numbers_of(array)?;
    Ok(Stored { bytes: all, scalar, endian })
}

/// An array of the geometry, by its tag and its name.
fn named<'a>(document: &Document, piece: &'a Piece, tag: &str, name: Option<&str>) -> Result<&'a Array<Place>, Error> {
    let is_it = |(other, array): &&(String, Array<Place>)| other == tag && name.is_none_or(|name| array.name == name);
    let found = piece.geometry.iter().find(is_it);
    let lacks = || document.wrong(format!("its {tag} lack the array {}: it is damaged", name.unwrap_or("of their positions")));
    found.map(|(_, array)| array).ok_or_else(lacks)
}

/// Reads an array that is in the file.
fn stored(document: &Document, array: &Array<Place>, count: u64) -> Result<Stored, Error> {
    let (scalar, endian) = document.numbers_of(array)?;
    let (name, wanted) = (document.path.display().to_string(), count.saturating_mul(scalar.bytes() as u64));
    let mut bytes = document.bytes(array, count, scalar)?;
    let lacks = || document.wrong(format!("its array {} has fewer than {count} numbers: it is truncated or damaged", array.name));
    if wanted > bytes.most() {
        return Err(lacks());
    }
    let mut numbers = memory::zeroed::<u8>(&name, wanted as usize)?;
    let failed = |e| document.wrong(format!("the data of its array {} are truncated or damaged: {e}", array.name));
    let found = bytes.read(0, &mut numbers).map_err(failed)?;
    if found < numbers.len() { Err(lacks()) } else { Ok(Stored { bytes: numbers, scalar, endian }) }
}

/// The space that an array of the whole data set names, as 3D Slicer writes it.
fn space(document: &Document) -> Option<Space> {
    let array = document.fields.iter().find(|array| array.name == "SPACE")?;
    let mut name = [0; 3];
    let mut bytes = document.bytes(array, name.len() as u64, ScalarType::Uint8).ok()?;
    let found = bytes.read(0, &mut name).ok()?;
    std::str::from_utf8(&name[..found]).ok()?.parse().ok()
}
