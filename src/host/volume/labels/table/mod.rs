//! Files of names and colours.

mod columns;
mod json;
mod text;

#[cfg(feature = "zarr")]
pub(in crate::volume) use json::image_label;

use super::{Label, LabelTable, MOST};
use crate::error::Error;
use crate::panics::caught;
use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Largest table in bytes.
const LARGEST: u64 = 64 << 20;

/// What a volume file states about the ids of its voxels.
#[derive(Debug, PartialEq)]
pub(in crate::volume) struct Declared {
    /// The labels of each layer: each channel of the file is a layer of labels. Empty where it states none.
    pub layers: Vec<LabelTable>,
}

/// Reads a table of any format.
pub(super) fn read(path: &Path) -> Result<LabelTable, Error> {
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(|e| Error::read(path, e))?;
    file.take(LARGEST + 1).read_to_end(&mut bytes).map_err(|e| Error::read(path, e))?;
    if bytes.len() as u64 > LARGEST {
        return Err(Error::volume(path, format!("it has more than {LARGEST} bytes: too many for a table of labels")));
    }
    if bytes.len() == BINARY && path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("lut")) {
        return colors(&bytes);
    }
    let text = std::str::from_utf8(&bytes).map_err(|e| {
        let line = 1 + bytes[..e.valid_up_to()].iter().filter(|&&byte| byte == b'\n').count() as u64;
        wrong(path, line, "it is no text in UTF-8: a table of labels is text or JSON")
    })?;
    let text = text.trim_start_matches('\u{feff}');
    caught(path, || {
        if text.trim_start().starts_with(['{', '[']) {
            json::read(path, text)
        } else if columns::has_headings(text) {
            columns::read(path, text)
        } else {
            text::read(path, text)
        }
    })
}

/// Endings of tables that lie beside a volume. Programs for atlases write names and colours into files of their own (MRIcron).
const BESIDE: [&str; 4] = ["txt", "ctbl", "csv", "lut"];

/// The table beside a volume that is called like it; `None` if there is none.
pub(super) fn beside(volume: &Path) -> Option<LabelTable> {
    let unpacked = volume.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gz")).then(|| volume.with_extension(""));
    let whole = unpacked.unwrap_or_else(|| volume.into());
    let candidates = BESIDE.iter().flat_map(|ending| {
        let behind = whole.with_file_name(format!("{}.{ending}", whole.file_name().unwrap_or_default().to_string_lossy()));
        [behind, whole.with_extension(ending)]
    });
    let mut found: Option<LabelTable> = None;
    for file in candidates.filter(|file| file.is_file()) {
        let table = match read(&file) {
            Ok(table) => table,
            Err(e) => {
                tracing::warn!("{}: {e}: it is left out", volume.display());
                continue;
            }
        };
        let (of_names, is_used) = match found.take() {
            None => (table, true),
            Some(named) if named.has_default_colors() => (named.colored_as(&table), true),
            Some(named) => (named, false),
        };
        found = Some(of_names);
        if is_used {
            tracing::warn!("{}: its labels are those of {}, which lies beside it", volume.display(), file.display());
        }
    }
    found
}

impl LabelTable {
    /// Whether no label has a colour of its own.
    fn has_default_colors(&self) -> bool {
        self.labels.iter().all(|label| label.color == Self::default_color(label.id))
    }

    /// The labels with the colours of those that another table has.
    fn colored_as(mut self, other: &Self) -> Self {
        for label in &mut self.labels {
            label.color = other.get(label.id).map_or(label.color, |other| other.color);
        }
        self
    }
}

/// Bytes of a binary table.
const BINARY: usize = 3 * 256;

/// The colours of the ids 1 to 255 in a binary table, as MRIcron and ImageJ write them: 256 bytes of red, of green and of blue.
fn colors(bytes: &[u8]) -> Result<LabelTable, Error> {
    let color = |id: usize| [0, 256, 512].map(|first| f64::from(bytes[first + id]) / 255.0);
    LabelTable::new((1..256).map(|id| Label { color: color(id), ..Label::new(id as u32) }))
}

/// The labels of the lines of a table.
struct Lines<'a> {
    path: &'a Path,
    /// The line of each id.
    known: HashMap<u32, u64>,
    labels: Vec<Label>,
}

impl<'a> Lines<'a> {
    fn new(path: &'a Path) -> Self {
        Self { path, known: HashMap::new(), labels: Vec::new() }
    }

    /// Adds the label of a line, unless it is the background.
    fn add(&mut self, line: u64, label: Label) -> Result<(), Error> {
        if let Some(before) = self.known.insert(label.id, line) {
            let problem = format!("label {} is in line {before}, too: give each label a separate id", label.id);
            return Err(wrong(self.path, line, problem));
        }
        if self.known.len() > MOST {
            return Err(wrong(self.path, line, format!("more than {MOST} labels: leave out those that no voxel has")));
        }
        if label.id > 0 {
            self.labels.push(label);
        }
        Ok(())
    }
}

fn wrong(path: &Path, line: u64, problem: impl Into<String>) -> Error {
    Error::Labels { path: path.into(), line, problem: problem.into() }
}
