//! Antialiased lines, rectangles and text on transparent pixels.

use super::extent::Extent;
use crate::color::linear;
use crate::error::Error;
use crate::image::text::blend;
use crate::image::{Background, draw_text};
use crate::memory;
use crate::viewport::Viewport;
use glam::DVec2;

/// Straight-alpha RGBA8 pixels, with colours that are legible on the background.
pub(super) struct Canvas {
    pixels: Vec<u8>,
    extent: Extent,
    /// Part of the canvas, from its upper left corner, that lines and areas are clipped to.
    clip: Viewport,
    ink: [u8; 3],
    halo: [u8; 3],
}

const LIGHT: [u8; 3] = [236, 236, 236];
const DARK: [u8; 3] = [24, 24, 24];
/// Opacity of the halo around text and lines, which keeps them legible over bright volumes.
pub(super) const HALO: u8 = 150;

impl Canvas {
    pub fn new(extent: Extent, background: Background) -> Result<Self, Error> {
        let viewport = extent.viewport;
        let (ink, halo) = inks(background);
        Ok(Self { pixels: memory::zeroed("annotations", viewport.pixels() * 4)?, extent, clip: viewport, ink, halo })
    }

    /// Size of the canvas, and scale of what is drawn on it.
    pub fn extent(&self) -> Extent {
        self.extent
    }

    /// Clips the following lines and areas to the upper left part of this size.
    pub fn clip(&mut self, clip: Viewport) {
        self.clip = clip;
    }

    pub fn viewport(&self) -> Viewport {
        self.extent.viewport
    }

    /// Colour of lines and text.
    pub fn ink(&self) -> [u8; 3] {
        self.ink
    }

    /// Pixel `n`, premultiplied. `is_linear`: in linear light.
    pub fn pixel(&self, n: usize, is_linear: bool) -> [f32; 4] {
        let [r, g, b, a] = [0, 1, 2, 3].map(|channel| f32::from(self.pixels[4 * n + channel]) / 255.0);
        let decodes = is_linear && a > 0.0;
        let [r, g, b] = [r, g, b].map(|c| if decodes { linear(f64::from(c)) as f32 } else { c });
        [r * a, g * a, b * a, a]
    }

    /// Draws a line of `width` pixels with a halo. `opacity` is 0 … 1.
    pub fn line(&mut self, from: DVec2, to: DVec2, width: f64, color: [u8; 3], opacity: f64) {
        let rim = self.extent.scale;
        self.stroke([from, to], [width + 2.0 * rim; 2], self.halo, opacity * f64::from(HALO) / 255.0 * 0.6);
        self.stroke([from, to], [width; 2], color, opacity);
    }

