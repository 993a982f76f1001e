//! Colour bar.

use super::canvas::Canvas;
use super::extent::Extent;
use super::ticks::ticks;
use crate::settings::Blend;
use crate::transfer::TransferFunction;
use glam::DVec2;
use std::ops::Range;

/// Height of the bar as a fraction of the picture's height.
const HEIGHT: f64 = 0.44;
/// Widths in pixels at scale 1: of the bar, of the opacity profile at its maximum, of the ticks, and of the margin.
const BAR: f64 = 12.0;
const PROFILE: f64 = 22.0;
const TICK: f64 = 4.0;
const MARGIN: f64 = 12.0;

/// Distance of the unit from the bar, in pixels at scale 1.
const UNIT_GAP: f64 = 8.0;
/// Room between the bar with its profile and a picture on its left, in pixels at scale 1.
const GAP: f64 = 6.0;

/// Width of the column at the right edge that the bar and the unit take.
pub(super) fn room(transfer: &TransferFunction, blend: Blend, units: Option<&str>, extent: Extent) -> f64 {
    let scale = extent.scale;
    let width = |text: &str| extent.measured(text).x;
    let widest = labels(transfer, extent).iter().map(|(_, label)| width(label)).fold(0.0, f64::max);
    let profile = if blend.gathers_values() { 0.0 } else { PROFILE };
    let bar = (MARGIN + TICK + 3.0 + BAR + profile + GAP) * scale + widest;
    bar.max(units.map_or(0.0, width) + MARGIN * scale)
}

/// Rows of a picture of this size that the bar and the unit above it take, with a margin.
pub(super) fn rows(extent: Extent) -> Range<u32> {
    let height = f64::from(extent.viewport.height);
    let top = ((height - length(extent)) / 2.0).round();
    let margin = MARGIN * extent.scale;
    let unit = extent.measured("0").y + UNIT_GAP * extent.scale;
    let (first, last) = (top - unit - margin, top + length(extent) + margin);
    (first.floor().max(0.0) as u32)..(last.ceil().min(height) as u32)
}

/// Length of the bar in a picture of this size.
fn length(extent: Extent) -> f64 {
    (f64::from(extent.viewport.height) * HEIGHT).round()
}

/// Values and labels beside the bar.
fn labels(transfer: &TransferFunction, extent: Extent) -> Vec<(f64, String)> {
    let (lo, hi) = transfer.range();
    // Labels are at least two and a half lines apart.
    let most = ((length(extent) / (extent.measured("0").y * 2.5)) as usize).clamp(2, 6);
    ticks(lo, hi, most)
}

/// Draws the bar at the right edge; values ascend upwards. With compositing, a profile of the opacities is drawn beside the bar, relative
/// to their maximum. An iso-value is marked by a line.
pub(super) fn draw(transfer: &TransferFunction, blend: Blend, units: Option<&str>, canvas: &mut Canvas) {
    let (width, height) = (f64::from(canvas.viewport().width), f64::from(canvas.viewport().height));
    let scale = canvas.extent().scale;
    let (lo, hi) = transfer.range();
    let length = length(canvas.extent());
    let letters = canvas.text_size("0");
    let ticks = labels(transfer, canvas.extent());
    let widest = ticks.iter().map(|(_, label)| canvas.text_size(label).x).fold(0.0, f64::max);
    let right = (width - MARGIN * scale - widest - (TICK + 3.0) * scale).round();
    let (left, top) = (right - BAR * scale, ((height - length) / 2.0).round());
    let value = |row: f64| hi + (lo - hi) * (row / length);
    let largest = transfer.largest_opacity(lo, hi);
    for row in 0..length as u32 {
        let (y, at) = (top + f64::from(row), value(f64::from(row) + 0.5));
        let color = transfer.color(at).map(|c| (c * 255.0 + 0.5) as u8);
        canvas.area(DVec2::new(left, y), DVec2::new(right, y + 1.0), color, 1.0);
        // Take the maximum over each row, so that narrow peaks remain visible.
        let seen = transfer.largest_opacity(value(f64::from(row) + 1.0), value(f64::from(row)));
        if largest > 0.0 && blend == Blend::Composite {
            let reach = PROFILE * scale * seen / largest;
            canvas.area(DVec2::new(left - reach, y), DVec2::new(left, y + 1.0), color, 0.75);
        }
    }
    let ink = canvas.ink();
    frame(canvas, DVec2::new(left, top), DVec2::new(right, top + length), scale);
    if let Blend::Iso(iso) = blend
        && lo <= iso
        && iso <= hi
        && hi > lo
    {
        let row = (top + length * (hi - iso) / (hi - lo) - scale / 2.0).round();
        canvas.area(DVec2::new(left - PROFILE * scale, row), DVec2::new(right, row + scale), ink, 1.0);
    }
    for (at, label) in ticks {
        let y = if hi > lo { top + length * (hi - at) / (hi - lo) } else { top + length / 2.0 };
        // Snap to whole pixels: a thin line between pixels would be blurred.
        let row = (y - scale / 2.0).round();
        canvas.area(DVec2::new(right, row), DVec2::new(right + TICK * scale, row + scale), ink, 1.0);
        canvas.text([right + (TICK + 3.0) * scale, y - letters.y / 2.0], &label);
    }
    if let Some(units) = units {
        let size = canvas.text_size(units);
        let at = (right - size.x / 2.0).min(width - size.x - MARGIN / 2.0 * scale);
        canvas.text([at, top - size.y - UNIT_GAP * scale], units);
    }
}

/// Draws a border around a rectangle.
fn frame(canvas: &mut Canvas, from: DVec2, to: DVec2, width: f64) {
    let (ink, outside) = (canvas.ink(), DVec2::splat(width));
    let (lo, hi) = (from - outside, to + outside);
    let sides = [
        (lo, DVec2::new(hi.x, from.y)),
        (DVec2::new(lo.x, to.y), hi),
        (DVec2::new(lo.x, from.y), DVec2::new(from.x, to.y)),
        (DVec2::new(to.x, from.y), DVec2::new(hi.x, to.y)),
    ];
    for (from, to) in sides {
        canvas.area(from, to, ink, 1.0);
    }
}
