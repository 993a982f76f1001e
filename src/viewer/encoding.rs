//! Pictures as bytes: JPEG while something moves, PNG at rest.

use super::replies::Format;
use crate::error::Error;
use crate::image::Background;
use crate::viewport::Viewport;
use jpeg_encoder::{ColorType, Encoder, SamplingFactor};
use std::io;
use std::path::Path;

/// JPEG quality of moving pictures, up to 100: a page of 768² takes about 60 kB.
const MOVING_QUALITY: u8 = 80;
/// Longest side of a JPEG file.
const LONGEST_SIDE: u32 = 65_535;

/// Encodes a picture of 8-bit RGBA. Without a background only PNG keeps the opacity.
pub(super) fn encoded(rgba: &[u8], size: Viewport, background: Background, moving: bool) -> Result<(Format, Vec<u8>), Error> {
    let opaque = background != Background::Transparent;
    if moving && opaque && size.width.max(size.height) <= LONGEST_SIDE { jpeg(rgba, size) } else { png(rgba, size, opaque) }
}

fn jpeg(rgba: &[u8], size: Viewport) -> Result<(Format, Vec<u8>), Error> {
    let mut bytes = Vec::with_capacity(size.pixels() / 4);
    let mut encoder = Encoder::new(&mut bytes, MOVING_QUALITY);
    encoder.set_sampling_factor(SamplingFactor::F_2_2);
    let [width, height] = [size.width, size.height].map(|side| side as u16);
    encoder.encode(rgba, width, height, ColorType::Rgba).map_err(failed)?;
    Ok((Format::Jpeg, bytes))
}

fn png(rgba: &[u8], size: Viewport, opaque: bool) -> Result<(Format, Vec<u8>), Error> {
    let mut bytes = Vec::with_capacity(size.pixels());
    let mut encoder = png::Encoder::new(&mut bytes, size.width, size.height);
    encoder.set_color(if opaque { png::ColorType::Rgb } else { png::ColorType::Rgba });
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header().map_err(failed)?;
    if opaque {
        let rgb: Vec<u8> = rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        writer.write_image_data(&rgb).map_err(failed)?;
    } else {
        writer.write_image_data(rgba).map_err(failed)?;
    }
    writer.finish().map_err(failed)?;
    Ok((Format::Png, bytes))
}

fn failed(error: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Error {
    Error::write(Path::new("the page's picture"), io::Error::other(error))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A smooth picture, half transparent.
    fn picture(size: Viewport) -> Vec<u8> {
        let pixel = |n: usize| [(n % size.width as usize) as u8, (n / size.width as usize) as u8, 90, 128];
        (0..size.pixels()).flat_map(pixel).collect()
    }

    #[test]
    fn png_keeps_every_bit() {
        let size = Viewport { width: 37, height: 21 };
        for (background, channels) in [(Background::BLACK, 3), (Background::Transparent, 4)] {
            let (format, bytes) = encoded(&picture(size), size, background, false).unwrap();
            assert_eq!(format, Format::Png);
            let image = image::load_from_memory(&bytes).unwrap();
            assert_eq!(image.color().channel_count(), channels);
            let expected: Vec<u8> =
                picture(size).chunks_exact(4).flat_map(|pixel| pixel[..usize::from(channels)].to_vec()).collect();
            assert_eq!(image.into_bytes(), expected);
        }
    }

    #[test]
    fn moving_pictures_are_subsampled_jpegs_unless_transparent() {
        /// Of 8-bit steps, for a smooth picture.
        const LOSS: u8 = 6;
        let size = Viewport { width: 64, height: 48 };
        let (format, bytes) = encoded(&picture(size), size, Background::BLACK, true).unwrap();
        assert_eq!(format, Format::Jpeg);
        // The frame header lists the sampling factors of each component: 2×2 of luminance, 1×1 of the others.
        let frame = bytes.windows(2).position(|marker| marker == [0xff, 0xc0]).unwrap();
        assert_eq!([11, 14, 17].map(|at| bytes[frame + at]), [0x22, 0x11, 0x11]);
        let decoded = image::load_from_memory(&bytes).unwrap().into_rgb8();
        for (pixel, original) in decoded.pixels().zip(picture(size).chunks_exact(4)) {
            assert!((0..3).all(|c| pixel.0[c].abs_diff(original[c]) <= LOSS), "{pixel:?} of {original:?}");
        }
        assert_eq!(encoded(&picture(size), size, Background::Transparent, true).unwrap().0, Format::Png);
    }
}
