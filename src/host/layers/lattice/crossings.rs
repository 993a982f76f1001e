//! Where the rays of a view cross the layers of a volume, and which pixels they belong to.

use super::{Lattice, Source};
use crate::layers::Rays;
use crate::viewport::Viewport;
use glam::DVec3;

/// Pixels around the volume.
const MARGIN: f64 = 1.0;

/// Pixels of the screen that rays of a volume cross: the first along x and y, and their number.
pub(super) struct Window {
    pub first: [u32; 2],
    pub size: [u32; 2],
}

impl Window {
    /// Around points on the screen.
    pub fn around(points: &[[f64; 2]], viewport: Viewport) -> Self {
        let ends = [0, 1].map(|n| {
            let side = f64::from([viewport.width, viewport.height][n]);
            let lo = points.iter().fold(f64::INFINITY, |lo, p| lo.min(p[n]));
            let hi = points.iter().fold(f64::NEG_INFINITY, |hi, p| hi.max(p[n]));
            [(lo - MARGIN).floor().clamp(0.0, side) as u32, (hi + MARGIN).ceil().clamp(0.0, side) as u32]
        });
        // Points that no number stands for are nowhere.
        Self { first: ends.map(|[lo, _]| lo), size: ends.map(|[lo, hi]| hi.saturating_sub(lo)) }
    }

    pub fn middle(&self) -> [f64; 2] {
        [0, 1].map(|n| f64::from(self.first[n]) + 0.5 * f64::from(self.size[n]))
    }
}

/// Where the rays of a view cross the layers, in homogeneous coordinates (u, v, w): of the eye's shears in a perspective, of the layer of the
/// volume's centre in a parallel view.
pub(super) struct Crossings {
    /// At (0, 0) on the screen, and changes along x and y.
    pub rays: [DVec3; 3],
    /// Of the corners of the field's support, and the spread of the rays there.
    pub corners: [(DVec3, f64); 8],
    /// See [`super::PixelRays::spread`].
    pub spread: [f64; 2],
}

impl Crossings {
    pub fn new(lattice: &Lattice, rays: &Rays, support: &[DVec3; 8]) -> Self {
        let frame = lattice.frame;
        match lattice.source {
            Source::Eye(eye) => Self {
                rays: rays.direction.map(|d| frame.local(d)),
                corners: support.map(|corner| (corner - eye, corner.z - eye.z)),
                spread: [lattice.centre_layer - eye.z, 1.0],
            },
            Source::Direction(_) => {
                let shear = lattice.shear();
                let across = |p: DVec3, z: f64| DVec3::new(p.x - z * shear[0], p.y - z * shear[1], 0.0);
                let [base, x, y] = rays.origin.map(|origin| frame.local(origin));
                let crossing = |p: DVec3| across(p, p.z - lattice.centre_layer) + DVec3::Z;
                Self {
                    rays: [crossing(base), across(x, x.z), across(y, y.z)],
                    corners: support.map(|corner| (crossing(corner), 1.0)),
                    spread: [1.0, 0.0],
                }
            }
        }
    }
}
