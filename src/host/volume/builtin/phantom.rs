//! Three-dimensional Shepp–Logan head phantom: a sum of ellipsoids.

use super::{Made, coordinates, made};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Centre, half axes, rotation about z in degrees, and the density added inside.
struct Ellipsoid {
    centre: [f64; 3],
    axes: [f64; 3],
    angle: f64,
    density: f64,
}

const fn ellipsoid(centre: [f64; 3], axes: [f64; 3], angle: f64, density: f64) -> Ellipsoid {
    Ellipsoid { centre, axes, angle, density }
}

/// Geometry of Kak & Slaney, *Principles of Computerized Tomographic Imaging* (1988), chapter 3. Their contrasts are 1 % of the skull's
/// density. These are ten times larger, as Toft proposed for display.
const ELLIPSOIDS: [Ellipsoid; 10] = [
    ellipsoid([0.0, 0.0, 0.0], [0.69, 0.92, 0.9], 0.0, 1.0),
    ellipsoid([0.0, 0.0, 0.0], [0.6624, 0.874, 0.88], 0.0, -0.8),
    ellipsoid([-0.22, 0.0, -0.25], [0.41, 0.16, 0.21], 108.0, -0.2),
    ellipsoid([0.22, 0.0, -0.25], [0.31, 0.11, 0.22], 72.0, -0.2),
    ellipsoid([0.0, 0.35, -0.25], [0.21, 0.25, 0.5], 0.0, 0.1),
    ellipsoid([0.0, 0.1, -0.25], [0.046, 0.046, 0.046], 0.0, 0.1),
    ellipsoid([-0.08, -0.65, -0.25], [0.046, 0.023, 0.02], 0.0, 0.1),
    ellipsoid([0.06, -0.65, -0.25], [0.046, 0.023, 0.02], 90.0, 0.1),
    ellipsoid([0.06, -0.105, 0.625], [0.056, 0.04, 0.1], 90.0, 0.1),
    ellipsoid([0.0, 0.1, 0.625], [0.056, 0.056, 0.1], 0.0, -0.1),
];

impl Ellipsoid {
    /// Approximate signed distance from the surface, negative inside; exact on the surface.
    fn distance(&self, point: DVec3) -> f64 {
        let axes = DVec3::from_array(self.axes);
        let from_centre = point - DVec3::from_array(self.centre);
        let turned = DVec2::from_angle(-self.angle.to_radians()).rotate(from_centre.truncate()).extend(from_centre.z);
        let (scaled, steep) = (turned / axes, turned / (axes * axes));
        let size = scaled.length();
        // The gradient vanishes at the centre. Use the distance to the nearest pole there.
        if size < 0.5 { (size - 1.0) * axes.min_element() } else { (size - 1.0) * size / steep.length() }
    }

    /// Fraction of a cell of size `width` around `point` inside the ellipsoid, 0 … 1.
    fn share(&self, point: DVec3, width: f64) -> f64 {
        let distance = self.distance(point);
        if width > 0.0 { (0.5 - distance / width).clamp(0.0, 1.0) } else { f64::from(u8::from(distance <= 0.0)) }
    }
}

/// Density of a cell of size `width` around a point of \[−1, 1\]³; at the point itself if `width` is 0.
fn density(point: DVec3, width: f64) -> f64 {
    // Ellipsoids that cancel may leave a negative rounding error.
    ELLIPSOIDS.iter().map(|ellipsoid| ellipsoid.density * ellipsoid.share(point, width)).sum::<f64>().max(0.0)
}

/// Width of the smoothed surfaces in voxels. A scanner averages over its voxels, and shading needs a surface without steps.
const SURFACE: f64 = 1.5;

