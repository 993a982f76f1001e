//! Invalid files: errors name the file and the problem.

use crate::files::folder;
use layersplat::volume::{OpenOptions, Volume};
use layersplat::{Error, glam::DVec3};
use std::path::Path;

/// A file, the bytes to replace, their replacement, and an expected part of the message.
type Case<'a> = (&'a str, &'a [u8], &'a [u8], &'a str);

const TEXT: &[Case] = &[
    ("nrrd/raw.nrrd", b"dimension: 3", b"dimension: 0", "dimension"),
    ("nrrd/raw.nrrd", b"dimension: 3", b"dimension: 4", "sizes"),
    ("nrrd/raw.nrrd", b"sizes: 5 4 3", b"sizes: 5 0 3", "empty"),
    ("nrrd/raw.nrrd", b"sizes: 5 4 3", b"sizes: 5 4 4", "truncated"),
    ("nrrd/raw.nrrd", b"sizes: 5 4 3", b"sizes: 999999999 999999999 999999999", "too large"),
    ("nrrd/raw.nrrd", b"type: int16", b"type: block", "block"),
    ("nrrd/raw.nrrd", b"encoding: raw", b"encoding: bzip2", "bzip2"),
    ("nrrd/raw.nrrd", b"endian: little", b"endian: middle", "endian"),
    ("nrrd/raw.nrrd", b"spacings: 0.5", b"spacings: 0.0", "length 0"),
    ("nrrd/detached_raw.nhdr", b"detached_raw.raw", b"missing.raw", "missing.raw"),
    ("nrrd/numbered.nhdr", b"8 10 1", b"8 11 1", "names 4"),
    ("nrrd/numbered.nhdr", b"%02d", b"%02x", "file name pattern"),
    ("nrrd/ascii.nrrd", b"-3000", b"-3oo0", "-3oo0"),
    ("nrrd/itk_times.nrrd", b"(0,0,2,0)", b"(0,0,2,1)", "mix space with a fourth dimension: save a volume per time"),
    ("nrrd/itk_times.nrrd", b"(0,0,2,0)", b"(0,0,2,0,0)", "a vector of 1 to 4"),
    ("metaimage/plain.mha", b"DimSize = 5 4 3", b"DimSize = 5 4 -3", "DimSize"),
    ("metaimage/plain.mha", b"DimSize = 5 4 3", b"DimSize = 5 4 9", "truncated"),
    ("metaimage/plain.mha", b"NDims = 3", b"NDims = 0", "NDims"),
    ("metaimage/plain.mha", b"MET_SHORT", b"MET_STRING", "MET_STRING"),
    ("metaimage/plain.mhd", b"plain.raw", b"missing.raw", "missing.raw"),
    ("metaimage/listed.mhd", b"slice_10.raw\n", b"", "names 2"),
    ("metaimage/int16.mha", b"CompressedData = True", b"CompressedData = False", "truncated"),
    ("vtk/legacy_30.vtk", b"STRUCTURED_POINTS", b"POLYDATA", "holds a surface"),
    ("vtk/legacy_30.vtk", b"DIMENSIONS 5 4 3", b"DIMENSIONS 5 4 0", "DIMENSIONS"),
    ("vtk/legacy_30.vtk", b"unsigned_char", b"bit", "bit"),
    ("vtk/legacy_30.vtk", b"POINT_DATA 60", b"POINT_DATA 70", "lacks"),
    ("vtk/legacy_42_binary_int16.vtk", b"POINT_DATA 60", b"POINT_DATA 6000000000", "beyond its end"),
    ("numpy/int16.npy", b"<i2", b"<c8", "<c8: complex numbers"),
    ("numpy/int16.npy", b"'<i2'", b"'>c16'", ">c16: complex numbers"),
    ("numpy/int16.npy", b"(3, 4, 5)", b"(3, 4, 9)", "truncated"),
    ("numpy/int16.npy", b"(3, 4, 5)", b"()       ", "empty"),
    ("bov/values.bov", b"values.bin", b"missing.bin", "missing.bin"),
    ("bov/values.bov", b"FLOAT", b"COMPLEX", "COMPLEX"),
    ("bov/values.bov", b"5 4 3", b"5 4", "DATA_SIZE"),
];

