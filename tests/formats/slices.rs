//! Folders of slices, as microscopes and other programs leave them.

use crate::refused::refused;
use layersplat::volume::{ChannelDescription, LabelTable, Labels, OpenOptions, Volume};
use layersplat::{Error, TransferFunction};
use std::path::Path;

/// A picture of three pixels, one of indices into a palette of two colours if it is given.
fn picture(values: [u8; 3], palette: Option<&[u8]>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 3, 1);
    encoder.set_depth(png::BitDepth::Eight);
    match palette {
        None => encoder.set_color(png::ColorType::Grayscale),
        Some(palette) => {
            encoder.set_color(png::ColorType::Indexed);
            encoder.set_palette(palette.to_vec());
        }
    }
    encoder.write_header().unwrap().write_image_data(&values).unwrap();
    bytes
}

fn folder<'a>(files: impl IntoIterator<Item = (&'a str, Vec<u8>)>) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    files.into_iter().for_each(|(name, bytes)| std::fs::write(folder.path().join(name), bytes).unwrap());
    folder
}

fn values(path: &Path, options: &OpenOptions) -> Vec<f64> {
    let volume = Volume::open(path, options).unwrap_or_else(|e| panic!("{e}"));
    (0..volume.grid().voxel_count()).map(|i| volume.value(i)).collect()
}

/// What macOS, Windows and people leave in folders.
#[test]
fn other_files_are_no_slices() {
    let folder = folder([
        ("s0.png", picture([1, 2, 3], None)),
        ("s1.png", picture([4, 5, 6], None)),
        ("._s0.png", b"\0\x05\x16\x07".to_vec()),
        (".hidden.tif", Vec::new()),
        (".DS_Store", Vec::new()),
        ("Thumbs.db", Vec::new()),
        ("notes.txt", Vec::new()),
    ]);
    assert_eq!(values(folder.path(), &OpenOptions::default()), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
}

#[test]
fn indices_of_palettes_are_values_with_colours() {
    let palette = [255, 0, 0, 0, 255, 0, 0, 0, 255, 51, 102, 255];
    let slice = |z: u8| picture([0, z, 3], Some(&palette));
    let folder = folder([("s1.png", slice(1)), ("s2.png", slice(2))]);
    assert_eq!(values(folder.path(), &OpenOptions::default()), [0.0, 1.0, 3.0, 0.0, 2.0, 3.0]);
    let volume = Volume::open(folder.path(), &OpenOptions::default()).unwrap();
    let color = [0.2, 0.4, 1.0];
    assert_eq!(volume.contents().palette[3], color);
    assert_eq!(TransferFunction::automatic(&volume).color(3.0), color);
    let labels = Labels::open(folder.path(), &OpenOptions::default(), None).unwrap();
    let table: &LabelTable = labels.layers()[0].table();
    assert_eq!((table.get(3).unwrap().color, table.get(2).unwrap().color), (color, [0.0, 0.0, 1.0]));
    std::fs::write(folder.path().join("s3.png"), picture([0; 3], Some(&palette[3..]))).unwrap();
    refused(folder.path(), "another palette", "s3.png: its palette differs from that of");
}

#[test]
fn names_number_channels_and_times() {
    let names = ["w1DAPI", "w2GFP"];
    let mut files = Vec::new();
    for (c, channel) in names.iter().enumerate() {
        for t in 0..2 {
            for z in 8..11 {
                files.push((format!("a_z{z}_{channel}_t{t}.png"), picture([c as u8, t, z], None)));
            }
        }
    }
    let folder = folder(files.iter().map(|(name, bytes)| (name.as_str(), bytes.clone())));
    for (channel, frame) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let options = OpenOptions { channel: Some(channel), frame: Some(frame), ..OpenOptions::default() };
        let expected: Vec<f64> = (8..11).flat_map(|z| [channel as f64, frame as f64, f64::from(z)]).collect();
        assert_eq!(values(folder.path(), &options), expected);
    }
    let described = ChannelDescription::of_file(folder.path(), &OpenOptions::default()).unwrap();
    assert_eq!(described.iter().map(|channel| channel.name.as_deref()).collect::<Vec<_>>(), [Some("DAPI"), Some("GFP")]);
    let missing = OpenOptions { channel: Some(2), ..OpenOptions::default() };
    assert!(matches!(Volume::open(folder.path(), &missing), Err(Error::Settings { field: "channel", .. })));
    std::fs::remove_file(folder.path().join("a_z9_w2GFP_t1.png")).unwrap();
    refused(folder.path(), "a missing slice", "some of channel 2 and time 1 are missing: add them");
}
