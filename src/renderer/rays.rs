//! Frames by ray casting, with and without pre-integrated segments, and by slicing.

use super::classification::{SLAB_VALUES, Table, TableSizes};
use super::frame::{Declaring, Resources};
use super::region::Region;
use super::sampling::Steps;
use super::scene::Scene;
use super::screen::screen_params;
use super::tiles::{Drawn, Target, Tiles, declare_target};
use crate::device::launch::rays::{
    CastSegments, CastSegmentsArguments, CastValues, CastValuesArguments, Raycast, RaycastArguments, Slicing, SlicingArguments,
};
use crate::device::launch::structs::{ClassificationParams, MarchParams, SampleParams, SegmentParams};
use crate::device::launch::{Launcher, Rendering};
use crate::error::Error;
use crate::layers::{Axis, Kernel};

/// Rays are marched in the upload's own layout.
const AXIS: Axis = Axis::Z;
/// Most steps across a volume.
const MOST_STEPS: f64 = (1 << 22) as f64;

/// What rays bring back.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Gathers {
    /// A picture.
    Colors,
    /// In place of colours, the ray parameter where something is seen first, and the mean one times the opacity.
    Depths,
}

/// Draws by marching along the rays of screen pixels. Steps are lengths in smallest spacings.
#[derive(Default)]
pub(super) struct MarchedRays {
    raycast: Launcher<Raycast>,
    slicing: Launcher<Slicing>,
    segments: Launcher<CastSegments>,
    values: Launcher<CastValues>,
}

/// Declares what [`MarchedRays::cast`] and [`MarchedRays::cast_values`] need.
pub(super) fn declare_casting(declaring: &Declaring, kernel: Kernel, resources: &mut Resources) {
    declare_rays(declaring, resources);
    declaring.visibility(AXIS, kernel, resources);
}

/// Declares what [`MarchedRays::slice`] needs.
pub(super) fn declare_slicing(declaring: &Declaring, resources: &mut Resources) {
    declare_segments(declaring, Kernel::Linear, resources);
    resources.kept(("the table of slicing", None, None), [TableSizes::slicing()]);
}

/// Declares what [`MarchedRays::cast_segments`] needs.
pub(super) fn declare_segments(declaring: &Declaring, kernel: Kernel, resources: &mut Resources) {
    declare_casting(declaring, kernel, resources);
    declaring.integrals(kernel, resources);
}

fn declare_rays(declaring: &Declaring, resources: &mut Resources) {
    declare_target(declaring.viewport.pixels(), Tiles::of_screen(declaring.viewport, declaring.tuning), resources);
}

impl MarchedRays {
    /// Casts rays, each sample classified by itself.
    pub fn cast(
        &mut self,
        scene: &mut Scene,
        kernel: Kernel,
        step: f64,
        gathers: Gathers,
        target: &mut Target,
    ) -> Result<(), Error> {
        check_steps(scene, step)?;
        let Scene { device, settings, viewport, .. } = *scene;
        let visible = scene.visible_blocks(AXIS, kernel)?;
        let table = scene.table(kernel)?;
        let layout = match kernel {
            Kernel::Gaussian => scene.gaussian_layout()?,
            _ => scene.weighted(AXIS, kernel)?,
        };
        let steps = scene.steps(1);
        let sample = point_params(scene, &table, steps);
        let region = Region::marched(scene, kernel, step);
        let tiles = Tiles::of_screen(viewport, device.tuning());
        let Drawn { samples: frame, active_samples, .. } = &target.prepare(tiles);
        self.raycast.launch(
            device,
            (layout.voxels.kind(), kernel, Rendering { depths: gathers == Gathers::Depths, ..region.rendering }),
            &RaycastArguments {
                voxels: &layout.voxels,
                view: layout.view,
                visible: &visible.flags,
                table: &table.entries,
                s: screen_params(scene, steps, AXIS.frame(), tiles),
                p: MarchParams { length: (step * steps.shortest()) as f32, ..march_params(visible.blocks, settings.culling) },
                sample,
                clip: region.for_kernels(AXIS.frame()),
                frame,
                active_samples,
            },
        )
    }

