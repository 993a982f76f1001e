//! DICOM files that many programs write, and that state less than the standard requires, or something else.

use crate::refused::refused;
use layersplat::glam::DVec3;
use layersplat::volume::{OpenOptions, Volume};
use std::path::Path;

/// Columns, rows and slices.
const DIMS: [usize; 3] = [3, 2, 3];
pub const EXPLICIT: &str = "1.2.840.10008.1.2.1";
const IMPLICIT: &str = "1.2.840.10008.1.2";
const BIG: &str = "1.2.840.10008.1.2.2";

/// An element: group, number, representation, and value in little-endian order with the size of its numbers.
pub type Element = (u16, u16, &'static [u8; 2], Vec<u8>, usize);

pub fn text(group: u16, number: u16, vr: &'static [u8; 2], value: &str) -> Element {
    let padded = if value.len() % 2 == 1 { format!("{value} ") } else { value.into() };
    (group, number, vr, padded.into_bytes(), 1)
}

pub fn whole(group: u16, number: u16, value: u16) -> Element {
    (group, number, b"US", value.to_le_bytes().to_vec(), 2)
}

/// How elements are written.
#[derive(Clone, Copy)]
pub struct Encoding {
    explicit: bool,
    big: bool,
    /// Whether the representation of everything but the pixels is unknown.
    unknown: bool,
}

pub const PLAIN: Encoding = Encoding { explicit: true, big: false, unknown: false };

impl Encoding {
    fn number(self, bytes: &[u8]) -> Vec<u8> {
        if self.big { bytes.iter().rev().copied().collect() } else { bytes.to_vec() }
    }

    pub fn write(self, elements: &[Element]) -> Vec<u8> {
        let mut out = Vec::new();
        for (group, number, vr, value, size) in elements {
            let vr = if self.unknown && *group != 0x7fe0 { b"UN" } else { vr };
            out.extend(self.number(&group.to_le_bytes()));
            out.extend(self.number(&number.to_le_bytes()));
            let is_long = matches!(vr, b"OB" | b"OW" | b"UN" | b"SQ");
            let len = value.len();
            match (self.explicit, is_long) {
                (true, true) => out.extend([&vr[..], &[0, 0], &self.number(&(len as u32).to_le_bytes())].concat()),
                (true, false) => out.extend([&vr[..], &self.number(&(len as u16).to_le_bytes())].concat()),
                (false, _) => out.extend(self.number(&(len as u32).to_le_bytes())),
            }
            out.extend(value.chunks(*size).flat_map(|number| self.number(number)));
        }
        out
    }
}

/// The stored number of a voxel. Its value is half of it less 1024.
fn stored(x: usize, y: usize, z: usize) -> u16 {
    (x + 10 * y + 100 * z) as u16
}

fn slice(z: usize, kind: &str) -> Vec<Element> {
    let [columns, rows, _] = DIMS;
    let pixels = (0..rows * columns).flat_map(|i| stored(i % columns, i / columns, z).to_le_bytes()).collect();
    vec![
        text(8, 8, b"CS", kind),
        text(8, 0x16, b"UI", "1.2.840.10008.5.1.4.1.1.2"),
        text(8, 0x18, b"UI", &format!("1.2.3.{z}")),
        text(8, 0x60, b"CS", "CT"),
        text(0x18, 0x50, b"DS", "2.5"),
        text(0x20, 0xe, b"UI", "1.2.4"),
        text(0x20, 0x11, b"IS", "7"),
        text(0x20, 0x13, b"IS", &z.to_string()),
        text(0x20, 0x32, b"DS", &format!("1\\2\\{}", 3.0 + 2.5 * z as f64)),
        text(0x20, 0x37, b"DS", "1\\0\\0\\0\\1\\0"),
        whole(0x28, 2, 1),
        text(0x28, 4, b"CS", "MONOCHROME2"),
        whole(0x28, 0x10, rows as u16),
        whole(0x28, 0x11, columns as u16),
        text(0x28, 0x30, b"DS", "0.5\\0.25"),
        whole(0x28, 0x100, 16),
        whole(0x28, 0x101, 16),
        whole(0x28, 0x102, 15),
        whole(0x28, 0x103, 0),
        text(0x28, 0x1052, b"DS", "-1024"),
        text(0x28, 0x1053, b"DS", "0.5"),
        (0x7fe0, 0x10, b"OW", pixels, 2),
    ]
}

/// An item of a sequence.
pub fn item(inside: &[u8]) -> Vec<u8> {
    [&[0xfe, 0xff, 0, 0xe0][..], &(inside.len() as u32).to_le_bytes(), inside].concat()
}

/// Preamble and file meta information.
pub fn meta(syntax: Option<&str>) -> Vec<u8> {
    let mut uid = |uid: &str| {
        let mut element = text(2, 0x10, b"UI", uid);
        element.3.iter_mut().for_each(|c| *c = if *c == b' ' { 0 } else { *c });
        element
    };
    let elements: Vec<Element> =
        [text(2, 2, b"UI", "1.2.840.10008.5.1.4.1.1.2 ")].into_iter().chain(syntax.map(&mut uid)).collect();
    [&[0; 128][..], b"DICM", &PLAIN.write(&elements)].concat()
}

fn series(before: &[u8], encoding: Encoding, kind: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for z in 0..DIMS[2] {
        let bytes = [before, &encoding.write(&slice(z, kind))].concat();
        std::fs::write(folder.path().join(format!("IM{z}")), bytes).unwrap();
    }
    folder
}

#[track_caller]
fn holds(path: &Path, options: &OpenOptions, what: &str) {
    let volume = Volume::open(path, options).unwrap_or_else(|e| panic!("{what}: {e}"));
    let [columns, rows, _] = DIMS;
    assert_eq!(volume.grid().dims(), DIMS, "{what}");
    let expected = |i: usize| f64::from(stored(i % columns, i / columns % rows, i / columns / rows)) / 2.0 - 1024.0;
    let wrong = (0..DIMS.iter().product()).find(|&i| volume.value(i) != expected(i));
    assert_eq!(wrong, None, "{what}");
    let origin = volume.grid().index_to_world().translation;
    assert_eq!((volume.grid().spacing(), origin), (DVec3::new(0.25, 0.5, 2.5), DVec3::new(-1.0, -2.0, 3.0)), "{what}");
}

/// Archives store attributes of the standard without their representation.
#[test]
fn unknown_representations_are_those_of_the_dictionary() {
    let unknown = Encoding { unknown: true, ..PLAIN };
    let folder = series(&meta(Some(EXPLICIT)), unknown, "ORIGINAL");
    holds(folder.path(), &OpenOptions::default(), "unknown");
    // A whole sequence, whose items are implicit: the positions of a file of many frames.
    let implicit = Encoding { explicit: false, ..PLAIN };
    let nested = |group: u16, number: u16, inside: &[Element]| (group, number, b"UN", item(&implicit.write(inside)), 1);
    let per_frame: Vec<u8> = (0..DIMS[2])
        .flat_map(|z| {
            let position = text(0x20, 0x32, b"DS", &format!("1\\2\\{}", 3.0 + 2.5 * z as f64));
            item(&implicit.write(&[nested(0x20, 0x9113, &[position])]))
        })
        .collect();
    let is_own = |(group, number, ..): &Element| [(0x20, 0x32), (8, 8)].contains(&(*group, *number));
    let mut elements: Vec<Element> = slice(0, "").into_iter().filter(|element| !is_own(element)).collect();
    let pixels = (0..DIMS[2]).flat_map(|z| slice(z, "").pop().unwrap().3).collect();
    elements.pop();
    elements.insert(8, text(0x28, 8, b"IS", &DIMS[2].to_string()));
    elements.sort_by_key(|(group, number, ..)| (*group, *number));
    elements.push((0x5200, 0x9230, b"UN", per_frame, 1));
    elements.push((0x7fe0, 0x10, b"OW", pixels, 2));
    let path = folder.path().join("frames.dcm");
    std::fs::write(&path, [meta(Some(EXPLICIT)), PLAIN.write(&elements)].concat()).unwrap();
    holds(&path, &OpenOptions::default(), "a sequence");
}

#[test]
fn elements_tell_an_encoding_that_is_missing_or_wrong() {
    let encodings = [
        ("explicit", PLAIN),
        ("implicit", Encoding { explicit: false, ..PLAIN }),
        ("big-endian", Encoding { big: true, ..PLAIN }),
    ];
    for (what, encoding) in encodings {
        for syntax in [EXPLICIT, IMPLICIT, BIG] {
            let folder = series(&meta(Some(syntax)), encoding, "ORIGINAL");
            holds(folder.path(), &OpenOptions::default(), &format!("{what} elements under {syntax}"));
        }
        for before in [&meta(None)[..], &meta(None)[132..], b"DICM", b""] {
            let folder = series(before, encoding, "ORIGINAL");
            let what = format!("{what} elements after {} bytes", before.len());
            holds(folder.path(), &OpenOptions::default(), &what);
            holds(&folder.path().join("IM1"), &OpenOptions::default(), &what);
        }
    }
}

/// A copy that was cut off, text, and what macOS leaves on foreign disks.
#[test]
fn other_files_of_a_folder_are_left_out() {
    let folder = series(&meta(Some(EXPLICIT)), PLAIN, "ORIGINAL");
    let whole = std::fs::read(folder.path().join("IM0")).unwrap();
    let shifted = [&meta(Some(EXPLICIT))[..], b"\x08\0\x08\0XX\xff\xff\xff\xff\xff\x7f"].concat();
    for (name, bytes) in
        [("cut", &whole[..200]), ("damaged", &shifted), ("notes.txt", b"1, 2"), ("._IM0", &whole), (".DS_Store", b"")]
    {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    holds(folder.path(), &OpenOptions::default(), "a folder");
    holds(folder.path(), &OpenOptions { series: Some("7".into()), ..OpenOptions::default() }, "a series");
    holds(&folder.path().join("IM2"), &OpenOptions::default(), "a file");
    refused(&folder.path().join("damaged"), "a damaged file", "damaged: its header is truncated or damaged");
}

#[test]
fn mosaics_are_refused() {
    let folder = series(&meta(Some(EXPLICIT)), PLAIN, "ORIGINAL\\PRIMARY\\M\\MOSAIC");
    refused(folder.path(), "a mosaic", "its slices are tiles of one picture (a Siemens mosaic): separate them");
}

/// A slice with other colours.
fn colored(photometric: &str, more: Vec<Element>) -> (tempfile::TempDir, std::path::PathBuf) {
    let is_changed = |element: &Element| more.iter().any(|other| (other.0, other.1) == (element.0, element.1));
    let kept = slice(0, "ORIGINAL").into_iter().filter(|element| (element.0, element.1) != (0x28, 4) && !is_changed(element));
    let mut elements: Vec<Element> = kept.chain([text(0x28, 4, b"CS", photometric)]).collect();
    elements.extend(more);
    elements.sort_by_key(|(group, number, ..)| (*group, *number));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("IM0");
    std::fs::write(&path, [meta(Some(EXPLICIT)), PLAIN.write(&elements)].concat()).unwrap();
    (folder, path)
}

/// Indices are the values, and the palette is kept.
#[test]
fn palettes_are_read() {
    let words = |number: u16, values: &[u16]| -> Element {
        let vr = if number < 0x1200 { b"US" } else { b"OW" };
        (0x28, number, vr, values.iter().flat_map(|n| n.to_le_bytes()).collect(), 2)
    };
    // Sixteen bits, and eight bits of which two share a word. The first two numbers have the first color.
    let long = |part: u16| [words(0x1101 + part, &[4, 1, 16]), words(0x1201 + part, &[0, 65535, 257 * part, 0])];
    let short = |part: u16| [words(0x1101 + part, &[4, 1, 8]), words(0x1201 + part, &[0xff00, part])];
    for more in [(0..3).flat_map(long).collect::<Vec<_>>(), (0..3).flat_map(short).collect()] {
        let (_folder, path) = colored("PALETTE COLOR", more);
        let volume = Volume::open(&path, &OpenOptions::default()).unwrap();
        assert_eq!(volume.value(4), f64::from(stored(1, 1, 0)) / 2.0 - 1024.0);
        let colors = &volume.contents().palette;
        assert_eq!((colors.len(), colors[0], colors[1], colors[2]), (5, [0.0; 3], [0.0; 3], [1.0; 3]));
        assert_eq!(colors[3].map(|part| (part * 255.0).round()), [0.0, 1.0, 2.0]);
    }
    let (_folder, path) = colored("PALETTE COLOR", Vec::new());
    refused(&path, "no palette", "its palette is missing, in segments or damaged");
}

/// Luminance and chrominance as pydicom converts them, interleaved and as planes.
#[test]
fn luminance_is_color() {
    const STORED: [[u8; 3]; 6] = [[0, 128, 128], [255, 128, 128], [76, 85, 255], [149, 44, 21], [29, 255, 107], [200, 3, 250]];
    const RGB: [[u8; 3]; 6] = [[0, 0, 0], [255, 255, 255], [254, 0, 0], [0, 254, 0], [0, 0, 254], [255, 156, 0]];
    for planar in [0, 1] {
        let interleaved: Vec<u8> = STORED.concat();
        let planes = (0..3).flat_map(|part| STORED.map(|pixel| pixel[part])).collect();
        let bits = [whole(0x28, 0x100, 8), whole(0x28, 0x101, 8), whole(0x28, 0x102, 7)];
        let more = [whole(0x28, 2, 3), whole(0x28, 6, planar), text(0x28, 0x1052, b"DS", "0"), text(0x28, 0x1053, b"DS", "1")];
        let pixels = (0x7fe0, 0x10, b"OB", if planar == 0 { interleaved } else { planes }, 1);
        let (_folder, path) = colored("YBR_FULL", more.into_iter().chain(bits).chain([pixels]).collect());
        for channel in 0..3 {
            let volume = Volume::open(&path, &OpenOptions { channel: Some(channel), ..OpenOptions::default() }).unwrap();
            assert_eq!([0, 1, 2, 3, 4, 5].map(|i| volume.value(i) as u8), RGB.map(|pixel| pixel[channel]), "planar {planar}");
        }
    }
    let (_folder, path) = colored("YBR_FULL_422", vec![whole(0x28, 2, 3)]);
    refused(&path, "half of the chrominance", "its colours are YBR_FULL_422 of 16 bits: convert them to RGB");
}
