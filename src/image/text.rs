//! Bitmap text, 8×8 pixels per character or an integer multiple.

use font8x8::UnicodeFonts;

/// Pixels along each side of a character at scale 1.
const SIDE: u32 = 8;
/// Empty rows between lines.
const LEADING: u32 = 2;

/// Draws text on straight-alpha RGBA8 pixels, with its upper left corner `at` (column, row).
///
/// Characters are 8·`scale` pixels wide and high, lines 10·`scale` apart. Text is clipped to the picture. Characters missing from the
/// font become boxes. A translucent `color` is blended with the picture.
///
/// ```
/// use layersplat::image::{draw_text, text_size};
///
/// let [width, height] = text_size("Hg", 2);
/// let mut pixels = vec![0; (width * height * 4) as usize];
/// draw_text(&mut pixels, [width, height], [0, 0], "Hg", [255, 255, 255, 255], 2);
/// assert!(pixels.contains(&255));
/// ```
///
/// # Panics
/// If `pixels` does not have 4·`size[0]`·`size[1]` bytes.
pub fn draw_text(pixels: &mut [u8], size: [u32; 2], at: [i32; 2], text: &str, color: [u8; 4], scale: u32) {
    assert_eq!(pixels.len(), size[0] as usize * size[1] as usize * 4);
    let scale = i64::from(scale);
    for (line, letters) in text.lines().enumerate() {
        let top = i64::from(at[1]) + line as i64 * i64::from(SIDE + LEADING) * scale;
        for (n, letter) in letters.chars().enumerate() {
            let left = i64::from(at[0]) + n as i64 * i64::from(SIDE) * scale;
            for (x, y) in dots(letter) {
                let from = [left + i64::from(x) * scale, top + i64::from(y) * scale];
                fill(pixels, size, from, scale, color);
            }
        }
    }
}

/// Width and height of text in pixels.
///
/// ```
/// assert_eq!(layersplat::image::text_size("one\nthree", 2), [80, 36]);
/// ```
pub fn text_size(text: &str, scale: u32) -> [u32; 2] {
    let letters = text.lines().map(|line| line.chars().count() as u32).max().unwrap_or(0);
    let lines = text.lines().count() as u32;
    [letters * SIDE * scale, (lines * (SIDE + LEADING)).saturating_sub(LEADING) * scale]
}

/// Positions of the set pixels of a character.
fn dots(letter: char) -> impl Iterator<Item = (u32, u32)> {
    /// Replacement of characters missing from the font.
    const BOX: [u8; 8] = [0x7f, 0x41, 0x41, 0x41, 0x41, 0x41, 0x7f, 0];
    let rows = font8x8::BASIC_FONTS.get(letter).or_else(|| font8x8::LATIN_FONTS.get(letter));
    let rows = rows.or_else(|| font8x8::GREEK_FONTS.get(letter)).unwrap_or(BOX);
    (0..SIDE).flat_map(move |y| (0..SIDE).filter(move |x| rows[y as usize] >> x & 1 == 1).map(move |x| (x, y)))
}

/// Fills a square, clipped to the picture.
fn fill(pixels: &mut [u8], size: [u32; 2], from: [i64; 2], side: i64, color: [u8; 4]) {
    let inside = |from: i64, size: u32| from.max(0)..(from + side).min(i64::from(size));
    for y in inside(from[1], size[1]) {
        for x in inside(from[0], size[0]) {
            let first = (y as usize * size[0] as usize + x as usize) * 4;
            blend(&mut pixels[first..first + 4], color);
        }
    }
}

/// Blends a straight-alpha colour over a straight-alpha pixel.
pub(crate) fn blend(pixel: &mut [u8], color: [u8; 4]) {
    let (above, below) = (f32::from(color[3]) / 255.0, f32::from(pixel[3]) / 255.0);
    let alpha = above + below * (1.0 - above);
    if alpha <= 0.0 {
        return;
    }
    for (channel, &new) in pixel.iter_mut().zip(&color[..3]) {
        let mixed = (f32::from(new) * above + f32::from(*channel) * below * (1.0 - above)) / alpha;
        *channel = (mixed + 0.5) as u8;
    }
    pixel[3] = (alpha * 255.0 + 0.5) as u8;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(text: &str, at: [i32; 2], scale: u32) -> Vec<String> {
        let size = [20, 10];
        let mut pixels = vec![0; 20 * 10 * 4];
        draw_text(&mut pixels, size, at, text, [9, 8, 7, 255], scale);
        let row = |row: &[u8]| row.chunks_exact(4).map(|p| if p == [9, 8, 7, 255] { '#' } else { '.' }).collect();
        pixels.chunks_exact(80).map(row).collect()
    }

    #[test]
    fn a_letter_is_where_it_should_be() {
        let rows = drawn("L", [3, 1], 1);
        // The stem of an L, its foot, and the empty last row.
        assert!(rows[0].chars().all(|c| c == '.') && rows[9].chars().all(|c| c == '.'), "{rows:#?}");
        assert!(rows[1..8].iter().all(|row| row.contains('#')) && rows[7].matches('#').count() > 4, "{rows:#?}");
        let twice = drawn("-", [0, -4], 2);
        assert_eq!(twice.concat().matches('#').count(), 4 * drawn("-", [0, 0], 1).concat().matches('#').count());
    }

    #[test]
    fn what_lies_beyond_is_left_out() {
        for at in [[-100, 0], [0, 900], [i32::MAX, i32::MAX], [i32::MIN, 3]] {
            assert!(!drawn("Wide text\nof lines", at, 3).concat().contains('#'), "{at:?}");
        }
        let whole = drawn("MM", [2, 0], 1);
        let cut = drawn("MM", [-6, 0], 1);
        assert_eq!(&whole[3][10..18], &cut[3][2..10]);
    }

    #[test]
    fn letters_of_many_kinds_have_shapes() {
        for letter in ['a', 'Z', '0', 'µ', 'Å', '°', 'α', '漢'] {
            assert!(dots(letter).count() > 3, "{letter}");
        }
        assert_eq!((dots(' ').count(), text_size("", 1)), (0, [0, 0]));
    }

    #[test]
    fn colours_are_mixed_by_opacity() {
        let mut pixel = [200, 100, 0, 255];
        blend(&mut pixel, [0, 100, 200, 51]);
        assert_eq!(pixel, [160, 100, 40, 255]);
        let mut empty = [9, 9, 9, 0];
        blend(&mut empty, [50, 60, 70, 80]);
        assert_eq!(empty, [50, 60, 70, 80]);
    }
}
