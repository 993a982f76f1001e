//! Files that are rare but valid: transforms that disagree, padding behind gzip, blank lines, lists of files, thousands of channels.

use flate2::Compression;
use flate2::write::GzEncoder;
use layersplat::glam::{DAffine3, DMat3, DVec3};
use layersplat::volume::{ChannelDescription, Grid, LabelTable, Labels, OpenOptions, Volume};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tempfile::TempDir;

const DIMS: [i16; 3] = [4, 3, 2];
/// Positions are 32-bit floats.
const PLACE: f64 = 1e-6;
/// `info` of a file of 8,000 channels took 85 seconds, quadratic in their number.
const QUICK: Duration = Duration::from_secs(1);

/// A NIfTI-1 file of 16-bit integers, 0, 1, 2 …, with the unit mm. The rows of its sform are those of `sform`, and its qform has the spacing
/// 2, 3, 4 and the origin 5, 6, 7.
fn nifti(sform: Option<DAffine3>, has_qform: bool, channels: i16) -> Vec<u8> {
    let mut file = vec![0; 352];
    let mut put = |at: usize, bytes: &[u8]| file[at..at + bytes.len()].copy_from_slice(bytes);
    let floats = |numbers: &[f64]| numbers.iter().flat_map(|&n| (n as f32).to_le_bytes()).collect::<Vec<u8>>();
    put(0, &348i32.to_le_bytes());
    put(40, &[5, DIMS[0], DIMS[1], DIMS[2], 1, channels, 1, 1].map(i16::to_le_bytes).concat());
    put(70, &[4, 16].map(i16::to_le_bytes).concat());
    put(76, &floats(&[1.0, 2.0, 3.0, 4.0]));
    put(108, &floats(&[352.0, 1.0, 0.0]));
    put(123, &[2]);
    put(252, &[i16::from(has_qform), i16::from(sform.is_some())].map(i16::to_le_bytes).concat());
    put(268, &floats(&[5.0, 6.0, 7.0]));
    for row in 0..3 {
        let affine = sform.unwrap_or(DAffine3::IDENTITY);
        let numbers = [0, 1, 2].map(|i| affine.matrix3.col(i)[row]);
        put(280 + 16 * row, &floats(&[&numbers[..], &[affine.translation[row]]].concat()));
    }
    put(344, b"n+1\0");
    let count = DIMS.iter().product::<i16>() as usize * channels as usize;
    file.extend((0..count).flat_map(|n| (n as i16).to_le_bytes()));
    file
}

/// An sform of slices that are shifted along y by this angle in degrees.
fn sheared(degrees: f64) -> DAffine3 {
    let tilt = degrees.to_radians();
    let axes = DMat3::from_cols(DVec3::X * 2.0, DVec3::Y * 3.0, DVec3::new(0.0, tilt.sin(), tilt.cos()) * 4.0);
    DAffine3::from_mat3_translation(axes, DVec3::new(1.0, 2.0, 3.0))
}

