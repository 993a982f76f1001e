//! Colour paths of least CIEDE2000 difference, for ParaView's colour space `Lab/CIEDE2000` (Zeyen et al. 2018).
//!
//! A path is a shortest path in a grid of RGB colours. Its parameter is the fraction of the accumulated colour difference.

use super::color_space::{Triple, lab};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Grid steps per channel, and grid nodes per channel.
const STEPS: usize = 16;
const SIDE: usize = STEPS + 1;

/// CIELAB coordinates of the grid nodes.
static LABS: LazyLock<Vec<Triple>> = LazyLock::new(|| (0..SIDE * SIDE * SIDE).map(|node| lab(color(node))).collect());

/// Vertices of a piecewise-linear path from one colour to another, each with its parameter in (0, 1]. The start is omitted.
pub(super) fn path(from: Triple, to: Triple) -> Vec<(f64, Triple)> {
    let nodes = shortest(nearest(from), nearest(to));
    let inner = nodes.iter().skip(1).take(nodes.len().saturating_sub(2)).map(|&node| color(node));
    let colors: Vec<Triple> = std::iter::once(from).chain(inner).chain([to]).collect();
    let mut sums = vec![0.0];
    for pair in colors.windows(2) {
        sums.push(sums[sums.len() - 1] + difference(lab(pair[0]), lab(pair[1])));
    }
    let whole = sums[sums.len() - 1];
    let last = colors.len() - 1;
    let share = |n: usize| if n == last { 1.0 } else { sums[n] / whole };
    (1..=last).map(|n| (share(n), colors[n])).collect()
}

fn coordinates(node: usize) -> [usize; 3] {
    [node % SIDE, node / SIDE % SIDE, node / (SIDE * SIDE)]
}

fn color(node: usize) -> Triple {
    coordinates(node).map(|c| c as f64 / STEPS as f64)
}

fn nearest(color: Triple) -> usize {
    let [r, g, b] = color.map(|c| (c.clamp(0.0, 1.0) * STEPS as f64).round() as usize);
    r + SIDE * (g + SIDE * b)
}

/// The up to 26 neighbours of a grid node.
fn neighbours(node: usize) -> impl Iterator<Item = usize> {
    let own = coordinates(node);
    (0..27).filter(|&n| n != 13).filter_map(move |n| {
        let offset = [n % 3, n / 3 % 3, n / 9];
        let at: [usize; 3] = std::array::from_fn(|c| (own[c] + offset[c]).wrapping_sub(1));
        at.iter().all(|&c| c < SIDE).then(|| at[0] + SIDE * (at[1] + SIDE * at[2]))
    })
}

/// Nodes of the path with the least sum of differences (Dijkstra).
fn shortest(from: usize, to: usize) -> Vec<usize> {
    let mut found = vec![(f64::INFINITY, from); LABS.len()];
    found[from].0 = 0.0;
    // The bit patterns of non-negative floats sort like the floats.
    let mut open = BinaryHeap::from([Reverse((0u64, from))]);
    while let Some(Reverse((bits, node))) = open.pop() {
        let sum = f64::from_bits(bits);
        if node == to {
            break;
        }
        if sum > found[node].0 {
            continue;
        }
        for next in neighbours(node) {
            let sum = sum + difference(LABS[node], LABS[next]);
            if sum < found[next].0 {
                found[next] = (sum, node);
                open.push(Reverse((sum.to_bits(), next)));
            }
        }
    }
    let mut nodes = vec![to];
    while nodes[nodes.len() - 1] != from {
        nodes.push(found[nodes[nodes.len() - 1]].1);
    }
    nodes.reverse();
    nodes
}

/// The CIEDE2000 difference of two colours in CIELAB (Sharma, Wu & Dalal 2005).
fn difference(one: Triple, other: Triple) -> f64 {
    let chroma = |[_, a, b]: Triple| a.hypot(b);
    let strong = |c: f64| (c.powi(7) / (c.powi(7) + 25f64.powi(7))).sqrt();
    let widened = 1.5 - 0.5 * strong((chroma(one) + chroma(other)) / 2.0);
    let polar = |[l, a, b]: Triple| {
        let a = a * widened;
        let hue = if a == 0.0 && b == 0.0 { 0.0 } else { b.atan2(a).rem_euclid(2.0 * PI) };
        (l, a.hypot(b), hue)
    };
    let ((l1, c1, h1), (l2, c2, h2)) = (polar(one), polar(other));
    let grey = c1 * c2 == 0.0;
    let turn = if grey { 0.0 } else { (h2 - h1 + PI).rem_euclid(2.0 * PI) - PI };
    let (dl, dc, dh) = (l2 - l1, c2 - c1, 2.0 * (c1 * c2).sqrt() * (turn / 2.0).sin());
    let (l, c) = ((l1 + l2) / 2.0, (c1 + c2) / 2.0);
    let hue = if grey { h1 + h2 } else { h1 + turn / 2.0 };
    let degrees = hue.to_degrees().rem_euclid(360.0);
    let wave = |times: f64, less: f64| (times * hue - less.to_radians()).cos();
    let t = 1.0 - 0.17 * wave(1.0, 30.0) + 0.24 * wave(2.0, 0.0) + 0.32 * wave(3.0, -6.0) - 0.20 * wave(4.0, 63.0);
    let light = (l - 50.0).powi(2);
    let (sl, sc, sh) = (1.0 + 0.015 * light / (20.0 + light).sqrt(), 1.0 + 0.045 * c, 1.0 + 0.015 * c * t);
    let blue = 60f64.to_radians() * (-((degrees - 275.0) / 25.0).powi(2)).exp();
    let turned = -blue.sin() * 2.0 * strong(c);
    let (dl, dc, dh) = (dl / sl, dc / sc, dh / sh);
    (dl * dl + dc * dc + dh * dh + turned * dc * dh).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs from the table of Sharma, Wu and Dalal, which has four digits.
    #[test]
    fn differences_are_the_published_ones() {
        for (one, other, expected) in [
            ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
            ([50.0, -1.3802, -84.2814], [50.0, 0.0, -82.7485], 1.0),
            ([50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
            ([50.0, 2.49, -0.001], [50.0, -2.49, 0.0009], 7.1792),
            ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
            ([50.0, 2.5, 0.0], [58.0, 24.0, 15.0], 19.4535),
            ([60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644),
            ([22.7233, 20.0904, -46.694], [23.0331, 14.973, -42.5619], 2.0373),
            ([2.0776, 0.0795, -1.135], [0.9033, -0.0636, -0.5514], 0.9082),
        ] {
            for found in [difference(one, other), difference(other, one)] {
                assert!((found - expected).abs() < 1e-4, "{one:?} {other:?}: {found} for {expected}");
            }
        }
    }

    #[test]
    fn paths_end_where_they_should_with_even_differences() {
        let (from, to) = ([0.03, 0.1, 0.97], [0.9, 0.21, 0.02]);
        let path = path(from, to);
        assert_eq!(path[path.len() - 1], (1.0, to));
        assert!(path.is_sorted_by(|a, b| a.0 < b.0));
        let first = difference(lab(from), lab(path[0].1)) / path[0].0;
        for pair in path.windows(2) {
            let rate = difference(lab(pair[0].1), lab(pair[1].1)) / (pair[1].0 - pair[0].0);
            assert!((rate / first - 1.0).abs() < 1e-9, "{pair:?}");
        }
        assert_eq!(super::path([0.5; 3], [0.51; 3]), [(1.0, [0.51; 3])]);
        assert_eq!(super::path([0.5; 3], [0.5; 3]), [(1.0, [0.5; 3])]);
    }
}