#[cfg(feature = "vtk")]
const XML: &[Case] = &[
    ("vtk/ascii_plain.vti", b"\"ImageData\"", b"\"UnstructuredGrid\"", "UnstructuredGrid"),
    ("vtk/ascii_plain.vti", b"Piece Extent=\"0 4 0 3 0 2\"", b"Piece Extent=\"0 4 0 3 2 0\"", "no points"),
    ("vtk/ascii_plain.vti", b"Piece Extent=\"0 4 0 3 0 2\"", b"Piece Extent=\"0 4 0 3 0 9\"", "numbers"),
    ("vtk/ascii_plain.vti", b"\"Int16\"", b"\"String\"", "String"),
    ("vtk/ascii_plain.vti", b"</Piece>", b"</Peace>", "XML"),
    ("vtk/binary_plain.vti", b"eAAAA", b"eAAAB", "base64"),
    ("vtk/binary_plain.vti", b"eAAAA", b"*AAAA", "base64"),
    ("vtk/binary_zlib.vti", b"vtkZLibDataCompressor", b"vtkLZMADataCompressor", "LZMA"),
    ("vtk/appended_zlib.vti", b"offset=\"0\"", b"offset=\"99999999999\"", "truncated"),
    ("vtk/appended_plain.vti", b"Piece Extent=\"0 4 0 3 0 2\"", b"Piece Extent=\"0 4 0 3 0 9\"", "expected"),
    ("vtk/ascii_plain.vti", b"</Piece>", b"</Piece><Piece Extent=\"0 4 0 3 2 4\"></Piece>", "lacks the array values"),
    ("vtk/pieces.vti", b"Extent=\"2 4 0 1 0 2\"", b"Extent=\"2 4 0 1 0 1\"", "do not cover the image"),
    ("vtk/pieces.vti", b"Extent=\"2 4 0 1 0 2\"", b"Extent=\"2 4 0 1 0 9\"", "it is damaged"),
    ("vtk/pieces.vti", b"Extent=\"0 2 0 3 0 2\"", b"Extent=\"0 2 0 3 0 999999999\"", "it is damaged"),
    ("vtk/pieces.vti", b"Extent=\"2 4 1 3 0 2\"", b"Extent=\"900000002 900000004 1 3 0 2\"", "do not cover the image"),
];

/// Copies the folder of a case and changes one file.
pub fn changed(file: &str, change: impl FnOnce(&mut Vec<u8>)) -> (tempfile::TempDir, std::path::PathBuf) {
    let temporary = tempfile::tempdir().unwrap();
    let source = folder().join(file);
    for entry in std::fs::read_dir(source.parent().unwrap()).unwrap().map(|entry| entry.unwrap()) {
        if entry.path().is_file() {
            std::fs::copy(entry.path(), temporary.path().join(entry.file_name())).unwrap();
        }
    }
    let path = temporary.path().join(source.file_name().unwrap());
    let mut bytes = std::fs::read(&path).unwrap();
    change(&mut bytes);
    std::fs::write(&path, bytes).unwrap();
    (temporary, path)
}

#[track_caller]
pub fn refused(path: &Path, what: &str, word: &str) {
    let message = match Volume::open(path, &OpenOptions::default()) {
        Ok(volume) => panic!("{what} is opened: {volume:?}"),
        Err(e) => e.to_string(),
    };
    assert!(message.contains(word), "{what}: '{word}' is not in: {message}");
    // The message names a file in the folder.
    assert!(message.contains(path.parent().unwrap().to_str().unwrap()), "{what}: {message}");
}

fn refused_text(cases: &[Case]) {
    for &(file, from, to, word) in cases {
        let what = format!("{file} with {}", String::from_utf8_lossy(to));
        let (_temporary, path) = changed(file, |bytes| {
            let at =
                bytes.windows(from.len()).position(|part| part == from).unwrap_or_else(|| panic!("{what}: nothing to change"));
            bytes.splice(at..at + from.len(), to.iter().copied());
        });
        refused(&path, &what, word);
    }
}

#[test]
fn wrong_headers_are_named() {
    refused_text(TEXT);
}

#[test]
#[cfg(feature = "vtk")]
fn wrong_xml_is_named() {
    refused_text(XML);
}

