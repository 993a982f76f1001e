//! Depth cueing of a frame, as a plane equation.

use super::field::Field;
use crate::layers::Rays;
use crate::settings::{DepthCue, Settings};
use glam::DVec3;

/// Depth of a box, relative to its diagonal, below which it counts as flat and nothing fades: floats cannot resolve it.
const FLAT: f64 = 1e-6;

/// The share of the cue's colour at a point p in voxels, before it is clamped to 0 … strength: slope · p + at_origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CuePlane {
    pub slope: DVec3,
    pub at_origin: f64,
    pub cue: DepthCue,
}

impl CuePlane {
    /// The depth cueing of a whole volume, of which the field may hold a part; `None` if nothing fades.
    pub fn new(settings: &Settings, field: &Field, rays: &Rays) -> Option<Self> {
        let cue = settings.fading()?;
        let (mut lowest, mut highest) = (DVec3::ZERO, DVec3::from_array(field.grid().dims().map(|n| n as f64 - 1.0)));
        if let Some(crop) = settings.clipping.crop {
            (lowest, highest) = (lowest.max(crop.lowest), highest.min(crop.highest));
        }
        // Depth in world units along the central ray, from the plane of voxel (0, 0, 0).
        let per_voxel = -rays.to_eye * rays.spacing;
        let (one, other) = (per_voxel * lowest, per_voxel * highest);
        let (mut nearest, farthest) = (one.min(other).element_sum(), one.max(other).element_sum());
        if let Some(eye) = rays.eye() {
            nearest = nearest.max(per_voxel.dot(eye));
        }
        let depth = farthest - nearest;
        if !lowest.cmple(highest).all() || depth <= FLAT * ((highest - lowest) * rays.spacing).length() {
            return None;
        }
        Some(Self { slope: per_voxel * (cue.strength / depth), at_origin: -nearest * (cue.strength / depth), cue })
    }
}
