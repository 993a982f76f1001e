//! Structured points in legacy files, `.vtk`.

use super::arrays::{self, Array, Image};
use super::scanner::{Scanner, word};
use crate::error::Error;
use crate::volume::format::bytes::{Bytes, Held, Plain};
use crate::volume::format::load::{Opened, upright};
use crate::volume::format::{Format, Found, OpenOptions};
use glam::DVec3;
use std::fs::File;
use std::ops::Range;

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
        let (image, arrays) = image(&mut scanner)?;
        let array = arrays::chosen(path, &arrays, options)?;
        let (scalar, endian) = scanner.numbers_of(array)?;
        let header = array.header(path, &image, scalar, endian, options)?;
        let bytes: Box<dyn Bytes> = if scanner.is_text {
            Box::new(Held(scanner.parsed(array, array.numbers(&image), scalar)?))
        } else {
            let failed = |e| Error::read(path, e);
            Box::new(Plain::new(File::open(path).map_err(failed)?, array.place.start).map_err(failed)?)
        };
        Ok(Opened { header, bytes, exact: false })
    }
}

/// Arrays and the ranges of bytes that they are in.
type Arrays = Vec<Array<Range<u64>>>;

fn image(scanner: &mut Scanner) -> Result<(Image, Arrays), Error> {
    let (mut points, mut spacing, mut origin) = (None, DVec3::ONE, DVec3::ZERO);
    let arrays = scanner.arrays(|scanner, keyword, words| {
        match keyword {
            "DATASET" if word(words, 1).eq_ignore_ascii_case("STRUCTURED_POINTS") => {}
            "DATASET" => {
                return Err(scanner.wrong(format!("it holds {}: expected STRUCTURED_POINTS; resample it", word(words, 1))));
            }
            "DIMENSIONS" => points = Some(scanner.three::<usize>(words)?),
            "SPACING" | "ASPECT_RATIO" => spacing = DVec3::from_array(scanner.three(words)?),
            "ORIGIN" => origin = DVec3::from_array(scanner.three(words)?),
            _ => return Ok(false),
        }
        Ok(true)
    })?;
    let points = points.filter(|points| !points.contains(&0));
    let points = points.ok_or_else(|| scanner.wrong("it has no DIMENSIONS, or one of them is 0"))?;
    Ok((Image { points, index_to_world: upright(spacing, origin) }, arrays))
}
