//! Ray clip region.

use super::field::Field;
use super::light::extinction_estimator;
use super::scene::{GradientVoxels, Scene};
use crate::device::launch::structs::RayEnds;
use crate::device::launch::{BlendMode, Gradients, Rendering};
use crate::layers::{AxisFrame, GradientEstimator, Kernel, Rays};
use crate::settings::Blend;
use crate::settings::ClipPlane;
use crate::volume::Grid;
use glam::DVec3;

/// Rounding margin for the ends of steps.
const STEP_MARGIN: f64 = 1.01;
/// A half-space without points. An inverted box would not do: kernels would keep what lies between its faces.
const EMPTY_HALF_SPACE: (DVec3, f64) = (DVec3::ZERO, -1.0);

/// The part of a volume in which rays are evaluated: a box and half-spaces, in voxels (x, y, z).
#[derive(Clone)]
pub(super) struct Region {
    lowest: DVec3,
    highest: DVec3,
    /// Half-spaces n·p + d ≥ 0 as (n, d), n of unit length.
    planes: Vec<(DVec3, f64)>,
    /// Where a field with voxels of its own ends, in these.
    pub own_ends: Option<(DVec3, DVec3)>,
    /// Kernel permutation flags. `clipped` is set if something visible lies outside the region, so that rays must be clipped.
    pub rendering: Rendering,
}

impl Region {
    /// The region for layers of a kernel's field, with this number of samples per layer.
    pub fn new(scene: &Scene, kernel: Kernel, samples_per_layer: u32) -> Self {
        Self::reached(scene, kernel, samples_per_layer, f64::INFINITY)
    }

    /// The region for rays marched through a kernel's field, with steps of at most `step` voxels along any axis. No step that
    /// reaches into the field starts farther outside than that.
    pub fn marched(scene: &Scene, kernel: Kernel, step: f64) -> Self {
        Self::reached(scene, kernel, 1, STEP_MARGIN * step)
    }

    /// The region for rays from a light through the field of the paper's cubic: what is cut away casts no shadow.
    pub fn for_light(scene: &Scene) -> Self {
        let Scene { field, settings, .. } = scene;
        let last = DVec3::from_array(field.grid().dims().map(|n| n as f64 - 1.0));
        let background_shows = settings.blend == Blend::Composite && scene.background_shows();
        let clipped = !settings.clipping.is_empty() || background_shows;
        let margin = if background_shows { 1.0 } else { f64::INFINITY };
        let blend = if settings.blend == Blend::Composite { BlendMode::Composite } else { BlendMode::Iso { refined: false } };
        let rendering = rendering(scene, Kernel::Cubic, blend, clipped);
        let estimator = extinction_estimator(settings).unwrap_or(GradientEstimator::Central);
        let gradients = Gradients { estimate: estimator.into(), voxels: None };
        let rendering = Rendering {
            several_lights: false,
            colored_lights: false,
            depth_cue: false,
            light_volume: false,
            studio: false,
            gradients,
            ..rendering
        };
        Self::cropped(scene, (DVec3::splat(-margin), last + margin), rendering)
    }

    /// The region for surfaces and splats. Only clipping limits it, not the end of the field or the eye.
    pub fn of_clipping(scene: &Scene) -> Self {
        let everything = DVec3::splat(f64::INFINITY);
        let clipped = !scene.settings.clipping.is_empty();
        Self::cropped(scene, (-everything, everything), rendering(scene, Kernel::Cubic, BlendMode::Composite, clipped))
    }

    /// `beyond`: maximum distance from the field at which a step that reaches into it can begin or end.
    fn reached(scene: &Scene, kernel: Kernel, samples_per_layer: u32, beyond: f64) -> Self {
        let Scene { field, settings, .. } = scene;
        let radius = f64::from(kernel.radius());
        let last = DVec3::from_array(field.grid().dims().map(|n| n as f64 - 1.0));
        let support = (DVec3::splat(-radius), last + radius);
        let background_shows = settings.blend == Blend::Composite && scene.background_shows();
        let clipped = scene.is_cut
            || !settings.clipping.is_empty()
            || settings.blend != Blend::Composite
            || background_shows
            || !scene.rays.all_ahead(support.0, support.1);
        let extent = |last: DVec3| {
            if settings.blend.gathers_values() {
                // An axis with a single voxel has no length between voxels; use the extent of its layer.
                let half_layer = DVec3::select(last.cmpeq(DVec3::ZERO), DVec3::splat(0.5), DVec3::ZERO);
                Some((-half_layer, last + half_layer))
            } else {
                background_shows.then_some((DVec3::splat(-radius), last + radius))
            }
        };
        // A field with voxels of its own ends among these.
        let own_last = DVec3::from_array(field.own_grid().dims().map(|n| n as f64 - 1.0));
        let own_ends = extent(own_last).filter(|_| field.is_framed());
        let whole = match extent(last).filter(|_| own_ends.is_none()) {
            Some(extent) => extent,
            // Nothing outside the field is visible. Clipping steps at its end would only shorten the part inside.
            None if clipped => (support.0 - beyond, support.1 + beyond),
            None => support,
        };
        let blend = match field.blend_of_numbers(settings.blend) {
            Blend::Composite => BlendMode::Composite,
            Blend::Maximum => BlendMode::Maximum,
            Blend::Minimum => BlendMode::Minimum,
            Blend::Average => BlendMode::Average,
            Blend::Iso(_) => BlendMode::Iso { refined: samples_per_layer > 1 },
        };
        Self { own_ends, ..Self::cropped(scene, whole, rendering(scene, kernel, blend, clipped)) }
    }