    /// Gathers values, or finds an iso-surface, between planes that are a step apart.
    pub fn cast_values(
        &mut self,
        scene: &mut Scene,
        kernel: Kernel,
        step: f64,
        gathers: Gathers,
        target: &mut Target,
    ) -> Result<(), Error> {
        check_steps(scene, step)?;
        let Scene { device, settings, viewport, .. } = *scene;
        let visible = scene.visible_blocks(AXIS, kernel)?;
        let table = scene.table(kernel)?;
        let mut layout = scene.weighted(AXIS, kernel)?;
        layout.view.background = scene.field.background_for(settings.blend);
        let steps = scene.steps(1);
        let sample = point_params(scene, &table, steps);
        let region = Region::marched(scene, kernel, longest_slab(scene, step));
        let tiles = Tiles::of_screen(viewport, device.tuning());
        let Drawn { samples: frame, active_samples, .. } = &target.prepare(tiles);
        let useful = scene.field.useful_values(settings.blend).unwrap_or([f32::NEG_INFINITY, f32::INFINITY]);
        self.values.launch(
            device,
            (layout.voxels.kind(), kernel, Rendering { depths: gathers == Gathers::Depths, ..region.rendering }),
            &CastValuesArguments {
                voxels: &layout.voxels,
                view: layout.view,
                visible: &visible.flags,
                table: &table.entries,
                s: screen_params(scene, steps, AXIS.frame(), tiles),
                p: slab_params(scene, step, useful, visible.blocks),
                sample,
                clip: region.for_kernels(AXIS.frame()),
                frame,
                active_samples,
            },
        )
    }

    /// Slices.
    pub fn slice(&mut self, scene: &mut Scene, step: f64, target: &mut Target) -> Result<(), Error> {
        check_steps(scene, step)?;
        let Scene { device, viewport, .. } = *scene;
        let steps = scene.steps(1);
        let thickness = step * steps.shortest();
        let visible = scene.visible_blocks(AXIS, Kernel::Linear)?;
        let (integrals, slabs) = scene.slicing_table(thickness)?;
        let table = scene.table(Kernel::Linear)?;
        let layout = scene.layout(AXIS)?;
        let sample = point_params(scene, &table, steps);
        let region = Region::marched(scene, Kernel::Linear, longest_slab(scene, step));
        let tiles = Tiles::of_screen(viewport, device.tuning());
        let Drawn { samples: frame, active_samples, .. } = &target.prepare(tiles);
        self.slicing.launch(
            device,
            (layout.voxels.kind(), integrals.needs.cut, region.rendering),
            &SlicingArguments {
                voxels: &layout.voxels,
                view: layout.view,
                visible: &visible.flags,
                table: &slabs,
                s: screen_params(scene, steps, AXIS.frame(), tiles),
                p: MarchParams {
                    table_first: integrals.scale.first,
                    table_per_value: integrals.scale.per_value * (SLAB_VALUES - 1) as f32 / integrals.scale.last as f32,
                    table_size: SLAB_VALUES as i32,
                    ..slab_params(scene, step, integrals.visible_values, visible.blocks)
                },
                sample,
                clip: region.for_kernels(AXIS.frame()),
                frame,
                active_samples,
            },
        )
    }

