//! Data files of a MetaImage.

use crate::error::Error;
use crate::volume::ScalarType;
use crate::volume::format::bytes::{Bytes, Held, Packed, Plain, Zlib};
use crate::volume::format::keyed::Keyed;
use crate::volume::format::{OpenOptions, numbered, text};
use std::fs::File;
use std::path::Path;

/// Whether the numbers are text.
pub(super) fn is_text(fields: &Keyed) -> bool {
    fields.get(&["BinaryData"]).is_some() && !fields.is_true(&["BinaryData"])
}

/// Data of the whole array. The product of `sizes` must not overflow.
pub(super) fn bytes(
    path: &Path,
    options: &OpenOptions,
    fields: &Keyed,
    sizes: &[usize],
    (channels, scalar): (usize, ScalarType),
) -> Result<Box<dyn Bytes>, Error> {
    let named = fields.need("ElementDataFile")?;
    let of = |axes: usize| sizes[..axes].iter().product::<usize>() as u64 * (channels * scalar.bytes()) as u64;
    let whole = of(sizes.len());
    if named.eq_ignore_ascii_case("LOCAL") {
        return one(path, fields, fields.end, whole, scalar);
    }
    let Some((files, axes)) = several(path, options, fields, named)? else {
        return one(&numbered::beside(path, named, options)?, fields, 0, whole, scalar);
    };
    let each = of(axes.unwrap_or(sizes.len() - 1).clamp(1, sizes.len()));
    let fields = fields.clone();
    numbered::joined(path, files, whole, each, move |file| one(file, &fields, 0, each, scalar))
}

/// Files of `LIST [axes]` or `pattern first last step`, and the number of axes per file.
fn several(path: &Path, options: &OpenOptions, fields: &Keyed, named: &str) -> Result<Option<numbered::Several>, Error> {
    let words: Vec<&str> = named.split_whitespace().collect();
    if words.first() == Some(&"LIST") {
        let files = fields.listed.iter().map(|name| numbered::beside(path, name, options)).collect::<Result<_, _>>()?;
        let axes = words.get(1).and_then(|axes| axes.trim_end_matches(['D', 'd']).parse().ok());
        return Ok(Some((files, axes)));
    }
    let numbers: Option<Vec<i64>> = words.iter().skip(1).map(|word| word.parse().ok()).collect();
    let Some(&[first, last, ref step @ ..]) = numbers.as_deref().filter(|_| named.contains('%')) else { return Ok(None) };
    let names = numbered::names(words[0], first, last, step.first().copied().unwrap_or(1));
    let names = names.map_err(|problem| fields.wrong(problem))?;
    let files = names.iter().map(|name| numbered::beside(path, name, options)).collect::<Result<_, _>>()?;
    Ok(Some((files, None)))
}

/// Data of one file from byte `start`, `len` bytes after decompression.
fn one(path: &Path, fields: &Keyed, start: u64, len: u64, scalar: ScalarType) -> Result<Box<dyn Bytes>, Error> {
    let failed = |e| Error::read(path, e);
    let file = File::open(path).map_err(failed)?;
    if is_text(fields) {
        let text = text::read_from(path, file, start)?;
        return Ok(Box::new(Held(text::numbers(path, &text, len / scalar.bytes() as u64, scalar)?)));
    }
    if fields.is_true(&["CompressedData"]) {
        return Ok(Box::new(Packed::<Zlib>::new(path, start, 0).map_err(failed)?));
    }
    let skip = fields.number::<i64>("HeaderSize")?.unwrap_or(0);
    let plain = match u64::try_from(skip) {
        Ok(skip) => Plain::new(file, start.saturating_add(skip)),
        Err(_) if skip == -1 => Plain::last(file, len),
        Err(_) => return Err(fields.wrong(format!("its HeaderSize is {skip}: expected -1 or a number of bytes"))),
    };
    Ok(Box::new(plain.map_err(failed)?))
}
