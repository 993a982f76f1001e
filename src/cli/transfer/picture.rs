//! Plot of a transfer function: the volume's histogram, the opacity curve over it, and a colour bar below.

use crate::error::Error;
use crate::image::{Frame, draw_text, text_size};
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Statistics, Volume};

const BACKGROUND: [u8; 4] = [24, 26, 31, 255];
const PLOT: [u8; 4] = [33, 36, 43, 255];
const HISTOGRAM: [u8; 4] = [76, 83, 98, 255];
const GRID: [u8; 4] = [255, 255, 255, 26];
const CURVE: [u8; 4] = [255, 255, 255, 255];
const TEXT: [u8; 4] = [226, 229, 235, 255];
const FAINT: [u8; 4] = [150, 157, 170, 255];
/// Alpha of the colours below the curve.
const FILL_ALPHA: u8 = 150;
/// Samples per pixel and axis.
const FINE: u32 = 4;
/// Size of pictures with 8-pixel letters. Multiples of it have larger letters.
const BASE: [u32; 2] = [640, 360];
/// Smallest size in which all labels fit.
const MIN_SIZE: [u32; 2] = [320, 180];
/// Approximate number of values on the horizontal axis.
const VALUES: f64 = 7.0;

/// Plots a transfer function over the values of a volume.
pub(super) fn plot(transfer: &TransferFunction, volume: &Volume, size: Viewport) -> Result<Frame, Error> {
    if size.width < MIN_SIZE[0] || size.height < MIN_SIZE[1] {
        let value = format!("{}x{}", size.width, size.height);
        return Err(Error::OutOfRange { name: "viewport", value, expected: "a picture of 320x180 pixels or more" });
    }
    crate::memory::require("the picture", size.pixels() as u64 * (4 + 16))?;
    let statistics = volume.statistics();
    let mut page = Page::new(size, shown_range(&statistics, transfer), top(transfer));
    page.plot(transfer, &statistics);
    page.color_bar(transfer);
    page.axes();
    page.title(transfer.name(), volume.name());
    let frame = page.pixels.chunks_exact(4).map(|p| std::array::from_fn(|c| f32::from(p[c]) / 255.0)).collect();
    Ok(Frame::new(size, frame))
}

/// Range of the horizontal axis: that of the data, or of the function if all voxels have one value.
fn shown_range(statistics: &Statistics, transfer: &TransferFunction) -> (f64, f64) {
    let ranges = [(statistics.min, statistics.max), transfer.range()];
    ranges.into_iter().find(|(lo, hi)| lo < hi).unwrap_or((statistics.min - 0.5, statistics.min + 0.5))
}

/// Opacity at the top of the plot: the smallest of some round numbers that no opacity exceeds.
fn top(transfer: &TransferFunction) -> f64 {
    let largest = transfer.opacities().iter().map(|point| point.1).fold(0.0, f64::max);
    [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5].into_iter().find(|&top| largest <= top).unwrap_or(1.0)
}

/// A rectangle in pixels; `right` and `bottom` are exclusive.
#[derive(Clone, Copy)]
struct Area {
    left: u32,
    top: u32,
    right: u32,
    bottom: u32,
}

impl Area {
    fn width(self) -> u32 {
        self.right - self.left
    }

    fn height(self) -> u32 {
        self.bottom - self.top
    }
}

struct Page {
    pixels: Vec<u8>,
    size: [u32; 2],
    scale: u32,
    plot: Area,
    bar: Area,
    range: (f64, f64),
    top: f64,
}

impl Page {
    fn new(size: Viewport, range: (f64, f64), top: f64) -> Self {
        let (width, height) = (size.width, size.height);
        let scale = (width / BASE[0]).min(height / BASE[1]).max(1);
        let (left, right) = (56 * scale, width - 20 * scale);
        let bar = Area { left, right, top: height - 56 * scale, bottom: height - 32 * scale };
        let plot = Area { left, right, top: 34 * scale, bottom: bar.top - 8 * scale };
        let pixels = BACKGROUND.repeat(size.pixels());
        Self { pixels, size: [width, height], scale, plot, bar, range, top }
    }

    /// The value at a fraction of the plot's width.
    fn value(&self, share: f64) -> f64 {
        self.range.0 + (self.range.1 - self.range.0) * share
    }

