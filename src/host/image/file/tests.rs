use super::*;
use crate::image::read_image;
use std::collections::BTreeMap;

fn frame() -> Frame {
    let pixels = vec![
        [0.0; 4],
        [0.25, 0.0, 0.5, 0.5],
        [1.0, 1.0, 1.0, 1.0],
        [0.1, 0.2, 0.3, 0.4],
        [0.0, 0.0, 0.0, 1.0],
        [0.5, 0.5, 0.5, 0.75],
    ];
    Frame::new(Viewport::new(3, 2).unwrap(), pixels)
}

#[test]
fn files_come_back_as_they_were_written() {
    let folder = tempfile::tempdir().unwrap();
    let npy = folder.path().join("a.npy");
    frame().save(&npy, None).unwrap();
    assert_eq!(read_image(&npy).unwrap(), frame());
    let png = folder.path().join("a.png");
    frame().save(&png, Some(Background::Transparent)).unwrap();
    assert!(read_image(&png).unwrap().compare(&frame()).unwrap().max_difference < 1.0 / 255.0);
    frame().save(&png, None).unwrap();
    let over_black = read_image(&png).unwrap();
    assert!(over_black.pixels().iter().all(|p| p[3] == 1.0));
    let exr = folder.path().join("a.exr");
    frame().save(&exr, None).unwrap();
    assert_eq!(read_image(&exr).unwrap(), frame());
    frame().save(&exr, Some(Background::Color([0.0, 0.0, 1.0]))).unwrap();
    assert_eq!(read_image(&exr).unwrap(), frame().over(Background::Color([0.0, 0.0, 1.0])));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3, "no temporary files may be left");
}

/// Largest error of smooth gradients in JPEG, relative to 1: coefficients are rounded by a few steps of 255.
const JPEG_ERROR: f64 = 0.025;

#[test]
fn jpeg_stands_on_a_colour() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.jpeg");
    let ramp = |n: usize| [(n % 32) as f32 / 64.0, (n / 32) as f32 / 64.0, 0.2, 0.5];
    let smooth = Frame::new(Viewport::new(32, 24).unwrap(), (0..32 * 24).map(ramp).collect());
    for background in [None, Some(Background::Color([1.0, 0.5, 0.0]))] {
        smooth.save(&path, background).unwrap();
        let expected = smooth.clone().over(background.unwrap_or(Background::BLACK));
        let found = read_image(&path).unwrap().compare(&expected).unwrap().max_difference;
        assert!(found < JPEG_ERROR, "{background:?}: {found}");
    }
    std::fs::remove_file(&path).unwrap();
    let refused = smooth.save(&path, Some(Background::Transparent)).unwrap_err();
    assert!(refused.to_string().contains("not support transparency") && refused.fields() == ["background"], "{refused}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn truncated_files_are_refused_at_any_length() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.npy", "a.png", "a.exr", "a.jpg", "a.webp"] {
        let path = folder.path().join(name);
        frame().save(&path, None).unwrap();
        let whole = std::fs::read(&path).unwrap();
        // The last 12 bytes of a PNG are an empty end chunk, which decoders may ignore. They may also tolerate a few missing bytes in a JPEG.
        let needed = if name == "a.jpg" { header_of(&whole) } else { whole.len() - 12 };
        for length in 0..needed {
            std::fs::write(&path, &whole[..length]).unwrap();
            assert!(read_image(&path).is_err(), "{name} at {length} of {}", whole.len());
        }
    }
}

/// Bytes of a JPEG before its coefficients.
fn header_of(jpeg: &[u8]) -> usize {
    jpeg.windows(2).position(|marker| marker == [0xff, 0xda]).unwrap()
}

#[cfg(unix)]
#[test]
fn links_lead_to_what_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let (target, link) = (folder.path().join("a.npy"), folder.path().join("link.npy"));
    frame().save(&target, Some(Background::BLACK)).unwrap();
    std::os::unix::fs::symlink(&target, &link).unwrap();
    frame().save(&link, None).unwrap();
    assert!(link.is_symlink());
    assert_eq!(read_image(&target).unwrap(), frame());
}

