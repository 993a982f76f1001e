//! Quadrature over the kernel's depth.

use super::kernel_function::kernel_function;

/// A node z in \[−1, 1\] of the quadrature over the kernel's depth, and its weight. All weights sum to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussNode {
    /// Position in layers.
    pub z: f64,
    /// Gauss weight times f(z), normalised.
    pub weight: f64,
}

/// Four Gauss nodes on each half of \[−1, 1\], weighted with f(z): F(x, y) ≈ Σ w f(x + s_u z) f(y + s_v z). The weights sum to 1, so the
/// lattice sum is exactly 1.
pub fn quadrature_nodes() -> [GaussNode; 8] {
    const HALF: [(f64, f64); 4] = [
        (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
        (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    ];
    let mut nodes = [GaussNode { z: 0.0, weight: 0.0 }; 8];
    for (i, node) in nodes.iter_mut().enumerate() {
        let (x, w) = HALF[i % 4];
        node.z = (x + if i < 4 { -1.0 } else { 1.0 }) / 2.0;
        node.weight = w * kernel_function(node.z);
    }
    let sum: f64 = nodes.iter().map(|n| n.weight).sum();
    nodes.map(|n| GaussNode { weight: n.weight / sum, ..n })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layers::footprint;
    use approx::assert_abs_diff_eq;

    /// math.md states 0.25 % of the value range for eight nodes and |s| ≤ 1; single footprints stay within it, too.
    const QUADRATURE_ERROR: f64 = 0.0025;

    #[test]
    fn nodes_sum_to_one_and_approach_the_footprint() {
        let nodes = quadrature_nodes();
        assert_abs_diff_eq!(nodes.iter().map(|n| n.weight).sum::<f64>(), 1.0, epsilon = 1e-15);
        let mut largest: f64 = 0.0;
        for (s_u, s_v) in [(0.0, 0.0), (0.4, -0.9), (1.0, 1.0), (1.0, 0.3)] {
            for (x, y) in [(0.0, 0.0), (0.5, 0.25), (0.9, 0.1), (0.33, 1.2)] {
                let sum: f64 =
                    nodes.iter().map(|n| n.weight * kernel_function(x + s_u * n.z) * kernel_function(y + s_v * n.z)).sum();
                largest = largest.max((sum - footprint(x, y, s_u, s_v)).abs());
            }
        }
        assert!(largest < QUADRATURE_ERROR, "{largest}");
    }
}
