//! Automatic transfer function, derived from a volume's histogram and gradients.
//!
//! The value range is divided into classes, one per material. Air and noise (the lowest class) are transparent. Each other class
//! has a distinct colour and an opacity low enough to keep the next class visible.

use super::TransferFunction;
use super::sources::visible_range;
use crate::volume::{HISTOGRAM_BINS, Statistics, Volume};

/// Number of value classes. The lowest one (air and noise) is transparent.
const CLASSES: usize = 4;
/// Exponent applied to the histogram counts, so that rare materials (bone, vessels) weigh against millions of air voxels.
const DAMPING: f64 = 0.4;
/// Target optical depth of a ray through each visible class, outermost first, if the voxels of the class were spread evenly over the
/// volume.
const DEPTHS: [f64; CLASSES - 1] = [0.7, 2.0, 6.0];
/// Minimum and maximum opacity of each visible class, outermost first.
const LIMITS: [(f64, f64); CLASSES - 1] = [(0.006, 0.25), (0.02, 0.6), (0.08, 0.9)];
/// Colours at the start and the end of each visible class.
const COLORS: [[[f64; 3]; 2]; CLASSES - 1] = [
    [[0.25, 0.45, 0.85], [0.35, 0.70, 0.95]],
    [[0.95, 0.55, 0.25], [1.00, 0.80, 0.40]],
    [[1.00, 0.93, 0.80], [1.00, 1.00, 1.00]],
];
/// Half the width of an opacity ramp at a threshold, as a fraction of the narrower adjacent class.
const RAMP: f64 = 0.12;
/// Approximate number of voxels whose neighbours are sampled.
const ASKED: usize = 2_000_000;

/// Ascending thresholds between the classes.
type Thresholds = [f64; CLASSES - 1];

pub(super) fn from_statistics(statistics: &Statistics, volume: &Volume) -> TransferFunction {
    let (lo, hi) = visible_range(volume);
    let name = TransferFunction::AUTOMATIC;
    if statistics.min >= statistics.max {
        let color = COLORS[1];
        let points = vec![(lo, color[0]), (hi, color[1])];
        // A thin volume must stay visible and a thick one translucent.
        let thickness = volume.grid().dims().into_iter().min().unwrap_or(1) as f64;
        let opacity = (1.0 - (-DEPTHS[1] / thickness).exp()).clamp(0.1, 0.9);
        return TransferFunction::new(name, points, vec![(lo, 0.0), ((lo + hi) / 2.0, 0.0), (hi, opacity)]).expect("ascending");
    }
    let thresholds = sharpened(classes(statistics), statistics, volume);
    let ends = [thresholds[0], thresholds[1], thresholds[2], hi];
    let (mut colors, mut opacities) = (vec![(lo, COLORS[0][0])], vec![(lo, 0.0)]);
    let mut opacity = 0.0;
    for class in 0..CLASSES - 1 {
        let (from, to) = (ends[class], ends[class + 1]);
        let before = if class == 0 { from - lo } else { from - ends[class - 1] };
        let half = RAMP * before.min(to - from);
        let own = opacity_for(statistics, from, to, volume, class).max(opacity);
        opacities.extend([(from - half, opacity), (from + half, own)]);
        // The outermost class starts with its colour, without a ramp from the class below.
        let begins = if class == 0 { from - half } else { from + half };
        if class > 0 {
            colors.push((from - half, COLORS[class - 1][1]));
        }
        colors.push((begins, COLORS[class][0]));
        opacity = own;
    }
    colors.push((hi, COLORS[CLASSES - 2][1]));
    opacities.push((hi, opacity));
    TransferFunction::new(name, colors, opacities).expect("ascending by construction")
}

