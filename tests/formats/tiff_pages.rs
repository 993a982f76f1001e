//! TIFF files whose pages are stored in unusual ways, written by the tests.

use crate::refused::refused;
use layersplat::volume::{Contents, OpenOptions, Volume};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Sides of a page, and of its tiles, which stick out of it.
const WIDTH: usize = 21;
const HEIGHT: usize = 18;
const TILE: usize = 16;

/// A tag: its number, and 16-bit numbers, or 32-bit ones if they do not fit, or text.
enum Tag<'a> {
    Numbers(u16, Vec<u32>),
    Text(u16, &'a str),
}

/// A little-endian file of pages, each with its tags and its strips or tiles.
fn file(pages: &[(Vec<Tag>, Vec<Vec<u8>>)], is_tiled: bool) -> Vec<u8> {
    let mut bytes = b"II*\0\0\0\0\0".to_vec();
    let mut last = 4;
    for (tags, chunks) in pages {
        let [mut offsets, mut counts] = [Vec::new(), Vec::new()];
        for chunk in chunks {
            offsets.push(bytes.len() as u32);
            counts.push(chunk.len() as u32);
            bytes.extend_from_slice(chunk);
        }
        let [at, len] = if is_tiled { [324, 325] } else { [273, 279] };
        let stored = [Tag::Numbers(at, offsets), Tag::Numbers(len, counts)];
        let mut entries: Vec<(u16, u16, u32, Vec<u8>)> = tags
            .iter()
            .chain(&stored)
            .map(|tag| match tag {
                Tag::Text(tag, text) => (*tag, 2, text.len() as u32 + 1, [text.as_bytes(), b"\0"].concat()),
                Tag::Numbers(tag, numbers) if *tag != at && numbers.iter().all(|&n| n < 65536) => {
                    (*tag, 3, numbers.len() as u32, numbers.iter().flat_map(|&n| (n as u16).to_le_bytes()).collect())
                }
                Tag::Numbers(tag, numbers) => {
                    (*tag, 4, numbers.len() as u32, numbers.iter().flat_map(|n| n.to_le_bytes()).collect())
                }
            })
            .collect();
        entries.sort_by_key(|entry| entry.0);
        for (_, _, _, value) in &mut entries {
            if value.len() > 4 {
                let at = bytes.len() as u32;
                bytes.append(value);
                *value = at.to_le_bytes().to_vec();
            }
            value.resize(4, 0);
        }
        let directory = bytes.len() as u32;
        bytes[last..last + 4].copy_from_slice(&directory.to_le_bytes());
        bytes.extend((entries.len() as u16).to_le_bytes());
        for (tag, kind, count, value) in entries {
            bytes.extend([&tag.to_le_bytes()[..], &kind.to_le_bytes(), &count.to_le_bytes(), &value].concat());
        }
        last = bytes.len();
        bytes.extend([0; 4]);
    }
    bytes
}

fn numbers<'a>(pairs: &[(u16, u32)]) -> Vec<Tag<'a>> {
    pairs.iter().map(|&(tag, number)| Tag::Numbers(tag, vec![number])).collect()
}

const SIZE: [(u16, u32); 2] = [(256, WIDTH as u32), (257, HEIGHT as u32)];

fn written(bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

fn open(path: &Path, options: &OpenOptions) -> Volume<'static> {
    Volume::open(path, options).unwrap_or_else(|e| panic!("{e}"))
}

fn channel(channel: usize) -> OpenOptions {
    OpenOptions { channel: Some(channel), ..OpenOptions::default() }
}

fn value(x: usize, y: usize, sample: usize) -> u8 {
    (7 * x + 11 * y + 50 * sample) as u8
}

