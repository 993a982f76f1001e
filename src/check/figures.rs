//! Expected pictures, and the comparison of rendered pictures with them.

use super::Family;
use super::pictures::{SIZE, VIEWS};
use crate::color::Curve;
use crate::image::{Background, Frame};
use std::sync::LazyLock;

/// Premultiplied 16-bit RGBA: a row of pictures per family, a column per view. `truth.rs` computes them in `f64` on the host, independent
/// of any device. Scattered light in cells has no such reference: the studio's pictures are those of a device on which they are near the path
/// tracer's. `cargo test --lib figures -- --ignored` writes the file.
const FILE: &[u8] = include_bytes!("figures.png");

/// Largest accepted difference of a channel: two 8-bit steps.
///
/// Devices differ from the reference by approximations: tables of 4096 entries, footprints by quadrature, slicing's 256 values. For these
/// pictures that is at most half a step on PoCL and Intel (the tests allow one); the rest is a margin for other floating-point
/// implementations. A lattice warped by a tenth of a pixel is off by five steps.
pub const TOLERANCE: f64 = 2.0 / 255.0;

/// Half an 8-bit step: additional tolerance of displayed pictures.
const ROUNDING: f64 = 0.5 / 255.0;

/// Background of displayed pictures, different from black and white in all channels.
pub(super) const BACKGROUND: Background = Background::Color([0.2, 0.4, 0.8]);

static SHEET: LazyLock<Vec<[f32; 4]>> = LazyLock::new(|| {
    let sheet =
        image::load_from_memory_with_format(FILE, image::ImageFormat::Png).expect("figures.png is a picture").into_rgba16();
    assert_eq!(
        sheet.dimensions(),
        (columns() as u32, (Family::Surfaces as u32 + 1) * SIZE.height),
        "figures.png has an unexpected size"
    );
    sheet.pixels().map(|pixel| pixel.0.map(|c| f32::from(c) / f32::from(u16::MAX))).collect()
});

/// Width of the sheet in pixels.
fn columns() -> usize {
    VIEWS * SIZE.width as usize
}

/// The expected picture of view `n` of a family.
pub(super) fn expected(family: Family, n: usize) -> Frame {
    let (width, height) = (SIZE.width as usize, SIZE.height as usize);
    let row = |y: usize| (family as usize * height + y) * columns() + n * width;
    Frame::new(SIZE, (0..height).flat_map(|y| &SHEET[row(y)..][..width]).copied().collect())
}

/// Largest difference of any channel of any pixel; infinite for NaN.
pub(super) fn difference(found: &Frame, expected: &Frame) -> f64 {
    found.compare(expected).map_or(f64::INFINITY, |comparison| comparison.max_difference)
}

