//! DICOM segmentations.

use crate::dicom_encodings::{EXPLICIT, Element, PLAIN, item, meta, text, whole};
use crate::refused::refused;
use layersplat::glam::DVec3;
use layersplat::volume::{ChannelDescription, Labels, OpenOptions, Volume};
use std::path::Path;

/// Columns, rows and slices. A frame has 15 bits, so that most begin within a byte.
const DIMS: [usize; 3] = [5, 3, 6];
/// Segment and slice of each frame, in no order; slice 2 has none, and segments 1 and 3 overlap.
const FRAMES: [(u16, usize); 6] = [(7, 5), (1, 1), (3, 1), (1, 0), (7, 3), (3, 4)];

/// Whether a segment has a voxel.
fn is_in(segment: u16, x: usize, y: usize, z: usize) -> bool {
    FRAMES.contains(&(segment, z)) && (if segment == 7 { (x + z).is_multiple_of(2) } else { x > y + usize::from(segment / 2) })
}

fn places() -> impl Iterator<Item = [usize; 3]> {
    let [columns, rows, slices] = DIMS;
    (0..columns * rows * slices).map(move |i| [i % columns, i / columns % rows, i / columns / rows])
}

fn sequence(group: u16, number: u16, items: &[Vec<Element>]) -> Element {
    (group, number, b"SQ", items.iter().flat_map(|elements| item(&PLAIN.write(elements))).collect(), 1)
}

fn position(z: usize) -> Element {
    sequence(0x20, 0x9113, &[vec![text(0x20, 0x32, b"DS", &format!("1\\2\\{}", 3.0 + 2.5 * z as f64))]])
}

/// A segmentation of a kind, with the frames and pixels that are given; `between`: whether it states the distance of slices.
fn segmentation(kind: &str, bits: u16, frames: &[(u16, usize)], between: bool, pixels: Vec<u8>) -> Vec<u8> {
    let [columns, rows, _] = DIMS;
    let lab = |l: u16, a: u16, b: u16| (0x62, 0xd, b"US", [l, a, b].iter().flat_map(|n| n.to_le_bytes()).collect(), 2);
    // Red, green and blue as highdicom writes them.
    let segments = [
        vec![whole(0x62, 4, 1), text(0x62, 5, b"LO", "Köpfe"), lab(34886, 53484, 50172)],
        vec![whole(0x62, 4, 3), text(0x62, 5, b"LO", "liver"), lab(46230, 14911, 48930)],
        vec![whole(0x62, 4, 7), text(0x62, 5, b"LO", "spleen")],
    ];
    let own = |&(segment, z): &(u16, usize)| {
        let segment = sequence(0x62, 0xa, &[vec![whole(0x62, 0xb, segment)]]);
        vec![position(z)].into_iter().chain((kind != "LABELMAP").then_some(segment)).collect()
    };
    let mut measures = vec![text(0x18, 0x50, b"DS", "1"), text(0x28, 0x30, b"DS", "0.5\\0.25")];
    if between {
        measures.insert(1, text(0x18, 0x88, b"DS", "2.5"));
    }
    let orientation = sequence(0x20, 0x9116, &[vec![text(0x20, 0x37, b"DS", "1\\0\\0\\0\\1\\0")]]);
    let elements = [
        text(8, 5, b"CS", "ISO_IR 192"),
        text(8, 0x16, b"UI", "1.2.840.10008.5.1.4.1.1.66.4"),
        text(0x20, 0xe, b"UI", "1.2.5"),
        whole(0x28, 2, 1),
        text(0x28, 4, b"CS", "MONOCHROME2"),
        text(0x28, 8, b"IS", &frames.len().to_string()),
        whole(0x28, 0x10, rows as u16),
        whole(0x28, 0x11, columns as u16),
        whole(0x28, 0x100, bits),
        whole(0x28, 0x101, bits),
        whole(0x28, 0x102, bits - 1),
        whole(0x28, 0x103, 0),
        text(0x62, 1, b"CS", kind),
        sequence(0x62, 2, &segments),
        whole(0x62, 0xe, 200),
        sequence(0x5200, 0x9229, &[vec![orientation, sequence(0x28, 0x9110, &[measures])]]),
        sequence(0x5200, 0x9230, &frames.iter().map(own).collect::<Vec<_>>()),
        (0x7fe0, 0x10, if bits > 8 { b"OW" } else { b"OB" }, pixels, 1),
    ];
    [meta(Some(EXPLICIT)), PLAIN.write(&elements)].concat()
}

