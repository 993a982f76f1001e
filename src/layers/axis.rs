//! The layer axis: the one most parallel to the view, in voxel units.

use glam::DVec3;
use serde::Serialize;

/// An axis of the voxel grid.
///
/// ```
/// use layersplat::{Axis, glam::DVec3};
///
/// assert_eq!(Axis::most_parallel(DVec3::new(0.2, -0.9, 0.3)), Axis::Y);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// i, the fastest in memory.
    X,
    /// j.
    Y,
    /// k, the slowest in memory.
    Z,
}

/// Directions closer to 45° than this (relative) count as a tie: the lowest axis wins, whatever rounding says.
const TIE: f64 = 1e-9;

/// Components within this share of the largest take part in [`Axis::shares`]: 1.5° about 45°. Turning through it no picture
/// changes by more than a step of 8 bits per 0.1°.
const NEARLY: f64 = 0.05;

impl Axis {
    /// All three, in order.
    pub const ALL: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

    /// 0, 1 or 2.
    pub fn index(self) -> usize {
        self as usize
    }

    /// The 45° rule: argmax |d| of a direction in voxel units; on a tie the lowest index.
    pub fn most_parallel(direction: DVec3) -> Axis {
        let d = direction.abs();
        let limit = d.max_element() * (1.0 - TIE);
        Axis::ALL.into_iter().find(|a| d[a.index()] >= limit).unwrap_or(Axis::X)
    }

    /// How much each layer axis has to say in a direction in voxel units, most parallel first: one axis alone but for
    /// directions within 1.5° of 45°, and shares that change smoothly there. They sum to 1.
    pub fn shares(direction: DVec3) -> Vec<(Axis, f64)> {
        let first = Self::most_parallel(direction);
        let largest = direction.abs().max_element();
        let share = |axis: Axis| {
            let t = ((direction[axis.index()].abs() / largest - 1.0) / NEARLY + 1.0).clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t)
        };
        let others = Axis::ALL.into_iter().filter(|&axis| axis != first);
        let mut shares: Vec<(Axis, f64)> = std::iter::once(first).chain(others).map(|a| (a, share(a))).collect();
        let sum: f64 = shares.iter().map(|s| s.1).sum();
        shares.retain(|s| s.1 > 0.0);
        shares.into_iter().map(|(axis, share)| (axis, share / sum)).collect()
    }

    /// This axis with the other two.
    pub fn frame(self) -> AxisFrame {
        match self {
            Axis::X => AxisFrame { u: 2, v: 1, a: 0 },
            Axis::Y => AxisFrame { u: 0, v: 2, a: 1 },
            Axis::Z => AxisFrame { u: 0, v: 1, a: 2 },
        }
    }
}

/// A layer axis `a` and the in-layer axes `u` and `v`, as indices into x, y, z. About y all is turned alike, as cameras turn: where y is
/// in the layers and another axis beside it, y is v.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AxisFrame {
    /// First in-layer axis.
    pub u: usize,
    /// Second in-layer axis.
    pub v: usize,
    /// Layer axis.
    pub a: usize,
}

impl AxisFrame {
    /// The layer axis.
    pub fn layer_axis(self) -> Axis {
        Axis::ALL[self.a]
    }

    /// A vector (x, y, z) as (u, v, a).
    pub fn local(self, p: DVec3) -> DVec3 {
        DVec3::new(p[self.u], p[self.v], p[self.a])
    }

    /// A vector (u, v, a) as (x, y, z).
    pub fn global(self, p: DVec3) -> DVec3 {
        let mut out = DVec3::ZERO;
        (out[self.u], out[self.v], out[self.a]) = (p.x, p.y, p.z);
        out
    }

    /// The shear (s_u, s_v) of a direction: how far a ray moves in u and v from one layer to the next. Infinite or NaN
    /// for a direction that lies in the layers.
    pub fn shear(self, direction: DVec3) -> [f64; 2] {
        [direction[self.u] / direction[self.a], direction[self.v] / direction[self.a]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn argmax_with_ties_to_the_lowest() {
        assert_eq!(Axis::most_parallel(DVec3::new(0.2, -0.9, 0.5)), Axis::Y);
        assert_eq!(Axis::most_parallel(DVec3::new(-0.1, 0.2, -0.3)), Axis::Z);
        let (s, c) = 45f64.to_radians().sin_cos();
        assert_eq!(Axis::most_parallel(DVec3::new(s, 0.0, c)), Axis::X);
        assert_eq!(Axis::most_parallel(DVec3::new(c, 0.0, s)), Axis::X);
        assert_eq!(Axis::most_parallel(DVec3::new(0.0, s, -c)), Axis::Y);
    }

    #[test]
    fn local_and_global_are_inverse() {
        for axis in Axis::ALL {
            let p = DVec3::new(1.0, 2.0, 3.0);
            assert_eq!(axis.frame().global(axis.frame().local(p)), p);
        }
    }

    #[test]
    fn shares_change_smoothly_and_end_where_one_axis_is_enough() {
        assert_eq!(Axis::shares(DVec3::new(0.2, -1.0, 0.9)), [(Axis::Y, 1.0)]);
        let at = |degrees: f64| Axis::shares(DVec3::new(degrees.to_radians().cos(), degrees.to_radians().sin(), 0.1));
        assert_eq!(at(45.0), [(Axis::X, 0.5), (Axis::Y, 0.5)]);
        let mut last = 1.0;
        for n in 0..=400 {
            let shares = at(43.0 + 0.01 * f64::from(n));
            assert!((shares.iter().map(|s| s.1).sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(shares.windows(2).all(|pair| pair[0].1 >= pair[1].1 - 1e-9));
            let of_x = shares.iter().find(|s| s.0 == Axis::X).map_or(0.0, |s| s.1);
            assert!(of_x <= last && last - of_x < 0.006, "{n}: from {last} to {of_x}");
            last = of_x;
        }
        assert_eq!(last, 0.0);
    }
}
