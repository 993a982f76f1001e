//! Where rays of a view count.

use super::scene::Scene;
use crate::device::launch::structs::Clipping;
use crate::device::launch::{BlendMode, Rendering};
use crate::layers::{AxisFrame, Kernel};
use crate::settings::Blend;
use crate::settings::ClipPlane;
use crate::volume::Grid;
use glam::DVec3;

/// Room for rounding where steps end.
const LONGER: f64 = 1.01;
/// A plane that nothing lies before: a box turned inside out would hold what lies between its faces.
const NOTHING: (DVec3, f64) = (DVec3::ZERO, -1.0);

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
    /// For layers of a kernel's field, with so many samples per layer.
    pub fn new(scene: &Scene, kernel: Kernel, samples_per_layer: u32) -> Self {
        Self::reached(scene, kernel, samples_per_layer, f64::INFINITY)
    }

    /// For rays that are marched through such a field, with steps of at most this many voxels along any axis: what lies beyond the field
    /// by more is never met.
    pub fn marched(scene: &Scene, kernel: Kernel, step: f64) -> Self {
        Self::reached(scene, kernel, 1, LONGER * step)
    }

    /// For splats that are drawn as they are, wherever the field ends or the eye is.
    pub fn for_splats(scene: &Scene) -> Self {
        let clipped = !scene.settings.clipping.is_empty();
        let everything = DVec3::splat(f64::INFINITY);
        Self::cropped(scene, (-everything, everything), rendering(scene, BlendMode::Composite, clipped))
    }

    /// `beyond`: how far from the field steps can begin or end that reach into it.
    fn reached(scene: &Scene, kernel: Kernel, samples_per_layer: u32, beyond: f64) -> Self {
        let Scene { field, settings, .. } = scene;
        let radius = f64::from(kernel.radius());
        let last = DVec3::from_array(field.grid().dims().map(|n| n as f64 - 1.0));
        let support = (DVec3::splat(-radius), last + radius);
        let background_shows = settings.blend == Blend::Composite && scene.background_shows();
        let clipped = !settings.clipping.is_empty()
            || settings.blend != Blend::Composite
            || background_shows
            || !scene.rays.all_ahead(support.0, support.1);
        let whole = if settings.blend.gathers_values() {
            // An axis of a single voxel has no length among voxels: its layer has.
            let half_layer = DVec3::select(last.cmpeq(DVec3::ZERO), DVec3::splat(0.5), DVec3::ZERO);
            (-half_layer, last + half_layer)
        } else if clipped && !background_shows {
            // Nothing shows beyond the field: to cut steps where it ends would only take from what they hold inside.
            (support.0 - beyond, support.1 + beyond)
        } else {
            support
        };
        let blend = match field.blend_of_numbers(settings.blend) {
            Blend::Composite => BlendMode::Composite,
            Blend::Maximum => BlendMode::Maximum,
            Blend::Minimum => BlendMode::Minimum,
            Blend::Average => BlendMode::Average,
            Blend::Iso(_) => BlendMode::Iso { refined: samples_per_layer > 1 },
        };
        Self::cropped(scene, whole, rendering(scene, blend, clipped))
    }

    /// What clipping leaves of a box.
    fn cropped(scene: &Scene, (mut lowest, mut highest): (DVec3, DVec3), rendering: Rendering) -> Self {
        let Scene { field, settings, .. } = scene;
        if let Some(crop) = settings.clipping.crop {
            (lowest, highest) = (lowest.max(crop.lowest), highest.min(crop.highest));
        }
        let planes = if lowest.cmplt(highest).all() {
            settings.clipping.planes.iter().flatten().map(|plane| in_voxels(plane, field.grid())).collect()
        } else {
            vec![NOTHING]
        };
        Self { lowest, highest, planes, rendering }
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

    /// The same for a program of layers that may cut rays though this view's need not be: nothing is cut.
    pub fn for_layers(&self, frame: AxisFrame) -> Clipping {
        let everything = DVec3::splat(f64::INFINITY);
        let uncut = Self { lowest: -everything, highest: everything, planes: Vec::new(), rendering: self.rendering };
        if self.rendering.clipped { self.for_kernels(frame) } else { uncut.for_kernels(frame) }
    }

    /// The same along x, y, z.
    pub fn for_pixels(&self) -> Clipping {
        self.for_kernels(AxisFrame { u: 0, v: 1, a: 2 })
    }
}

fn rendering(scene: &Scene, blend: BlendMode, clipped: bool) -> Rendering {
    let settings = scene.settings;
    let several_lights = settings.shading.is_some_and(|shading| shading.lights.as_slice().len() > 1);
    Rendering { blend, clipped, gradient_opacity: settings.gradient_opacity.is_some(), several_lights, depths: false }
}

/// A plane in voxels.
fn in_voxels(plane: &ClipPlane, grid: &Grid) -> (DVec3, f64) {
    let normal = grid.direction().transpose() * plane.normal.normalize() * grid.spacing();
    let d = -normal.dot(grid.world_to_voxel(plane.point));
    (normal / normal.length(), d / normal.length())
}