    /// Draws the histogram and the opacity curve.
    fn plot(&mut self, transfer: &TransferFunction, statistics: &Statistics) {
        let area = self.plot;
        let columns = (area.width() * FINE) as usize;
        let rows = f64::from(area.height() * FINE);
        let share = |column: usize| (column as f64 + 0.5) / columns as f64;
        let bars: Vec<f64> = (0..columns).map(|c| bar(statistics, self.value(share(c))) * rows).collect();
        let heights: Vec<f64> = (0..columns).map(|c| transfer.opacity(self.value(share(c))) / self.top * rows).collect();
        let colors: Vec<[u8; 4]> = (0..columns).map(|c| shade(transfer.color(self.value(share(c))), FILL_ALPHA)).collect();
        // Half the line width, horizontally and vertically, so that vertical steps are drawn too.
        let half = (FINE * self.scale) as usize;
        let ends: Vec<(f64, f64)> = (0..columns)
            .map(|c| {
                let near = &heights[c.saturating_sub(half)..(c + half + 1).min(columns)];
                let (least, most) = near.iter().fold((f64::MAX, f64::MIN), |(a, b), &h| (a.min(h), b.max(h)));
                (least - half as f64, most + half as f64)
            })
            .collect();
        for y in 0..area.height() {
            for x in 0..area.width() {
                let samples = (0..FINE * FINE).map(|n| {
                    let column = (x * FINE + n % FINE) as usize;
                    let height = rows - f64::from(y * FINE + n / FINE) - 0.5;
                    let mut color = if height < bars[column] { HISTOGRAM } else { PLOT };
                    if height < heights[column] {
                        color = over(colors[column], color);
                    }
                    if ends[column].0 < height && height < ends[column].1 { CURVE } else { color }
                });
                self.set(area.left + x, area.top + y, mean(samples));
            }
        }
    }

    fn color_bar(&mut self, transfer: &TransferFunction) {
        let area = self.bar;
        for x in 0..area.width() {
            let samples = (0..FINE).map(|n| {
                let share = (f64::from(x * FINE + n) + 0.5) / f64::from(area.width() * FINE);
                shade(transfer.color(self.value(share)), 255)
            });
            let color = mean(samples);
            (area.top..area.bottom).for_each(|y| self.set(area.left + x, y, color));
        }
    }

    /// Draws grid lines at round opacities, ticks at round values, and their labels.
    fn axes(&mut self) {
        let (plot, bar, scale) = (self.plot, self.bar, self.scale);
        for step in 0..=4 {
            let opacity = self.top * f64::from(step) / 4.0;
            let y = plot.bottom - 1 - (plot.height() - 1) * step / 4;
            (plot.left..plot.right).for_each(|x| self.mark(x, y, GRID));
            if step % 2 == 0 {
                let label = number(opacity, self.top / 4.0);
                let [width, height] = text_size(&label, scale as f32);
                self.write([plot.left as i32 - (width + 6 * scale) as i32, y as i32 - (height / 2) as i32], &label, FAINT);
            }
        }
        let (lo, hi) = self.range;
        let step = round_step((hi - lo) / VALUES);
        let first = (lo / step).ceil();
        let mut free = 0;
        // Bounded, and possibly empty far from 0, where neighbouring floats differ by more than a step.
        let values = (0..=2 * VALUES as u32).map(|n| (first + f64::from(n)) * step).filter(|value| (lo..=hi).contains(value));
        for value in values {
            let x = bar.left + ((value - lo) / (hi - lo) * f64::from(bar.width() - 1)).round() as u32;
            (plot.top..plot.bottom).for_each(|y| self.mark(x, y, GRID));
            (bar.bottom..bar.bottom + 4 * scale).for_each(|y| self.mark(x, y, FAINT));
            let label = number(value, step);
            let width = text_size(&label, scale as f32)[0];
            let left = (x as i32 - width as i32 / 2).clamp(0, (self.size[0] - width.min(self.size[0])) as i32);
            if left >= free {
                self.write([left, (bar.bottom + 8 * scale) as i32], &label, TEXT);
                free = left + (width + 8 * scale) as i32;
            }
        }
    }

    fn title(&mut self, transfer: &str, volume: &str) {
        let (left, right, scale) = (self.plot.left, self.plot.right, self.scale);
        let kinds = "opacity, log histogram";
        let letters = |width: u32| (width / (8 * scale)) as usize;
        let kinds_width = text_size(kinds, scale as f32)[0];
        // File name without folders.
        let transfer = transfer.rsplit(['/', '\\']).next().unwrap_or(transfer);
        let title = shortened(&format!("{transfer} on {volume}"), letters(right - left - kinds_width - 16 * scale));
        self.write([left as i32, 14 * scale as i32], &title, TEXT);
        self.write([(right - kinds_width) as i32, 14 * scale as i32], kinds, FAINT);
    }

