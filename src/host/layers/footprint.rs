//! Exact footprint of a voxel in its layer.

use super::kernel_function::kernel_function;

/// Nodes and weights of the 5-point Gauss–Legendre rule on \[−1, 1\]: exact up to degree 9, the degree of f·f·f.
const GAUSS_5: [(f64, f64); 5] = [
    (0.0, 0.568_888_888_888_888_9),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

/// F(x, y) = ∫ f(x + s_u z) f(y + s_v z) f(z) dz over \[−1, 1\]: contribution of a voxel of value 1 at the origin to the splat sum at
/// (x, y) of its layer, for rays of shear (s_u, s_v). All lengths are in voxels.
///
/// Between knots of the three factors, the integrand is a polynomial of degree 9, so five-point Gauss quadrature per piece is exact.
/// Support: |x| < 1+|s_u|, |y| < 1+|s_v|. Σ F over all voxels is 1.
pub fn footprint(x: f64, y: f64, s_u: f64, s_v: f64) -> f64 {
    let mut knots = vec![-1.0, 0.0, 1.0];
    for (p, s) in [(x, s_u), (y, s_v)] {
        if s != 0.0 {
            knots.extend([-1.0, 0.0, 1.0].map(|k| (k - p) / s).into_iter().filter(|z| z.abs() < 1.0));
        }
    }
    knots.sort_by(f64::total_cmp);
    knots
        .windows(2)
        .map(|piece| {
            let (centre, half) = ((piece[0] + piece[1]) / 2.0, (piece[1] - piece[0]) / 2.0);
            let integrand = |z: f64| kernel_function(x + s_u * z) * kernel_function(y + s_v * z) * kernel_function(z);
            half * GAUSS_5.iter().map(|(node, weight)| weight * integrand(centre + half * node)).sum::<f64>()
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn lattice_sum(x: f64, y: f64, s_u: f64, s_v: f64) -> f64 {
        let reach = |s: f64| (2.0 + s.abs()).ceil() as i32;
        let rows = -reach(s_v)..=reach(s_v);
        rows.flat_map(|j| (-reach(s_u)..=reach(s_u)).map(move |i| (i, j)))
            .map(|(i, j)| footprint(x - f64::from(i), y - f64::from(j), s_u, s_v))
            .sum()
    }

    #[test]
    fn lattice_sum_is_one_for_every_direction_and_offset() {
        for (s_u, s_v) in [(0.0, 0.0), (0.3, -0.7), (1.0, 1.0), (-1.0, 0.2), (0.5, 0.5), (1e-9, 0.4), (2.5, -1.7)] {
            for (x, y) in [(0.0, 0.0), (0.5, 0.5), (0.13, 0.77), (0.999, 1e-7)] {
                assert_abs_diff_eq!(lattice_sum(x, y, s_u, s_v), 1.0, epsilon = 1e-12);
            }
        }
    }

    #[test]
    fn straight_on_it_is_the_cross_section() {
        for (x, y) in [(0.0, 0.0), (0.25, -0.5), (0.9, 0.1)] {
            assert_abs_diff_eq!(footprint(x, y, 0.0, 0.0), kernel_function(x) * kernel_function(y), epsilon = 1e-14);
        }
    }

    #[test]
    fn support_and_symmetry() {
        assert_abs_diff_eq!(footprint(1.6, 0.0, 0.6, 0.2), 0.0);
        assert!(footprint(1.5, 0.0, 0.6, 0.2) > 0.0);
        assert_abs_diff_eq!(footprint(0.3, 0.4, 0.6, 0.2), footprint(-0.3, -0.4, 0.6, 0.2), epsilon = 1e-15);
        assert_abs_diff_eq!(footprint(0.3, 0.4, 0.6, 0.2), footprint(0.4, 0.3, 0.2, 0.6), epsilon = 1e-15);
    }

    #[test]
    fn its_integral_is_one() {
        let n = 200;
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n {
                let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n) * 4.0 - 2.0;
                sum += footprint(at(i), at(j), 0.7, -0.4);
            }
        }
        assert_abs_diff_eq!(sum * 16.0 / f64::from(n * n), 1.0, epsilon = 1e-5);
    }
}