#[test]
fn wrong_bytes_are_named() {
    let cases: [(&str, usize, &[u8], &str); 9] = [
        ("nifti/little_1.nii", 40, &[0], "axes"),
        ("nifti/little_1.nii", 42, &[0, 0], "empty"),
        ("nifti/little_1.nii", 42, &[255, 127], "truncated"),
        ("nifti/little_1.nii", 70, &[32], "datatype is 32: complex numbers"),
        ("nifti/little_1.nii", 70, &[0, 7], "datatype is 1792: complex numbers"),
        ("nifti/little_1.nii", 70, &[0, 8], "datatype is 2048: complex numbers"),
        ("nifti/little_2.nii", 175, &[0x80], "vox_offset"),
        ("nifti/pair_1.hdr", 70, &[1, 0], "datatype is 1"),
        ("numpy/int16.npy", 6, &[9], "version 9"),
    ];
    for (file, at, with, word) in cases {
        let (_temporary, path) = changed(file, |bytes| bytes[at..at + with.len()].copy_from_slice(with));
        refused(&path, &format!("{file} with {with:?} at {at}"), word);
    }
    let (_temporary, path) = changed("nifti/pair_1.hdr", |_| {});
    std::fs::remove_file(path.with_extension("img")).unwrap();
    refused(&path, "half a pair", ".img");
}

#[test]
fn choices_that_there_are_not_name_their_field() {
    let options = OpenOptions::default();
    let cases = [
        ("nrrd/times.nrrd", OpenOptions { frame: Some(2), ..options.clone() }, "frame"),
        ("nrrd/rgb.nrrd", OpenOptions { channel: Some(3), ..options.clone() }, "channel"),
        ("nrrd/raw.nrrd", OpenOptions { frame: Some(1), ..options.clone() }, "frame"),
        ("nrrd/raw.nrrd", OpenOptions { channel: Some(1), ..options.clone() }, "channel"),
        ("nifti/little_1.nii", OpenOptions { array: Some("none".into()), ..options.clone() }, "array"),
        ("nifti/little_1.nii", OpenOptions { level: Some(layersplat::volume::Level::Number(0)), ..options.clone() }, "level"),
        ("nifti/little_1.nii", OpenOptions { series: Some("none".into()), ..options.clone() }, "series"),
        ("vtk/legacy_several_ascii.vtk", OpenOptions { array: Some("none".into()), ..options.clone() }, "array"),
    ];
    for (file, options, name) in cases {
        match Volume::open(folder().join(file), &options).unwrap_err() {
            Error::Settings { field, problem } => assert!(field == name && problem.contains(file), "{file}: {problem}"),
            e => panic!("{e}"),
        }
    }
}

#[test]
#[cfg(feature = "dicom")]
fn series_that_are_no_volumes_say_why() {
    let cases = [
        ("gap", "2.5 to 5"),
        ("overview", "different directions"),
        ("unequal", "1 to 2"),
        ("sizes", "alike"),
        ("jpeg2000.dcm", "JPEG 2000"),
        ("no_pixels.dcm", "without pixels"),
    ];
    for (name, word) in cases {
        refused(&folder().join("dicom/refused").join(name), name, word);
    }
    // A given spacing overrides invalid distances.
    for name in ["tilted", "gap"] {
        let options = OpenOptions { spacing: Some(DVec3::ONE), ..OpenOptions::default() };
        assert_eq!(Volume::open(folder().join("dicom/refused").join(name), &options).unwrap().grid().spacing(), DVec3::ONE);
    }
}

#[test]
#[cfg(feature = "dicom")]
fn several_series_are_named() {
    for (series, words) in [(None, ["2 'first' (3 slices", "4 'dynamic' (6 slices"]), (Some("none"), ["'none'", "dynamic"])] {
        let options = OpenOptions { series: series.map(String::from), ..OpenOptions::default() };
        match Volume::open(folder().join("dicom/several"), &options).unwrap_err() {
            Error::Settings { field: "series", problem } => assert!(words.iter().all(|word| problem.contains(word)), "{problem}"),
            e => panic!("{e}"),
        }
    }
}

/// A store, one of its files, the bytes to replace, their replacement, and an expected part of the message.
#[cfg(feature = "zarr")]
type StoreCase<'a> = (&'a str, &'a str, &'a [u8], &'a [u8], &'a str);