/// Thresholds that minimise the within-class variance of the damped histogram (Otsu 1979).
fn classes(statistics: &Statistics) -> Thresholds {
    let weights: Vec<f64> = smoothed(&statistics.histogram).iter().map(|n| n.powf(DAMPING)).collect();
    // Running sums of weight, and of weight times bin.
    let mut sums = vec![(0.0, 0.0)];
    for (bin, w) in weights.iter().enumerate() {
        let (weight, moment) = sums[bin];
        sums.push((weight + w, moment + w * bin as f64));
    }
    // Maximising weight · mean² of the classes minimises their within-class variance.
    let between = |from: usize, to: usize| {
        let (weight, moment) = (sums[to].0 - sums[from].0, sums[to].1 - sums[from].1);
        if weight > 0.0 { moment * moment / weight } else { 0.0 }
    };
    let bins = weights.len();
    let best_with = |first: std::ops::Range<usize>| {
        let mut best = (f64::NEG_INFINITY, [bins / 4, bins / 2, 3 * bins / 4]);
        for a in first {
            for b in a + 1..bins - 1 {
                let two = between(0, a) + between(a, b);
                for c in b + 1..bins {
                    let score = two + between(b, c) + between(c, bins);
                    if score > best.0 {
                        best = (score, [a, b, c]);
                    }
                }
            }
        }
        best.1
    };
    let mut best = best_with(1..bins - 2);
    // The most frequent class surrounds the object of interest, so it counts as background.
    let most = (0..bins).max_by(|&a, &b| weights[a].total_cmp(&weights[b])).unwrap_or(0);
    if (best[0]..best[1]).contains(&most) && best[1] < bins - 2 {
        best = best_with(best[1]..best[1] + 1);
    }
    best.map(|bin| statistics.min + (statistics.max - statistics.min) * bin as f64 / bins as f64)
}

/// The histogram at half the resolution, smoothed with a (1, 2, 1) / 4 filter.
fn smoothed(histogram: &[u64]) -> Vec<f64> {
    let pairs: Vec<f64> = histogram.chunks(2).map(|pair| pair.iter().sum::<u64>() as f64).collect();
    let at = |i: usize, d: isize| pairs[(i as isize + d).clamp(0, pairs.len() as isize - 1) as usize];
    (0..pairs.len()).map(|i| 0.25 * at(i, -1) + 0.5 * at(i, 0) + 0.25 * at(i, 1)).collect()
}

/// Moves the thresholds to material boundaries. Each becomes the mean mid-edge value of the voxel pairs that cross it, weighted by
/// the squared difference of the pair. A threshold moves by at most a third of the distance to its neighbour.
fn sharpened(thresholds: Thresholds, statistics: &Statistics, volume: &Volume) -> Thresholds {
    let mut sums = volume.look(|value| edges(thresholds, volume, value));
    volume.add_all(sums.as_flattened_mut());
    std::array::from_fn(|n| {
        let below = if n == 0 { statistics.min } else { thresholds[n - 1] };
        let above = if n + 1 == thresholds.len() { statistics.max } else { thresholds[n + 1] };
        let [weight, moment] = sums[n];
        let edge = if weight > 0.0 { moment / weight } else { thresholds[n] };
        let own = thresholds[n];
        edge.clamp(own - (own - below) / 3.0, own + (above - own) / 3.0)
    })
}

/// For each threshold: the sum of edge weights, and the sum of weights times mid-edge values.
fn edges(thresholds: Thresholds, volume: &Volume, value: &dyn Fn(usize) -> f64) -> [[f64; 2]; CLASSES - 1] {
    let dims = volume.grid().dims();
    let count = volume.grid().voxel_count();
    let strides = [1, dims[0], dims[0] * dims[1]];
    let every = (count / ASKED).max(1);
    let mut sums = [[0.0; 2]; CLASSES - 1];
    let (own, held) = (volume.own_box(), volume.held_box());
    for i in (0..count).step_by(every) {
        let place = volume.grid().place(i);
        if !own.has(place) {
            continue;
        }
        for axis in 0..3 {
            let at = place[axis];
            if at == held.first[axis] || at + 1 >= held.end(axis) {
                continue;
            }
            let (a, b) = (value(i - strides[axis]), value(i + strides[axis]));
            for (sum, threshold) in sums.iter_mut().zip(thresholds) {
                if (a < threshold) != (b < threshold) {
                    let weight = (b - a) * (b - a);
                    *sum = [sum[0] + weight, sum[1] + weight * (a + b) / 2.0];
                }
            }
        }
    }
    sums
}