fn written(bytes: &[u8], name: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

fn open(path: &Path) -> Volume<'static> {
    Volume::open(path, &OpenOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn the_qform_serves_where_the_sform_is_sheared() {
    for degrees in [0.05, 20.0] {
        let (_folder, path) = written(&nifti(Some(sheared(degrees)), true, 1), "a.nii");
        let grid = open(&path).grid().clone();
        let expected =
            DAffine3::from_mat3_translation(DMat3::from_diagonal(DVec3::new(2.0, 3.0, 4.0)), DVec3::new(5.0, 6.0, 7.0));
        assert!(grid.index_to_world().abs_diff_eq(expected, PLACE) && grid.has_anatomy(), "{degrees}: {grid:?}");
    }
    // Where it is not, it counts.
    let (_folder, path) = written(&nifti(Some(sheared(0.0)), true, 1), "a.nii");
    let volume = open(&path);
    assert!(volume.grid().index_to_world().abs_diff_eq(sheared(0.0), PLACE));
    assert_eq!(volume.contents().length_unit.as_deref(), Some("mm"));
}

#[test]
fn small_shears_are_rounded() {
    let (_folder, path) = written(&nifti(Some(sheared(0.09)), false, 1), "a.nii");
    let grid = open(&path).grid().clone();
    let turn = grid.direction();
    assert!((turn.transpose() * turn).abs_diff_eq(DMat3::IDENTITY, 1e-12));
    assert!(grid.centre().abs_diff_eq(sheared(0.09).transform_point3(grid.centre_in_voxels()), PLACE));
}

/// Whole numbers of a linear field stay exact under linear interpolation, up to the precision of floats.
const EXACT: f64 = 1e-4;

#[test]
fn larger_shears_are_resampled() {
    for degrees in [0.2, 20.0] {
        let (_folder, path) = written(&nifti(Some(sheared(degrees)), false, 1), "a.nii");
        let volume = open(&path);
        let grid = volume.grid();
        let covering = Grid::covering([4, 3, 2], sheared(degrees)).unwrap();
        assert_eq!((grid.dims(), grid.has_anatomy(), volume.background()), (covering.dims(), true, 0.0));
        assert!(grid.index_to_world().abs_diff_eq(covering.index_to_world(), PLACE));
        assert!(volume.range().0 == 0.0 && volume.range().1 <= 23.0);
        let (mut inside, [x, y, _]) = (0, grid.dims());
        for index in 0..grid.voxel_count() {
            let place = DVec3::new((index % x) as f64, (index / x % y) as f64, (index / x / y) as f64);
            let own = sheared(degrees).inverse().transform_point3(grid.index_to_world().transform_point3(place));
            if own.cmpge(DVec3::splat(-1e-6)).all() && own.cmple(DVec3::new(3.0, 2.0, 1.0) + 1e-6).all() {
                let expected = own.dot(DVec3::new(1.0, 4.0, 12.0));
                assert!((volume.value(index) - expected).abs() < EXACT, "{degrees}, {place}: {}", volume.value(index));
                inside += 1;
            } else if own.cmplt(DVec3::NEG_ONE).any() || own.cmpgt(DVec3::new(4.0, 3.0, 2.0)).any() {
                assert_eq!(volume.value(index), 0.0, "{place} lies beyond all voxels");
            }
        }
        assert!(inside >= 12, "{inside} voxels inside");
        // Channels are described, and ids are not interpolated.
        assert_eq!(ChannelDescription::of_file(&path, &OpenOptions::default()).unwrap().len(), 1);
        let message = Labels::open(&path, &OpenOptions::default(), None).unwrap_err().to_string();
        assert!(message.contains("resample it onto orthogonal axes, or give a spacing"), "{message}");
    }
}

/// The gantry of this series is tilted by 17.74 degrees.
#[cfg(feature = "dicom")]
#[test]
fn tilted_gantries_are_resampled() {
    let volume = open(&crate::files::folder().join("dicom/refused/tilted"));
    let spacing = OpenOptions { spacing: Some(DVec3::ONE), ..OpenOptions::default() };
    let stored = Volume::open(crate::files::folder().join("dicom/refused/tilted"), &spacing).unwrap();
    assert!(volume.grid().has_anatomy() && volume.grid().dims()[1] > stored.grid().dims()[1]);
    assert!(volume.range().0 >= stored.range().0 && volume.range().1 <= stored.range().1);
}

#[test]
fn zeros_behind_gzip_are_padding_and_other_bytes_are_damage() {
    let bytes = nifti(None, true, 1);
    let packed = |bytes: &[u8]| {
        let mut packer = GzEncoder::new(Vec::new(), Compression::default());
        packer.write_all(bytes).unwrap();
        packer.finish().unwrap()
    };
    let (one, two) = (packed(&bytes), [packed(&bytes[..400]), packed(&bytes[400..])].concat());
    for start in [&one, &two] {
        for (end, is_valid) in [(&[0; 700][..], true), (b"", true), (b"\0\0text behind it", false)] {
            let (_folder, path) = written(&[start, end].concat(), "a.nii.gz");
            match Volume::open(&path, &OpenOptions::default()) {
                Ok(volume) => assert!(is_valid && volume.range() == (0.0, 23.0), "{end:?}"),
                Err(e) => assert!(!is_valid && e.to_string().contains("a.nii.gz: "), "{e}"),
            }
        }
    }
}

#[test]
fn thousands_of_channels_are_described_quickly() {
    let (_folder, path) = written(&nifti(None, true, 1000), "a.nii");
    let options = OpenOptions { channel: Some(999), ..OpenOptions::default() };
    let first = 999 * 24;
    assert_eq!(Volume::open(&path, &options).unwrap().range(), (f64::from(first), f64::from(first + 23)));
    let start = Instant::now();
    let colors = ChannelDescription::colors(&vec![ChannelDescription::default(); 8000]);
    assert!(colors.len() == 8000 && start.elapsed() < QUICK, "{:?}", start.elapsed());
}

#[test]
fn cifti_is_named() {
    let mut file = vec![0; 640];
    let mut put = |at: usize, bytes: &[u8]| file[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &540i32.to_le_bytes());
    put(4, b"n+2\0\r\n\x1a\n");
    put(12, &16i16.to_le_bytes());
    put(16, &[6i64, 1, 1, 1, 1, 1, 20].map(i64::to_le_bytes).concat());
    put(504, &3006i32.to_le_bytes());
    let (_folder, path) = written(&file, "a.dscalar.nii");
    let message = Volume::open(&path, &OpenOptions::default()).unwrap_err().to_string();
    assert!(message.contains("it is CIFTI") && message.contains("wb_command -cifti-separate"), "{message}");
}

/// A legacy file of VTK whose voxels are `first`, `first` + 1, …, with blank lines after its title and after each line of its header.
fn legacy(first: u8) -> Vec<u8> {
    let lines = ["# vtk DataFile Version 3.0\ntitle", "BINARY", "DATASET STRUCTURED_POINTS", "DIMENSIONS 4 3 2", "SPACING 1 1 2"];
    let data = "POINT_DATA 24\n\nSCALARS s unsigned_char 1\nLOOKUP_TABLE default\n";
    let head = format!("{}\n\n\n{data}", lines.join("\n\n"));
    [head.as_bytes(), &(first..first + 24).collect::<Vec<u8>>()].concat()
}

#[test]
fn blank_lines_of_vtk_mean_nothing() {
    let (_folder, path) = written(&legacy(10), "a.vtk");
    let volume = open(&path);
    assert_eq!((volume.range(), volume.grid().spacing()), ((10.0, 33.0), DVec3::new(1.0, 1.0, 2.0)));
    assert_eq!(volume.value(5), 15.0);
}

#[test]
fn series_have_the_order_of_time() {
    let list = r#"{"file-series-version": "1.0", "files": [{"name": "b.vtk", "time": 7.5}, {"name": "a.vtk", "time": 0}]}"#;
    let (folder, path) = written(list.as_bytes(), "a.vtk.series");
    std::fs::write(folder.path().join("a.vtk"), legacy(10)).unwrap();
    std::fs::write(folder.path().join("b.vtk"), legacy(90)).unwrap();
    for (frame, first) in [(0, 10.0), (1, 90.0)] {
        let volume = Volume::open(&path, &OpenOptions { frame: Some(frame), ..OpenOptions::default() }).unwrap();
        assert_eq!((volume.value(0), volume.contents().frames), (first, 2));
    }
    for (text, expected) in
        [("{\"files\": []}", "it lists no files"), ("{\"files\": [{\"name\": \"a.vtk\"}]}", "missing field `time`")]
    {
        std::fs::write(&path, text).unwrap();
        let message = Volume::open(&path, &OpenOptions::default()).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn binary_tables_are_the_colours_of_ids() {
    let mut bytes = vec![0u8; 768];
    (bytes[3], bytes[256 + 3], bytes[512 + 3]) = (255, 51, 0);
    let (_folder, path) = written(&bytes, "aal.lut");
    let table = LabelTable::open(&path).unwrap();
    assert_eq!((table.labels().len(), table.get(3).unwrap().color), (255, [1.0, 0.2, 0.0]));
}

/// MRIcron's atlases have names and colours in files beside them.
#[test]
fn tables_beside_a_file_are_its_own() {
    let (folder, path) = written(&nifti(None, true, 1), "aal.nii");
    let beside = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    let label = || Labels::open(&path, &OpenOptions::default(), None).unwrap().layers()[0].table().get(1).cloned().unwrap();
    assert_eq!((label().name, label().color), (None, LabelTable::default_color(1)));
    beside("aal.csv", b"this is no table");
    beside("aal.txt", b"1 Precentral_L 2001\n2 Precentral_R 2002\n");
    assert_eq!(label().name.as_deref(), Some("Precentral_L"));
    let mut colors = vec![0u8; 768];
    (colors[1], colors[256 + 1]) = (255, 51);
    beside("aal.nii.lut", &colors);
    assert_eq!((label().name.as_deref(), label().color), (Some("Precentral_L"), [1.0, 0.2, 0.0]));
    // A table with colours is whole.
    beside("aal.nii.txt", b"1 Other 0 0 255 0\n");
    assert_eq!((label().name.as_deref(), label().color), (Some("Other"), [0.0, 0.0, 1.0]));
    beside("named.txt", b"1 Given 0 0 255 0\n");
    let given = Labels::open(&path, &OpenOptions::default(), Some(&folder.path().join("named.txt"))).unwrap();
    assert_eq!(given.layers()[0].table().get(1).unwrap().name.as_deref(), Some("Given"));
}

#[test]
fn negative_ids_are_background() {
    let mut bytes = nifti(None, true, 1);
    bytes[352..354].copy_from_slice(&(-3i16).to_le_bytes());
    let (_folder, path) = written(&bytes, "a.nii");
    let labels = Labels::open(&path, &OpenOptions::default(), None).unwrap();
    let layer = &labels.layers()[0];
    assert_eq!((layer.ids().len(), layer.voxels_of(0), layer.voxels_of(1)), (24, 1, 1));
}