pub(super) fn shepp_logan(dims: [usize; 3]) -> Arc<dyn Made> {
    let [x, y, z] = coordinates(dims);
    let steps: Vec<f64> = dims.iter().filter(|&&n| n > 1).map(|&n| 2.0 / (n as f64 - 1.0)).collect();
    let width = SURFACE * steps.iter().sum::<f64>() / steps.len().max(1) as f64;
    made(dims, move |i, j, k| density(DVec3::new(x[i], y[j], z[k]), width))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding error of sums of a few decimal fractions.
    const ROUNDING: f64 = 1e-12;

    #[test]
    fn densities_at_points() {
        for (point, expected) in [
            // Outside, skull, brain.
            ([0.0, 0.95, 0.0], 0.0),
            ([0.0, 0.9, 0.0], 1.0),
            ([0.675, 0.0, 0.0], 1.0),
            ([0.0, 0.0, 0.89], 1.0),
            ([0.0, -0.5, 0.3], 0.2),
            // Both ventricles, which tilt outwards at the top: along their long axes, and beside them.
            ([-0.22, 0.0, -0.25], 0.0),
            ([0.22, 0.0, -0.25], 0.0),
            ([-0.22 - 0.4 * 0.309, 0.4 * 0.951, -0.25], 0.0),
            ([-0.22 + 0.4 * 0.309, 0.4 * 0.951, -0.25], 0.3),
            ([0.22 + 0.3 * 0.309, 0.3 * 0.951, -0.25], 0.0),
            ([0.22 + 0.3 * 0.309, -0.3 * 0.951, -0.25], 0.2),
            // Tumours.
            ([0.0, 0.45, -0.25], 0.3),
            ([0.0, 0.45, 0.26], 0.2),
            ([-0.08, -0.65, -0.25], 0.3),
            ([0.06, -0.61, -0.25], 0.3),
            ([0.1, -0.65, -0.25], 0.2),
            ([0.06, -0.105, 0.7], 0.3),
            ([0.0, 0.1, 0.625], 0.1),
            // Overlap of the large ellipsoid and the smallest sphere.
            ([0.0, 0.12, -0.25], 0.4),
        ] {
            let found = density(DVec3::from_array(point), 0.0);
            assert!((found - expected).abs() < ROUNDING, "{point:?}: {found}, not {expected}");
        }
    }

    /// Distances along the axes are exact at the poles. Half the density is reached on the smoothed surface.
    #[test]
    fn distances_from_the_skull() {
        let skull = &ELLIPSOIDS[0];
        for (point, expected) in [([0.0, 1.0, 0.0], 0.08), ([0.69, 0.0, 0.0], 0.0), ([0.0, 0.0, -0.8], -0.1), ([0.0; 3], -0.69)] {
            // At s on an axis of half length a, (q−1)·q/|∇| is (s/a − 1)·a.
            let found = skull.distance(DVec3::from_array(point));
            assert!((found - expected).abs() < ROUNDING, "{point:?}: {found}, not {expected}");
        }
        assert!((density(DVec3::new(0.69, 0.0, 0.0), 0.02) - 0.5).abs() < ROUNDING);
        assert!((density(DVec3::new(0.694, 0.0, 0.0), 0.02) - 0.3).abs() < ROUNDING);
    }

    /// An ellipsoid has the volume 4π/3·abc; the sum of all densities is the weighted sum of these.
    #[test]
    fn mass_is_that_of_the_ellipsoids() {
        const N: usize = 120;
        /// Sums over cells of size 1/60 approximate the integrals; errors at the surfaces mostly cancel.
        const DISCRETE: f64 = 0.01;
        let place = |n: usize| (2 * n + 1) as f64 / N as f64 - 1.0;
        let cells = (0..N * N * N).map(|n| DVec3::new(place(n % N), place(n / N % N), place(n / N / N)));
        let mass = |width| cells.clone().map(|cell| density(cell, width)).sum::<f64>() * (2.0 / N as f64).powi(3);
        let volume = |e: &Ellipsoid| e.axes.iter().product::<f64>() * 4.0 / 3.0 * std::f64::consts::PI;
        // The parts of the ventricles that lie outside each other overlap brain only.
        let expected: f64 = ELLIPSOIDS.iter().map(|e| volume(e) * e.density).sum();
        for width in [0.0, SURFACE * 2.0 / N as f64] {
            assert!((mass(width) / expected - 1.0).abs() < DISCRETE, "{}, not {expected}", mass(width));
        }
    }
}
