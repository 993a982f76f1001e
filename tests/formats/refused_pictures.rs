//! Slice files, one of them invalid.

use crate::refused::refused;
use layersplat::volume::{OpenOptions, Volume};
use png::{BitDepth, ColorType};
use std::path::Path;

/// A picture of `width` × 4 pixels with repeating bytes.
fn png(width: u32, color: ColorType, depth: BitDepth) -> Vec<u8> {
    let mut picture = Vec::new();
    let mut encoder = png::Encoder::new(&mut picture, width, 4);
    encoder.set_color(color);
    encoder.set_depth(depth);
    let row = (width as usize * color.samples() * depth as usize).div_ceil(8);
    let bytes: Vec<u8> = (0..row * 4).map(|n| (n % 251) as u8).collect();
    encoder.write_header().unwrap().write_image_data(&bytes).unwrap();
    picture
}

fn grey() -> Vec<u8> {
    png(5, ColorType::Grayscale, BitDepth::Eight)
}

/// Three 8-bit grey slices; the second one is replaced.
fn with_second(slice: &[u8]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (n, slice) in [&grey(), slice, &grey()].into_iter().enumerate() {
        std::fs::write(folder.path().join(format!("slice_{n}.png")), slice).unwrap();
    }
    folder
}

/// Changes the declared size of a picture, with a valid checksum.
fn declared(mut picture: Vec<u8>, width: u32, height: u32) -> Vec<u8> {
    picture[16..20].copy_from_slice(&width.to_be_bytes());
    picture[20..24].copy_from_slice(&height.to_be_bytes());
    let mut checksum = flate2::Crc::new();
    checksum.update(&picture[12..29]);
    picture[29..33].copy_from_slice(&checksum.sum().to_be_bytes());
    picture
}

#[test]
fn slices_that_differ_are_named() {
    let cases = [
        (png(6, ColorType::Grayscale, BitDepth::Eight), "slice_1.png: it has 6x4 pixels of uint8, but"),
        (png(5, ColorType::Grayscale, BitDepth::Sixteen), "slice_1.png: it has 5x4 pixels of uint16, but"),
        (png(5, ColorType::Rgb, BitDepth::Eight), "slice_1.png: it has 5x4 pixels of uint8 with 3 channels, but"),
        (declared(grey(), 5, 60_000), "slice_1.png: it has 5x60000 pixels"),
    ];
    for (slice, words) in cases {
        let folder = with_second(&slice);
        refused(&folder.path().join("slice_%d.png"), words, words);
        refused(&folder.path().join("slice_%d.png"), words, "slices must be alike");
    }
}

#[test]
fn damaged_slices_are_named() {
    let whole = grey();
    for (slice, what) in [
        (&whole[..whole.len() - 20], "cut within its pixels"),
        (&whole[..20], "cut within its header"),
        (&b"GIF89a"[..], "another format"),
        (b"", "an empty file"),
    ] {
        refused(&with_second(slice).path().join("slice_%d.png"), what, "slice_1.png");
    }
    let folder = tempfile::tempdir().unwrap();
    let bomb = folder.path().join("bomb.png");
    std::fs::write(&bomb, declared(grey(), 60_000, 60_000)).unwrap();
    refused(&bomb, "more pixels than its compressed data can hold", "60000x60000x1 voxels of uint8, 3600000000 bytes");
}

/// Masks are one-bit pictures.
#[test]
fn bits_are_black_and_white() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mask.png");
    std::fs::write(&path, png(8, ColorType::Grayscale, BitDepth::One)).unwrap();
    let volume = Volume::open(&path, &OpenOptions::default()).unwrap();
    // Rows are the bytes 0 to 3.
    let row = |y: usize| [5, 6, 7].map(|x| volume.value(x + 8 * y));
    assert_eq!([row(0), row(1), row(2), row(3)], [[0.0; 3], [0.0, 0.0, 255.0], [0.0, 255.0, 0.0], [0.0, 255.0, 255.0]]);
}

