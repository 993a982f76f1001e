//! Data files of an NRRD.

use super::axes::Axes;
use super::fields::Fields;
use crate::error::Error;
use crate::volume::ScalarType;
use crate::volume::format::bytes::{Bytes, Gzip, Held, Packed, Plain};
use crate::volume::format::{OpenOptions, numbered, text};
use std::fs::File;
use std::io::{BufRead, BufReader, Seek, SeekFrom};
use std::path::Path;

/// Data of the whole array.
pub(super) fn bytes(
    path: &Path,
    options: &OpenOptions,
    fields: &Fields,
    axes: &Axes,
    scalar: ScalarType,
) -> Result<Box<dyn Bytes>, Error> {
    let whole = axes.bytes(scalar);
    let Some(named) = fields.get("data file") else { return one(path, fields, fields.end, whole, scalar) };
    let Some((files, per_file)) = several(path, options, fields, named)? else {
        return one(&numbered::beside(path, named, options)?, fields, 0, whole, scalar);
    };
    let axes_per_file = per_file.unwrap_or(axes.sizes.len() - 1).clamp(1, axes.sizes.len());
    let each = axes.stride(axes_per_file, scalar);
    let fields = fields.clone();
    numbered::joined(path, files, whole, each, move |file| one(file, &fields, 0, each, scalar))
}

/// Files of `LIST [axes]` or `pattern first last step [axes]`, and the number of axes per file.
fn several(path: &Path, options: &OpenOptions, fields: &Fields, named: &str) -> Result<Option<numbered::Several>, Error> {
    let words: Vec<&str> = named.split_whitespace().collect();
    if words.first() == Some(&"LIST") {
        let files = fields.listed.iter().map(|name| numbered::beside(path, name, options)).collect::<Result<_, _>>()?;
        return Ok(Some((files, words.get(1).and_then(|n| n.parse().ok()))));
    }
    let numbers: Option<Vec<i64>> = words.iter().skip(1).map(|word| word.parse().ok()).collect();
    let Some(&[first, last, step, ref rest @ ..]) = numbers.as_deref().filter(|_| named.contains('%')) else { return Ok(None) };
    let names = numbered::names(words[0], first, last, step).map_err(|problem| fields.wrong(problem))?;
    let files = names.iter().map(|name| numbered::beside(path, name, options)).collect::<Result<_, _>>()?;
    Ok(Some((files, rest.first().and_then(|&n| usize::try_from(n).ok()))))
}

/// Data of one file from byte `start`, `len` bytes after decompression.
fn one(path: &Path, fields: &Fields, start: u64, len: u64, scalar: ScalarType) -> Result<Box<dyn Bytes>, Error> {
    let failed = |e| Error::read(path, e);
    let mut file = File::open(path).map_err(failed)?;
    let lines = u64::try_from(fields.whole("line skip")?).map_err(|_| fields.wrong("its line skip is below 0"))?;
    let start = behind_lines(&mut file, start, lines).map_err(failed)?;
    let skip = fields.whole("byte skip")?;
    let skipped = u64::try_from(skip);
    let encoding = fields.encoding().to_ascii_lowercase();
    match (encoding.as_str(), skipped) {
        ("raw", Ok(skip)) => Ok(Box::new(Plain::new(file, start.saturating_add(skip)).map_err(failed)?)),
        ("raw", Err(_)) if skip == -1 => Ok(Box::new(Plain::last(file, len).map_err(failed)?)),
        ("gz" | "gzip", Ok(skip)) => Ok(Box::new(Packed::<Gzip>::new(path, start, skip).map_err(failed)?)),
        ("txt" | "text" | "ascii", Ok(skip)) => {
            let text = text::read_from(path, file, start.saturating_add(skip))?;
            Ok(Box::new(Held(text::numbers(path, &text, len / scalar.bytes() as u64, scalar)?)))
        }
        ("hex", Ok(skip)) => {
            Ok(Box::new(Held(text::hexadecimal(path, &text::read_from(path, file, start.saturating_add(skip))?)?)))
        }
        (_, Err(_)) => Err(fields.wrong(format!(
            "its byte skip is {skip}: negative values are invalid, except -1 for raw data at the end of \
                                      a file"
        ))),
        (other, _) => Err(fields.wrong(format!("its encoding is '{other}': expected raw, gzip, ascii or hex; re-encode it"))),
    }
}

/// Byte after `lines` lines.
fn behind_lines(file: &mut File, start: u64, lines: u64) -> std::io::Result<u64> {
    file.seek(SeekFrom::Start(start))?;
    let mut reader = BufReader::new(file);
    let mut at = start;
    for _ in 0..lines {
        let skipped = reader.skip_until(b'\n')? as u64;
        if skipped == 0 {
            break;
        }
        at += skipped;
    }
    Ok(at)
}