#[test]
fn unwritable_places_leave_nothing() {
    let folder = tempfile::tempdir().unwrap();
    assert!(frame().save(folder.path().join("missing/a.png"), None).is_err());
    assert!(frame().save(folder.path().join("a.bmp"), None).is_err());
    let lost = Frame::new(Viewport::new(3, 2).unwrap(), frame().pixels().iter().map(|p| [f32::NAN, p[1], p[2], p[3]]).collect());
    let unfinished = folder.path().join("nan.npy");
    lost.save(&unfinished, None).unwrap();
    assert!(read_image(&unfinished).unwrap_err().to_string().contains("6 of its numbers"));
    std::fs::remove_file(unfinished).unwrap();
    std::fs::create_dir(folder.path().join("b.png")).unwrap();
    assert!(frame().save(folder.path().join("b.png"), None).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// The chunks of a PNG: names and contents.
fn chunks(png: &[u8]) -> Vec<(String, Vec<u8>)> {
    let mut rest = &png[8..];
    let mut chunks = Vec::new();
    while let [a, b, c, d, after @ ..] = rest {
        let length = u32::from_be_bytes([*a, *b, *c, *d]) as usize;
        chunks.push((String::from_utf8(after[..4].to_vec()).unwrap(), after[4..4 + length].to_vec()));
        rest = &after[4 + length + 4..];
    }
    chunks
}

fn chunk(png: &[u8], name: &str) -> Option<Vec<u8>> {
    chunks(png).into_iter().find(|(found, _)| found == name).map(|(_, content)| content)
}

fn encoded(frame: &Frame, name: &str, background: Option<Background>, encoding: Encoding) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    frame.save_encoded(&path, background, &encoding, None).unwrap();
    std::fs::read(path).unwrap()
}

const SIXTEEN: Encoding = Encoding { bits: Some(BitDepth::Sixteen), dither: false, dpi: None, description: None };

fn at(dpi: u16) -> Encoding {
    Encoding { dpi: NonZeroU16::new(dpi), ..Encoding::default() }
}

/// Chunks of PNGs, by their bytes: sRGB with perceptual intent before the pixels, and a resolution only if given.
#[test]
fn pngs_say_srgb_and_their_resolution() {
    for encoding in [Encoding::default(), SIXTEEN, at(300)] {
        let png = encoded(&frame(), "a.png", None, encoding.clone());
        let names: Vec<String> = chunks(&png).into_iter().map(|(name, _)| name).collect();
        let first = |name: &str| names.iter().position(|found| found == name);
        assert!(first("sRGB").unwrap() < first("IDAT").unwrap(), "{names:?}");
        assert_eq!(chunk(&png, "sRGB").unwrap(), [0]);
        let header = chunk(&png, "IHDR").unwrap();
        assert_eq!(header[8..10], [if encoding == SIXTEEN { 16 } else { 8 }, 6], "bits and colour type");
        // 300 / 0.0254 = 11811.02 pixels per metre, unit 1.
        let density = encoding.dpi.map(|_| [11_811_u32.to_be_bytes().as_slice(), &11_811_u32.to_be_bytes(), &[1]].concat());
        assert_eq!(chunk(&png, "pHYs"), density);
    }
}

/// A description, with letters beyond ASCII, comes back from PNG and OpenEXR; without one, nothing is written.
#[test]
fn descriptions_are_metadata() {
    use exr::prelude::{ReadChannels, ReadLayers, read};
    let text = "layersplat render größe.raw";
    let described = Encoding { description: Some(text.into()), ..Encoding::default() };
    let png = encoded(&frame(), "a.png", None, described.clone());
    let texts: Vec<_> = chunks(&png).into_iter().filter(|(name, _)| name == "iTXt").map(|(_, content)| content).collect();
    let holds =
        |keyword: &str, value: &str| texts.iter().any(|t| t.starts_with(keyword.as_bytes()) && t.ends_with(value.as_bytes()));
    assert!(holds("Description\0", text) && holds("Software\0", env!("CARGO_PKG_VERSION")), "{texts:?}");
    assert_eq!(chunk(&encoded(&frame(), "a.png", None, Encoding::default()), "iTXt"), None);

    let exr = encoded(&frame(), "a.exr", None, described);
    let image = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let comments = image.from_buffered(std::io::Cursor::new(exr)).unwrap().layer_data.attributes.comments.unwrap();
    assert_eq!(comments.to_string(), text);
}

/// Entries of the first directory of a little-endian TIFF: tag, type, count, and the four bytes of the value.
fn tags(tiff: &[u8]) -> BTreeMap<u16, (u16, u32, [u8; 4])> {
    assert_eq!(tiff[..4], *b"II*\0");
    let short = |at: usize| u16::from_le_bytes(tiff[at..at + 2].try_into().unwrap());
    let long = |at: usize| u32::from_le_bytes(tiff[at..at + 4].try_into().unwrap());
    let first = long(4) as usize;
    let entry = |n: usize| first + 2 + 12 * n;
    let bytes = |at: usize| tiff[at..at + 4].try_into().unwrap();
    (0..short(first).into()).map(|n| (short(entry(n)), (short(entry(n) + 2), long(entry(n) + 4), bytes(entry(n) + 8)))).collect()
}

/// Resolutions of JPEG, TIFF and OpenEXR, by their bytes.
#[test]
fn other_formats_hold_their_resolution() {
    // JFIF: unit 1, dots per inch, across and down.
    let jpeg = encoded(&frame(), "a.jpg", None, at(600));
    let start = jpeg.windows(5).position(|word| word == b"JFIF\0").unwrap();
    assert_eq!(jpeg[start + 7..start + 12], [1, 2, 88, 2, 88]);
    let exr = encoded(&frame(), "a.exr", None, at(600));
    let name = b"xDensity\0float\0\x04\0\0\0";
    let start = exr.windows(name.len()).position(|word| word == name).unwrap() + name.len();
    assert_eq!(f32::from_le_bytes(exr[start..start + 4].try_into().unwrap()), 600.0);
    assert!(!encoded(&frame(), "a.exr", None, Encoding::default()).windows(8).any(|word| word == b"xDensity"));
    if cfg!(feature = "tiff") {
        let tiff = encoded(&frame(), "a.tif", None, at(600));
        let tags = tags(&tiff);
        for tag in [282, 283] {
            let (kind, count, place) = tags[&tag];
            let place = u32::from_le_bytes(place) as usize;
            assert_eq!((kind, count, &tiff[place..place + 8]), (5, 1, [88, 2, 0, 0, 1, 0, 0, 0].as_slice()), "{tag}");
        }
        // Inches.
        assert_eq!(tags[&296].2[..2], [2, 0]);
    }
}

/// Samples per pixel, bits and the kind of alpha of TIFF.
#[cfg(feature = "tiff")]
#[test]
fn tiffs_say_what_they_hold() {
    for (background, samples) in [(None, 3), (Some(Background::Transparent), 4)] {
        for (encoding, bits) in [(Encoding::default(), 8), (SIXTEEN, 16)] {
            let tiff = encoded(&frame(), "a.tiff", background, encoding);
            let tags = tags(&tiff);
            assert_eq!(tags[&277].2[0], samples, "samples per pixel");
            let (kind, count, place) = tags[&258];
            let place = u32::from_le_bytes(place) as usize;
            assert_eq!((kind, count, tiff[place]), (3, samples.into(), bits), "bits per sample");
            // 2: unassociated alpha.
            assert_eq!(tags.get(&338).map(|tag| tag.2[0]), (samples == 4).then_some(2));
            assert_eq!(tags[&262].2[0], 2, "RGB");
        }
    }
}

/// Formats without loss come back as the rounded numbers of the frame.
#[test]
fn integers_come_back_as_they_were_written() {
    let (transparent, blue) = (Background::Transparent, Background::Color([0.0, 0.0, 1.0]));
    for name in ["a.png", "a.tif", "a.webp"] {
        if name == "a.tif" && cfg!(not(feature = "tiff")) {
            continue;
        }
        for background in [transparent, blue] {
            let bytes = encoded(&frame(), name, Some(background), Encoding::default());
            let found = image::load_from_memory(&bytes).unwrap().into_rgba8().into_raw();
            assert!(found == frame().to_rgba8(background), "{name}, {background:?}");
            if name == "a.webp" {
                continue;
            }
            let deep = encoded(&frame(), name, Some(background), SIXTEEN);
            let found = image::load_from_memory(&deep).unwrap();
            assert!(matches!(found.color(), image::ColorType::Rgba16 | image::ColorType::Rgb16));
            let expected: Vec<u16> = frame()
                .pixels()
                .iter()
                .flat_map(|&pixel| display::straight(pixel, background))
                .map(|c| (f64::from(c) * 65_535.0).round() as u16)
                .collect();
            assert!(found.into_rgba16().into_raw() == expected, "{name}, {background:?}: 16 bits");
        }
    }
}

/// Constant shades keep their mean, to the 4096 thresholds of the pattern, and exact bytes stay; rounding is off by up to half a step.
#[test]
fn dithered_shades_keep_their_mean() {
    const SIDE: u32 = 64;
    let dither = Encoding { dither: true, ..Encoding::default() };
    let shade = |value: f32| Frame::new(Viewport::new(SIDE, SIDE).unwrap(), vec![[value, 0.0, 1.0, 1.0]; (SIDE * SIDE) as usize]);
    let mean = |value: f32, encoding| {
        let bytes = image::load_from_memory(&encoded(&shade(value), "a.png", None, encoding)).unwrap().into_rgba8();
        assert!(bytes.pixels().all(|p| p.0[1..] == [0, 255, 255]), "exact bytes stay");
        bytes.pixels().map(|p| f64::from(p[0])).sum::<f64>() / f64::from(SIDE * SIDE)
    };
    let (mut worst, mut rounded) = (0.0_f64, 0.0_f64);
    for value in [0.2, 0.301, 0.4999, 0.7123, 0.9] {
        let exact = f64::from(value) * 255.0;
        worst = worst.max((mean(value, dither.clone()) - exact).abs());
        rounded = rounded.max((mean(value, Encoding::default()) - exact).abs());
    }
    assert!(worst <= 1.0 / 4096.0 && rounded > 0.2, "{worst}, {rounded}");
    for n in 0..=255_u8 {
        assert_eq!(mean(f32::from(n) / 255.0, dither.clone()), f64::from(n));
    }
}
