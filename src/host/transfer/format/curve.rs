//! Approximates VTK's curves between control points by linear pieces.

use super::MAX_POINTS;
use crate::transfer::ControlPoint;

/// Largest error of the approximation, in units of colour and opacity: a quarter of an 8-bit step.
pub(super) const TOLERANCE: f64 = 1e-3;
/// Subdivision levels of each half of a curve: 4 to 256 pieces, enough to follow the steepest curves within the tolerance.
const HALVINGS: std::ops::Range<u32> = 2..8;

/// A control point with the shape of the curve that follows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node<const N: usize> {
    pub value: f64,
    pub y: [f64; N],
    /// Fraction of the interval at which the curve reaches half its height, 0 … 1.
    pub midpoint: f64,
    /// 0: straight on both sides of the midpoint; 1: nearly a step there.
    pub sharpness: f64,
}

impl<const N: usize> Node<N> {
    /// A node followed by a straight line.
    pub fn straight(value: f64, y: [f64; N]) -> Self {
        Self { value, y, midpoint: 0.5, sharpness: 0.0 }
    }
}

/// Interpolation between two nodes.
pub(super) enum Mix<'a, const N: usize> {
    /// A line.
    Straight,
    /// Any other curve: from, to, fraction.
    Curved(&'a dyn Fn([f64; N], [f64; N], f64) -> [f64; N]),
}

/// Control points of the piecewise-linear approximation, or a description of what is wrong with the nodes.
pub(super) fn pieces<const N: usize>(nodes: &[Node<N>], mix: &Mix<N>) -> Result<Vec<ControlPoint<[f64; N]>>, String> {
    let unit = 0.0..=1.0;
    if let Some(node) = nodes.iter().find(|n| !unit.contains(&n.midpoint) || !unit.contains(&n.sharpness)) {
        let Node { value, midpoint, sharpness, .. } = node;
        return Err(format!("the point at {value} has midpoint {midpoint} and sharpness {sharpness}: both must be from 0 to 1"));
    }
    let mut points: Vec<_> = nodes.first().map(|node| (node.value, node.y)).into_iter().collect();
    for pair in nodes.windows(2) {
        between(&pair[0], &pair[1], mix, &mut points);
        if points.len() > MAX_POINTS {
            return Err(format!("has more than {MAX_POINTS} points, including those that approximate its curves: use fewer"));
        }
    }
    Ok(points)
}

/// Appends the control points after `from`, up to and including `to`.
fn between<const N: usize>(from: &Node<N>, to: &Node<N>, mix: &Mix<N>, points: &mut Vec<ControlPoint<[f64; N]>>) {
    let (midpoint, sharpness) = bounded(from);
    let value = |share: f64| if share < 1.0 { from.value + (to.value - from.value) * share } else { to.value };
    let mixed = |share: f64| match mix {
        Mix::Straight => std::array::from_fn(|c| from.y[c] + (to.y[c] - from.y[c]) * share),
        Mix::Curved(curve) => curve(from.y, to.y, share),
    };
    if from.value >= to.value {
        points.push((to.value, to.y));
    } else if matches!(mix, Mix::Straight) && sharpness < STRAIGHT {
        points.extend((midpoint != 0.5).then(|| (value(midpoint), mixed(0.5))));
        points.push((to.value, to.y));
    } else {
        let at = |share: f64| mixed(eased(share, midpoint, sharpness));
        for (begin, end) in [(0.0, midpoint), (midpoint, 1.0)] {
            halved(&at, (begin, at(begin)), (end, at(end)), 0, &mut |share, y| points.push((value(share), y)));
        }
        // The round trip through a colour space loses digits; the end point must be exact.
        if let Some(last) = points.last_mut() {
            *last = (to.value, to.y);
        }
    }
}

/// Pushes the ends of the linear pieces that approximate `curve` between two of its points.
fn halved<const N: usize>(
    curve: &impl Fn(f64) -> [f64; N],
    from: (f64, [f64; N]),
    to: (f64, [f64; N]),
    halvings: u32,
    push: &mut impl FnMut(f64, [f64; N]),
) {
    let share = |part: f64| from.0 + (to.0 - from.0) * part;
    let off = |part: f64| {
        let y = curve(share(part));
        (0..N).any(|c| (y[c] - from.1[c] - (to.1[c] - from.1[c]) * part).abs() > TOLERANCE / 2.0)
    };
    if halvings < HALVINGS.start || (halvings < HALVINGS.end && [0.25, 0.5, 0.75].into_iter().any(off)) {
        let middle = (share(0.5), curve(share(0.5)));
        halved(curve, from, middle, halvings + 1, push);
        halved(curve, middle, to, halvings + 1, push);
    } else {
        push(to.0, to.1);
    }
}

/// Sharpness below which a curve counts as straight.
const STRAIGHT: f64 = 0.01;

/// Midpoint, kept away from both ends, and sharpness.
fn bounded<const N: usize>(node: &Node<N>) -> (f64, f64) {
    (node.midpoint.clamp(1e-5, 1.0 - 1e-5), node.sharpness)
}