#[cfg(feature = "zarr")]
const STORES: &[StoreCase] = &[
    ("plain.zarr", ".zarray", b"\"<i2\"", b"\"<c8\"", "<c8\": complex numbers"),
    ("plain.zarr", ".zarray", b"\"zarr_format\": 2", b"\"zarr_format\": 4", "zarr_format"),
    ("plain.zarr", ".zarray", b"\"shape\": [\n    3", b"\"shape\": [\n    0", "shape"),
    ("plain.zarr", ".zarray", b"\"shape\": [\n    3", b"\"shape\": [\n    99999999999999999", "2^40"),
    ("plain.zarr", ".zarray", b"\"shape\": [\n    3,", b"\"shape\": [\n    3, 9,", "axes"),
    ("plain.zarr", ".zarray", b"\"chunks\": [\n    2", b"\"chunks\": [\n    3", "expected 120"),
    (
        "plain.zarr",
        ".zarray",
        b"\"filters\": null",
        b"\"filters\": [{\"id\": \"delta\", \"dtype\": \"<f4\"}]",
        "delta of \"<f4\"",
    ),
    ("plain.zarr", ".zarray", b"\"filters\": null", b"\"filters\": [{\"id\": \"packbits\"}]", "packbits, which is not supported"),
    ("plain.zarr", ".zarray", b"\"chunks\": [\n    2", b"\"chunks\": [\n    20000000", "too large for its shape, [3, 4, 5]"),
    ("bz2_alone.zarr", ".zarray", b"\"id\"", b"\"id\"", "bz2, which is not supported"),
    (
        "3_plain.zarr",
        "zarr.json",
        b"\"storage_transformers\": []",
        b"\"storage_transformers\": [{\"name\": \"x\"}]",
        "storage transformer \"x\"",
    ),
    (
        "3_plain.zarr",
        "zarr.json",
        b"\"attributes\"",
        b"\"turned\": {}, \"attributes\"",
        "extension turned, which is not supported",
    ),
    ("3_shards_end.zarr", "zarr.json", b"\"chunk_shape\": [\n          1,", b"\"chunk_shape\": [\n          3,", "no multiple"),
    ("3_shards_end.zarr", "zarr.json", b"\"crc32c\"", b"\"gzip\"", "the index of its shards"),
    ("3_plain.zarr", "zarr.json", b"\"regular\"", b"\"crooked\"", "crooked"),
    ("3_plain.zarr", "zarr.json", b"\"int16\"", b"\"complex64\"", "complex64\": complex numbers"),
    ("3_zstd.zarr", "zarr.json", b"\"zstd\"", b"\"pack\"", "pack, which is not supported"),
    ("ome_moved.zarr", ".zattrs", b"\"coarse\"", b"\"../../\"", "is not an array below it"),
    ("ome_moved.zarr", ".zattrs", b"\"translation\"", b"\"rotation\"", "scale and translation"),
];

#[cfg(feature = "zarr")]
#[test]
fn wrong_stores_are_named() {
    for &(store, file, from, to, word) in STORES {
        let what = format!("{store} with {}", String::from_utf8_lossy(to));
        let temporary = tempfile::tempdir().unwrap();
        let path = temporary.path().join(store);
        crate::damage::copied(&folder().join("zarr").join(store), &path);
        let mut bytes = std::fs::read(path.join(file)).unwrap();
        let at = bytes.windows(from.len()).position(|part| part == from);
        let at = at.unwrap_or_else(|| panic!("{what}: nothing to change"));
        bytes.splice(at..at + from.len(), to.iter().copied());
        std::fs::write(path.join(file), bytes).unwrap();
        refused(&path, &what, word);
    }
}

/// A chunk that decompresses to more than its size, and one with a wrong checksum.
#[cfg(feature = "zarr")]
#[test]
fn pieces_that_lie_are_refused() {
    use std::io::Read;
    let mut large = Vec::new();
    flate2::read::GzEncoder::new(&[0; 1 << 20][..], flate2::Compression::best()).read_to_end(&mut large).unwrap();
    for (store, piece, bytes, word) in [
        ("gzip.zarr", "0.0.0", Some(large), "more than"),
        ("3_checked.zarr", "c/0/0/0", None, "checksum"),
        ("3_shards_start.zarr", "c/0/0/0", None, "checksum of the index"),
    ] {
        let temporary = tempfile::tempdir().unwrap();
        let path = temporary.path().join(store);
        crate::damage::copied(&folder().join("zarr").join(store), &path);
        let bytes = bytes.unwrap_or_else(|| {
            let mut bytes = std::fs::read(path.join(piece)).unwrap();
            bytes[10] ^= 1;
            bytes
        });
        std::fs::write(path.join(piece), bytes).unwrap();
        refused(&path, store, word);
    }
}

