//! Text in an outline font, antialiased.

use ab_glyph::{Font, FontRef, GlyphId, OutlineCurve, Point, PxScale, ScaleFont, point};
use glam::DVec2;
use std::sync::OnceLock;

/// DejaVu Sans, reduced to Latin, Greek and signs (`scripts/font`).
const FONT: &[u8] = include_bytes!("font/DejaVuSans-latin-greek.ttf");

/// Height of the em square in pixels at scale 1.
#[doc(hidden)]
pub const EM: f32 = 12.0;
/// Height of capital letters and digits in pixels at scale 1: 0.73 em.
const CAPITALS: u32 = 9;
/// Distance of lines in pixels at scale 1.
const LINE: u32 = 15;

fn font() -> &'static FontRef<'static> {
    static PARSED: OnceLock<FontRef<'static>> = OnceLock::new();
    PARSED.get_or_init(|| FontRef::try_from_slice(FONT).expect("the font is part of the crate"))
}

/// The size at which an em square is `EM`·`scale` pixels high.
fn pixels(scale: f32) -> PxScale {
    let font = font();
    let em = font.units_per_em().expect("the font is scalable");
    PxScale::from(EM * scale * font.height_unscaled() / em)
}

/// Draws text on straight-alpha RGBA8 pixels. `at` is the left end (column) and the top of capital letters (row) of the first line.
///
/// Capital letters and digits are 9·`scale` pixels high, lines 15·`scale` apart; letters may reach 3·`scale` pixels below. Text is clipped to
/// the picture. Characters missing from the font become boxes. A translucent `color` is blended with the picture.
///
/// ```
/// use layersplat::image::{draw_text, text_size};
///
/// let [width, height] = text_size("Hg", 2.0);
/// let mut pixels = vec![0; (width * height * 4) as usize];
/// draw_text(&mut pixels, [width, height], [0, 0], "Hg", [255, 255, 255, 255], 2.0);
/// assert!(pixels.contains(&255));
/// ```
///
/// # Panics
/// If `pixels` does not have 4·`size[0]`·`size[1]` bytes.
pub fn draw_text(pixels: &mut [u8], size: [u32; 2], at: [i32; 2], text: &str, color: [u8; 4], scale: f32) {
    assert_eq!(pixels.len(), size[0] as usize * size[1] as usize * 4);
    for (line, letters) in text.lines().enumerate() {
        let below = (line as f32 * LINE as f32 + CAPITALS as f32) * scale;
        let baseline = i64::from(at[1]) + below.round() as i64;
        for (glyph, left) in placed(letters, scale).0 {
            draw_glyph(pixels, size, [i64::from(at[0]), baseline], (glyph, left), color, scale);
        }
    }
}

/// Width and height of text in pixels. The height is that from the top of capital letters to the last baseline.
///
/// ```
/// let [width, height] = layersplat::image::text_size("one\nthree", 2.0);
/// assert!((60..80).contains(&width) && height == 48);
/// ```
pub fn text_size(text: &str, scale: f32) -> [u32; 2] {
    let width = text.lines().map(|line| placed(line, scale).1).fold(0.0, f32::max);
    let lines = text.lines().count() as u32;
    let height = (lines * LINE).saturating_sub(LINE - CAPITALS) as f32 * scale;
    [width.ceil() as u32, height.round() as u32]
}

/// The glyphs of a line with the distances of their origins from its left end, and the width of the line.
fn placed(line: &str, scale: f32) -> (Vec<(GlyphId, f32)>, f32) {
    let font = font().as_scaled(pixels(scale));
    let mut left = 0.0;
    let glyph = |letter| {
        let (glyph, at) = (font.glyph_id(letter), left);
        left += font.h_advance(glyph);
        (glyph, at)
    };
    let glyphs = line.chars().map(glyph).collect();
    (glyphs, left)
}

/// A step along the outline of text, in pixels right of and below the place where [`draw_text`] has its `at`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(hidden)]
pub enum Step {
    /// Begins a contour, which closes where the next one begins.
    Move(DVec2),
    Line(DVec2),
    /// A cubic Bézier curve: two control points and the end.
    Curve([DVec2; 3]),
}

/// Outlines of the letters of a text. Overlapping contours are filled by the nonzero rule.
#[doc(hidden)]
pub fn outlines(text: &str, scale: f32) -> Vec<Step> {
    let font = font();
    let unit = EM * scale / font.units_per_em().expect("the font is scalable");
    let mut steps = Vec::new();
    for (line, letters) in text.lines().enumerate() {
        let baseline = (line as f32 * LINE as f32 + CAPITALS as f32) * scale;
        for (glyph, left) in placed(letters, scale).0 {
            let at = |p: Point| DVec2::new((left + p.x * unit).into(), (baseline - p.y * unit).into());
            let mut end = None;
            for curve in font.outline(glyph).map(|outline| outline.curves).unwrap_or_default() {
                let (from, step, to) = match curve {
                    OutlineCurve::Line(a, b) => (a, Step::Line(at(b)), b),
                    OutlineCurve::Quad(a, b, c) => {
                        let (start, control, stop) = (at(a), at(b), at(c));
                        (a, Step::Curve([start.lerp(control, 2.0 / 3.0), stop.lerp(control, 2.0 / 3.0), stop]), c)
                    }
                    OutlineCurve::Cubic(a, b, c, d) => (a, Step::Curve([b, c, d].map(at)), d),
                };
                if end != Some(from) {
                    steps.push(Step::Move(at(from)));
                }
                steps.push(step);
                end = Some(to);
            }
        }
    }
    steps
}

