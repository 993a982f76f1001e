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
pub(super) const MARGIN: f64 = 12.0;
/// Opacity of the profile.
pub(super) const PROFILE_OPACITY: f64 = 0.75;

/// Distance of the unit from the bar, in pixels at scale 1.
const UNIT_GAP: f64 = 8.0;
/// Room between the bar with its profile, or a list, and a picture on its left, in pixels at scale 1.
pub(super) const GAP: f64 = 6.0;

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

/// Shapes of the bar, in pixels of a picture.
pub(super) struct Layout {
    /// Upper left and lower right corner of the bar. Values ascend upwards.
    pub bar: [DVec2; 2],
    /// Border, ticks and the line of an iso-value.
    pub lines: Vec<[DVec2; 2]>,
    /// Upper left corners and texts: the unit last.
    pub labels: Vec<(DVec2, String)>,
}

impl Layout {
    /// Places the bar at the right edge of a picture.
    pub fn new(transfer: &TransferFunction, blend: Blend, units: Option<&str>, extent: Extent) -> Self {
        let (width, height) = (f64::from(extent.viewport.width), f64::from(extent.viewport.height));
        let scale = extent.scale;
        let (lo, hi) = transfer.range();
        let length = length(extent);
        let letters = extent.measured("0");
        let ticks = labels(transfer, extent);
        let widest = ticks.iter().map(|(_, label)| extent.measured(label).x).fold(0.0, f64::max);
        let right = (width - MARGIN * scale - widest - (TICK + 3.0) * scale).round();
        let (left, top) = (right - BAR * scale, ((height - length) / 2.0).round());
        let bar = [DVec2::new(left, top), DVec2::new(right, top + length)];
        let mut lines = frame(bar, scale).to_vec();
        if let Blend::Iso(iso) = blend
            && lo <= iso
            && iso <= hi
            && hi > lo
        {
            let row = (top + length * (hi - iso) / (hi - lo) - scale / 2.0).round();
            lines.push([DVec2::new(left - PROFILE * scale, row), DVec2::new(right, row + scale)]);
        }
        let mut labels = Vec::new();
        for (at, label) in ticks {
            let y = if hi > lo { top + length * (hi - at) / (hi - lo) } else { top + length / 2.0 };
            // Snap to whole pixels: a thin line between pixels would be blurred.
            let row = (y - scale / 2.0).round();
            lines.push([DVec2::new(right, row), DVec2::new(right + TICK * scale, row + scale)]);
            labels.push((DVec2::new(right + (TICK + 3.0) * scale, y - letters.y / 2.0), label));
        }
        if let Some(units) = units {
            let size = extent.measured(units);
            let at = (right - size.x / 2.0).min(width - size.x - MARGIN / 2.0 * scale);
            labels.push((DVec2::new(at, top - size.y - UNIT_GAP * scale), units.to_owned()));
        }
        Self { bar, lines, labels }
    }
}

/// Colour of a part of the bar, and length of the opacity profile beside it.
pub(super) struct Part {
    pub color: [u8; 3],
    pub reach: f64,
}

/// The bar in `count` parts of equal height, from the top. With compositing, the profile is relative to the largest opacity.
pub(super) fn parts(transfer: &TransferFunction, blend: Blend, extent: Extent, count: u32) -> Vec<Part> {
    let (lo, hi) = transfer.range();
    let value = |part: f64| hi + (lo - hi) * (part / f64::from(count));
    let largest = if blend == Blend::Composite { transfer.largest_opacity(lo, hi) } else { 0.0 };
    let part = |part: u32| {
        let part = f64::from(part);
        let color = transfer.color(value(part + 0.5)).map(|c| (c * 255.0 + 0.5) as u8);
        // Take the maximum over each part, so that narrow peaks remain visible.
        let seen = if largest > 0.0 { transfer.largest_opacity(value(part + 1.0), value(part)) / largest } else { 0.0 };
        Part { color, reach: PROFILE * extent.scale * seen }
    };
    (0..count).map(part).collect()
}

/// Draws the bar at the right edge, and the profile of the opacities beside it.
pub(super) fn draw(transfer: &TransferFunction, blend: Blend, units: Option<&str>, canvas: &mut Canvas) {
    let extent = canvas.extent();
    let Layout { bar: [from, to], lines, labels } = Layout::new(transfer, blend, units, extent);
    for (row, part) in parts(transfer, blend, extent, length(extent) as u32).iter().enumerate() {
        let y = from.y + row as f64;
        canvas.area(DVec2::new(from.x, y), DVec2::new(to.x, y + 1.0), part.color, 1.0);
        canvas.area(DVec2::new(from.x - part.reach, y), DVec2::new(from.x, y + 1.0), part.color, PROFILE_OPACITY);
    }
    let ink = canvas.ink();
    for [from, to] in lines {
        canvas.area(from, to, ink, 1.0);
    }
    for (at, label) in labels {
        canvas.text(at.to_array(), &label);
    }
}

/// The sides of a border around a rectangle.
pub(super) fn frame([from, to]: [DVec2; 2], width: f64) -> [[DVec2; 2]; 4] {
    let outside = DVec2::splat(width);
    let (lo, hi) = (from - outside, to + outside);
    [
        [lo, DVec2::new(hi.x, from.y)],
        [DVec2::new(lo.x, to.y), hi],
        [DVec2::new(lo.x, from.y), DVec2::new(from.x, to.y)],
        [DVec2::new(to.x, from.y), DVec2::new(hi.x, to.y)],
    ]
}