    fn write(&mut self, at: [i32; 2], text: &str, color: [u8; 4]) {
        draw_text(&mut self.pixels, self.size, at, text, color, self.scale as f32);
    }

    fn set(&mut self, x: u32, y: u32, color: [u8; 4]) {
        let first = (y as usize * self.size[0] as usize + x as usize) * 4;
        self.pixels[first..first + 4].copy_from_slice(&color);
    }

    fn mark(&mut self, x: u32, y: u32, color: [u8; 4]) {
        let first = (y as usize * self.size[0] as usize + x as usize) * 4;
        let below: [u8; 4] = std::array::from_fn(|c| self.pixels[first + c]);
        self.set(x, y, over(color, below));
    }
}

/// Height of the histogram at a value, 0 … 1 on a logarithmic scale, so that rare values are visible.
fn bar(statistics: &Statistics, value: f64) -> f64 {
    let (min, max) = (statistics.min, statistics.max);
    let bins = statistics.histogram.len();
    let bin = if min < max { ((value - min) / (max - min) * bins as f64).floor() } else { 0.0 };
    let count = if bin >= 0.0 && bin <= bins as f64 { statistics.histogram[(bin as usize).min(bins - 1)] } else { 0 };
    let largest = statistics.histogram.iter().max().map_or(1.0, |&n| (n as f64).ln_1p()).max(1.0);
    (count as f64).ln_1p() / largest
}

fn shade(color: [f64; 3], alpha: u8) -> [u8; 4] {
    let [r, g, b] = color.map(|c| (c * 255.0).round() as u8);
    [r, g, b, alpha]
}

/// Composites a colour over an opaque one.
fn over(above: [u8; 4], below: [u8; 4]) -> [u8; 4] {
    let alpha = u32::from(above[3]);
    let mixed = |c: usize| ((u32::from(above[c]) * alpha + u32::from(below[c]) * (255 - alpha) + 127) / 255) as u8;
    [mixed(0), mixed(1), mixed(2), 255]
}

fn mean(samples: impl Iterator<Item = [u8; 4]>) -> [u8; 4] {
    let (mut sums, mut count) = ([0u32; 4], 0);
    for sample in samples {
        sums.iter_mut().zip(sample).for_each(|(sum, c)| *sum += u32::from(c));
        count += 1;
    }
    sums.map(|sum| ((sum + count / 2) / count) as u8)
}

/// The smallest 1, 2 or 5 times a power of ten that is at least `least`.
fn round_step(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0].map(|n| n * power).into_iter().find(|&step| step >= least).unwrap_or(10.0 * power)
}

/// Formats a number with the digits that steps of `step` need.
fn number(value: f64, step: f64) -> String {
    let size = value.abs().max(step);
    if value != 0.0 && !(1e-4..1e6).contains(&size) {
        let digits = (size / step).log10().ceil().clamp(1.0, 9.0) as usize;
        let text = format!("{value:.digits$e}");
        return match text.split_once('e') {
            Some((mantissa, power)) => format!("{}e{power}", mantissa.trim_end_matches('0').trim_end_matches('.')),
            None => text,
        };
    }
    let exact = |digits: &usize| {
        let power = 10f64.powi(*digits as i32);
        ((value * power).round() / power - value).abs() < step * 1e-3
    };
    let digits = (0..=6).find(exact).unwrap_or(6);
    format!("{:.digits$}", value + 0.0)
}

fn shortened(text: &str, letters: usize) -> String {
    if text.chars().count() <= letters {
        return text.to_owned();
    }
    text.chars().take(letters.saturating_sub(3)).collect::<String>() + "..."
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round_and_numbers_short() {
        for (least, step) in [(0.9, 1.0), (1.0, 1.0), (1.1, 2.0), (36.4, 50.0), (60.0, 100.0), (0.0031, 0.005)] {
            assert!((round_step(least) / step - 1.0).abs() < 1e-12, "{least}");
        }
        for (value, step, text) in [
            (50.0, 50.0, "50"),
            (-0.0, 1.0, "0"),
            (0.25, 0.25, "0.25"),
            (0.5, 0.25, "0.5"),
            (2e7, 1e7, "2e7"),
            (1e9 + 1e3, 1e3, "1.000001e9"),
            (100.0, 20.0, "100"),
            (37.5, 12.5, "37.5"),
        ] {
            assert_eq!(number(value, step), text);
        }
    }
}
