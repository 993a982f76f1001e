//! The paper's data sets, and the paper's results on them.

use crate::error::Error;
use crate::transfer::TransferFunction;
use crate::volume::{OpenOptions, Volume};
use std::path::{Path, PathBuf};

/// A row of the paper's Table 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PaperRow {
    /// Name of the data set, with which file names begin.
    pub name: &'static str,
    /// Number of effective splats.
    pub splats: &'static str,
    /// Frames per second of axis-aligned sheets, view-aligned sheets, layered splatting and slicing.
    pub fps: [Option<f64>; 4],
}

const fn row(name: &'static str, splats: &'static str, axis: f64, view: f64, layered: f64, slicing: Option<f64>) -> PaperRow {
    PaperRow { name, splats, fps: [Some(axis), Some(view), Some(layered), slicing] }
}

/// Table 1 of the paper.
const TABLE_1: [PaperRow; 8] = [
    row("fuel", "14K", 39.8, 47.0, 100.3, Some(197.1)),
    row("lobster", "233K", 15.0, 13.2, 43.0, None),
    row("aneurism", "79K", 26.7, 23.0, 48.7, Some(47.3)),
    row("neghip", "122K", 7.9, 11.1, 30.7, Some(192.6)),
    row("engine", "1.3M", 3.8, 3.0, 23.2, Some(43.0)),
    row("skull", "1.4M", 3.6, 2.7, 16.5, Some(43.6)),
    row("foot", "4.6M", 0.9, 0.8, 8.3, Some(40.9)),
    row("vertebra", "1.6M", 3.0, 2.4, 14.9, None),
];

/// Built-in volumes used if no data set is found, with their transfer functions.
const BUILT_IN: [(&str, Demonstration); 2] = [("builtin:hydrogen@64", shells), ("builtin:marschner-lobb@64", solid)];

/// Makes the transfer function of a built-in volume.
type Demonstration = fn() -> Result<TransferFunction, Error>;

/// A faint outer shell around a dense inner one. Its edges show differences between renderers.
fn shells() -> Result<TransferFunction, Error> {
    let colors = vec![(0.0, [0.25, 0.5, 1.0]), (70.0, [0.4, 0.8, 0.9]), (110.0, [1.0, 0.6, 0.25]), (255.0, [1.0, 0.9, 0.6])];
    let opacities = vec![(0.0, 0.0), (18.0, 0.0), (26.0, 0.12), (36.0, 0.01), (100.0, 0.01), (120.0, 0.6), (255.0, 0.6)];
    TransferFunction::new("shells", colors, opacities)
}

/// Opaque above the mean value.
fn solid() -> Result<TransferFunction, Error> {
    let colors = vec![(0.0, [0.8, 0.75, 0.65]), (130.0, [0.8, 0.75, 0.65]), (255.0, [0.3, 0.5, 0.8])];
    TransferFunction::new("solid", colors, vec![(0.0, 0.0), (118.0, 0.0), (138.0, 0.8), (255.0, 0.8)])
}

/// A data set that can be opened.
pub(super) struct Source {
    pub name: String,
    /// File or built-in name.
    path: PathBuf,
    transfer: TransferSource,
    pub paper: Option<PaperRow>,
}

/// Source of the transfer function of a data set.
enum TransferSource {
    File(PathBuf),
    Automatic,
    Demonstration(Demonstration),
}

/// A data set in memory.
pub(super) struct DataSet {
    pub volume: Volume<'static>,
    pub transfer: TransferFunction,
}

/// Available data sets.
pub(super) struct Library {
    pub found: Vec<Source>,
    /// Data sets of the paper's table that were not found.
    pub missing: Vec<&'static str>,
}

