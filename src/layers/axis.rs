//! The layer axis: the one most parallel to the view, in voxel units.

use glam::DVec3;
use serde::Serialize;

/// An axis of the voxel grid.
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

    /// This axis with the other two.
    pub fn frame(self) -> AxisFrame {
        match self {
            Axis::X => AxisFrame { u: 1, v: 2, a: 0 },
            Axis::Y => AxisFrame { u: 0, v: 2, a: 1 },
            Axis::Z => AxisFrame { u: 0, v: 1, a: 2 },
        }
    }
}

/// A layer axis `a` and the in-layer axes `u` < `v`, as indices into x, y, z.
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
}