/// Largest difference of a picture displayed over [`BACKGROUND`] after a curve, minus the error of rounding to 8 bits.
pub(super) fn displayed_difference(found: &[u8], expected: &Frame, curve: Curve) -> f64 {
    if found.len() != 4 * SIZE.pixels() {
        return f64::INFINITY;
    }
    let found = found.chunks_exact(4).map(|pixel| std::array::from_fn(|c| f32::from(pixel[c]) / 255.0)).collect();
    let expected = expected.clone().with_curve(curve).curved().into_owned();
    (difference(&Frame::new(SIZE, found), &expected.over(BACKGROUND)) - ROUNDING).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::super::pictures::{Picture, transfer, views, volume};
    use super::super::truth::drawn;
    use super::*;
    use crate::reference::{PathTracer, against_halves};
    use image::{ImageBuffer, Rgba};
    use std::path::Path;

    /// The lowest bits are irrelevant to the comparison and do not compress: 12 of 16 are kept.
    const KEPT: u16 = !15;

    fn sheet() -> ImageBuffer<Rgba<u16>, Vec<u16>> {
        let frames: Vec<Vec<Frame>> =
            Family::ALL.iter().map(|&family| views(family).iter().map(|picture| drawn(family, picture)).collect()).collect();
        ImageBuffer::from_fn(columns() as u32, Family::ALL.len() as u32 * SIZE.height, |x, y| {
            let frame = &frames[(y / SIZE.height) as usize][(x / SIZE.width) as usize];
            let pixel = frame.pixel(x % SIZE.width, y % SIZE.height);
            assert!(pixel.iter().all(|c| (0.0..=1.0).contains(c)), "{pixel:?} cannot be stored");
            Rgba(pixel.map(|c| ((c * 65535.0 + 8.0) as u16) & KEPT))
        })
    }

    #[test]
    #[ignore = "writes src/check/figures.png, needed after a change of the pictures"]
    fn write_figures() {
        sheet().save(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/check/figures.png")).unwrap();
    }

    #[test]
    fn figures_are_the_references() {
        let stored = image::load_from_memory(FILE).unwrap().into_rgba16();
        let new = sheet();
        assert_eq!(stored.dimensions(), new.dimensions());
        // Another libm may round the last kept bit differently, and another device a word of the light field.
        let allowed = |y: u32| if y / SIZE.height == Family::Studio as u32 { 128 } else { 16 };
        let is_far =
            |(x, y, old): &(u32, u32, &Rgba<u16>)| (0..4).any(|c| old.0[c].abs_diff(new.get_pixel(*x, *y).0[c]) > allowed(*y));
        assert_eq!(stored.enumerate_pixels().filter(is_far).count(), 0, "pixels differ: write the figures again");
        for family in Family::ALL {
            for n in 0..VIEWS {
                let frame = expected(family, n);
                let seen = frame.pixels().iter().filter(|p| p[3] > 0.05).count();
                assert!(10 * seen > SIZE.pixels(), "{family} {n} shows little: {seen} pixels");
            }
        }
    }

    /// The path tracer has the linear kernel and central differences: of smooth bumps that is nearly the same.
    #[test]
    fn the_studio_is_near_the_path_tracer() {
        for (n, Picture { settings, camera, .. }) in views(Family::Studio).iter().enumerate() {
            let (volume, transfer) = (volume(), transfer());
            let truth = PathTracer::new(&volume, &transfer, settings).halves(camera, SIZE, 1, 64).unwrap();
            let (squares, brightness) = against_halves(&expected(Family::Studio, n), &truth, 1);
            let decibels = -10.0 * squares.log10();
            println!("{n}: {decibels:.1} dB, brightness {brightness:.3}");
            assert!(decibels > 40.0 && (0.95..1.05).contains(&brightness), "{n}: {decibels} dB, brightness {brightness}");
        }
    }

    /// Typical failures of broken devices are detected in every picture.
    #[test]
    fn wrong_pictures_differ() {
        let changed = |frame: &Frame, change: &dyn Fn(u32, u32) -> [f32; 4]| {
            let pixels = (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y)));
            difference(&Frame::new(SIZE, pixels.map(|(x, y)| change(x, y)).collect()), frame)
        };
        for family in Family::ALL {
            for n in 0..VIEWS {
                let right = expected(family, n);
                let what = format!("{family} {n}");
                assert_eq!(difference(&right, &right), 0.0);
                assert!(displayed_difference(&right.to_rgba8(BACKGROUND), &right, Curve::NONE) < 1e-6, "{what}");
                // Black with alpha 1, as rusticl rendered; an empty picture; NaN.
                assert!(changed(&right, &|_, _| [0.0, 0.0, 0.0, 1.0]) > 10.0 * TOLERANCE, "{what}");
                assert!(changed(&right, &|_, _| [0.0; 4]) > 10.0 * TOLERANCE, "{what}");
                assert_eq!(changed(&right, &|_, _| [f32::NAN; 4]), f64::INFINITY, "{what}");
                // Shifted by a pixel to the left, or up.
                assert!(changed(&right, &|x, y| right.pixel((x + 1).min(SIZE.width - 1), y)) > 2.0 * TOLERANCE, "{what}");
                assert!(changed(&right, &|x, y| right.pixel(x, (y + 1).min(SIZE.height - 1))) > 2.0 * TOLERANCE, "{what}");
                // Three 8-bit steps off in one channel of one pixel.
                for channel in 0..4 {
                    let off = changed(&right, &|x, y| {
                        let mut pixel = right.pixel(x, y);
                        pixel[channel] += if (x, y) == (14, 11) { 3.0 / 255.0 } else { 0.0 };
                        pixel
                    });
                    assert!(off > TOLERANCE, "{what}: {off}");
                }
                let mut shown = right.to_rgba8(BACKGROUND);
                shown[4 * 300] = shown[4 * 300].wrapping_add(4);
                assert!(displayed_difference(&shown, &right, Curve::NONE) > TOLERANCE, "{what}");
                shown.pop();
                assert_eq!(displayed_difference(&shown, &right, Curve::NONE), f64::INFINITY, "{what}");
            }
        }
    }
}
