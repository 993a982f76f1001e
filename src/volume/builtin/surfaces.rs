//! Surfaces and tubes with smooth edges.

use super::{Made, coordinates, made};
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

/// g / |∇g| approximates the distance from the gyroid g = sin x cos y + sin y cos z + sin z cos x = 0.
fn gyroid_density(point: DVec3) -> f64 {
    const PERIODS: f64 = 2.5;
    const THICKNESS: f64 = 0.28;
    let q = point * (PI * PERIODS);
    let (sin, cos) = (q.map(f64::sin), q.map(f64::cos));
    let g = sin.x * cos.y + sin.y * cos.z + sin.z * cos.x;
    let slope = DVec3::new(cos.x * cos.y - sin.z * sin.x, cos.y * cos.z - sin.x * sin.y, cos.z * cos.x - sin.y * sin.z);
    // |∇g| is at least about 1 on the surface, but may vanish elsewhere.
    soft(g / slope.length().max(0.5), THICKNESS) * within(point.length(), 0.93, 0.08)
}

/// The half-plane at angle φ around the axis cuts the knot twice: at angles 3φ/2 and 3φ/2 + π of the tube.
fn torus_knot_density(point: DVec3) -> f64 {
    const RADIUS: f64 = 0.56;
    const WINDING: f64 = 0.24;
    const TUBE: f64 = 0.1;
    let around = point.y.atan2(point.x);
    let across = DVec2::new(point.truncate().length() - RADIUS, point.z);
    let strand = DVec2::from_angle(1.5 * around) * WINDING;
    let distance = |strand: DVec2| {
        // The line crosses the plane at an angle: one and a half turns per revolution. Its true distance is therefore shorter.
        let along = RADIUS + strand.x;
        across.distance(strand) * along / along.hypot(1.5 * WINDING)
    };
    soft(distance(strand).min(distance(-strand)), TUBE)
}

pub(super) fn gyroid(dims: [usize; 3]) -> Arc<dyn Made> {
    sampled(dims, gyroid_density)
}

pub(super) fn torus_knot(dims: [usize; 3]) -> Arc<dyn Made> {
    sampled(dims, torus_knot_density)
}

fn sampled(dims: [usize; 3], density: fn(DVec3) -> f64) -> Arc<dyn Made> {
    let [x, y, z] = coordinates(dims);
    made(dims, move |i, j, k| density(DVec3::new(x[i], y[j], z[k])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_knot_is_where_its_line_is() {
        for n in 0..200 {
            let t = f64::from(n) / 200.0 * 4.0 * PI;
            let radius = 0.56 + 0.24 * (1.5 * t).cos();
            let on = DVec3::new(radius * t.cos(), radius * t.sin(), 0.24 * (1.5 * t).sin());
            assert!((torus_knot_density(on) - 1.0).abs() < 1e-12, "{t}");
            // The middle of the torus tube and its outside are empty.
            let middle = DVec3::new(0.56 * t.cos(), 0.56 * t.sin(), 0.0);
            assert!(torus_knot_density(middle) < 0.2 && torus_knot_density(on * 1.6 + DVec3::Z) < 1e-3, "{t}");
        }
    }

    #[test]
    fn the_gyroid_is_where_its_function_vanishes() {
        let step = 1.0 / 2.5;
        // A zero of g; then its maximum, a quarter of a period away.
        assert_eq!(gyroid_density(DVec3::ZERO), 1.0);
        assert!(gyroid_density(DVec3::new(step / 2.0, 0.0, step / 4.0)) < 0.1);
        assert_eq!((gyroid_density(DVec3::X), gyroid_density(DVec3::splat(0.7))), (0.0, 0.0));
        // Half a period along an axis changes the sign of some terms.
        assert!((gyroid_density(DVec3::X * step) - 1.0).abs() < 1e-12);
    }
}
