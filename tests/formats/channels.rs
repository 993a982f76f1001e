//! Metadata of channels, and colours of every format that has them, written by other programs.

use crate::files::{all, folder};
use layersplat::volume::{ChannelDescription, OpenOptions, Volume};
use std::path::PathBuf;

const GREEN: [f64; 3] = [0.0, 1.0, 0.0];
const BLUE: [f64; 3] = [0.0, 0.0, 1.0];

fn file(name: &str) -> PathBuf {
    folder().join("channels").join(name)
}

fn described(name: &str) -> Vec<ChannelDescription> {
    ChannelDescription::of_file(file(name), &OpenOptions::default()).unwrap_or_else(|e| panic!("{name}: {e}"))
}

type Stated = (Option<&'static str>, Option<[f64; 3]>, Option<(f64, f64)>, bool);

#[track_caller]
fn check(name: &str, expected: &[Stated]) {
    let found = described(name);
    let found: Vec<_> = found.iter().map(|c| (c.name.as_deref(), c.color, c.window, c.active)).collect();
    assert_eq!(found, expected, "{name}");
}

#[test]
#[cfg(feature = "tiff")]
fn tiff_has_names_colours_and_windows() {
    let third = Some([1.0, 0.0, 0.4]);
    let imagej = [
        (Some("DAPI"), Some(BLUE), Some((1.0, 200.5)), true),
        // An empty name and a window without a width are none.
        (None, Some(GREEN), Some((0.0, 255.0)), true),
        (Some("Texas Red"), third, None, true),
    ];
    check("imagej.tif", &imagej);
    check("imagej_big.tif", &imagej);
    check("grey.tif", &[(None, None, Some((3.0, 50.0)), true)]);
    // The bytes of a colour are red, green, blue and alpha.
    let ome = [
        (Some("Hoechst"), Some(BLUE), None, true),
        (Some("a & b"), None, None, true),
        (Some("mCherry"), Some([1.0, 0.0, 0.0]), None, true),
    ];
    check("named.ome.tif", &ome);
}

#[test]
#[cfg(feature = "zarr")]
fn ome_zarr_has_names_colours_and_windows() {
    // The third channel has no entry.
    let expected =
        [(Some("DAPI"), Some(BLUE), Some((10.0, 90.5)), true), (Some("EGFP"), None, None, false), (None, None, None, true)];
    check("omero_04.zarr", &expected);
    check("omero_05.zarr", &expected);
    assert_eq!(ChannelDescription::colors(&described("omero_04.zarr")), [BLUE, GREEN, [1.0, 0.0, 1.0]]);
    // What is malformed is named, and the volume opens all the same.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.zarr");
    let array = r#"{"zarr_format": 2, "shape": [2, 3, 4], "chunks": [2, 3, 4], "dtype": "|u1", "compressor": null, "fill_value": 0, "order": "C"}"#;
    std::fs::create_dir_all(path.join("0")).unwrap();
    std::fs::write(path.join(".zgroup"), r#"{"zarr_format": 2}"#).unwrap();
    std::fs::write(path.join("0/.zarray"), array).unwrap();
    let attributes =
        r#"{"multiscales": [{"axes": ["z", "y", "x"], "datasets": [{"path": "0"}]}], "omero": {"channels": [{"color": "red"}]}}"#;
    std::fs::write(path.join(".zattrs"), attributes).unwrap();
    let message = ChannelDescription::of_file(&path, &OpenOptions::default()).unwrap_err().to_string();
    assert!(message.contains("t.zarr: its omero metadata have a channel with color \"red\": expected six"), "{message}");
    assert!(Volume::open(&path, &OpenOptions::default()).is_ok());
}

/// Voxels of all of these are compared by `files::channels`.
#[test]
fn colours_have_three_or_four_channels() {
    let colours: Vec<_> = all().into_iter().filter(|expected| expected.file.starts_with("channels/rgb")).collect();
    assert!(colours.len() > 40);
    for expected in colours {
        let volume = Volume::open(folder().join(&expected.file), &expected.options).unwrap();
        let count = if expected.file.starts_with("channels/rgba") { 4 } else { 3 };
        let found = (volume.contents().channels, volume.contents().channel);
        assert_eq!(found, (count, expected.options.channel.unwrap_or(0)), "{}", expected.file);
        // Arrays of these formats may be vectors.
        let may_be_vectors = [".npy", ".vti", ".zarr"].iter().any(|ending| expected.file.ends_with(ending));
        assert_eq!(volume.contents().are_colors, !may_be_vectors, "{}", expected.file);
        let beyond = OpenOptions { channel: Some(count), ..expected.options.clone() };
        let message = Volume::open(folder().join(&expected.file), &beyond).unwrap_err().to_string();
        assert!(message.contains(&format!("channels are 0 to {}", count - 1)), "{message}");
    }
}

#[test]
fn components_of_colours_are_named() {
    let colors = [
        (Some("red"), Some([1.0, 0.0, 0.0]), None, true),
        (Some("green"), Some(GREEN), None, true),
        (Some("blue"), Some(BLUE), None, true),
    ];
    let with_alpha = [&colors[..], &[(Some("alpha"), None, None, false)]].concat();
    for name in ["rgb.nii", "rgb_uint16.nrrd", "rgb_uint8"] {
        check(name, &colors);
    }
    for name in ["rgba.nii", "rgba_float32.nrrd", "rgba_uint16"] {
        check(name, &with_alpha);
    }
    if cfg!(feature = "tiff") {
        check("rgb_float32.tif", &colors);
        check("rgba_uint8.tif", &with_alpha);
    }
    // These may be vectors.
    check("rgb_uint8.npy", &[(None, None, None, true); 3]);
}