/// All pixels of frames.
fn pixels(frames: &[(u16, usize)], of: impl Fn(u16, [usize; 3]) -> u8) -> Vec<u8> {
    let slice = |&(segment, z): &(u16, usize)| {
        places().filter(move |place| place[2] == z).map(move |place| (segment, place)).collect::<Vec<_>>()
    };
    frames.iter().flat_map(slice).map(|(segment, place)| of(segment, place)).collect()
}

fn packed(bits: &[u8]) -> Vec<u8> {
    bits.chunks(8).map(|byte| byte.iter().enumerate().map(|(n, bit)| bit << n).sum()).collect()
}

fn binary(frames: &[(u16, usize)], between: bool) -> Vec<u8> {
    let bits = pixels(frames, |segment, [x, y, z]| is_in(segment, x, y, z).into());
    segmentation("BINARY", 1, frames, between, packed(&bits))
}

fn written(bytes: &[u8]) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("segments.dcm");
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

fn opened(path: &Path, channel: usize) -> Volume<'static> {
    let volume = Volume::open(path, &OpenOptions { channel: Some(channel), ..OpenOptions::default() }).unwrap();
    assert_eq!(volume.grid().dims(), DIMS);
    let origin = volume.grid().index_to_world().translation;
    assert_eq!((volume.grid().spacing(), origin), (DVec3::new(0.25, 0.5, 2.5), DVec3::new(-1.0, -2.0, 3.0)));
    volume
}

#[track_caller]
fn holds(path: &Path, channel: usize, expected: impl Fn([usize; 3]) -> f64) {
    let volume = opened(path, channel);
    let wrong = places().enumerate().find(|&(i, place)| volume.value(i) != expected(place));
    assert_eq!(wrong, None, "channel {channel}");
}

#[test]
fn segments_that_overlap_are_in_layers() {
    let (folder, path) = written(&binary(&FRAMES, false));
    // A folder of one segmentation is it, too.
    for source in [path.as_path(), folder.path()] {
        let id = |segments: &[u16], [x, y, z]: [usize; 3]| {
            segments.iter().filter(|&&segment| is_in(segment, x, y, z)).map(|&segment| f64::from(segment)).sum()
        };
        holds(source, 0, |place| id(&[1, 7], place));
        holds(source, 1, |place| id(&[3], place));
        let labels = Labels::open(source, &OpenOptions::default(), None).unwrap();
        let layers: Vec<&[u32]> = labels.layers().iter().map(|layer| layer.ids()).collect();
        assert_eq!(layers, [&[0, 1, 7][..], &[0, 3]]);
        let label = |layer: usize, id: u32| labels.layers()[layer].table().get(id).unwrap().clone();
        let names = [(0, 1), (1, 3), (0, 7)].map(|(layer, id)| label(layer, id).name.unwrap());
        assert_eq!(names, ["Köpfe", "liver", "spleen"]);
        /// A byte of a colour, by which conversions through 16-bit CIELAB may be off.
        const STEP: f64 = 1.0 / 255.0;
        for (layer, id, expected) in [(0, 1, [255.0, 0.0, 0.0]), (1, 3, [10.0, 200.0, 40.0])] {
            let found = label(layer, id).color;
            assert!((0..3).all(|i| (found[i] - expected[i] / 255.0).abs() <= STEP), "{found:?}");
        }
    }
}