    /// Casts rays with pre-integrated segments.
    pub fn cast_segments(&mut self, scene: &mut Scene, kernel: Kernel, step: f64, target: &mut Target) -> Result<(), Error> {
        check_steps(scene, step)?;
        let Scene { device, settings, viewport, .. } = *scene;
        // Here steps are what divides a layer, not samples.
        let steps = scene.steps(1);
        let per_layer = (1.0 / step).round() as u32;
        let thinnest = step * steps.shortest();
        let visible = scene.visible_blocks(AXIS, kernel)?;
        let integrals = scene.integrals(kernel, thinnest, per_layer)?;
        let layout = scene.weighted(AXIS, kernel)?;
        let classification = ClassificationParams::from_integrals(scene, &integrals);
        let segment_params = SegmentParams::between_points(scene, steps, AXIS.frame(), Kernel::Linear, 1);
        let sample = scene.sample(AXIS.frame(), classification, segment_params);
        let segments = integrals.segments(settings.extinction, Kernel::Linear, 1);
        let region = Region::marched(scene, kernel, longest_slab(scene, step));
        let tiles = Tiles::of_screen(viewport, device.tuning());
        let Drawn { samples: frame, active_samples, .. } = &target.prepare(tiles);
        self.segments.launch(
            device,
            (layout.voxels.kind(), kernel, segments, region.rendering),
            &CastSegmentsArguments {
                voxels: &layout.voxels,
                view: layout.view,
                visible: &visible.flags,
                table: &integrals.nodes,
                s: screen_params(scene, steps, AXIS.frame(), tiles),
                p: slab_params(scene, step, integrals.visible_values, visible.blocks),
                sample,
                clip: region.for_kernels(AXIS.frame()),
                frame,
                active_samples,
            },
        )
    }
}

/// Refuses what would take practically forever, or more steps than floats can count.
fn check_steps(scene: &Scene, step: f64) -> Result<(), Error> {
    let grid = scene.field.grid();
    let steps = grid.diagonal() / (step * grid.spacing().min_element());
    if steps <= MOST_STEPS {
        return Ok(());
    }
    let problem = format!(
        "a step of {step} smallest spacings cuts the volume's diagonal into {steps:.0} steps, more than {MOST_STEPS:.0}: make \
         it longer"
    );
    Err(Error::Settings { field: "step", problem })
}

/// Parameters of samples that are looked up in a table, each by itself.
fn point_params(scene: &Scene, table: &Table, steps: Steps) -> SampleParams {
    let frame = AXIS.frame();
    scene.sample(frame, ClassificationParams::from_table(scene, table), SegmentParams::single(scene, steps, frame))
}

/// What all ways of marching need.
fn march_params(blocks: [i32; 2], culling: bool) -> MarchParams {
    MarchParams {
        blocks,
        culling: i32::from(culling),
        length: 0.0,
        slice_step: 0.0,
        thin: 0,
        table_first: 0.0,
        table_per_value: 0.0,
        table_size: 0,
        visible: [0.0; 2],
    }
}

/// What marching from plane to plane needs, between values that are of use, planes being `step` smallest spacings apart along the
/// central ray; other rays of a perspective cross them at an angle.
fn slab_params(scene: &Scene, step: f64, useful: [f32; 2], blocks: [i32; 2]) -> MarchParams {
    MarchParams {
        slice_step: slab_parameter(scene, step) as f32,
        thin: i32::from(longest_slab(scene, step) <= 1.0),
        visible: useful,
        ..march_params(blocks, scene.settings.culling)
    }
}

/// Ray parameter from one plane to the next: the same for all rays.
fn slab_parameter(scene: &Scene, step: f64) -> f64 {
    let Scene { rays, field, .. } = *scene;
    let spacing = field.grid().spacing();
    // World distance along the central ray per unit of the rays' parameter.
    let depth_per_parameter = -(rays.direction[0] * spacing).dot(rays.to_eye);
    step * spacing.min_element() / depth_per_parameter
}

/// The longest way of any ray through a slab along any axis, in voxels: a corner's, since directions are affine in pixels.
fn longest_slab(scene: &Scene, step: f64) -> f64 {
    let longest = scene.rays.corners(scene.viewport).iter().map(|ray| ray.direction.abs().max_element()).fold(0.0, f64::max);
    longest * slab_parameter(scene, step)
}
