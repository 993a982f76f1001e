//! Colours: elements of arrays, backgrounds, and the pixels of a frame.

use crate::arrays::Array;
use crate::types::{self, DataType};
use anari_sys::*;
use std::sync::OnceLock;

/// The linear colours of an array: missing components are 0, missing opacities 1.
pub fn decoded(array: &Array) -> Vec<[f32; 4]> {
    let size = types::bytes(array.element).unwrap_or(1).max(1);
    (*array.memory).as_ref().chunks_exact(size).map(|element| color(array.element, element)).collect()
}

/// The colour of an element.
fn color(element: DataType, bytes: &[u8]) -> [f32; 4] {
    let mut color = [0.0, 0.0, 0.0, 1.0];
    let mut fill = |values: &mut dyn Iterator<Item = f32>| color.iter_mut().zip(values).for_each(|(to, from)| *to = from);
    match element {
        ANARI_UFIXED8..=ANARI_UFIXED8_VEC4 => fill(&mut bytes.iter().map(|&byte| f32::from(byte) / 255.0)),
        ANARI_UFIXED16..=ANARI_UFIXED16_VEC4 => {
            fill(&mut bytes.as_chunks::<2>().0.iter().map(|&word| f32::from(u16::from_ne_bytes(word)) / 65_535.0));
        }
        ANARI_UFIXED32..=ANARI_UFIXED32_VEC4 => {
            let number = |&word: &[u8; 4]| (f64::from(u32::from_ne_bytes(word)) / f64::from(u32::MAX)) as f32;
            fill(&mut bytes.as_chunks::<4>().0.iter().map(number));
        }
        ANARI_FLOAT32..=ANARI_FLOAT32_VEC4 => {
            fill(&mut bytes.as_chunks::<4>().0.iter().map(|&word| f32::from_ne_bytes(word)));
        }
        ANARI_UFIXED8_RA_SRGB => color = [linear(bytes[0]), 0.0, 0.0, f32::from(bytes[1]) / 255.0],
        ANARI_UFIXED8_R_SRGB | ANARI_UFIXED8_RGB_SRGB => fill(&mut bytes.iter().map(|&byte| linear(byte))),
        ANARI_UFIXED8_RGBA_SRGB => {
            fill(&mut bytes[..3].iter().map(|&byte| linear(byte)).chain([f32::from(bytes[3]) / 255.0]));
        }
        _ => {}
    }
    color
}

/// The linear value of a byte of sRGB (IEC 61966-2-1).
fn linear(byte: u8) -> f32 {
    let encoded = f32::from(byte) / 255.0;
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Steps of the table of sRGB. The curve is steepest at 0, where a step of the table is 0.05 steps of a byte.
const STEPS: usize = 65_536;

/// The bytes of sRGB of linear values from 0 to 1.
fn srgb_table() -> &'static [u8; STEPS] {
    static TABLE: OnceLock<Box<[u8; STEPS]>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let encoded = |linear: f64| if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
        let table: Box<[u8]> = (0..STEPS).map(|i| (encoded(i as f64 / (STEPS - 1) as f64) * 255.0 + 0.5) as u8).collect();
        table.try_into().expect("it has this many steps")
    })
}

/// The byte of sRGB of a linear value, clamped to 0 … 1.
fn srgb(table: &[u8; STEPS], value: f32) -> u8 {
    // The cast saturates, and NaN becomes 0.
    table[usize::from((value * (STEPS - 1) as f32 + 0.5) as u16)]
}

/// The byte of a value from 0 to 1, halves rounded up. The cast saturates, and NaN becomes 0.
fn byte(value: f32) -> u8 {
    (value * 255.0 + 0.5) as u8
}

/// What is behind the volume. Rows begin at the bottom.
#[derive(Clone, Debug, PartialEq)]
pub enum Background {
    /// Straight colour and opacity.
    Color([f32; 4]),
    /// An image with this many columns, stretched over the frame.
    Image { columns: usize, pixels: Vec<[f32; 4]> },
}

impl Background {
    /// The opaque colour, if it is one.
    pub fn opaque(&self) -> Option<[f32; 3]> {
        match *self {
            Self::Color([r, g, b, 1.0]) if [r, g, b].iter().all(|c| (0.0..=1.0).contains(c)) => Some([r, g, b]),
            _ => None,
        }
    }

