//! How large and how good a picture is while a hand moves: as much as fits into the time of a frame.

use crate::settings::Quality;
use crate::viewport::Viewport;
use std::time::Duration;

/// Time of a frame: 30 frames per second.
const BUDGET: Duration = Duration::from_millis(33);
/// A picture is improved after frames that took less than this share of the budget.
const COMFORTABLE: f64 = 0.6;
/// Fast frames in a row before the picture is improved for the first time.
const FIRST_PATIENCE: u32 = 4;
/// Most fast frames before the picture is improved again after it had become too slow.
const MOST_PATIENCE: u32 = 64;
/// Pictures are not drawn with a shorter side than this, if the page has as many pixels.
const LEAST_SIDE: u32 = 384;

/// Steps from the best to the fastest: quality, and the share of the page's pixels along each side.
const STEPS: [(Quality, f64); 7] = [
    (Quality::Standard, 1.0),
    (Quality::Standard, 0.85),
    (Quality::Standard, 0.7),
    (Quality::Draft, 0.7),
    (Quality::Draft, 0.5),
    (Quality::Draft, 0.35),
    (Quality::Draft, 0.25),
];

/// Chooses a step from the times of the last frames.
#[derive(Debug)]
pub(super) struct Pace {
    step: usize,
    fast: u32,
    patience: u32,
}

impl Default for Pace {
    fn default() -> Self {
        Self { step: 0, fast: 0, patience: FIRST_PATIENCE }
    }
}

impl Pace {
    /// Quality and size of the next picture for a page of this size.
    pub fn choose(&self, page: Viewport) -> (Quality, Viewport) {
        let (quality, share) = STEPS[self.step];
        (quality, scaled(page, share))
    }

    /// Takes the time of a frame, from its start to its encoded bytes.
    pub fn record(&mut self, page: Viewport, took: Duration) {
        let share = took.as_secs_f64() / BUDGET.as_secs_f64();
        if share > 1.0 {
            // Twice the budget is two steps too many.
            let down = (share.log2().ceil() as usize).clamp(1, STEPS.len());
            let last = last_step(page);
            if self.step < last {
                self.patience = (2 * self.patience).min(MOST_PATIENCE);
            }
            self.step = (self.step + down).min(last);
            self.fast = 0;
        } else if share < COMFORTABLE {
            self.fast += 1;
            if self.fast >= self.patience && self.step > 0 {
                self.step -= 1;
                self.fast = 0;
            }
        } else {
            self.fast = 0;
        }
    }
}

/// The last step that differs from the one before.
fn last_step(page: Viewport) -> usize {
    let size = |step: usize| (STEPS[step].0, scaled(page, STEPS[step].1));
    (1..STEPS.len()).rev().find(|&step| size(step) != size(step - 1)).unwrap_or(0)
}

fn scaled(page: Viewport, share: f64) -> Viewport {
    let shorter = page.width.min(page.height);
    let least = f64::from(LEAST_SIDE.min(shorter)) / f64::from(shorter);
    let side = |pixels: u32| ((f64::from(pixels) * share.max(least)).round() as u32).max(1);
    Viewport { width: side(page.width), height: side(page.height) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: Viewport = Viewport { width: 1000, height: 768 };

    /// Draws frames of a device that takes `nanoseconds` per pixel, and returns the last times.
    fn drawn(pace: &mut Pace, nanoseconds: f64, frames: usize) -> Vec<Duration> {
        let mut times = Vec::new();
        for _ in 0..frames {
            let (quality, size) = pace.choose(PAGE);
            let factor = if quality == Quality::Draft { 0.6 } else { 1.0 };
            let took = Duration::from_secs_f64(size.pixels() as f64 * nanoseconds * factor * 1e-9);
            pace.record(PAGE, took);
            times.push(took);
        }
        times
    }

    #[test]
    fn fast_devices_draw_the_whole_page() {
        let mut pace = Pace::default();
        drawn(&mut pace, 10.0, 100);
        assert_eq!(pace.choose(PAGE), (Quality::Standard, PAGE));
    }

    #[test]
    fn slow_devices_hold_the_time_and_recover() {
        let mut pace = Pace::default();
        let times = drawn(&mut pace, 90.0, 200);
        let late = times.iter().filter(|&&took| took > BUDGET).count();
        assert!(late < 12, "{late} of 200 are late: it does not swing");
        assert!(pace.choose(PAGE).1.pixels() < PAGE.pixels());
        drawn(&mut pace, 5.0, 600);
        assert_eq!(pace.choose(PAGE), (Quality::Standard, PAGE));
    }

    #[test]
    fn pictures_keep_their_shape_and_a_least_size() {
        let mut pace = Pace::default();
        pace.record(PAGE, Duration::from_secs(5));
        let (quality, size) = pace.choose(PAGE);
        assert_eq!((quality, size), (Quality::Draft, Viewport { width: 500, height: 384 }));
        let small = Viewport { width: 200, height: 300 };
        let mut pace = Pace::default();
        pace.record(small, Duration::from_secs(5));
        assert_eq!(pace.choose(small), (Quality::Draft, small));
    }
}
