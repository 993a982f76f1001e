//! Where rays of a view count.

use super::scene::Scene;
use crate::device::launch::structs::Clipping;
use crate::device::launch::{BlendMode, Rendering};
use crate::layers::AxisFrame;
use crate::settings::Blend;
use crate::settings::ClipPlane;
use crate::volume::Grid;
use glam::DVec3;

/// The part of a volume in which rays count, in voxels (x, y, z): a box and planes.
pub(super) struct Region {
    lowest: DVec3,
    highest: DVec3,
    /// (n, d), n of unit length: n·p + d ≥ 0 counts.
    planes: Vec<(DVec3, f64)>,
    /// How rays end, and whether something that shows lies beyond the region, so that these must be cut.
    pub rendering: Rendering,
}

impl Region {
    /// For a field that is reconstructed with kernels of a radius, with so many samples per layer.
    pub fn new(scene: &Scene, radius: f64, samples_per_layer: u32) -> Self {
        let Scene { prepared, settings, .. } = scene;
        let grid = prepared.grid();
        let last = DVec3::from_array(grid.dims().map(|n| n as f64 - 1.0));
        let support = (DVec3::splat(-radius), last + radius);
        let (mut lowest, mut highest) = support;
        if settings.blend.gathers_values() {
            // An axis of a single voxel has no length among voxels: its layer has.
            let half_layer = DVec3::select(last.cmpeq(DVec3::ZERO), DVec3::splat(0.5), DVec3::ZERO);
            (lowest, highest) = (-half_layer, last + half_layer);
        }
        if let Some(crop) = settings.clipping.crop {
            (lowest, highest) = (lowest.max(crop.lowest), highest.min(crop.highest));
        }
        let blend = match prepared.blend_of_numbers(settings.blend) {
            Blend::Composite => BlendMode::Composite,
            Blend::Maximum => BlendMode::Maximum,
            Blend::Minimum => BlendMode::Minimum,
            Blend::Average => BlendMode::Average,
            Blend::Iso(_) => BlendMode::Iso { refined: samples_per_layer > 1 },
        };
        let clipped = !settings.clipping.is_empty()
            || settings.blend != Blend::Composite
            || prepared.background_visible()
            || !scene.rays.all_ahead(support.0, support.1);
        let planes = settings.clipping.planes.iter().flatten().map(|plane| in_voxels(plane, grid)).collect();
        Self { lowest, highest, planes, rendering: Rendering { blend, clipped } }
    }

    /// The same without a cut for what only the background or an eye inside would need: for splats that are drawn as they are.
    pub fn for_splats(scene: &Scene, radius: f64) -> Self {
        let mut region = Self::new(scene, radius, 1);
        region.rendering.clipped = !scene.settings.clipping.is_empty();
        region
    }

    /// As kernels take it, in the axes of `frame`.
    pub fn for_kernels(&self, frame: AxisFrame) -> Clipping {
        let narrow = |p: DVec3| frame.local(p).as_vec3().to_array();
        let mut planes = [[0.0; 4]; crate::settings::Clipping::MAX_PLANES];
        for (slot, (normal, d)) in planes.iter_mut().zip(&self.planes) {
            *slot = frame.local(*normal).extend(*d).as_vec4().to_array();
        }
        Clipping { lowest: narrow(self.lowest), highest: narrow(self.highest), planes, plane_count: self.planes.len() as i32 }
    }

    /// The same along x, y, z.
    pub fn for_pixels(&self) -> Clipping {
        self.for_kernels(AxisFrame { u: 0, v: 1, a: 2 })
    }
}

/// A plane in voxels.
fn in_voxels(plane: &ClipPlane, grid: &Grid) -> (DVec3, f64) {
    let normal = grid.direction().transpose() * plane.normal.normalize() * grid.spacing();
    let d = -normal.dot(grid.world_to_voxel(plane.point));
    (normal / normal.length(), d / normal.length())
}
