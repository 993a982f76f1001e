//! Scale bar with a round length in world units.

use super::canvas::Canvas;
use super::extent::Extent;
use super::screen::Screen;
use super::ticks::{round_up, written};
use glam::DVec2;

/// Longest bar, as a fraction of the picture's width.
const LONGEST: f64 = 0.22;
/// Distance from the edges of the picture, in pixels at scale 1.
const MARGIN: f64 = 16.0;
/// Unit of length without a name.
const UNITS: &str = "units";

/// Longest number that is a round length of a picture, for the room that its label needs.
const LONGEST_NUMBER: &str = "5.0e-5 ";

/// Width of the column at the right edge that a bar of any length takes.
pub(super) fn room(units: Option<&str>, extent: Extent) -> f64 {
    let label = extent.measured(LONGEST_NUMBER).x + extent.measured(units.unwrap_or(UNITS)).x;
    label + MARGIN / 2.0 * extent.scale
}

/// Draws the bar in the lower right corner, within `column` pixels from the right edge. Perspective views have no uniform scale and get no
/// bar.
pub(super) fn draw(screen: &Screen, units: Option<&str>, column: f64, canvas: &mut Canvas) {
    let Some(per_unit) = screen.pixels_per_unit() else { return };
    let (width, height) = (f64::from(canvas.viewport().width), f64::from(canvas.viewport().height));
    let scale = canvas.extent().scale;
    // At both ends, the margin includes the bar's tick.
    let longest = (width * LONGEST).min(column - 1.5 * MARGIN * scale).max(1.0);
    let length = round_down(longest / per_unit);
    let right = DVec2::new(width - MARGIN * scale, height - MARGIN * scale);
    let left = right - DVec2::X * (length * per_unit);
    let (ink, tick) = (canvas.ink(), DVec2::Y * 4.0 * scale);
    canvas.line(left, right, 2.0 * scale, ink, 1.0);
    for end in [left, right] {
        canvas.line(end - tick, end + tick, 1.5 * scale, ink, 1.0);
    }
    let label = format!("{} {}", written(length, length), units.unwrap_or(UNITS));
    let size = canvas.text_size(&label);
    let middle = (left.x + right.x - size.x) / 2.0;
    let beside = middle.min(width - size.x - MARGIN / 2.0 * scale);
    canvas.text([beside, left.y - 6.0 * scale - size.y], &label);
}

/// Largest number of the form 1, 2 or 5 times a power of ten that does not exceed `number`.
fn round_down(number: f64) -> f64 {
    let above = round_up(number);
    let power = 10f64.powf(above.log10().floor() - 1.0);
    let factors = [10.0, 5.0, 2.0, 1.0, 100.0, 50.0, 20.0];
    factors.into_iter().map(|factor| factor * power).filter(|&n| n <= number * (1.0 + 1e-9)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_round() {
        for (number, expected) in [(7.0, 5.0), (5.0, 5.0), (1.99, 1.0), (0.031, 0.02), (140.0, 100.0), (1e-12, 1e-12)] {
            assert!((round_down(number) / expected - 1.0).abs() < 1e-9, "{number}: {}", round_down(number));
        }
    }
}