#[cfg(feature = "tiff")]
mod tiffs {
    use super::*;
    use crate::refused::changed;

    /// Offset of a tag of a page; tifffile writes little-endian files.
    fn entry(bytes: &[u8], page: usize, tag: u16) -> usize {
        let int16 = |at: usize| u16::from_le_bytes(bytes[at..at + 2].try_into().unwrap());
        let int32 = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        let entries = |directory: usize| usize::from(int16(directory));
        let directory = (0..page).fold(int32(4), |at, _| int32(at + 2 + 12 * entries(at)));
        (0..entries(directory)).map(|n| directory + 2 + 12 * n).find(|&at| int16(at) == tag).unwrap()
    }

    /// A page, a tag, and its new value.
    type Value = (usize, u16, u32);

    /// Changes tags of pages.
    fn with(bytes: &mut [u8], values: &[Value]) {
        for &(page, tag, value) in values {
            let at = entry(bytes, page, tag);
            bytes[at + 8..at + 12].copy_from_slice(&value.to_le_bytes());
        }
    }

    const WIDTH: u16 = 256;
    const HEIGHT: u16 = 257;
    const BITS: u16 = 258;
    const COMPRESSION: u16 = 259;
    const SAMPLES: u16 = 277;
    const ROWS: u16 = 278;

    #[test]
    fn wrong_pages_are_named() {
        let huge = [0, 1, 2].map(|page| [(page, WIDTH, 60_000), (page, HEIGHT, 60_000), (page, ROWS, 60_000)]).concat();
        let cases: [(&str, &[Value], &str); 9] = [
            ("uint8.tif", &[(0, BITS, 24)], "its samples have 24 bits (format 1): expected 1 to 16, 32 or 64; convert it"),
            ("uint8.tif", &[(0, WIDTH, 0)], "it has a page of 0x4 pixels"),
            ("uint8.tif", &[(0, SAMPLES, 0)], "it has 0 samples per pixel"),
            ("uint8.tif", &[(0, COMPRESSION, 50_000)], "its pages are compressed with Zstandard: save them"),
            ("uint8.tif", &[(1, WIDTH, 6)], "page 1 has 6x4 pixels of uint8, but the first has 5x4 pixels of uint8"),
            ("uint8.tif", &[(1, HEIGHT, 3)], "page 1 has 5x3 pixels"),
            ("uint16.tif", &[(2, BITS, 8)], "page 2 has 5x4 pixels of uint8, but the first has 5x4 pixels of uint16"),
            (
                "rgb.tif",
                &[(1, SAMPLES, 1)],
                "page 1 has 5x4 pixels of uint8, but the first has 5x4 pixels of uint8 with 3 channels",
            ),
            ("zlib.tif", &huge, "60000x60000x3 voxels of uint16, 21600000000 bytes"),
        ];
        for (file, values, words) in cases {
            let (_temporary, path) = changed(&format!("tiff/{file}"), |bytes| with(bytes, values));
            refused(&path, &format!("{file} with {values:?}"), words);
        }
    }

    #[test]
    fn what_a_file_cannot_hold_is_refused() {
        for (file, tag) in [("uint8.tif", 273), ("uint8.tif", 279), ("strips.tif", 273)] {
            let (_temporary, path) = changed(&format!("tiff/{file}"), |bytes| {
                let at = entry(bytes, 0, tag);
                bytes[at + 4..at + 8].copy_from_slice(&0x0f00_0000u32.to_le_bytes());
            });
            refused(&path, file, &format!("tag {tag} has 251658240 numbers"));
        }
        for (file, words) in [
            ("uint8.tif", "its pages cannot be read"),
            ("zlib.tif", "truncated or damaged"),
            ("slice_9.tif", "truncated or damaged"),
        ] {
            let (_temporary, path) = changed(&format!("tiff/{file}"), |bytes| bytes.truncate(bytes.len() - 40));
            refused(&path, file, words);
        }
        let (_temporary, path) = changed("tiff/slice_9.tif", |bytes| with(bytes, &[(0, WIDTH, 4)]));
        refused(&path.with_file_name("slice_%d.tif"), "a slice of another size", "slice_9.tif: it has 4x4 pixels");
    }

