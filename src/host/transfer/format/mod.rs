//! Transfer function files. The content determines the format on reading, the file name on writing.

mod ciede2000;
mod color_space;
mod csv;
mod curve;
pub(super) mod paraview;
mod slicer_json;
mod slicer_text;

#[cfg(test)]
pub(super) use color_space::lab;

use super::TransferFunction;
use crate::error::Error;
use crate::panics::caught;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Largest file accepted.
const MAX_BYTES: u64 = 16 << 20;
/// Largest number of control points: one per 16-bit value.
const MAX_POINTS: usize = 1 << 16;

/// File formats of transfer functions.
///
/// ```
/// use layersplat::transfer::FileFormat;
/// use std::path::Path;
///
/// assert_eq!(FileFormat::from_path(Path::new("bone.vp.json"))?, FileFormat::SlicerJson);
/// assert!(FileFormat::from_path(Path::new("bone.txt")).is_err());
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FileFormat {
    /// A ParaView colour-map preset with opacities, `.json`.
    ParaView,
    /// 3D Slicer volume property as text, `.vp`. Slicer reads at most 1023 bytes of a line.
    SlicerText,
    /// 3D Slicer volume property as JSON, `.vp.json`.
    SlicerJson,
    /// Lines of value, red, green, blue and opacity, `.csv`.
    Csv,
}

impl FileFormat {
    /// The format of a file name's extension.
    ///
    /// # Errors
    /// [`Error::UnknownName`] if no format has that extension.
    pub fn from_path(path: &Path) -> Result<Self, Error> {
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let endings = [
            (".vp.json", FileFormat::SlicerJson),
            (".json", FileFormat::ParaView),
            (".vp", FileFormat::SlicerText),
            (".csv", FileFormat::Csv),
        ];
        let found = endings.into_iter().find(|(ending, _)| name.ends_with(ending));
        found.map(|(_, format)| format).ok_or_else(|| Error::UnknownName {
            what: "transfer function format",
            name: path.display().to_string(),
            known: "a name ending in .json (ParaView), .vp or .vp.json (3D Slicer), or .csv".into(),
        })
    }
}

impl TransferFunction {
    /// Formats this function as the content of a file. Every format keeps all control points. Only ParaView presets keep the name.
    /// CSV lists colours and opacities at the same values.
    ///
    /// ```
    /// use layersplat::TransferFunction;
    /// use layersplat::transfer::FileFormat;
    ///
    /// let red = TransferFunction::new("red", vec![(0.0, [1.0, 0.0, 0.0])], vec![(0.0, 0.0), (9.0, 0.5)])?;
    /// assert_eq!(red.to_text(FileFormat::Csv), "value,r,g,b,a\n0,1,0,0,0\n9,1,0,0,0.5\n");
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    pub fn to_text(&self, format: FileFormat) -> String {
        match format {
            FileFormat::ParaView => paraview::written(self),
            FileFormat::SlicerText => slicer_text::written(self),
            FileFormat::SlicerJson => slicer_json::written(self),
            FileFormat::Csv => csv::written(self),
        }
    }
}

/// Reads a file of any format. Of a ParaView file, takes the preset called `preset`, or the first one.
pub(super) fn read(path: &Path, preset: Option<&str>) -> Result<TransferFunction, Error> {
    let file = path.display().to_string();
    let mut bytes = Vec::new();
    let opened = File::open(path).map_err(|e| Error::read(path, e))?;
    opened.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(|e| Error::read(path, e))?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(bad(&file, format!("is larger than {} MiB, the limit for transfer functions", MAX_BYTES >> 20)));
    }
    let text = String::from_utf8(bytes).map_err(|_| bad(&file, unrecognised("is not UTF-8 text")))?;
    caught(path, || parse(&text, &file, preset))
}

/// Parses the text of a file of any format. `file` names it in errors.
pub(super) fn parse(text: &str, file: &str, preset: Option<&str>) -> Result<TransferFunction, Error> {
    // Some editors begin a file with a byte-order mark, which JSON does not have.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let first = text.trim_start().lines().next().unwrap_or("").trim_end();
    let is_json = first.starts_with(['{', '[']);
    if is_json && !text.contains("\"volumeProperties\"") {
        return paraview::parse(text, file, preset);
    }
    if let Some(preset) = preset {
        return Err(bad(file, format!("has no preset '{preset}', because its format holds one function only: omit the preset")));
    }
    match first {
        "" => Err(bad(file, unrecognised("is empty"))),
        _ if is_json => slicer_json::parse(text, file),
        _ if first.starts_with('#') || first.contains(csv::SEPARATORS) => csv::parse(text, file),
        number if number.parse::<f64>().is_ok() => slicer_text::parse(text, file),
        _ => Err(bad(file, unrecognised("has an unknown format"))),
    }
}

