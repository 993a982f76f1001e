//! What the pictures are to be, stored, and how far drawn ones are from it.

use super::Family;
use super::pictures::{SIZE, VIEWS};
use crate::image::{Background, Frame};
use std::sync::LazyLock;

/// Premultiplied RGBA in 16 bits: a row of pictures per family, a column per view. They are drawn by `truth.rs`, in `f64` on the host: what is
/// true, not what some device once showed. `cargo test --lib figures -- --ignored` writes them.
const FILE: &[u8] = include_bytes!("figures.png");

/// Largest difference of a channel that is taken for right: two steps of an 8-bit picture.
///
/// Devices differ from the reference by what they approximate: tables of 4096 entries, footprints by quadrature, slicing's 256 values. Of
/// these pictures that is half a step at most, on PoCL and Intel (the tests allow one); other floats have room beside it. A lattice warped a
/// tenth of a pixel aside is off by five.
pub const TOLERANCE: f64 = 2.0 / 255.0;

/// Half a step of 8 bits: what a displayed picture may differ more.
const ROUNDING: f64 = 0.5 / 255.0;

/// Behind displayed pictures: other than black and white in all channels.
pub(super) const BACKGROUND: Background = Background::Color([0.2, 0.4, 0.8]);

static SHEET: LazyLock<Vec<[f32; 4]>> = LazyLock::new(|| {
    let sheet =
        image::load_from_memory_with_format(FILE, image::ImageFormat::Png).expect("figures.png is a picture").into_rgba16();
    assert_eq!(
        sheet.dimensions(),
        (columns() as u32, Family::ALL.len() as u32 * SIZE.height),
        "figures.png is of other pictures"
    );
    sheet.pixels().map(|pixel| pixel.0.map(|c| f32::from(c) / f32::from(u16::MAX))).collect()
});

/// Pixels of a row of the sheet.
fn columns() -> usize {
    VIEWS * SIZE.width as usize
}

/// The picture that view `n` of a family is to be.
pub(super) fn expected(family: Family, n: usize) -> Frame {
    let (width, height) = (SIZE.width as usize, SIZE.height as usize);
    let row = |y: usize| (family as usize * height + y) * columns() + n * width;
    Frame::new(SIZE, (0..height).flat_map(|y| &SHEET[row(y)..][..width]).copied().collect())
}

/// Largest difference of any channel of any pixel; what is not a number differs by infinity.
pub(super) fn difference(found: &Frame, expected: &Frame) -> f64 {
    found.compare(expected).map_or(f64::INFINITY, |comparison| comparison.max_difference)
}

/// The same of a picture that is displayed over [`BACKGROUND`], less what its rounding explains.
pub(super) fn displayed_difference(found: &[u8], expected: &Frame) -> f64 {
    if found.len() != 4 * SIZE.pixels() {
        return f64::INFINITY;
    }
    let found = found.chunks_exact(4).map(|pixel| std::array::from_fn(|c| f32::from(pixel[c]) / 255.0)).collect();
    (difference(&Frame::new(SIZE, found), &expected.clone().over(BACKGROUND)) - ROUNDING).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::super::pictures::of;
    use super::super::truth::drawn;
    use super::*;
    use image::{ImageBuffer, Rgba};
    use std::path::Path;

    /// The lower bits say nothing of what is compared, and do not pack: 12 of 16 are kept.
    const KEPT: u16 = !15;

    fn sheet() -> ImageBuffer<Rgba<u16>, Vec<u16>> {
        let frames: Vec<Vec<Frame>> =
            Family::ALL.iter().map(|&family| of(family).iter().map(|picture| drawn(family, picture)).collect()).collect();
        ImageBuffer::from_fn(columns() as u32, Family::ALL.len() as u32 * SIZE.height, |x, y| {
            let frame = &frames[(y / SIZE.height) as usize][(x / SIZE.width) as usize];
            let pixel = frame.pixel(x % SIZE.width, y % SIZE.height);
            assert!(pixel.iter().all(|c| (0.0..=1.0).contains(c)), "{pixel:?} cannot be stored");
            Rgba(pixel.map(|c| ((c * 65535.0 + 8.0) as u16) & KEPT))
        })
    }

    #[test]
    #[ignore = "writes src/check/figures.png, after a change of the pictures"]
    fn write_figures() {
        sheet().save(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/check/figures.png")).unwrap();
    }

    #[test]
    fn figures_are_the_references() {
        let stored = image::load_from_memory(FILE).unwrap().into_rgba16();
        let new = sheet();
        assert_eq!(stored.dimensions(), new.dimensions());
        // Another libm may round the last bit that is kept otherwise.
        let far = stored.pixels().zip(new.pixels()).filter(|(a, b)| (0..4).any(|c| a.0[c].abs_diff(b.0[c]) > 16)).count();
        assert_eq!(far, 0, "pixels differ: write the figures anew");
        for family in Family::ALL {
            for n in 0..VIEWS {
                let frame = expected(family, n);
                let seen = frame.pixels().iter().filter(|p| p[3] > 0.05).count();
                assert!(10 * seen > SIZE.pixels(), "{family} {n} shows little: {seen} pixels");
            }
        }
    }

    /// What a broken device may show is noticed in every picture.
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
                assert!(displayed_difference(&right.to_rgba8(BACKGROUND), &right) < 1e-6, "{what}");
                // Black with alpha 1, as rusticl had it; nothing at all; no number.
                assert!(changed(&right, &|_, _| [0.0, 0.0, 0.0, 1.0]) > 10.0 * TOLERANCE, "{what}");
                assert!(changed(&right, &|_, _| [0.0; 4]) > 10.0 * TOLERANCE, "{what}");
                assert_eq!(changed(&right, &|_, _| [f32::NAN; 4]), f64::INFINITY, "{what}");
                // A pixel to the left, or up.
                assert!(changed(&right, &|x, y| right.pixel((x + 1).min(SIZE.width - 1), y)) > 2.0 * TOLERANCE, "{what}");
                assert!(changed(&right, &|x, y| right.pixel(x, (y + 1).min(SIZE.height - 1))) > 2.0 * TOLERANCE, "{what}");
                // Three steps of 8 bits off in one channel of one pixel.
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
                assert!(displayed_difference(&shown, &right) > TOLERANCE, "{what}");
                shown.pop();
                assert_eq!(displayed_difference(&shown, &right), f64::INFINITY, "{what}");
            }
        }
    }
}