    /// Intersects a box with the crop box and the clip planes.
    fn cropped(scene: &Scene, (mut lowest, mut highest): (DVec3, DVec3), rendering: Rendering) -> Self {
        let Scene { field, settings, .. } = scene;
        if let Some(crop) = settings.clipping.crop {
            (lowest, highest) = (lowest.max(crop.lowest), highest.min(crop.highest));
        }
        let planes = if lowest.cmplt(highest).all() {
            settings.clipping.planes.iter().flatten().map(|plane| in_voxels(plane, field.grid())).collect()
        } else {
            vec![EMPTY_HALF_SPACE]
        };
        Self { lowest, highest, planes, own_ends: None, rendering }
    }

    /// The part that several regions with the same clip planes share.
    pub fn intersection<'a>(regions: impl Iterator<Item = &'a Self>) -> Self {
        let shared = |one: Self, other: &Self| Self {
            lowest: one.lowest.max(other.lowest),
            highest: one.highest.min(other.highest),
            planes: if one.planes.len() < other.planes.len() { other.planes.clone() } else { one.planes },
            own_ends: None,
            rendering: Rendering { clipped: one.rendering.clipped || other.rendering.clipped, ..one.rendering },
        };
        regions.cloned().reduce(|one, other| shared(one, &other)).expect("a scene has a field")
    }

    /// Kernel permutation flags for gradients that are estimated from these voxels.
    pub fn rendering_from(&self, gradients: &GradientVoxels) -> Rendering {
        let voxels = gradients.are_separate.then(|| gradients.layout.voxels.kind());
        Rendering { gradients: Gradients { voxels, ..self.rendering.gradients }, ..self.rendering }
    }

    /// Kernel argument, in the axes of `frame`, for rays without ends of their own.
    pub fn for_kernels(&self, frame: AxisFrame) -> RayEnds {
        let narrow = |p: DVec3| frame.local(p).as_vec3().to_array();
        let mut planes = [[0.0; 4]; crate::settings::Clipping::MAX_PLANES];
        for (slot, (normal, d)) in planes.iter_mut().zip(&self.planes) {
            *slot = frame.local(*normal).extend(*d).as_vec4().to_array();
        }
        RayEnds {
            interval: [f32::NEG_INFINITY, f32::INFINITY],
            lowest: narrow(self.lowest),
            highest: narrow(self.highest),
            planes,
            plane_count: self.planes.len() as i32,
        }
    }

    /// Kernel argument for layers. A general program clips rays even if this view needs no clipping; it then gets an unbounded
    /// region.
    pub fn for_layers(&self, frame: AxisFrame) -> RayEnds {
        let everything = DVec3::splat(f64::INFINITY);
        let uncut =
            Self { lowest: -everything, highest: everything, planes: Vec::new(), own_ends: None, rendering: self.rendering };
        if self.rendering.clipped { self.for_kernels(frame) } else { uncut.for_kernels(frame) }
    }

    /// Kernel argument for the rays of screen pixels, which begin at the eye.
    pub fn for_screen(&self, frame: AxisFrame, rays: &Rays) -> RayEnds {
        RayEnds { interval: [rays.start as f32, f32::INFINITY], ..self.for_kernels(frame) }
    }
}

fn rendering(scene: &Scene, kernel: Kernel, blend: BlendMode, clipped: bool) -> Rendering {
    let settings = scene.settings;
    // Unlit pictures share the programs of lit ones, unless these read further voxels.
    let estimator = settings.needed_gradient().unwrap_or_else(|| {
        let unused = settings.gradient_estimator();
        if Field::has_separate_gradients(kernel, unused) { GradientEstimator::for_kernel(kernel) } else { unused }
    });
    let gradients = Gradients { estimate: estimator.into(), voxels: None };
    let several_lights = settings.shading.is_some_and(|shading| shading.lights.as_slice().len() > 1);
    Rendering {
        blend,
        clipped,
        gradient_opacity: settings.gradient_opacity.is_some(),
        several_lights,
        colored_lights: settings.studio.is_some() || settings.shading.is_some_and(|shading| !shading.is_white()),
        depth_cue: settings.fading().is_some(),
        light_volume: settings.sweeps_light(),
        studio: settings.studio.is_some(),
        gradients,
        depths: false,
        pixel_rays: false,
    }
}

/// Converts a clip plane to voxel coordinates.
fn in_voxels(plane: &ClipPlane, grid: &Grid) -> (DVec3, f64) {
    let normal = grid.direction().transpose() * plane.normal.normalize() * grid.spacing();
    let d = -normal.dot(grid.world_to_voxel(plane.point));
    (normal / normal.length(), d / normal.length())
}
