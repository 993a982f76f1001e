//! All files of files/expected.json.

use layersplat::Error;
use layersplat::glam::{DAffine3, DVec3};
use layersplat::volume::{Level, OpenOptions, Volume};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Positions are stored as 32-bit floats, up to 30 from the origin.
const PLACE: f64 = 1e-5;

pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats/files")
}

/// A file, its options, and the content that its writer declares.
pub struct Expected {
    pub file: String,
    pub options: OpenOptions,
    dims: [usize; 3],
    /// Voxel (x, y, z) is `intercept + slope * (x, y, z) · strides`.
    strides: [f64; 3],
    slope: f64,
    intercept: f64,
    affine: DAffine3,
    /// Indices of the missing voxels.
    missing: Vec<usize>,
}

impl Expected {
    fn new(entry: &Value) -> Self {
        let number = |value: &Value| value.as_f64().unwrap();
        let row = |i: usize, j: usize| number(&entry["affine"][i][j]);
        let column = |j: usize| DVec3::new(row(0, j), row(1, j), row(2, j));
        let whole = |name: &str| entry[name].as_u64().map(|n| n as usize);
        Self {
            file: entry["file"].as_str().unwrap().into(),
            options: OpenOptions {
                frame: whole("frame"),
                channel: whole("channel"),
                array: entry["array"].as_str().map(String::from),
                series: entry["series"].as_str().map(String::from),
                level: whole("level").map(Level::Number),
                ..OpenOptions::default()
            },
            dims: [0, 1, 2].map(|i| entry["dims"][i].as_u64().unwrap() as usize),
            strides: [0, 1, 2].map(|i| number(&entry["strides"][i])),
            slope: number(&entry["slope"]),
            intercept: number(&entry["intercept"]),
            affine: DAffine3::from_cols(column(0), column(1), column(2), column(3)),
            missing: serde_json::from_value(entry["missing"].clone()).unwrap_or_default(),
        }
    }

    /// Differences of a volume from the declared content.
    pub fn differences(&self, volume: &Volume) -> Vec<String> {
        let mut wrong = Vec::new();
        if volume.grid().dims() != self.dims {
            return vec![format!("{:?} voxels, expected {:?}", volume.grid().dims(), self.dims)];
        }
        let found = volume.grid().index_to_world();
        if !found.abs_diff_eq(self.affine, PLACE) {
            wrong.push(format!("it lies at {found}, expected {}", self.affine));
        }
        if volume.invalid() != self.missing.len() {
            wrong.push(format!("{} missing voxels, expected {}", volume.invalid(), self.missing.len()));
        }
        let [x, y, _] = self.dims;
        for index in 0..self.dims.iter().product() {
            let place = [index % x, index / x % y, index / x / y];
            let number: f64 = (0..3).map(|i| place[i] as f64 * self.strides[i]).sum();
            let value = self.intercept + self.slope * number;
            let expected = if self.missing.contains(&index) { volume.background() } else { value };
            let found = volume.value(index);
            if found != expected {
                wrong.push(format!("voxel {place:?} is {found}, expected {expected}"));
                break;
            }
        }
        wrong
    }
}

/// All files that this build supports.
pub fn all() -> Vec<Expected> {
    let text = std::fs::read_to_string(folder().join("expected.json")).unwrap();
    let entries: Vec<Value> = serde_json::from_str(&text).unwrap();
    let readable = |file: &str| {
        let built = [(".vti", cfg!(feature = "vtk")), (".npz", cfg!(feature = "npz")), (".tif", cfg!(feature = "tiff"))];
        built.iter().all(|(ending, built)| !file.ends_with(ending) || *built)
            && (cfg!(feature = "dicom") || !file.starts_with("dicom/"))
            && (cfg!(feature = "hdf5") || ![".h5", ".nc", ".vtkhdf", ".mnc", ".hdf5"].iter().any(|ending| file.ends_with(ending)))
            && (cfg!(feature = "zarr") || !file.contains(".zarr"))
    };
    entries.iter().map(Expected::new).filter(|expected| readable(&expected.file)).collect()
}

/// Opens all files of a folder; panics with all differences.
#[track_caller]
fn check(format: &str) {
    let of_format: Vec<Expected> = all().into_iter().filter(|expected| expected.file.starts_with(format)).collect();
    assert!(!of_format.is_empty(), "no files of {format}");
    let mut wrong = Vec::new();
    for expected in of_format {
        // In memory; and in a temporary file if it cannot be mapped.
        for memory in [None, Some(0)] {
            let options = OpenOptions { memory, ..expected.options.clone() };
            let differences = match Volume::open(folder().join(&expected.file), &options) {
                Ok(volume) => expected.differences(&volume),
                Err(e) => vec![e.to_string()],
            };
            wrong.extend(differences.iter().map(|difference| format!("{}, memory {memory:?}: {difference}", expected.file)));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

macro_rules! formats {
    ($($name:ident),*) => {$(
        #[test]
        fn $name() {
            check(concat!(stringify!($name), "/"));
        }
    )*};
}
formats!(nrrd, nifti, metaimage, vtk, numpy, bov, png, labels, channels);
#[cfg(feature = "tiff")]
formats!(tiff);
#[cfg(feature = "dicom")]
formats!(dicom);
#[cfg(feature = "hdf5")]
formats!(hdf5);
#[cfg(feature = "zarr")]
formats!(zarr);
#[cfg(any(feature = "hdf5", feature = "zarr"))]
formats!(conventions);
#[cfg(feature = "hdf5")]
formats!(minc, netcdf);

/// A frame, channel, array, series or level that a file does not have is refused, in every format.
#[test]
fn what_a_file_does_not_have_is_refused() {
    for Expected { file, options, .. } in all() {
        let path = folder().join(&file);
        let volume = Volume::open(&path, &options).unwrap_or_else(|e| panic!("{file}: {e}"));
        let (frames, channels) = (volume.contents().frames, volume.contents().channels);
        let none = || Some(String::from("no such name"));
        let wrong: [(&str, OpenOptions); 6] = [
            ("frame", OpenOptions { frame: Some(frames), ..options.clone() }),
            ("channel", OpenOptions { channel: Some(channels), ..options.clone() }),
            ("channel", OpenOptions { channel: None, channel_name: none(), ..options.clone() }),
            ("array", OpenOptions { array: none(), ..options.clone() }),
            ("series", OpenOptions { series: none(), ..options.clone() }),
            ("level", OpenOptions { level: Some(Level::Number(99)), ..options.clone() }),
        ];
        for (field, options) in wrong {
            match Volume::open(&path, &options) {
                Err(Error::Settings { field: found, problem }) => {
                    assert_eq!(found, field, "{file}: {problem}");
                    // Others than the file itself may be named: the header of a pair, or a slice.
                    let folder = path.parent().unwrap().to_str().unwrap();
                    assert!(problem.contains(folder), "{file}: {problem}");
                }
                // An array without a group around it has no other arrays.
                Err(Error::Volume { .. }) if field == "array" && file.contains(".zarr") => {}
                other => panic!("{file} with another {field}: {other:?}"),
            }
        }
    }
}

#[test]
fn a_wrong_expectation_is_noticed() {
    let mut expected = all().into_iter().find(|expected| expected.file == "nrrd/raw.nrrd").unwrap();
    let volume = Volume::open(folder().join(&expected.file), &expected.options).unwrap();
    assert_eq!(expected.differences(&volume), [""; 0]);
    expected.affine.translation.x += 1e-4;
    assert_eq!(expected.differences(&volume).len(), 1);
    expected.strides.swap(0, 1);
    assert_eq!(expected.differences(&volume).len(), 2);
}
