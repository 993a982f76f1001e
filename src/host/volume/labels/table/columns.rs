//! Tables with a line of headings, separated by commas or tabs: `index,name`, the `dseg.tsv` of BIDS, and exports of spreadsheets.

use super::{Lines, wrong};
use crate::error::Error;
use crate::volume::colors;
use crate::volume::labels::{Label, LabelTable};
use csv::{ReaderBuilder, StringRecord, Trim};
use std::path::Path;

/// Headings of the ids and of the names, the first that a file has.
const IDS: [&str; 4] = ["index", "id", "label", "value"];
const NAMES: [&str; 3] = ["name", "structure", "label"];
/// Headings of red, green and blue, from 0 to 255.
const COMPONENTS: [[&str; 2]; 3] = [["r", "red"], ["g", "green"], ["b", "blue"]];
/// Headings of `#rrggbb`.
const COLORS: [&str; 3] = ["color", "colour", "hex"];

/// The columns of a table, by number.
struct Columns {
    id: usize,
    name: Option<usize>,
    color: Option<usize>,
    components: Option<[usize; 3]>,
}

impl Columns {
    /// `None` if these are no headings of a table of labels.
    fn from_headings(headings: &StringRecord) -> Option<Self> {
        let found = |names: &[&str]| names.iter().find_map(|name| headings.iter().position(|h| h.eq_ignore_ascii_case(name)));
        let id = found(&IDS)?;
        let components = COMPONENTS.map(|names| found(&names));
        let components = if let [Some(r), Some(g), Some(b)] = components { Some([r, g, b]) } else { None };
        Some(Self { id, name: found(&NAMES).filter(|&name| name != id), color: found(&COLORS), components })
    }

    /// The label of a row. Empty cells of names and colours state none.
    fn label(&self, row: &StringRecord) -> Result<Label, String> {
        let cell = |column: usize| row.get(column).filter(|text| !text.is_empty() && *text != "n/a");
        let id = cell(self.id).unwrap_or_default();
        let id = id.parse().map_err(|_| format!("'{id}' is no id: expected a whole number from 0 to {}", u32::MAX))?;
        let name = self.name.and_then(cell).map(Into::into);
        let mut label = Label { name, ..Label::new(id) };
        if let Some(text) = self.color.and_then(cell) {
            label.color = colors::from_hex(text).ok_or_else(|| format!("'{text}' is no colour: expected #rrggbb"))?;
        } else if let Some(columns) = self.components {
            for (component, column) in label.color.iter_mut().zip(columns) {
                let text = cell(column).unwrap_or_default();
                let byte: u8 = text.parse().map_err(|_| format!("'{text}' is no component of a colour: expected 0 to 255"))?;
                *component = f64::from(byte) / 255.0;
            }
        }
        Ok(label)
    }
}

/// Whether a text begins with headings of such a table.
pub(super) fn has_headings(text: &str) -> bool {
    let mut reader = reader(text);
    reader.headers().is_ok_and(|headings| headings.len() > 1 && Columns::from_headings(headings).is_some())
}

/// Reads a table whose first line has headings.
pub(super) fn read(path: &Path, text: &str) -> Result<LabelTable, Error> {
    let mut reader = reader(text);
    let unreadable = |e: csv::Error| wrong(path, e.position().map_or(1, csv::Position::line), e.to_string());
    let columns = Columns::from_headings(reader.headers().map_err(unreadable)?);
    let columns = columns.ok_or_else(|| wrong(path, 1, "no column has ids: call it index or id"))?;
    let mut lines = Lines::new(path);
    for row in reader.records() {
        let row = row.map_err(unreadable)?;
        let line = row.position().map_or(1, csv::Position::line);
        let label = columns.label(&row).map_err(|problem| wrong(path, line, problem))?;
        lines.add(line, label)?;
    }
    LabelTable::new(lines.labels)
}

fn reader(text: &str) -> csv::Reader<&[u8]> {
    let first = text.lines().next().unwrap_or_default();
    let delimiter = if first.contains('\t') { b'\t' } else { b',' };
    ReaderBuilder::new().delimiter(delimiter).trim(Trim::All).from_reader(text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Result<LabelTable, String> {
        read(Path::new("t.csv"), text).map_err(|e| e.to_string())
    }

    #[test]
    fn columns_are_found_by_their_headings() {
        let named = table("index,name\n0,Unknown\n2,\"Matter, white\"\r\n17,\n").unwrap();
        let white = named.get(2).unwrap();
        assert_eq!((white.name.as_deref(), white.color), (Some("Matter, white"), LabelTable::default_color(2)));
        assert_eq!((named.labels().len(), named.get(17).unwrap().name.as_deref()), (2, None));
        let bids = table("index\tname\tabbreviation\tcolor\n3\tGray Matter\tGM\t#ff0033\n4\tWhite\tWM\tn/a\n").unwrap();
        assert_eq!(bids.get(3).unwrap().color, [1.0, 0.0, 0.2]);
        assert_eq!(bids.get(4).unwrap().color, LabelTable::default_color(4));
        let components = table("Name,Label,R,G,B\nliver,7,255,51,0\n").unwrap();
        let liver = components.get(7).unwrap();
        assert_eq!((liver.name.as_deref(), liver.color), (Some("liver"), [1.0, 0.2, 0.0]));
    }

    #[test]
    fn other_texts_have_no_headings() {
        assert!(has_headings("id,name\n") && has_headings("Index\tName\n3\tA\n"));
        for other in ["3 Liver 200 60 30 0\n", "index name\n", "# Color table file\n", "0 0 0 0 0 0 0 \"a, id\"\n", ""] {
            assert!(!has_headings(other), "{other}");
        }
    }

    #[test]
    fn malformed_rows_are_named() {
        for (text, expected) in [
            ("index,name\n3,A\n3,B\n", "t.csv, line 3: label 3 is in line 2, too"),
            ("index,name\n-3,A\n", "line 2: '-3' is no id"),
            ("index,name\n,A\n", "line 2: '' is no id"),
            ("index,name\n1,A,B\n", "line 2"),
            ("index,color\n1,red\n", "line 2: 'red' is no colour: expected #rrggbb"),
            ("id,r,g,b\n1,0,256,0\n", "line 2: '256' is no component"),
        ] {
            let message = table(text).unwrap_err();
            assert!(message.contains(expected), "{text}: {message}");
        }
    }
}
