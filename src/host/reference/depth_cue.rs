//! Depth cueing of a sample.

use crate::layers::Ray;
use crate::settings::{DepthCue, Settings};
use crate::volume::Volume;
use glam::DVec3;

/// Depth of a box, relative to its diagonal, below which it counts as flat.
const FLAT: f64 = 1e-6;

/// Fades colours by their depth in a view: see [`DepthCue`].
#[derive(Clone, Copy)]
pub(super) struct Fade {
    cue: DepthCue,
    /// From the plane of voxel (0, 0, 0), in world units along the central ray.
    nearest: f64,
    farthest: f64,
    /// World length of voxel steps along the central ray.
    per_voxel: DVec3,
}

impl Fade {
    /// The fade along a ray; `None` without depth cueing. `to_eye` is the reversed direction of the central ray, in grid axes.
    pub fn new(volume: &Volume, settings: &Settings, ray: &Ray, to_eye: DVec3) -> Option<Self> {
        let cue = settings.depth_cue?;
        let grid = volume.grid();
        let last = DVec3::from_array(grid.dims().map(|n| (n - 1) as f64));
        let [lowest, highest] = match settings.clipping.crop {
            Some(crop) => [DVec3::ZERO.max(crop.lowest), last.min(crop.highest)],
            None => [DVec3::ZERO, last],
        };
        let per_voxel = -to_eye * grid.spacing();
        let (mut nearest, mut farthest) = (f64::INFINITY, f64::NEG_INFINITY);
        for corner in 0..8 {
            let end = |i: usize| if corner >> i & 1 == 0 { lowest[i] } else { highest[i] };
            let depth = per_voxel.dot(DVec3::new(end(0), end(1), end(2)));
            (nearest, farthest) = (nearest.min(depth), farthest.max(depth));
        }
        if ray.start.is_finite() {
            let eye = ray.origin + ray.direction * ray.start;
            nearest = nearest.max(per_voxel.dot(eye));
        }
        let flat = farthest - nearest <= FLAT * ((highest - lowest) * grid.spacing()).length();
        (!flat).then_some(Self { cue, nearest, farthest, per_voxel })
    }

    /// A lit colour at a point in voxels.
    pub fn at(self, point: DVec3, color: [f64; 3]) -> [f64; 3] {
        let far = (self.per_voxel.dot(point) - self.nearest) / (self.farthest - self.nearest);
        let share = self.cue.strength * far.clamp(0.0, 1.0);
        std::array::from_fn(|i| color[i] * (1.0 - share) + self.cue.color[i] * share)
    }
}

/// A lit colour, faded if there is depth cueing.
pub(super) fn faded(fade: Option<Fade>, point: DVec3, color: [f64; 3]) -> [f64; 3] {
    fade.map_or(color, |fade| fade.at(point, color))
}