/// Codes of nine bits: the code that clears the table often enough, each byte by itself, and, as many writers, no code at the end.
fn lzw(bytes: &[u8]) -> Vec<u8> {
    let mut codes = Vec::new();
    for some in bytes.chunks(200) {
        codes.push(256);
        codes.extend(some.iter().map(|&byte| u16::from(byte)));
    }
    let bits: Vec<u16> = codes.iter().flat_map(|code| (0..9).rev().map(move |bit| code >> bit & 1)).collect();
    bits.chunks(8).map(|byte| byte.iter().enumerate().map(|(n, bit)| (bit << (7 - n)) as u8).sum()).collect()
}

fn deflate(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// Bytes by themselves.
fn pack_bits(bytes: &[u8]) -> Vec<u8> {
    bytes.chunks(100).flat_map(|some| [&[some.len() as u8 - 1][..], some].concat()).collect()
}

type Packed = (u32, fn(&[u8]) -> Vec<u8>);

const METHODS: [Packed; 4] = [(1, |bytes| bytes.to_vec()), (5, lzw), (8, deflate), (32773, pack_bits)];

/// The numbers of a tile or strip of some samples, the differences along rows if `differences`.
fn chunk(left: usize, top: usize, [width, height]: [usize; 2], samples: &[usize], differences: bool) -> Vec<u8> {
    let mut bytes = Vec::new();
    for y in top..top + height {
        for x in left..left + width {
            for &sample in samples {
                let before = if differences && x > left { value(x - 1, y, sample) } else { 0 };
                bytes.push(value(x, y, sample).wrapping_sub(before));
            }
        }
    }
    bytes
}

/// Each sample of a pixel is a channel, whatever the samples mean and however they are stored.
#[test]
fn samples_are_channels_however_they_are_stored() {
    for (samples, photometric, extra) in [(3, 2, 0), (4, 2, 0), (4, 2, 1), (4, 2, 2), (6, 2, 0), (2, 1, 0), (5, 1, 0)] {
        for is_planar in [false, true] {
            for is_tiled in [false, true] {
                for (method, packed) in METHODS {
                    let differences = [5, 8].contains(&method) && samples != 4;
                    let colours = if photometric == 2 { 3 } else { 1 };
                    let mut tags = numbers(&SIZE);
                    tags.extend(numbers(&[(258, 8), (259, method), (262, photometric), (277, samples as u32)]));
                    tags.extend(numbers(&[(284, 1 + u32::from(is_planar)), (317, 1 + u32::from(differences))]));
                    tags.push(Tag::Numbers(338, vec![extra; samples - colours]));
                    let side = if is_tiled { [TILE, TILE] } else { [WIDTH, 5] };
                    tags.extend(if is_tiled { numbers(&[(322, TILE as u32), (323, TILE as u32)]) } else { numbers(&[(278, 5)]) });
                    let planes: Vec<Vec<usize>> =
                        if is_planar { (0..samples).map(|n| vec![n]).collect() } else { vec![(0..samples).collect()] };
                    let mut chunks = Vec::new();
                    for plane in &planes {
                        for top in (0..HEIGHT).step_by(side[1]) {
                            for left in (0..WIDTH).step_by(side[0]) {
                                let height = if is_tiled { TILE } else { side[1].min(HEIGHT - top) };
                                chunks.push(packed(&chunk(left, top, [side[0], height], plane, differences)));
                            }
                        }
                    }
                    let (_folder, path) = written(&file(&[(tags, chunks)], is_tiled));
                    let what = format!("{samples} samples, extra {extra}, planar {is_planar}, tiled {is_tiled}, method {method}");
                    for sample in 0..samples {
                        let volume = open(&path, &channel(sample));
                        assert_eq!((volume.grid().dims(), volume.contents().channels), ([WIDTH, HEIGHT, 1], samples), "{what}");
                        let expected = |i: usize| f64::from(value(i % WIDTH, i / WIDTH, sample));
                        assert_eq!(
                            (0..WIDTH * HEIGHT).find(|&i| volume.value(i) != expected(i)),
                            None,
                            "{what}, sample {sample}"
                        );
                    }
                }
            }
        }
    }
}

/// Pages of one strip with 8 bits, one of which has the values `z`, `z` + 1, …
fn pages<'a>(count: usize, description: &'a str) -> Vec<(Vec<Tag<'a>>, Vec<Vec<u8>>)> {
    let page = |z: usize| {
        let mut tags = numbers(&SIZE);
        tags.extend(numbers(&[(258, 8), (259, 1), (262, 1), (278, HEIGHT as u32)]));
        tags.extend((z == 0).then_some(Tag::Text(270, description)));
        (tags, vec![vec![z as u8; WIDTH * HEIGHT]])
    };
    (0..count).map(page).collect()
}