    /// Draws a line without a halo. Its width changes linearly between its ends. Pixels are weighted by coverage.
    pub fn stroke(&mut self, ends: [DVec2; 2], widths: [f64; 2], color: [u8; 3], opacity: f64) {
        let [from, to] = ends;
        if !(from.is_finite() && to.is_finite()) {
            return;
        }
        let reach = widths[0].max(widths[1]) / 2.0 + 1.0;
        let (lo, hi) = (from.min(to) - reach, from.max(to) + reach);
        let (columns, rows) = (clipped(lo.x, hi.x, self.clip.width), clipped(lo.y, hi.y, self.clip.height));
        let along = to - from;
        let length = along.length_squared();
        for y in rows {
            for x in columns.clone() {
                let point = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let t = if length > 0.0 { ((point - from).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
                let half = (widths[0] + (widths[1] - widths[0]) * t) / 2.0;
                let covered = half + 0.5 - point.distance(from + along * t);
                // A line thinner than a pixel covers at most its width.
                self.cover(x, y, color, covered.clamp(0.0, (2.0 * half).min(1.0)) * opacity);
            }
        }
    }

    /// Fills a rectangle; its edges may lie within pixels.
    pub fn area(&mut self, from: DVec2, to: DVec2, color: [u8; 3], opacity: f64) {
        let (columns, rows) = (clipped(from.x, to.x, self.clip.width), clipped(from.y, to.y, self.clip.height));
        let share = |n: u32, lo: f64, hi: f64| (hi.min(f64::from(n) + 1.0) - lo.max(f64::from(n))).clamp(0.0, 1.0);
        for y in rows {
            for x in columns.clone() {
                self.cover(x, y, color, share(x, from.x, to.x) * share(y, from.y, to.y) * opacity);
            }
        }
    }

    fn cover(&mut self, x: u32, y: u32, [r, g, b]: [u8; 3], opacity: f64) {
        let alpha = (opacity * 255.0 + 0.5) as u8;
        if alpha > 0 {
            let first = (y as usize * self.extent.viewport.width as usize + x as usize) * 4;
            blend(&mut self.pixels[first..first + 4], [r, g, b, alpha]);
        }
    }

    /// Draws text with a halo; `at` is its upper left corner.
    pub fn text(&mut self, at: [f64; 2], text: &str) {
        self.text_in(at, text, self.ink);
    }

    pub fn text_in(&mut self, at: [f64; 2], text: &str, color: [u8; 3]) {
        let Extent { viewport, scale } = self.extent;
        let (size, scale) = ([viewport.width, viewport.height], scale as f32);
        let at = at.map(|c| c.round() as i32);
        let [r, g, b] = self.halo;
        let rim = scale.round().max(1.0) as i32;
        for (x, y) in [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)] {
            draw_text(&mut self.pixels, size, [at[0] + x * rim, at[1] + y * rim], text, [r, g, b, HALO], scale);
        }
        let [r, g, b] = color;
        draw_text(&mut self.pixels, size, at, text, [r, g, b, 255], scale);
    }

    /// Size of text in pixels.
    pub fn text_size(&self, text: &str) -> DVec2 {
        self.extent.measured(text)
    }
}

/// Colours of lines and text, and of the halo around them.
pub(super) fn inks(background: Background) -> ([u8; 3], [u8; 3]) {
    let is_light = match background {
        Background::Color([r, g, b]) => 0.299 * r + 0.587 * g + 0.114 * b > 0.5,
        // The final background is unknown; the halo keeps everything legible.
        Background::Transparent => false,
    };
    if is_light { (DARK, LIGHT) } else { (LIGHT, DARK) }
}

/// Pixels between two coordinates, clipped to the canvas.
fn clipped(lo: f64, hi: f64, size: u32) -> std::ops::Range<u32> {
    // Float-to-integer casts saturate.
    (lo.floor().max(0.0) as u32).min(size)..(hi.ceil().max(0.0) as u32).min(size)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding of opacities to 8 bits, per partially covered pixel.
    const ROUNDING: f64 = 1.0 / 255.0;

    fn canvas(side: u32) -> Canvas {
        Canvas::new(Extent::new(Viewport::new(side, side).unwrap(), None), Background::BLACK).unwrap()
    }

    fn covered(canvas: &Canvas) -> f64 {
        (0..canvas.viewport().pixels()).map(|n| f64::from(canvas.pixel(n, false)[3])).sum()
    }

    #[test]
    fn areas_cover_what_they_should() {
        let mut canvas = canvas(20);
        canvas.area(DVec2::new(2.25, 3.5), DVec2::new(7.0, 9.75), LIGHT, 1.0);
        assert!((covered(&canvas) - 4.75 * 6.25).abs() < 40.0 * ROUNDING, "{}", covered(&canvas));
        canvas.area(DVec2::splat(-1e9), DVec2::splat(1e9), LIGHT, 1.0);
        assert_eq!(covered(&canvas), 400.0);
    }

    #[test]
    fn lines_cover_their_width_in_any_direction() {
        for (angle, width) in [(0.0, 1.0), (0.3, 1.0), (0.3, 2.5), (0.8, 0.5), (1.4, 1.5)] {
            let mut canvas = canvas(100);
            let half = DVec2::from_angle(angle) * 30.0;
            canvas.stroke([DVec2::splat(50.0) - half, DVec2::splat(50.0) + half], [width; 2], LIGHT, 1.0);
            // Round caps add about one width. Distance approximates coverage to within a few percent.
            let found = covered(&canvas) / (60.0 * width);
            assert!((0.9..1.15).contains(&found), "{angle}, {width}: {found}");
        }
    }

    #[test]
    fn ink_differs_from_what_it_is_on() {
        let ink = |background| Canvas::new(Extent::new(Viewport::new(9, 9).unwrap(), None), background).unwrap().ink();
        assert_eq!(ink(Background::BLACK), LIGHT);
        assert_eq!(ink(Background::Color([1.0, 1.0, 0.0])), DARK);
    }
}