/// Slices without frames are background: the stated distance tells how many these are.
#[test]
fn missing_slices_are_background() {
    let apart: Vec<_> = FRAMES.into_iter().filter(|(segment, _)| *segment == 7).chain([(7, 0)]).collect();
    let (_folder, path) = written(&binary(&apart, true));
    let is_7 = |[x, y, z]: [usize; 3]| if is_in(7, x, y, z) { 7.0 } else { 0.0 };
    holds(&path, 0, is_7);
    // Without it, slices 0, 3 and 5 have no smallest step.
    let (folder, path) = written(&binary(&apart, false));
    refused(&path, "uneven slices", "its slices are 5 apart at least and 12.5 in all, which is no whole number of equal steps");
    drop(folder);
}

#[test]
fn label_maps_and_fractions_are_numbers() {
    let frames: Vec<(u16, usize)> = [4, 0, 1, 2, 3, 5].map(|z| (0, z)).to_vec();
    let number = |[x, y, z]: [usize; 3]| (x + 5 * y + 15 * z) as u8;
    let maps = segmentation("LABELMAP", 8, &frames, true, pixels(&frames, |_, place| number(place)));
    let (_folder, path) = written(&maps);
    holds(&path, 0, |place| number(place).into());
    let labels = Labels::open(&path, &OpenOptions::default(), None).unwrap();
    assert_eq!(labels.layers()[0].table().get(3).unwrap().name.as_deref(), Some("liver"));

    let frames: Vec<(u16, usize)> = (0..6).flat_map(|z| [(3, z), (1, 5 - z)]).filter(|frame| *frame != (1, 2)).collect();
    let shares = pixels(&frames, |segment, place| number(place) + segment as u8);
    let (_folder, path) = written(&segmentation("FRACTIONAL", 8, &frames, true, shares));
    let share = |segment: f64| {
        move |place: [usize; 3]| {
            let is_missing = segment == 1.0 && place[2] == 2;
            if is_missing { 0.0 } else { (f64::from(number(place)) + segment) / 200.0 }
        }
    };
    for (channel, segment) in [(0, 1.0), (1, 3.0)] {
        let volume = opened(&path, channel);
        let off = places().enumerate().map(|(i, place)| (volume.value(i) - share(segment)(place)).abs()).fold(0.0, f64::max);
        assert!(off < f32::EPSILON.into(), "{off}");
    }
    assert!(!Labels::are_declared(&path, &OpenOptions::default()).unwrap());
    let named = ChannelDescription::of_file(&path, &OpenOptions::default()).unwrap();
    assert_eq!(named.iter().map(|channel| channel.name.clone().unwrap()).collect::<Vec<_>>(), ["Köpfe", "liver"]);
}

#[test]
fn segments_without_numbers_or_places_are_refused() {
    let twice = [FRAMES[1], FRAMES[1], FRAMES[3]];
    let (_folder, path) = written(&binary(&twice, true));
    refused(&path, "a frame twice", "two of its frames show segment 1 at one place");
    let plain = binary(&FRAMES, true);
    let without = |tag: [u8; 4], other: [u8; 4]| {
        let mut bytes = plain.clone();
        let found: Vec<usize> = (0..bytes.len() - 4).filter(|&at| bytes[at..at + 4] == tag).collect();
        found.iter().for_each(|&at| bytes[at..at + 4].copy_from_slice(&other));
        written(&bytes)
    };
    let (_folder, path) = without([0x62, 0, 0xb, 0], [0x62, 0, 0xc, 0]);
    refused(&path, "no segment", "its frame 0 does not state the number of its segment");
    let (_folder, path) = without([0x20, 0, 0x13, 0x91], [0x20, 0, 0x14, 0x91]);
    refused(&path, "no position", "the frames of its segments have no positions");
    let (_folder, path) = written(&plain[..plain.len() - 8]);
    refused(&path, "cut off", "its pixels are truncated or damaged");
}