    /// The colour behind the middle of a pixel, in a frame of `width` × `height`; `row` counts from the bottom.
    fn at(&self, column: usize, row: usize, [width, height]: [usize; 2]) -> [f32; 4] {
        match self {
            Self::Color(color) => *color,
            Self::Image { columns, pixels } => {
                let rows = pixels.len() / columns;
                let place = |pixel: usize, of: usize, count: usize| {
                    let place = ((pixel as f32 + 0.5) / of as f32 * count as f32 - 0.5).clamp(0.0, (count - 1) as f32);
                    let first = place as usize;
                    (first, (first + 1).min(count - 1), place - first as f32)
                };
                let (x0, x1, u) = place(column, width, *columns);
                let (y0, y1, v) = place(row, height, rows);
                let mixed = |a: [f32; 4], b: [f32; 4], t: f32| std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t);
                let line = |y: usize| mixed(pixels[y * columns + x0], pixels[y * columns + x1], u);
                mixed(line(y0), line(y1), v)
            }
        }
    }
}

/// A premultiplied pixel over straight colour and opacity.
fn over([r, g, b, a]: [f32; 4], [red, green, blue, alpha]: [f32; 4]) -> [f32; 4] {
    let rest = (1.0 - a) * alpha;
    [r + rest * red, g + rest * green, b + rest * blue, a + rest]
}

/// Premultiplied pixels, row by row from the top, as those of a frame over a background, row by row from the bottom.
fn finished<T>(pixels: &[[f32; 4]], width: usize, background: &Background, finish: impl Fn([f32; 4]) -> [T; 4]) -> Vec<[T; 4]> {
    let size = [width, pixels.len() / width];
    let mut all = Vec::with_capacity(pixels.len());
    for (row, line) in pixels.chunks_exact(width).rev().enumerate() {
        match background {
            Background::Color(color) => all.extend(line.iter().map(|&pixel| finish(over(pixel, *color)))),
            Background::Image { .. } => {
                let pixels = line.iter().enumerate();
                all.extend(pixels.map(|(column, &pixel)| finish(over(pixel, background.at(column, row, size)))));
            }
        }
    }
    all
}

/// Pixels of a frame in one of its types, row by row from the bottom.
#[derive(Debug)]
pub enum Pixels {
    Bytes(DataType, Vec<[u8; 4]>),
    Floats(Vec<[f32; 4]>),
}

impl Pixels {
    /// Premultiplied pixels, row by row from the top, over a background.
    pub fn new(format: DataType, pixels: &[[f32; 4]], width: usize, background: &Background) -> Self {
        match format {
            ANARI_FLOAT32_VEC4 => Self::Floats(finished(pixels, width, background, |pixel| pixel)),
            ANARI_UFIXED8_RGBA_SRGB => {
                let table = srgb_table();
                let encode = |[r, g, b, a]: [f32; 4]| [srgb(table, r), srgb(table, g), srgb(table, b), byte(a)];
                Self::Bytes(format, finished(pixels, width, background, encode))
            }
            _ => Self::Bytes(format, finished(pixels, width, background, |pixel| pixel.map(byte))),
        }
    }

    /// Bytes of red, green, blue and alpha, row by row from the top.
    pub fn from_rgba8(bytes: &[u8], width: usize) -> Self {
        let mut rows = Vec::with_capacity(bytes.len() / 4);
        bytes.as_chunks::<4>().0.chunks_exact(width).rev().for_each(|row| rows.extend_from_slice(row));
        Self::Bytes(ANARI_UFIXED8_VEC4, rows)
    }

    /// The type and the first pixel.
    pub fn mapped(&self) -> (DataType, *const u8) {
        match self {
            Self::Bytes(format, pixels) => (*format, pixels.as_ptr().cast()),
            Self::Floats(pixels) => (ANARI_FLOAT32_VEC4, pixels.as_ptr().cast()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes of sRGB survive decoding and encoding.
    #[test]
    fn srgb_is_its_own_inverse() {
        for encoded in 0..=255 {
            assert_eq!(srgb(srgb_table(), linear(encoded)), encoded);
        }
        assert_eq!([-1.0, f32::NAN, 2.0].map(|value| srgb(srgb_table(), value)), [0, 0, 255]);
    }

    #[test]
    fn frames_begin_at_the_bottom_and_lie_over_their_background() {
        let (top, bottom) = ([0.25, 0.0, 0.0, 0.5], [0.0; 4]);
        let over = |background| match Pixels::new(ANARI_UFIXED8_VEC4, &[top, bottom], 1, &background) {
            Pixels::Bytes(_, pixels) => pixels,
            Pixels::Floats(_) => unreachable!(),
        };
        assert_eq!(over(Background::Color([0.0, 0.0, 1.0, 1.0])), [[0, 0, 255, 255], [64, 0, 128, 255]]);
        assert_eq!(over(Background::Color([1.0, 1.0, 1.0, 0.0])), [[0, 0, 0, 0], [64, 0, 0, 128]]);
        let image = Background::Image { columns: 1, pixels: vec![[1.0, 1.0, 1.0, 1.0], [0.0, 1.0, 0.0, 1.0]] };
        assert_eq!(over(image), [[255, 255, 255, 255], [64, 128, 0, 255]]);
    }
}
