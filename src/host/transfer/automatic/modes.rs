//! Materials of a survey: modes of the histogram of voxels with weak gradients.
//!
//! Inside a material, gradients are weak and values are near the material's own. At a boundary, values pass through all between two
//! materials with strong gradients: the arcs of the value–gradient histogram (Kindlmann & Durkin 1998). So materials are the modes among
//! flat voxels. A mode counts if the valley that separates it from a higher one is deep enough (its persistence).

use super::survey::Survey;

/// Standard deviation of the smoothing, as a fraction of the bins.
const SMOOTHING: f64 = 1.0 / 100.0;
/// Smallest ratio of a mode to the valley beside it.
const PERSISTENCE: f64 = 1.5;
/// Smallest excess of a mode over the valley, in standard deviations of its count.
const SIGNIFICANCE: f64 = 5.0;
/// Smallest number of flat voxels of a mode, as a fraction of the voxels outside the largest mode.
const SMALLEST: f64 = 0.02;
/// The same for modes below the largest: cavities are small.
const SMALLEST_CAVITY: f64 = 5e-3;
/// Smallest share of the voxels in a mode's range of values that are flat; with fewer, it is the end of an edge.
const SOLID: f64 = 0.1;
/// Largest number of values of integers that are labels rather than samples of a quantity.
const LABELS: usize = 8;
/// Largest number of modes.
const MOST: usize = 6;
/// Height at which a mode ends, as a fraction of its peak.
const FOOT: f64 = 0.05;

/// A mode among the flat voxels. Positions are bins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// Position of the peak: the middle of its bin.
    pub peak: f64,
    /// Positions where the mode has fallen to its foot, or where a valley separates it from the next one.
    pub from: f64,
    pub to: f64,
    /// Share of the sampled voxels that are flat and belong to the mode.
    pub share: f64,
    /// Share of the voxels on the faces that belong to the mode.
    pub face_share: f64,
}

/// The modes of a survey, ascending by value.
pub fn modes(survey: &Survey) -> Vec<Mode> {
    let flat = smoothed(&survey.flat, SMOOTHING * survey.bins() as f64);
    if survey.bins() <= LABELS {
        return labels(survey);
    }
    let (mut peaks, mut valleys) = extrema(&flat);
    // Valleys that separate nothing are removed, the shallowest first.
    loop {
        let depth = |n: usize| flat[peaks[n]].min(flat[peaks[n + 1]]) / flat[valleys[n]].max(f64::MIN_POSITIVE);
        let Some(shallowest) = (0..valleys.len()).min_by(|&a, &b| depth(a).total_cmp(&depth(b))) else { break };
        let (a, b) = (peaks[shallowest], peaks[shallowest + 1]);
        let (lower, valley) = (flat[a].min(flat[b]), flat[valleys[shallowest]]);
        if depth(shallowest) >= PERSISTENCE && lower - valley > SIGNIFICANCE * lower.sqrt() && peaks.len() <= MOST {
            break;
        }
        valleys.remove(shallowest);
        peaks.remove(if flat[a] < flat[b] { shallowest } else { shallowest + 1 });
    }
    let (all, all_faces) = (sum(&survey.counts), sum(&survey.faces));
    let end = |n: usize| valleys.get(n).map_or(survey.bins(), |valley| valley + 1);
    let mode = |n: usize| {
        let basin = if n == 0 { 0 } else { end(n - 1) }..end(n);
        let (from, to) = feet(&flat, peaks[n], &basin);
        let inside = from..to;
        let own = sum(&survey.flat[inside.clone()]);
        let mode = Mode {
            peak: peaks[n] as f64 + 0.5,
            from: from as f64,
            to: to as f64,
            share: own / all.max(1.0),
            face_share: sum(&survey.faces[basin]) / all_faces.max(1.0),
        };
        (own > SOLID * sum(&survey.counts[inside])).then_some(mode)
    };
    let found: Vec<Mode> = (0..peaks.len()).filter_map(mode).collect();
    let Some(largest) = found.iter().copied().max_by(|a, b| a.share.total_cmp(&b.share)) else { return found };
    let least = |mode: &Mode| if mode.peak < largest.peak { SMALLEST_CAVITY } else { SMALLEST };
    found.into_iter().filter(|mode| *mode == largest || mode.share > least(mode) * (1.0 - largest.share)).collect()
}

/// A mode for each value of a mask or of a few labels.
fn labels(survey: &Survey) -> Vec<Mode> {
    let share = |numbers: &[f64], bin: usize| numbers[bin] / sum(numbers).max(1.0);
    let mode = |bin: usize| Mode {
        peak: bin as f64 + 0.5,
        from: bin as f64,
        to: bin as f64 + 1.0,
        share: share(&survey.counts, bin),
        face_share: share(&survey.faces, bin),
    };
    (0..survey.bins()).filter(|&bin| survey.counts[bin] > 0.0).map(mode).collect()
}

/// Positions of the maxima, and of the minima between them.
fn extrema(curve: &[f64]) -> (Vec<usize>, Vec<usize>) {
    let (mut peaks, mut valleys) = (Vec::new(), Vec::new());
    let (mut highest, mut lowest, mut rising) = (0, 0, true);
    for i in 1..curve.len() {
        if rising {
            if curve[i] > curve[highest] {
                highest = i;
            } else if curve[i] < curve[highest] {
                peaks.push(highest);
                (lowest, rising) = (i, false);
            }
        } else if curve[i] < curve[lowest] {
            lowest = i;
        } else if curve[i] > curve[lowest] {
            valleys.push(lowest);
            (highest, rising) = (i, true);
        }
    }
    if rising {
        peaks.push(highest);
    }
    (peaks, valleys)
}

/// First and last bin (exclusive) around a peak, within its basin, above its foot.
fn feet(curve: &[f64], peak: usize, basin: &std::ops::Range<usize>) -> (usize, usize) {
    let low = |i: usize| curve[i] < FOOT * curve[peak];
    let from = (basin.start..peak).rev().find(|&i| low(i)).map_or(basin.start, |i| i + 1);
    let to = (peak..basin.end).find(|&i| low(i)).unwrap_or(basin.end);
    (from, to.max(peak + 1))
}

/// Convolution with a Gaussian of standard deviation `sigma`, in bins. Nothing leaves at the ends.
pub fn smoothed(numbers: &[f64], sigma: f64) -> Vec<f64> {
    let radius = (3.0 * sigma).ceil() as isize;
    if sigma < 0.3 {
        return numbers.to_vec();
    }
    let weights: Vec<f64> = (-radius..=radius).map(|d| (-0.5 * (d as f64 / sigma).powi(2)).exp()).collect();
    let all = sum(&weights);
    let mut spread = vec![0.0; numbers.len()];
    for (i, &number) in numbers.iter().enumerate() {
        for (weight, d) in weights.iter().zip(-radius..) {
            let to = (i as isize + d).clamp(0, numbers.len() as isize - 1) as usize;
            spread[to] += number * weight / all;
        }
    }
    spread
}

pub fn sum(numbers: &[f64]) -> f64 {
    numbers.iter().sum()
}