    /// A page of its file in which SGI's ImageDepth says how many slices it has.
    #[test]
    fn pages_of_several_slices_are_refused() {
        let deep = |slices: u16| {
            changed("tiff/uint8.tif", |bytes| {
                // In the place of the software's name, the last tag.
                let at = entry(bytes, 0, 305);
                bytes[at..at + 2].copy_from_slice(&32997u16.to_le_bytes());
                bytes[at + 2..at + 12].copy_from_slice(&[3, 0, 1, 0, 0, 0, slices as u8, 0, 0, 0]);
            })
        };
        let (_temporary, path) = deep(3);
        refused(&path, "a page of 3 slices", "its pages have 3 slices each (ImageDepth): save one page per slice");
        let (_temporary, path) = deep(1);
        assert!(Volume::open(&path, &OpenOptions::default()).is_ok());
    }

    /// The photometric interpretation is about display: values are those that are stored, whatever it says.
    #[test]
    fn white_is_zero_leaves_values_as_they_are() {
        // Tag 262 of one short number, which becomes 0: of classic TIFF in both byte orders, and of BigTIFF.
        let tags: [(&[u8], usize); 3] = [
            (&[6, 1, 3, 0, 1, 0, 0, 0, 1, 0], 8),
            (&[1, 6, 0, 3, 0, 0, 0, 1, 0, 1], 9),
            (&[6, 1, 3, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1, 0], 12),
        ];
        for file in "uint8 int8 uint16 int16 uint32 float16 float32 float64 big_endian bigtiff zlib strips tiled".split(' ') {
            let file = format!("tiff/{file}.tif");
            let mut pages = 0;
            let (_temporary, path) = changed(&file, |bytes| {
                for (tag, value) in tags {
                    let found: Vec<usize> = (0..bytes.len() - tag.len()).filter(|&at| bytes[at..].starts_with(tag)).collect();
                    pages += found.len();
                    found.into_iter().for_each(|at| bytes[at + value] = 0);
                }
            });
            assert!(pages > 1, "{file}: {pages} pages");
            let open = |path: &Path| Volume::open(path, &OpenOptions::default()).unwrap_or_else(|e| panic!("{file}: {e}"));
            let (found, expected) = (open(&path), open(&crate::files::folder().join(&file)));
            let wrong = (0..expected.grid().voxel_count()).find(|&n| found.value(n) != expected.value(n));
            assert_eq!(wrong, None, "{file}");
        }
    }

    #[test]
    fn complex_samples_are_named() {
        for format in [5, 6] {
            let (_temporary, path) = changed("tiff/float64.tif", |bytes| with(bytes, &[(0, 339, format)]));
            refused(
                &path,
                "complex samples",
                "its samples are complex numbers, and a voxel has one number: save their magnitude",
            );
        }
    }

    /// Slides and confocal stacks have small pictures of their pages between them.
    #[test]
    fn previews_are_no_slices() {
        let (_temporary, path) = changed("tiff/uint8.tif", |bytes| {
            // Replaces the tag of the resolution unit.
            let at = entry(bytes, 1, 296);
            bytes[at..at + 2].copy_from_slice(&254u16.to_le_bytes());
            with(bytes, &[(1, 254, 1)]);
        });
        let volume = Volume::open(&path, &OpenOptions::default()).unwrap();
        assert_eq!(volume.grid().dims(), [5, 4, 2]);
    }
}

#[test]
fn folders_without_slices_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let message = |path: &Path| Volume::open(path, &OpenOptions::default()).unwrap_err().to_string();
    assert!(message(folder.path()).contains("no numbered"));
    assert!(message(&folder.path().join("s%d.png")).contains("no files match"));
}
