//! Surfaces and tubes with smooth edges.

use super::{Made, coordinates, kept_columns, made};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// Gaussian falloff: 1 at distance 0, 0.5 at distance `half`, 0 far away.
fn soft(distance: f64, half: f64) -> f64 {
    (-(distance / half).powi(2) * std::f64::consts::LN_2).exp()
}

/// Smooth step from 1 inside `radius` to 0 outside, over `width`.
fn within(distance: f64, radius: f64, width: f64) -> f64 {
    let t = ((radius - distance) / width + 0.5).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Phase of a coordinate of the gyroid.
fn phase(coordinate: f64) -> f64 {
    const PERIODS: f64 = 2.5;
    coordinate * (PI * PERIODS)
}

/// g / |∇g| approximates the distance from the gyroid g = sin x cos y + sin y cos z + sin z cos x = 0. `sin` and `cos` are those of the phases
/// of `point`.
fn gyroid_density(point: DVec3, sin: DVec3, cos: DVec3) -> f64 {
    const THICKNESS: f64 = 0.28;
    let inside = within(point.length(), 0.93, 0.08);
    if inside == 0.0 {
        return 0.0;
    }
    let g = sin.x * cos.y + sin.y * cos.z + sin.z * cos.x;
    let slope = DVec3::new(cos.x * cos.y - sin.z * sin.x, cos.y * cos.z - sin.x * sin.y, cos.z * cos.x - sin.y * sin.z);
    // |∇g| is at least about 1 on the surface, but may vanish elsewhere.
    soft(g / slope.length().max(0.5), THICKNESS) * inside
}

const KNOT_RADIUS: f64 = 0.56;
const KNOT_WINDING: f64 = 0.24;

/// What points of one x and y have in common: their distance from the axis less the radius, and a strand's position in their half-plane.
#[derive(Clone, Copy)]
struct KnotColumn {
    across: f64,
    strand: DVec2,
}

impl KnotColumn {
    fn new(x: f64, y: f64) -> Self {
        let strand = DVec2::from_angle(1.5 * y.atan2(x)) * KNOT_WINDING;
        Self { across: DVec2::new(x, y).length() - KNOT_RADIUS, strand }
    }

    /// The half-plane at angle φ around the axis cuts the knot twice: at angles 3φ/2 and 3φ/2 + π of the tube.
    fn density(self, z: f64) -> f64 {
        const TUBE: f64 = 0.1;
        let distance = |strand: DVec2| {
            // The line crosses the plane at an angle: one and a half turns per revolution. Its true distance is therefore shorter.
            let along = KNOT_RADIUS + strand.x;
            DVec2::new(self.across, z).distance(strand) * along / along.hypot(1.5 * KNOT_WINDING)
        };
        soft(distance(self.strand).min(distance(-self.strand)), TUBE)
    }
}

pub(super) fn gyroid(dims: [usize; 3]) -> Arc<dyn Made> {
    let axes = coordinates(dims).map(|axis| axis.into_iter().map(|x| (x, phase(x).sin(), phase(x).cos())).collect::<Vec<_>>());
    made(dims, move |i, j, k| {
        let [x, y, z] = [axes[0][i], axes[1][j], axes[2][k]];
        gyroid_density(DVec3::new(x.0, y.0, z.0), DVec3::new(x.1, y.1, z.1), DVec3::new(x.2, y.2, z.2))
    })
}

pub(super) fn torus_knot(dims: [usize; 3]) -> Arc<dyn Made> {
    let [x, y, z] = coordinates(dims);
    let column = move |i: usize, j: usize| KnotColumn::new(x[i], y[j]);
    let column = kept_columns(dims, column);
    made(dims, move |i, j, k| column(i, j).density(z[k]))
}

#[cfg(test)]
mod tests {
    use super::super::{layers, unit_coordinate};
    use super::*;

    fn gyroid_at(point: DVec3) -> f64 {
        let phases = point.map(phase);
        gyroid_density(point, phases.map(f64::sin), phases.map(f64::cos))
    }

    fn torus_knot_at(point: DVec3) -> f64 {
        KnotColumn::new(point.x, point.y).density(point.z)
    }

    /// Tables and threads do not change a byte.
    #[test]
    fn voxels_have_the_density_of_their_point() {
        for dims in [[31, 17, 20], [1, 9, 8], [20, 18, 1]] {
            for (made, density) in [(gyroid(dims), gyroid_at as fn(DVec3) -> f64), (torus_knot(dims), torus_knot_at)] {
                let bytes = layers("made", &*made, dims, &(0..dims[2])).unwrap();
                let place = |n: usize| [n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]];
                let point = |n: usize| DVec3::from_array(std::array::from_fn(|a| unit_coordinate(place(n)[a], dims[a])));
                let expected: Vec<u8> = (0..bytes.len()).map(|n| (density(point(n)) * 255.0).round() as u8).collect();
                assert!(bytes == expected && bytes.iter().any(|&byte| byte > 0), "{dims:?}");
            }
        }
    }

    #[test]
    fn the_knot_is_where_its_line_is() {
        for n in 0..200 {
            let t = f64::from(n) / 200.0 * 4.0 * PI;
            let radius = 0.56 + 0.24 * (1.5 * t).cos();
            let on = DVec3::new(radius * t.cos(), radius * t.sin(), 0.24 * (1.5 * t).sin());
            assert!((torus_knot_at(on) - 1.0).abs() < 1e-12, "{t}");
            // The middle of the torus tube and its outside are empty.
            let middle = DVec3::new(0.56 * t.cos(), 0.56 * t.sin(), 0.0);
            assert!(torus_knot_at(middle) < 0.2 && torus_knot_at(on * 1.6 + DVec3::Z) < 1e-3, "{t}");
        }
    }

    #[test]
    fn the_gyroid_is_where_its_function_vanishes() {
        let step = 1.0 / 2.5;
        // A zero of g; then its maximum, a quarter of a period away.
        assert_eq!(gyroid_at(DVec3::ZERO), 1.0);
        assert!(gyroid_at(DVec3::new(step / 2.0, 0.0, step / 4.0)) < 0.1);
        assert_eq!((gyroid_at(DVec3::X), gyroid_at(DVec3::splat(0.7))), (0.0, 0.0));
        // Half a period along an axis changes the sign of some terms.
        assert!((gyroid_at(DVec3::X * step) - 1.0).abs() < 1e-12);
    }
}