/// The pages of a frame and channel.
fn slices(path: &Path, frame: usize, channel: usize) -> Vec<f64> {
    let volume = open(path, &OpenOptions { frame: Some(frame), channel: Some(channel), ..OpenOptions::default() });
    (0..volume.grid().dims()[2]).map(|z| volume.value(z * WIDTH * HEIGHT)).collect()
}

#[test]
fn descriptions_order_pages() {
    let (_folder, path) = written(&file(&pages(12, r#"{"shape": [2, 3, 2, 18, 21], "axes": "TZCYX"}"#), false));
    assert_eq!((slices(&path, 0, 0), slices(&path, 1, 1)), (vec![0.0, 2.0, 4.0], vec![7.0, 9.0, 11.0]));
    let (_folder, path) = written(&file(&pages(6, "ImageJ=1.5\nimages=6\nchannels=2\nslices=3\norder=zct\n"), false));
    assert_eq!(slices(&path, 0, 1), [3.0, 4.0, 5.0]);
    let (_folder, path) = written(&file(&pages(5, r#"{"shape": [6, 18, 21]}"#), false));
    refused(&path, "missing pages", "its description declares 6 pages, and it has 5: it is truncated");
}

/// OME-XML of three slices and two channels, whose planes are where `data` says.
fn ome(data: &str) -> String {
    format!(
        "<OME UUID='urn:uuid:own'><Image Name='a'><Pixels DimensionOrder='XYZCT' SizeZ='3' SizeC='2' SizeT='1'>{data}</Pixels></Image>\
         <Image Name='other'><Pixels DimensionOrder='XYZCT' SizeZ='1' SizeC='1' SizeT='1'><TiffData IFD='6'/></Pixels></Image></OME>"
    )
}

#[test]
fn planes_of_ome_are_the_pages_that_it_tells() {
    let told = [5, 1, 3, 0, 2, 4];
    let data: Vec<String> =
        (0..6).map(|n| format!("<TiffData FirstC='{}' FirstZ='{}' IFD='{}'/>", n / 3, n % 3, told[n])).collect();
    let (_folder, path) = written(&file(&pages(7, &ome(&data.concat())), false));
    assert_eq!((slices(&path, 0, 0), slices(&path, 0, 1)), (vec![5.0, 1.0, 3.0], vec![0.0, 2.0, 4.0]));
    let other = open(&path, &OpenOptions { array: Some("other".into()), ..OpenOptions::default() });
    assert_eq!((other.grid().dims()[2], other.value(0)), (1, 6.0));
    refused_with(&path, &OpenOptions { array: Some("third".into()), ..OpenOptions::default() }, "whose arrays are a, other");
}

#[track_caller]
fn refused_with(path: &Path, options: &OpenOptions, words: &str) {
    let message = Volume::open(path, options).unwrap_err().to_string();
    assert!(message.contains(words), "{message}");
}

#[test]
fn planes_of_ome_may_be_in_other_files() {
    let folder = tempfile::tempdir().unwrap();
    let data = "<TiffData IFD='0' PlaneCount='3'><UUID FileName='a.tif'>urn:uuid:own</UUID></TiffData>\
                <TiffData IFD='1' FirstC='1' PlaneCount='3'><UUID FileName='b.tif'>urn:uuid:b</UUID></TiffData>";
    let own = folder.path().join("a.tif");
    std::fs::write(&own, file(&pages(3, &ome(data)), false)).unwrap();
    assert_eq!(slices(&own, 0, 0), [0.0, 1.0, 2.0]);
    refused_with(&own, &channel(1), "its OME-XML names the file b.tif, which is missing: put it into the same folder");
    std::fs::write(folder.path().join("b.tif"), file(&pages(4, ""), false)).unwrap();
    assert_eq!(slices(&own, 0, 1), [1.0, 2.0, 3.0]);
    // Files that are dropped together onto the viewer's page come in a folder.
    assert_eq!(slices(folder.path(), 0, 1), [1.0, 2.0, 3.0]);
    std::fs::write(folder.path().join("b.tif"), file(&pages(3, ""), false)).unwrap();
    refused_with(&own, &channel(1), "declares a plane 5 that has no page: it is incomplete");
    let outside = data.replace("b.tif", "../b.tif");
    std::fs::write(&own, file(&pages(3, &ome(&outside)), false)).unwrap();
    refused_with(&own, &channel(1), "../b.tif, which is not a file of the same folder");
}

#[test]
fn indices_of_palettes_are_values() {
    let palette: Vec<u32> = (0..3).flat_map(|part| (0..16).map(move |n| (part * 1000 + n) * 17)).collect();
    let page = |palette: Vec<u32>| {
        let mut tags = numbers(&SIZE);
        tags.extend(numbers(&[(258, 4), (259, 1), (262, 3), (278, HEIGHT as u32)]));
        tags.push(Tag::Numbers(320, palette));
        // Two pixels in a byte, and half a byte at the end of each row.
        (tags, vec![[0x12, 0x3f].into_iter().cycle().take(WIDTH.div_ceil(2) * HEIGHT).collect()])
    };
    let (_folder, path) = written(&file(&[page(palette.clone()), page(palette.clone())], false));
    let volume = open(&path, &OpenOptions::default());
    assert_eq!([0, 1, 2, 3, 20].map(|x| volume.value(x)), [1.0, 2.0, 3.0, 15.0, 1.0]);
    let Contents { palette: found, .. } = volume.contents();
    let expected = [0, 1, 2].map(|part| f64::from((part * 1000 + 5) * 17) / 65535.0);
    assert_eq!((found.len(), found[5]), (16, expected));
    let mut other = palette.clone();
    other[3] = 0;
    let (_folder, path) = written(&file(&[page(palette), page(other)], false));
    refused(&path, "another palette", "page 1 has another palette than the first, so that equal numbers mean different colours");
}

/// Twelve bits per number, one bit per number from the lowest on, and a strip of zeros that is left out.
#[test]
fn bits_are_numbers() {
    let page = |pairs: &[(u16, u32)], bytes: Vec<u8>| {
        let mut tags = numbers(&SIZE);
        tags.extend(numbers(&[(259, 1), (262, 1), (278, HEIGHT as u32)]));
        tags.extend(numbers(pairs));
        written(&file(&[(tags, vec![bytes])], false))
    };
    let row: Vec<u8> = [0x12, 0x3a, 0xbc].into_iter().cycle().take((12 * WIDTH).div_ceil(8)).collect();
    let (_folder, path) = page(&[(258, 12)], row.repeat(HEIGHT));
    assert_eq!(
        [0, 1, 2, WIDTH].map(|i| open(&path, &OpenOptions::default()).value(i)),
        [0x123, 0xabc, 0x123, 0x123].map(f64::from)
    );
    let (_folder, path) = page(&[(258, 1), (266, 2)], [0b0000_0101, 0, 0].repeat(HEIGHT));
    assert_eq!([0, 1, 2, 3, WIDTH].map(|i| open(&path, &OpenOptions::default()).value(i)), [1.0, 0.0, 1.0, 0.0, 1.0]);
    let (_folder, path) = page(&[(258, 8)], Vec::new());
    assert_eq!(open(&path, &OpenOptions::default()).range(), (0.0, 0.0));
}