fn unrecognised(problem: &str) -> String {
    format!(
        "{problem}: expected a ParaView preset (JSON), a 3D Slicer volume property (.vp or .vp.json), or lines of value,r,g,b,a (CSV)"
    )
}

fn bad(file: &str, problem: impl Into<String>) -> Error {
    Error::Transfer { name: file.into(), problem: problem.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORMATS: [(FileFormat, &str); 4] = [
        (FileFormat::ParaView, "a.json"),
        (FileFormat::SlicerText, "a.vp"),
        (FileFormat::SlicerJson, "a.vp.json"),
        (FileFormat::Csv, "a.csv"),
    ];

    /// Numbers without a short decimal form, a step in each function, and points at different values.
    fn awkward() -> TransferFunction {
        let third = 1.0 / 3.0;
        let colors =
            vec![(-1024.0, [third, 0.1, 1.0]), (7.0, [0.0, 0.7 * third, 1e-9]), (7.0, [1.0, 1.0, third]), (1e7, [0.0; 3])];
        let opacities = vec![(-1e3 * third, 0.0), (2.0, third), (2.0, 0.9), (3e6 + third, 1.0)];
        TransferFunction::new("awkward", colors, opacities).unwrap()
    }

    #[test]
    fn what_is_written_is_read_again_to_the_bit() {
        for (format, name) in FORMATS {
            assert_eq!(FileFormat::from_path(Path::new(name)).unwrap(), format);
            let again = parse(&awkward().to_text(format), name, None).unwrap();
            if format == FileFormat::Csv {
                continue;
            }
            assert_eq!((again.colors(), again.opacities()), (awkward().colors(), awkward().opacities()), "{name}");
        }
    }

    /// Points that CSV adds lie on the line between their neighbours, up to rounding.
    #[test]
    fn csv_has_the_same_function() {
        const ROUNDING: f64 = 1e-15;
        let again = parse(&awkward().to_text(FileFormat::Csv), "a.csv", None).unwrap();
        let values = awkward().colors().iter().map(|p| p.0).chain(awkward().opacities().iter().map(|p| p.0)).collect::<Vec<_>>();
        for value in values.iter().flat_map(|&v| [v.next_down(), v, v.next_up(), v + 0.4, v - 1234.5]) {
            assert!((again.opacity(value) - awkward().opacity(value)).abs() <= ROUNDING, "opacity at {value}");
            let pairs = again.color(value).into_iter().zip(awkward().color(value));
            assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() <= ROUNDING), "colour at {value}");
        }
    }

    /// Truncated text gives an error, or the function of the text that is left. A truncated number may be another number.
    #[test]
    fn truncated_text_never_panics_and_json_never_passes() {
        for (format, name) in FORMATS {
            let whole = awkward().to_text(format);
            for length in 0..whole.trim_end().len() {
                let cut = parse(&whole[..length], name, None);
                let is_json = matches!(format, FileFormat::ParaView | FileFormat::SlicerJson);
                assert!(!is_json || cut.is_err(), "{name} at {length}");
                assert!(cut.err().is_none_or(|e| e.to_string().contains(name)), "{name} at {length}");
            }
        }
    }

    /// A changed byte gives an error or a valid function.
    #[test]
    fn flipped_bytes_never_panic() {
        for (format, name) in FORMATS {
            let whole = awkward().to_text(format).into_bytes();
            for at in 0..whole.len() {
                for flipped in [b'9', b'-', b'"', b',', b'e', b'\n', whole[at] ^ 0x80] {
                    let mut bytes = whole.clone();
                    bytes[at] = flipped;
                    if let Ok(transfer) = parse(&String::from_utf8_lossy(&bytes), name, None) {
                        assert!((0.0..=1.0).contains(&transfer.opacity(5.0)), "{name} at {at}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_nothing_is_refused_by_name() {
        for (text, word) in [
            ("", "is empty"),
            (" \n\t\n", "is empty"),
            ("hello", "unknown format"),
            ("{", "is not JSON"),
            ("[1, 2]", "not a ParaView"),
            ("<xml/>", "unknown format"),
        ] {
            let message = parse(text, "f.x", None).unwrap_err().to_string();
            assert!(message.contains("f.x") && message.contains(word), "{text}: {message}");
        }
        assert!(parse("0,0,0,0,0\n", "f.csv", Some("x")).unwrap_err().to_string().contains("no preset 'x'"));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("large.json");
        File::create(&path).unwrap().set_len(MAX_BYTES + 1).unwrap();
        assert!(read(&path, None).unwrap_err().to_string().contains("larger than 16 MiB"));
        std::fs::write(&path, [0xff, 0xfe, 0x00]).unwrap();
        assert!(read(&path, None).unwrap_err().to_string().contains("not UTF-8"));
    }
}