/// Fraction of the height reached at fraction `share` of the interval: the curve of `vtkPiecewiseFunction`. A power law pulls each
/// side of the midpoint towards its end. A Hermite spline then eases it, with flatter ends for higher sharpness.
fn eased(share: f64, midpoint: f64, sharpness: f64) -> f64 {
    let even = if share < midpoint { 0.5 * share / midpoint } else { 0.5 + 0.5 * (share - midpoint) / (1.0 - midpoint) };
    if sharpness < STRAIGHT {
        return even;
    }
    let power = 1.0 + 10.0 * sharpness;
    let t = if even < 0.5 { 0.5 * (2.0 * even).powf(power) } else { 1.0 - 0.5 * (2.0 - 2.0 * even).powf(power) };
    let (t2, t3) = (t * t, t * t * t);
    // Both end slopes of the Hermite spline are 1 − sharpness.
    let eased = 3.0 * t2 - 2.0 * t3 + (1.0 - sharpness) * (2.0 * t3 - 3.0 * t2 + t);
    eased.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::interpolate;

    fn function(midpoint: f64, sharpness: f64) -> Vec<ControlPoint<[f64; 1]>> {
        let nodes = [Node { value: 10.0, y: [0.2], midpoint, sharpness }, Node::straight(30.0, [0.8])];
        pieces(&nodes, &Mix::Straight).unwrap()
    }

    fn at(points: &[ControlPoint<[f64; 1]>], value: f64) -> f64 {
        interpolate(points, value, |a, b, t| [a[0] + (b[0] - a[0]) * t])[0]
    }

    #[test]
    fn straight_ones_stay_as_they_are() {
        assert_eq!(function(0.5, 0.0), [(10.0, [0.2]), (30.0, [0.8])]);
        let bent = function(0.25, 0.0);
        assert_eq!((bent.len(), bent[1]), (3, (15.0, [0.5])));
    }

    /// Derived by hand: at sharpness 1, half-way to the midpoint, t = 1/2·(1/2)^11 and the fraction is 3t² − 2t³.
    #[test]
    fn sharp_ones_have_the_closed_form() {
        let t = 0.5 * 0.5f64.powi(11);
        assert!((eased(0.375, 0.75, 1.0) - (3.0 * t * t - 2.0 * t * t * t)).abs() < 1e-15);
        // At sharpness 0.5: t = 1/2·(1/2)^6, and half of the slope term.
        let t = 0.5 * 0.5f64.powi(6);
        let expected = 3.0 * t * t - 2.0 * t * t * t + 0.5 * (2.0 * t * t * t - 3.0 * t * t + t);
        assert!((eased(0.1, 0.2, 0.5) - expected).abs() < 1e-15 && (eased(0.6, 0.2, 0.5) - (1.0 - expected)).abs() < 1e-15);
    }

    #[test]
    fn halves_are_reached_at_the_midpoint_and_ends_kept() {
        for midpoint in [0.1, 0.5, 0.9] {
            for sharpness in [0.05, 0.3, 0.6, 0.9, 1.0] {
                let curve = function(midpoint, sharpness);
                assert_eq!((curve[0], curve[curve.len() - 1]), ((10.0, [0.2]), (30.0, [0.8])));
                assert!((at(&curve, 10.0 + 20.0 * midpoint) - 0.5).abs() < 1e-12, "{midpoint} {sharpness}");
                assert!(curve.is_sorted_by(|a, b| a.0 <= b.0 && a.1 <= b.1), "it rises: {midpoint} {sharpness}");
            }
        }
    }

    #[test]
    fn pieces_are_as_near_as_promised() {
        for midpoint in [0.0, 0.02, 0.5, 0.7, 1.0] {
            for sharpness in [0.0, 0.02, 0.2, 0.5, 0.8, 1.0] {
                let curve = function(midpoint, sharpness);
                let bounded = midpoint.clamp(1e-5, 1.0 - 1e-5);
                for i in 0..=5000 {
                    let share = f64::from(i) / 5000.0;
                    let off = at(&curve, 10.0 + 20.0 * share) - 0.2 - 0.6 * eased(share, bounded, sharpness);
                    assert!(off.abs() <= TOLERANCE, "{midpoint} {sharpness} at {share}: {off}");
                }
            }
        }
    }

    #[test]
    fn shapes_beyond_0_and_1_and_too_many_points_are_refused() {
        for (midpoint, sharpness) in [(-0.1, 0.0), (0.5, 1.1), (f64::NAN, 0.0), (0.5, f64::NAN)] {
            let nodes = [Node { value: 1.0, y: [0.0], midpoint, sharpness }];
            assert!(pieces(&nodes, &Mix::Straight).unwrap_err().contains("midpoint"));
        }
        let many: Vec<Node<1>> =
            (0..3000).map(|i| Node { value: f64::from(i), y: [f64::from(i % 2)], midpoint: 0.5, sharpness: 0.7 }).collect();
        assert!(pieces(&many, &Mix::Straight).unwrap_err().contains("use fewer"));
    }
}