/// Opacity per unit distance of the class of values from `from` to `to`.
fn opacity_for(statistics: &Statistics, from: f64, to: f64, volume: &Volume, class: usize) -> f64 {
    let count = volume.grid().voxel_count() as f64;
    let width = (statistics.max - statistics.min) / HISTOGRAM_BINS as f64;
    let own: u64 = (0..HISTOGRAM_BINS)
        .filter(|&bin| (from..to).contains(&(statistics.min + width * (bin as f64 + 0.5))))
        .map(|bin| statistics.histogram[bin])
        .sum();
    let met = (own as f64 / count * count.cbrt()).max(1e-3);
    let (least, most) = LIMITS[class];
    (1.0 - (-DEPTHS[class] / met).exp()).clamp(least, most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{Grid, Voxels};
    use glam::DVec3;

    fn automatic(values: Vec<f32>) -> TransferFunction {
        let grid = Grid::new([values.len(), 1, 1], DVec3::ONE).unwrap();
        TransferFunction::automatic(&Volume::new("t", grid, Voxels::Float32(values)).unwrap())
    }

    #[test]
    fn something_is_visible_and_not_everything() {
        let ramp = automatic((0..1000).map(|i| i as f32).collect());
        assert!(ramp.opacity(100.0) == 0.0 && ramp.opacity(999.0) > 0.0);
        let mask = automatic((0..1000).map(|i| if i % 2 == 0 { 0.0 } else { 1.0 }).collect());
        assert!(mask.opacity(0.0) == 0.0 && mask.opacity(1.0) > 0.0 && mask.opacity(1.0) < 1.0);
        let outlier = automatic((0..1000).map(|i| if i == 7 { 1e6 } else { 0.0 }).collect());
        assert!(outlier.opacity(0.0) == 0.0 && outlier.opacity(1e6) > 0.0);
        let negative = automatic((0..1000).map(|i| -1000.0 + i as f32).collect());
        assert!(negative.opacity(-1000.0) == 0.0 && negative.opacity(-1.0) > 0.0);
    }

    #[test]
    fn constant_volumes_have_one_too() {
        for value in [0.0, 5.0, -5.0] {
            assert!(automatic(vec![value; 8]).opacity(value.into()).is_finite());
        }
        assert!(automatic(vec![5.0; 8]).opacity(5.0) > 0.0);
    }

    /// Nested balls: noisy air, then a soft, a hard and a very hard material.
    #[test]
    fn materials_have_colours_of_their_own_and_noise_none() {
        let n = 48;
        let value = |i: usize| {
            let p = DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64) - 23.5;
            let noise = ((i * 7919) % 13) as f64;
            noise + [(8.0, 900.0), (14.0, 600.0), (20.0, 300.0)].iter().find(|b| p.length() < b.0).map_or(0.0, |b| b.1)
        };
        let grid = Grid::new([n; 3], DVec3::ONE).unwrap();
        let values = (0..n * n * n).map(|i| value(i) as f32).collect();
        let transfer = TransferFunction::automatic(&Volume::new("balls", grid, Voxels::Float32(values)).unwrap());
        assert_eq!(transfer.opacity(12.0), 0.0, "noise must be transparent");
        let materials = [306.0, 606.0, 906.0];
        let opacities = materials.map(|v| transfer.opacity(v));
        assert!(opacities[0] > 0.0 && opacities[0] < opacities[1] && opacities[1] < opacities[2], "{opacities:?}");
        let colors = materials.map(|v| transfer.color(v));
        for (a, b) in [(0, 1), (1, 2), (0, 2)] {
            let difference = (0..3).map(|c| (colors[a][c] - colors[b][c]).abs()).fold(0.0, f64::max);
            assert!(difference > 0.25, "{colors:?}");
        }
    }
}