/// Draws a glyph whose origin is `left` pixels right of `origin`, a column and a row.
fn draw_glyph(pixels: &mut [u8], size: [u32; 2], origin: [i64; 2], (glyph, left): (GlyphId, f32), color: [u8; 4], scale: f32) {
    // Whole pixels are added as integers, so that shapes do not depend on the position.
    let glyph = glyph.with_scale_and_position(self::pixels(scale), point(left.fract(), 0.0));
    let Some(outline) = font().outline_glyph(glyph) else { return };
    let from = outline.px_bounds().min;
    let [first_x, first_y] = [origin[0] + left as i64 + from.x as i64, origin[1] + from.y as i64];
    outline.draw(|x, y, coverage| {
        let (x, y) = (first_x + i64::from(x), first_y + i64::from(y));
        if (0..i64::from(size[0])).contains(&x) && (0..i64::from(size[1])).contains(&y) {
            let first = (y as usize * size[0] as usize + x as usize) * 4;
            let alpha = (f32::from(color[3]) * coverage.clamp(0.0, 1.0) + 0.5) as u8;
            blend(&mut pixels[first..first + 4], [color[0], color[1], color[2], alpha]);
        }
    });
}

/// Blends a straight-alpha colour over a straight-alpha pixel.
#[doc(hidden)]
pub fn blend(pixel: &mut [u8], color: [u8; 4]) {
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

    /// Rows of the picture, with `#` for pixels that are covered by more than a fifth.
    fn drawn(text: &str, at: [i32; 2], scale: f32) -> Vec<String> {
        let size = [60, 20];
        let mut pixels = vec![0; 60 * 20 * 4];
        draw_text(&mut pixels, size, at, text, [9, 8, 7, 255], scale);
        let row = |row: &[u8]| row.chunks_exact(4).map(|p| if p[3] > 51 { '#' } else { '.' }).collect();
        pixels.chunks_exact(240).map(row).collect()
    }

    fn covered(text: &str, scale: f32) -> usize {
        drawn(text, [1, 1], scale).concat().matches('#').count()
    }

    #[test]
    fn a_letter_is_where_it_should_be() {
        let rows = drawn("L", [3, 4], 1.0);
        let dark: Vec<usize> = (0..rows.len()).filter(|&n| rows[n].contains('#')).collect();
        // From the top of capitals to the baseline; the stem of an L, and its foot.
        assert_eq!((dark[0], dark.len()), (4, CAPITALS as usize), "{rows:#?}");
        assert!(rows[12].matches('#').count() > 3 && rows[8].matches('#').count() < 3, "{rows:#?}");
        let (once, twice) = (covered("M", 1.0), covered("M", 2.0));
        assert!((3 * once..6 * once).contains(&twice), "{once}, {twice}");
    }

    #[test]
    fn widths_are_those_drawn() {
        for text in ["1.25", "density", "µm³"] {
            let [width, height] = text_size(text, 1.0);
            let rows = drawn(text, [0, 2], 1.0);
            let last = rows.iter().filter_map(|row| row.rfind('#')).max().unwrap() as u32;
            assert!((width.saturating_sub(3)..=width).contains(&(last + 1)), "{text}: {width}, {last}");
            assert_eq!(height, CAPITALS);
        }
        assert_eq!(text_size("", 1.0), [0, 0]);
    }

    #[test]
    fn what_lies_beyond_is_left_out() {
        for at in [[-400, 0], [0, 900], [i32::MAX, i32::MAX], [i32::MIN, 3]] {
            assert!(!drawn("Wide text\nof lines", at, 3.0).concat().contains('#'), "{at:?}");
        }
        let (whole, cut) = (drawn("MM", [4, 2], 1.0), drawn("MM", [-6, 2], 1.0));
        assert_eq!(&whole[7][10..28], &cut[7][..18]);
    }

    /// Letters beyond ASCII have shapes of their own; a missing one is a box.
    #[test]
    fn letters_of_many_kinds_have_shapes() {
        let shape = |letter: char| drawn(&letter.to_string(), [1, 4], 1.0);
        for letter in "aZ0µÅ°α³⁻²→∇".chars() {
            assert!(shape(letter).concat().contains('#') && shape(letter) != shape('漢'), "{letter}");
        }
        assert!(shape('漢') == shape('語') && shape('漢').concat().contains('#') && !shape(' ').concat().contains('#'));
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
