//! Layer axis: the grid axis most parallel to the view, in voxel units.

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

/// Relative tolerance of ties at 45°, where the lowest axis wins. Absorbs rounding errors.
const TIE: f64 = 1e-9;

/// Axes whose components are within this fraction of the largest take part in [`Axis::shares`]: within 1.5° of 45°. A rotation through
/// this range changes no pixel by more than an 8-bit step per 0.1°.
const NEARLY: f64 = 0.05;

impl Axis {
    /// All axes, in order.
    pub const ALL: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

    /// 0, 1 or 2 for x, y or z.
    pub fn index(self) -> usize {
        self as usize
    }

    /// The 45° rule: argmax |d| of a direction in voxel units. On a tie the lowest axis wins.
    pub fn most_parallel(direction: DVec3) -> Axis {
        let d = direction.abs();
        let limit = d.max_element() * (1.0 - TIE);
        Axis::ALL.into_iter().find(|a| d[a.index()] >= limit).unwrap_or(Axis::X)
    }

    /// Blend weights of the layer axes for a direction in voxel units, most parallel axis first. The weights sum to 1. Only directions within
    /// 1.5° of 45° have more than one axis; there the weights change smoothly.
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

    /// Local frame with this axis as the layer axis.
    pub fn frame(self) -> AxisFrame {
        match self {
            Axis::X => AxisFrame { u: 2, v: 1, a: 0 },
            Axis::Y => AxisFrame { u: 0, v: 2, a: 1 },
            Axis::Z => AxisFrame { u: 0, v: 1, a: 2 },
        }
    }
}

/// Layer axis `a` and in-layer axes `u` and `v`, as indices into x, y, z.
///
/// Cameras orbit about y, so y is v whenever it is an in-layer axis.
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

    /// Converts (x, y, z) to (u, v, a).
    pub fn local(self, p: DVec3) -> DVec3 {
        DVec3::new(p[self.u], p[self.v], p[self.a])
    }

    /// Converts (u, v, a) to (x, y, z).
    pub fn global(self, p: DVec3) -> DVec3 {
        let mut out = DVec3::ZERO;
        (out[self.u], out[self.v], out[self.a]) = (p.x, p.y, p.z);
        out
    }

    /// Shear (s_u, s_v) of a direction: offset of a ray in u and v per layer. Infinite or NaN for directions parallel to the layers.
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
            let share_of_x = shares.iter().find(|s| s.0 == Axis::X).map_or(0.0, |s| s.1);
            assert!(share_of_x <= last && last - share_of_x < 0.006, "{n}: from {last} to {share_of_x}");
            last = share_of_x;
        }
        assert_eq!(last, 0.0);
    }
}