impl Library {
    /// Looks for the paper's data sets in the folder `volumes` and for their transfer functions in `transfers`.
    pub fn new(volumes: Option<&Path>, transfers: Option<&Path>) -> Result<Self, Error> {
        let mut files: Vec<PathBuf> = Vec::new();
        if let Some(folder) = volumes {
            let entries = std::fs::read_dir(folder).map_err(|e| Error::read(folder, e))?;
            for entry in entries {
                files.push(entry.map_err(|e| Error::read(folder, e))?.path());
            }
        }
        files.sort();
        if let Some(folder) = transfers {
            std::fs::read_dir(folder).map_err(|e| Error::read(folder, e))?;
        }
        let transfers = transfers.map(Path::to_path_buf).or_else(|| Some(volumes?.join("../transfer")));
        let (mut found, mut missing) = (Vec::new(), Vec::new());
        for paper in TABLE_1 {
            let file = files.iter().find(|path| is_volume(path, paper.name));
            match file {
                Some(path) => {
                    let transfer = transfers.as_ref().map(|folder| folder.join(format!("{}.json", paper.name)));
                    let transfer = transfer.filter(|file| file.is_file()).map_or(TransferSource::Automatic, TransferSource::File);
                    found.push(Source { name: paper.name.into(), path: path.into(), transfer, paper: Some(paper) });
                }
                None => missing.push(paper.name),
            }
        }
        if found.is_empty() {
            found = BUILT_IN
                .map(|(path, demonstration)| {
                    let transfer = TransferSource::Demonstration(demonstration);
                    Source { name: path.replace("builtin:", ""), path: path.into(), transfer, paper: None }
                })
                .into();
        }
        Ok(Self { found, missing })
    }

    /// Opens every data set once, so that errors appear before any work. Returns descriptions of data sets and transfer
    /// functions.
    pub fn check(&self) -> Result<Vec<String>, Error> {
        let describe = |set: &Source| {
            let transfer = set.open()?.transfer;
            let name = match &set.transfer {
                TransferSource::File(file) => file.file_name().unwrap_or_default().to_string_lossy().into_owned(),
                TransferSource::Automatic => "a transfer function from its histogram".into(),
                TransferSource::Demonstration(_) => format!("'{}'", transfer.name()),
            };
            Ok(format!("{} with {name}", set.name))
        };
        self.found.iter().map(describe).collect()
    }

    /// The data set for figures of a single one: engine as in the paper, or the first.
    pub fn shown(&self) -> &Source {
        self.found.iter().find(|set| set.name == "engine").unwrap_or(&self.found[0])
    }
}

/// Whether a file is a raw volume `NAME_…_uint8.raw.gz` or similar. The paper's files are unsigned.
fn is_volume(path: &Path, name: &str) -> bool {
    let file = path.file_name().and_then(|file| file.to_str()).unwrap_or_default();
    let lower = file.to_ascii_lowercase();
    let raw = lower.ends_with(".raw") || lower.ends_with(".raw.gz");
    raw && file.strip_prefix(name).is_some_and(|rest| rest.starts_with('_')) && file.contains("_uint")
}

impl Source {
    pub fn open(&self) -> Result<DataSet, Error> {
        let volume = Volume::open(&self.path, &OpenOptions::default())?;
        let transfer = match &self.transfer {
            TransferSource::File(file) => TransferFunction::from_file(file, None)?,
            TransferSource::Automatic => TransferFunction::automatic(&volume),
            TransferSource::Demonstration(transfer) => transfer()?,
        };
        Ok(DataSet { volume, transfer })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_file_names_are_recognised() {
        let is = |file: &str, name: &str| is_volume(Path::new(file), name);
        assert!(is("v/engine_256x256x128_uint8.raw.gz", "engine") && is("vertebra_512x512x512_uint16.raw", "vertebra"));
        assert!(!is("engine.json", "engine") && !is("engines_4x4x4_uint8.raw", "engine") && !is("fuel_1x1x1_int16.raw", "fuel"));
    }

    #[test]
    fn built_in_volumes_replace_missing_data_sets() {
        let library = Library::new(None, None).unwrap();
        assert_eq!((library.found.len(), library.missing.len()), (BUILT_IN.len(), TABLE_1.len()));
        assert!(library.shown().open().unwrap().volume.grid().dims()[0] > 0);
        assert!(Library::new(Some(Path::new("/no/such/folder")), None).is_err());
    }

    #[test]
    fn one_file_is_enough() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("fuel_2x2x2_uint8.raw"), [0, 1, 2, 3, 4, 5, 6, 7]).unwrap();
        let library = Library::new(Some(folder.path()), None).unwrap();
        assert_eq!((library.found.len(), library.missing.len(), library.shown().name.as_str()), (1, 7, "fuel"));
    }
}
