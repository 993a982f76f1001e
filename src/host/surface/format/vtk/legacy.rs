//! PolyData in legacy files, `.vtk`.

use super::{Declared, KINDS, Stored, add_array};
use crate::error::Error;
use crate::memory;
use crate::surface::Space;
use crate::surface::format::SurfaceFile;
use crate::volume::vtk::arrays::Array;
use crate::volume::vtk::scanner::Scanner;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;

/// The version from which on cells are offsets and indices, not lists behind their counts.
const OFFSETS: f64 = 5.0;

/// An array and its count of numbers.
type Counted = (Array<Range<u64>>, u64);

/// Cells of a kind.
struct Section {
    kind: usize,
    count: u64,
    /// Indices, or indices and counts.
    points: Counted,
    offsets: Option<Counted>,
}

pub(in crate::surface::format) fn read(path: &Path) -> Result<SurfaceFile, Error> {
    let mut scanner = Scanner::open(path)?;
    let (mut points, mut sections): (Option<Counted>, Vec<Section>) = (None, Vec::new());
    let arrays = scanner.arrays(|scanner, keyword, words| {
        let kind = KINDS.iter().position(|[_, name]| *name == keyword);
        match (keyword, kind) {
            // Behind the first, others stand alone where they are empty.
            ("DATASET" | "OFFSETS" | "CONNECTIVITY", _) => {}
            ("POINTS", _) => {
                let count = scanner.number::<u64>(words, 1)?.saturating_mul(3);
                points = Some(block(scanner, "points", words.get(2).map_or("", String::as_str), count)?);
            }
            (_, Some(kind)) => {
                let (count, size) = (scanner.number::<u64>(words, 1)?, scanner.number(words, 2)?);
                sections.push(section(scanner, kind, count, size)?);
            }
            _ => return Ok(false),
        }
        Ok(true)
    })?;
    let read = |array: &_, count| stored(&scanner, path, array, count);
    let stored = |(array, count): &Counted| read(array, *count);
    let wrong = |problem| scanner.wrong(problem);
    let points = points.ok_or_else(|| scanner.wrong("it has no POINTS"))?;
    let coding = if scanner.is_text { "text" } else { "binary" };
    let format = format!("VTK PolyData, legacy, {coding}");
    let mut file =
        SurfaceFile { format, header: scanner.title.clone(), points: stored(&points)?.points(), ..SurfaceFile::default() };
    let named = scanner.strings.iter().find(|(name, _)| name == "SPACE").and_then(|(_, space)| space.parse().ok());
    file.space = named.or_else(|| Space::of_header(&file.header));
    sections.sort_by_key(|section| section.kind);
    let mut number = 0;
    for section in &sections {
        let points = stored(&section.points)?.whole(0).map_err(wrong)?;
        let cells = match &section.offsets {
            Some(offsets) => Declared { ends: stored(offsets)?.whole(0).map_err(wrong)?.split_off(1), points },
            None => Declared::counted(&points, section.count).map_err(wrong)?,
        };
        number = cells.add(section.kind, &mut file, number).map_err(wrong)?;
    }
    for array in arrays {
        let entries = if array.cell_data { u64::from(number) } else { file.points.len() as u64 };
        let count = entries.saturating_mul(array.components as u64);
        add_array(&mut file, &array, &read(&array, count)?);
    }
    Ok(file)
}

/// Skips the numbers of an array of the geometry.
fn block(scanner: &mut Scanner, name: &str, type_name: &str, count: u64) -> Result<Counted, Error> {
    let place = scanner.skip(type_name, count)?;
    let (name, type_name) = (name.into(), type_name.into());
    let [cell_data, active, is_vector, are_normals, are_colors] = [false; 5];
    Ok((Array { name, type_name, components: 1, cell_data, active, is_vector, are_normals, are_colors, place }, count))
}

fn section(scanner: &mut Scanner, kind: usize, count: u64, size: u64) -> Result<Section, Error> {
    if scanner.version < OFFSETS {
        return Ok(Section { kind, count, points: block(scanner, "cells", "int", size)?, offsets: None });
    }
    let mut part = |keyword: &str, count| {
        let words = if count == 0 { None } else { scanner.words()? };
        match words.unwrap_or_default().as_slice() {
            [found, type_name] if found.eq_ignore_ascii_case(keyword) => block(scanner, keyword, type_name, count),
            [] if count == 0 => block(scanner, keyword, "int", 0),
            words => Err(scanner.wrong(format!("expected {keyword}, found '{}'", words.join(" ")))),
        }
    };
    let offsets = part("OFFSETS", count)?;
    Ok(Section { kind, count, points: part("CONNECTIVITY", size)?, offsets: Some(offsets).filter(|_| count > 0) })
}

/// Reads an array that is in the file.
fn stored(scanner: &Scanner, path: &Path, array: &Array<Range<u64>>, count: u64) -> Result<Stored, Error> {
    let (scalar, endian) = scanner.numbers_of(array)?;
    if scanner.is_text {
        return Ok(Stored { bytes: scanner.parsed(array, count, scalar)?, scalar, endian });
    }
    let (failed, wanted) = (|e| Error::read(path, e), count.saturating_mul(scalar.bytes() as u64));
    if wanted > array.place.end - array.place.start {
        return Err(scanner.wrong(format!("its array {} has fewer than {count} numbers: it is damaged", array.name)));
    }
    let mut file = File::open(path).map_err(failed)?;
    file.seek(SeekFrom::Start(array.place.start)).map_err(failed)?;
    let mut bytes = memory::zeroed::<u8>(&path.display().to_string(), wanted as usize)?;
    file.read_exact(&mut bytes).map_err(failed)?;
    Ok(Stored { bytes, scalar, endian })
}