#[cfg(feature = "zarr")]
#[test]
fn resolutions_are_chosen_by_number_or_by_pixels() {
    use layersplat::volume::Level;
    let opened = |level| {
        let options = OpenOptions { level: Some(level), ..OpenOptions::default() };
        Volume::open(folder().join("zarr/ome_04.zarr"), &options)
    };
    for (pixels, dims) in [(1, [2, 2, 3]), (4, [2, 2, 3]), (5, [5, 4, 3]), (1000, [5, 4, 3])] {
        assert_eq!(opened(Level::Pixels(pixels)).unwrap().grid().dims(), dims, "{pixels}");
    }
    // 5×4×3 voxels of one or two bytes, and 2×2×3.
    for (bytes, dims) in [(1, [2, 2, 3]), (59, [2, 2, 3]), (120, [5, 4, 3])] {
        assert_eq!(opened(Level::Bytes(bytes)).unwrap().grid().dims(), dims, "{bytes}");
    }
    let one = OpenOptions { level: Some(Level::Bytes(1)), ..OpenOptions::default() };
    Volume::open(folder().join("zarr/plain.zarr"), &one).unwrap();
    let message = opened(Level::Number(2)).unwrap_err().to_string();
    assert!(message.contains("levels are 0 to 1"), "{message}");
}

#[cfg(feature = "hdf5")]
#[test]
fn complex_datasets_are_named() {
    let path = folder().join("hdf5/refused/complex.h5");
    refused(&path, "the only dataset", "complex.h5: it has complex numbers, and a voxel has one number: save their magnitude");
    let options = OpenOptions { array: Some("k_space".into()), ..OpenOptions::default() };
    let message = Volume::open(&path, &options).unwrap_err().to_string();
    assert!(message.contains("the numbers of 'k_space' are complex numbers"), "{message}");
}

#[cfg(feature = "hdf5")]
#[test]
fn data_in_other_files_are_read_or_these_are_named() {
    let at = folder().join("conventions");
    for name in ["external.h5", "linked.h5"] {
        let options = OpenOptions::default();
        let volume = Volume::open(at.join(name), &options).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((volume.range(), volume.value(7)), ((-3000.0, 2900.0), -2300.0), "{name}");
    }
    for (name, expected) in [
        ("external.h5", "its data are in gone.bin, which is not in its folder: put it there"),
        ("linked.h5", "its data are in gone.h5, which is not in its folder: put it there"),
        (
            "virtual.h5",
            "a virtual dataset, whose numbers are in linked.h5 and in gone.h5, which is missing: give the file of its numbers",
        ),
        ("poly.vtkhdf", "it holds PolyData: expected ImageData; resample it"),
    ] {
        refused(&at.join("refused").join(name), name, expected);
    }
    refused(
        &folder().join("netcdf/refused/minc1.mnc"),
        "minc1.mnc",
        "it is MINC 1, whose slices are scaled each by its own range",
    );
}

#[test]
#[cfg(feature = "hdf5")]
fn several_datasets_are_named() {
    for array in [None, Some("none")] {
        let options = OpenOptions { array: array.map(String::from), ..OpenOptions::default() };
        match Volume::open(folder().join("hdf5/several.h5"), &options).unwrap_err() {
            Error::Settings { field: "array", problem } => {
                let named = problem.contains("first, deep/second") && !problem.contains("flat");
                assert!(named && problem.contains("several.h5"), "{problem}");
            }
            e => panic!("{e}"),
        }
    }
}

/// Formats of disabled features are recognised, and the error names the feature.
#[test]
fn what_this_build_does_not_read_is_named() {
    let cases = [
        ("dicom", cfg!(feature = "dicom"), ["dicom/oblique", "dicom/enhanced.dcm"]),
        ("hdf5", cfg!(feature = "hdf5"), ["hdf5/int16.h5", "hdf5/scaled.nc"]),
        ("zarr", cfg!(feature = "zarr"), ["zarr/plain.zarr", "zarr/ome_05.zarr"]),
    ];
    for (feature, built, names) in cases {
        for name in names {
            if built {
                Volume::open(folder().join(name), &OpenOptions::default()).unwrap();
            } else {
                refused(&folder().join(name), name, &format!("needs a build with the feature {feature}"));
            }
        }
    }
}

/// A spacing makes sheared files readable.
#[test]
fn a_spacing_that_is_given_wins() {
    let spacing = DVec3::new(1.0, 2.0, 3.0);
    let options = OpenOptions { spacing: Some(spacing), ..OpenOptions::default() };
    for file in
        ["nrrd/lps.nrrd", "nifti/little_1.nii", "metaimage/plain.mha", "vtk/legacy_30.vtk", "numpy/int16.npy", "bov/values.bov"]
    {
        let volume = Volume::open(folder().join(file), &options).unwrap();
        assert_eq!((volume.grid().spacing(), volume.grid().origin()), (spacing, DVec3::ZERO), "{file}");
    }
}
