//! Volumes of labels with their tables, written by other programs.

use crate::files::folder;
use layersplat::glam::DVec3;
use layersplat::volume::{Grid, Label, LabelLayer, LabelTable, Labels, OpenOptions, Placement, Volume};
use std::path::{Path, PathBuf};

/// Ids of the sparse volumes: 1, 2²⁶ + 1, …, all beyond what 32-bit floats tell apart.
const SPARSE: u32 = 1 << 26;

fn file(name: &str) -> PathBuf {
    folder().join("labels").join(name)
}

fn open(name: &str, options: &OpenOptions, table: Option<&Path>) -> Labels {
    Labels::open(file(name), options, table).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn named(layer: &LabelLayer) -> Vec<(u32, Option<&str>)> {
    layer.table().labels().iter().filter(|label| label.name.is_some()).map(|label| (label.id, label.name.as_deref())).collect()
}

#[test]
fn segments_of_several_layers_overlap() {
    // In memory, and in temporary files.
    for memory in [None, Some(0)] {
        let options = OpenOptions { memory, ..OpenOptions::default() };
        let labels = open("layers.seg.nrrd", &options, None);
        let [first, second] = labels.layers() else { panic!("{labels:?}") };
        assert_eq!(named(first), [(1, Some("liver")), (5, Some("spleen"))]);
        assert_eq!(named(second), [(1, Some("vessels \\ veins"))]);
        assert_eq!(first.table().get(5).map(|label| label.color), Some([0.5, 0.25, 0.125]));
        // Ids without a segment keep the colour of their number.
        assert_eq!((first.ids(), second.ids()), (&[0, 1, 2, 3, 4, 5][..], &[0, 1][..]));
        assert_eq!(first.table().get(3), Some(&Label::new(3)));
        assert_eq!((first.voxels_of(5), first.volume_of(5), second.voxels_of(1), first.voxels_of(6)), (10, 5.0, 30, 0));
        assert_eq!(second.palette(), [[0.0; 4], [0.0, 0.0, 1.0, 1.0]]);
        let (first, second) = (first.indices(memory).unwrap(), second.indices(memory).unwrap());
        for voxel in 0..60 {
            assert_eq!((first.value(voxel), second.value(voxel)), ((voxel / 10) as f64, (voxel % 2) as f64));
        }
        assert_eq!((first.contents().channels, second.contents().channel), (2, 1));
    }
    // One layer, and changes of both.
    let one = OpenOptions { channel: Some(1), ..OpenOptions::default() };
    assert_eq!(named(&open("layers.seg.nrrd", &one, None).layers()[0]).len(), 1);
    let mut labels = open("layers.seg.nrrd", &OpenOptions::default(), None);
    labels.change(&"spleen:only".parse().unwrap()).unwrap();
    let drawn = labels.layers().iter().flat_map(LabelLayer::present).filter(|label| label.visible).count();
    assert_eq!(drawn, 1);
    // The table may name labels that no voxel has.
    let layer = &open("one.seg.nrrd", &OpenOptions::default(), None).layers()[0].table().clone();
    assert_eq!(layer.get(3).map(|label| label.color), Some([1.0, 0.0, 0.0]));
}

#[test]
fn sparse_ids_stay_exact() {
    let mut cases = vec![
        ("sparse.nii.gz", None, vec![(1, Some("Left-Thalamus")), (77, Some("Absent")), (SPARSE + 1, Some("Right-Thalamus"))]),
        ("sparse_2.nii", None, vec![]),
    ];
    if cfg!(feature = "zarr") {
        let cells = vec![(1, Some("nucleus")), (SPARSE + 1, Some("membrane"))];
        cases.extend(["cells_04.zarr", "cells_05.zarr"].map(|name| (name, Some("labels/cells".to_owned()), cells.clone())));
    }
    for (name, array, names) in cases {
        for memory in [None, Some(0)] {
            let options = OpenOptions { array: array.clone(), memory, ..OpenOptions::default() };
            assert!(Labels::are_declared(file(name), &options).unwrap(), "{name}");
            let labels = open(name, &options, None);
            let [layer] = labels.layers() else { panic!("{name}: {labels:?}") };
            let expected: Vec<u32> = [0].into_iter().chain((0..60).map(|n| n * SPARSE + 1)).collect();
            assert_eq!(layer.ids(), expected, "{name}");
            assert_eq!(named(layer), names, "{name}");
            let indices = layer.indices(memory).unwrap();
            assert!((0..60).all(|voxel| indices.value(voxel) == (voxel + 1) as f64), "{name}");
            assert_eq!((indices.voxel_type().bytes(), indices.background(), layer.voxels_of(0)), (1, 0.0, 0), "{name}");
        }
    }
    if cfg!(feature = "zarr") {
        let options = OpenOptions { array: Some("labels/cells".into()), ..OpenOptions::default() };
        let cells = open("cells_04.zarr", &options, None);
        assert_eq!(cells.layers()[0].palette()[1], [0.0, 1.0, 0.2, 0.4]);
        assert!(!Labels::are_declared(file("cells_04.zarr"), &OpenOptions::default()).unwrap());
    }
}

#[test]
fn a_given_table_comes_before_that_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("own.json");
    std::fs::write(&table, r##"{"labels": [{"id": 1, "name": "own", "color": "#0000ff"}]}"##).unwrap();
    let labels = open("layers.seg.nrrd", &OpenOptions::default(), Some(&table));
    assert!(labels.layers().iter().all(|layer| named(layer) == [(1, Some("own"))]));
    assert_eq!(LabelTable::open(file("atlas.txt")).unwrap().labels().len(), 3);
}

/// The text header of a file with another value for a key, and its voxels.
fn altered(key: &str, value: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let bytes = std::fs::read(file("layers.seg.nrrd")).unwrap();
    let end = bytes.windows(2).position(|two| two == b"\n\n").unwrap();
    let header = String::from_utf8(bytes[..end].to_vec()).unwrap();
    assert!(header.contains(&format!("\n{key}:=")), "{key} of {header}");
    let line = |line: &str| if line.starts_with(&format!("{key}:=")) { format!("{key}:={value}\n") } else { format!("{line}\n") };
    let header: String = header.lines().map(line).collect();
    let path = folder.path().join("t.seg.nrrd");
    std::fs::write(&path, [header.as_bytes(), &bytes[end + 1..]].concat()).unwrap();
    // It is a volume of values all the same.
    layersplat::Volume::open(&path, &OpenOptions { channel: Some(0), ..OpenOptions::default() }).unwrap();
    let message = Labels::open(&path, &OpenOptions::default(), None).err().map_or(String::new(), |e| e.to_string());
    message.replace(&path.display().to_string(), "FILE")
}

#[test]
fn malformed_segments_are_named() {
    assert_eq!(altered("Segment0_Name", "other"), "");
    for (key, value, expected) in [
        ("Segment0_LabelValue", "0", "FILE: its Segment0_LabelValue is '0': expected a whole number from 1 to 4294967295"),
        ("Segment0_LabelValue", "x", "FILE: its Segment0_LabelValue is 'x': expected"),
        ("Segment0_LabelValue", "5", "its segments of layer 0 cannot be told apart: labels: two labels have the id 5"),
        ("Segment1_Layer", "2", "FILE: its segment 1 is in layer 2, but its sizes have layers 0 to 1"),
        ("Segment1_Layer", "-1", "its Segment1_Layer is '-1': expected a whole number from 0"),
        ("Segment2_Color", "0.5 0.25", "its Segment2_Color is '0.5 0.25': expected three numbers from 0 to 1"),
        ("Segment2_Color", "0.5 0.25 2", "expected three numbers from 0 to 1"),
    ] {
        let message = altered(key, value);
        assert!(message.contains(expected), "{key}, {value}: {message}");
    }
}

#[test]
fn volumes_without_ids_are_refused() {
    let others =
        |name: &str| Labels::open(folder().join(name), &OpenOptions::default(), None).map(|_| ()).unwrap_err().to_string();
    assert!(others("nifti/scaled.nii").contains("its voxel 0,0,0 is -12.5: ids of labels are whole numbers from 0"));
    assert!(others("nrrd/int16.nrrd").contains("more than 8 different negative numbers: ids of labels are whole numbers from 0"));
    let builtin = Labels::open("builtin:cube@8", &OpenOptions::default(), None).unwrap_err().to_string();
    assert!(builtin.contains("built-in volumes have values, not labels"), "{builtin}");
    // Fractions are none; 64-bit integers are.
    assert!(Labels::open(folder().join("nifti/float32_1.nii.gz"), &OpenOptions::default(), None).is_err());
    assert!(Labels::open(folder().join("nrrd/uint64.nrrd"), &OpenOptions::default(), None).is_ok());
}

/// Voxels of a ball's mask along each axis, their spacing, and the ball's radius. Its centre is that of the volume.
const COARSE: usize = 12;
const STEP: f64 = 4.0;
const RADIUS: f64 = 18.0;
/// Voxels of the masked volume along each axis.
const FINE: usize = 48;
/// Largest distance of the border of a coarse mask from the ball, in voxels of the volume: half a voxel of the mask, and half of its own
/// diagonal. Nearest voxels of the mask reach 3.3.
const BORDER: f64 = 2.9;

/// The mask of a ball, with or without a placement.
fn ball_mask(path: &Path, placement: &str) {
    let centre = |n: usize| (n as f64 + 0.5) * STEP - 0.5 - (FINE as f64 - 1.0) / 2.0;
    let id = |n: usize| {
        u8::from(DVec3::from_array([n % COARSE, n / COARSE % COARSE, n / COARSE / COARSE].map(centre)).length() < RADIUS)
    };
    let header = format!("NRRD0004\ntype: uint8\ndimension: 3\nsizes: {COARSE} {COARSE} {COARSE}\n{placement}encoding: raw\n\n");
    let ids: Vec<u8> = (0..COARSE.pow(3)).map(id).collect();
    std::fs::write(path, [header.as_bytes(), &ids].concat()).unwrap();
}

/// Masks lie where their own grid places them, with a smooth border.
#[test]
fn coarse_masks_have_smooth_borders() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.nrrd");
    let grid = Grid::new([FINE; 3], DVec3::ONE).unwrap();
    let voxels: Vec<u8> = (0..FINE.pow(3)).map(|n| u8::from(n > 0)).collect();
    let volume = Volume::new("block", grid.clone(), voxels).unwrap();
    let placed = "space dimension: 3\nspace directions: (4,0,0) (0,4,0) (0,0,4)\nspace origin: (1.5,1.5,1.5)\n";
    ball_mask(&path, placed);
    let masked = volume.masked(&Labels::open(&path, &OpenOptions::default(), None).unwrap()).unwrap();
    let distances = (0..FINE.pow(3)).map(|n| {
        let distance =
            (grid.index_to_world().transform_point3(DVec3::from_array(grid.place(n).map(|i| i as f64))) - grid.centre()).length();
        (distance, masked.value(n) > 0.0)
    });
    let (farthest, nearest) = distances.fold((0f64, f64::MAX), |(farthest, nearest), (distance, kept)| {
        if kept { (farthest.max(distance), nearest) } else { (farthest, nearest.min(distance)) }
    });
    assert!(farthest < RADIUS + BORDER && nearest > RADIUS - BORDER, "{farthest} {nearest}");
    // Of another size and without a placement, a mask would cut elsewhere.
    ball_mask(&path, "");
    let unplaced = Labels::open(&path, &OpenOptions::default(), None).unwrap();
    let problem = volume.masked(&unplaced).unwrap_err().to_string();
    assert!(problem.contains("12x12x12") && problem.contains("48x48x48"), "{problem}");
    // With the assumed one it is the same.
    let unstated = Placement { spacing: Some(DVec3::splat(STEP)), origin: Some(DVec3::splat(1.5)) };
    let again = volume.masked(&Labels::open(&path, &OpenOptions { unstated, ..OpenOptions::default() }, None).unwrap()).unwrap();
    assert!((0..FINE.pow(3)).all(|n| again.value(n) == masked.value(n)));
}
