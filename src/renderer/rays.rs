//! Ray casting, with and without pre-integrated segments.

use super::channels::{CHANNELS, FieldInputs, MergedInputs, declare_channels};
use super::classification::Table;
use super::field::Layout;
use super::frame::{Declaring, Resources};
use super::light::Illumination;
use super::region::Region;
use super::scene::Scene;
use super::screen::screen_params;
use super::tiles::{Drawn, Target, Tiles, declare_target};
use crate::device::launch::colors::{ColorArguments, ColorRaycast, ColorRaycastArguments};
use crate::device::launch::rays::{
    CastSegments, CastSegmentsArguments, CastValues, ChannelRaycast, ChannelRaycastArguments, MarchedField, Raycast,
    TableMarchArguments,
};
use crate::device::launch::structs::{ClassificationParams, MarchParams, SampleParams, SegmentParams};
use crate::device::launch::{Launcher, Rendering};
use crate::error::Error;
use crate::layers::{Axis, Kernel};
use std::sync::Arc;

/// Layer axis of the uploaded layout, in which rays are marched.
pub(super) const AXIS: Axis = Axis::Z;
/// Largest number of steps across a volume.
const MAX_STEPS: f64 = (1 << 22) as f64;

/// Output of rays.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum RayOutput {
    /// Colour and opacity.
    Colors,
    /// Instead of colours: ray parameter of the first visible point, and mean ray parameter times opacity.
    Depths,
}

/// Renders by marching along the rays of screen pixels. Steps are in smallest spacings.
#[derive(Default)]
pub(super) struct MarchedRays {
    raycast: Launcher<Raycast>,
    segments: Launcher<CastSegments>,
    values: Launcher<CastValues>,
    channels: Launcher<ChannelRaycast>,
    colors: Launcher<ColorRaycast>,
}

/// Declares the resources of [`MarchedRays::cast`] and [`MarchedRays::cast_values`].
pub(super) fn declare_casting(declaring: &Declaring, kernel: Kernel, resources: &mut Resources) {
    declare_rays(declaring, resources);
    declare_channels(declaring, resources);
    declaring.for_each_channel(|declaring| {
        declaring.visibility(AXIS, kernel, resources);
        declaring.gradients(AXIS, kernel, resources);
    });
}

/// Declares the resources of [`MarchedRays::cast_segments`].
pub(super) fn declare_segments(declaring: &Declaring, kernel: Kernel, resources: &mut Resources) {
    declare_casting(declaring, kernel, resources);
    declaring.integrals(None, kernel, resources);
}

fn declare_rays(declaring: &Declaring, resources: &mut Resources) {
    declare_target(declaring.viewport.pixels(), Tiles::for_screen(declaring.viewport, declaring.tuning), resources);
}

/// What rays that are marched through a field read, for steps of at most `step` voxels along any axis.
pub(super) fn inputs(
    scene: &mut Scene,
    kernel: Kernel,
    layout: Layout,
    sample: SampleParams,
    step: f64,
) -> Result<FieldInputs, Error> {
    let visible = scene.visible_blocks(AXIS, kernel)?;
    let gradients = scene.gradient_voxels(AXIS, kernel, &layout)?;
    let (region, length) = (Region::marched(scene, kernel, step), scene.steps(1).shortest());
    let place = scene.placement(AXIS.frame(), kernel, &region, &visible);
    let colors = scene.voxel_colors(AXIS);
    Ok(FieldInputs { layout, gradients, visible, sample, region, place, length, colors })
}

/// What rays with post-classified samples read, and their table.
fn cast_inputs(scene: &mut Scene, kernel: Kernel, step: f64) -> Result<(FieldInputs, Arc<Table>), Error> {
    let table = scene.table(kernel)?;
    let layout = match kernel {
        Kernel::Gaussian => scene.gaussian_layout()?,
        _ => scene.weighted(AXIS, kernel)?,
    };
    let sample = scene.table_samples(&table, scene.steps(1), AXIS.frame());
    Ok((inputs(scene, kernel, layout, sample, step)?, table))
}

/// Kernel arguments of a field through which rays are marched.
pub(super) fn marched<'a>(
    scene: &Scene,
    field: &'a FieldInputs,
    illumination: &'a Illumination,
    p: MarchParams,
    drawn: &'a Drawn,
) -> MarchedField<'a> {
    MarchedField {
        field: field.shaded(illumination.arguments(&field.visible.flags)),
        visible: &field.visible.flags,
        s: screen_params(scene, scene.steps(1), AXIS.frame(), drawn.tiles),
        p,
        sample: field.sample,
        ray_ends: field.region.for_screen(AXIS.frame(), scene.rays),
        output: drawn.output(),
    }
}

impl MarchedRays {
    /// Casts rays with post-classified samples.
    pub fn cast(
        &mut self,
        scene: &mut Scene,
        kernel: Kernel,
        step: f64,
        gathers: RayOutput,
        target: &mut Target,
    ) -> Result<(), Error> {
        check_steps(scene, step)?;
        let Scene { device, settings, .. } = *scene;
        let drawn = prepare(scene, target);
        let steps = scene.steps(1);
        let depths = gathers == RayOutput::Depths;
        let params = |blocks| MarchParams { length: (step * steps.shortest()) as f32, ..march_params(blocks, settings.culling) };
        if scene.draws_fields_together() {
            let inputs = scene.for_each_channel(|scene| cast_inputs(scene, kernel, step))?;
            let merged = MergedInputs::new(inputs.iter().map(|(field, _)| field).collect())?;
            let tables: Vec<_> = inputs.iter().map(|(_, table)| &table.entries).collect();
            let rendering = Rendering { depths, ..merged.rendering };
            let (illumination, fields) = (scene.illumination()?, merged.params(device, CHANNELS.name)?);
            let light = illumination.arguments(merged.unused());
            let ray_ends = merged.region.for_screen(AXIS.frame(), scene.rays);
            let arguments = ChannelRaycastArguments {
                channels: merged.shaded(&fields, &tables, light, ray_ends, drawn.output()),
                s: screen_params(scene, steps, AXIS.frame(), drawn.tiles),
                p: params(merged.blocks()),
                // Depths have none.
                colors: if depths { None } else { merged.colors() },
            };
            let variant = (merged.kind, kernel, rendering, merged.channels());
            return self.channels.launch(device, variant, &arguments);
        }
        let (field, table) = cast_inputs(scene, kernel, step)?;
        let rendering = Rendering { depths, ..field.rendering() };
        let variant = (field.layout.voxels.kind(), kernel, rendering);
        let illumination = scene.illumination()?;
        if let Some(fields) = scene.colors() {
            let layouts = scene.color_layouts(AXIS, kernel)?;
            let march = marched(scene, &field, &illumination, params(field.visible.blocks), &drawn);
            let arguments = ColorRaycastArguments {
                colors: ColorArguments {
                    others: fields.arguments(&layouts),
                    shaded: march.field,
                    visible: march.visible,
                    sample: march.sample,
                    ray_ends: march.ray_ends,
                    output: march.output,
                },
                s: march.s,
                p: march.p,
            };
            let (voxels, kernel, rendering) = variant;
            return self.colors.launch(device, (voxels, kernel, rendering, fields.of()), &arguments);
        }
        // Depths have no colours.
        let tint = if depths { None } else { scene.tint(AXIS.frame())? };
        let march = marched(scene, &field, &illumination, params(field.visible.blocks), &drawn);
        self.raycast.launch(device, variant, &TableMarchArguments { march, table: &table.entries, tint })
    }

    /// Reduces values, or finds an iso-surface, between planes one step apart.
    pub fn cast_values(
        &mut self,
        scene: &mut Scene,
        kernel: Kernel,
        step: f64,
        gathers: RayOutput,
        target: &mut Target,
    ) -> Result<(), Error> {
        check_steps(scene, step)?;
        let Scene { device, settings, .. } = *scene;
        let table = scene.table(kernel)?;
        let mut layout = scene.weighted(AXIS, kernel)?;
        layout.view.background = scene.field.background_for(settings.blend);
        let sample = scene.table_samples(&table, scene.steps(1), AXIS.frame());
        let field = inputs(scene, kernel, layout, sample, longest_slab(scene, step))?;
        let illumination = scene.illumination()?;
        let drawn = prepare(scene, target);
        let useful = scene.field.useful_values(settings.blend).unwrap_or([f32::NEG_INFINITY, f32::INFINITY]);
        let rendering = Rendering { depths: gathers == RayOutput::Depths, ..field.rendering() };
        let variant = (field.layout.voxels.kind(), kernel, rendering);
        let p = slab_params(scene, step, useful, field.visible.blocks);
        let march = marched(scene, &field, &illumination, p, &drawn);
        let tint = scene.tint(AXIS.frame())?;
        self.values.launch(device, variant, &TableMarchArguments { march, table: &table.entries, tint })
    }

    /// Casts rays with pre-integrated segments.
    pub fn cast_segments(&mut self, scene: &mut Scene, kernel: Kernel, step: f64, target: &mut Target) -> Result<(), Error> {
        check_steps(scene, step)?;
        let Scene { device, settings, .. } = *scene;
        // Layers are divided by the ray step here, not by samples per layer.
        let steps = scene.steps(1);
        let per_layer = (1.0 / step).round() as u32;
        let thinnest = step * steps.shortest();
        let integrals = scene.integrals(kernel, thinnest, per_layer)?;
        let layout = scene.weighted(AXIS, kernel)?;
        let classification = ClassificationParams::from_integrals(scene, &integrals);
        let segment_params = SegmentParams::between_points(scene.settings, steps, AXIS.frame(), Kernel::Linear, 1);
        let sample = scene.sample(AXIS.frame(), classification, segment_params);
        let field = inputs(scene, kernel, layout, sample, longest_slab(scene, step))?;
        let illumination = scene.illumination()?;
        let segments = integrals.segments(settings.extinction, 1);
        let drawn = prepare(scene, target);
        let p = slab_params(scene, step, integrals.visible_values, field.visible.blocks);
        let march = marched(scene, &field, &illumination, p, &drawn);
        let arguments = CastSegmentsArguments { march, table: &integrals.nodes, tint: scene.tint(AXIS.frame())? };
        self.segments.launch(device, (field.layout.voxels.kind(), kernel, segments, field.rendering()), &arguments)
    }
}

/// The render target in tiles of the screen.
pub(super) fn prepare(scene: &Scene, target: &mut Target) -> Drawn {
    target.prepare(Tiles::for_screen(scene.viewport, scene.device.tuning()))
}

/// Rejects steps so short that a frame would take unreasonably long, or that floats could not count them.
pub(super) fn check_steps(scene: &Scene, step: f64) -> Result<(), Error> {
    let grid = scene.field.grid();
    let steps = grid.diagonal() / (step * grid.spacing().min_element());
    if steps <= MAX_STEPS {
        return Ok(());
    }
    let problem = format!(
        "a step of {step} smallest spacings cuts the volume's diagonal into {steps:.0} steps, more than {MAX_STEPS:.0}: make \
         it longer"
    );
    Err(Error::Settings { field: "step", problem })
}

/// Parameters shared by all kernels that march rays.
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
        cut: 0,
        visible: [0.0; 2],
    }
}

/// Parameters for marching between planes `step` smallest spacings apart along the central ray. Other rays of a perspective
/// projection cross the planes at an angle. Only values in the range `useful` matter.
pub(super) fn slab_params(scene: &Scene, step: f64, useful: [f32; 2], blocks: [i32; 2]) -> MarchParams {
    MarchParams {
        slice_step: slab_parameter(scene, step) as f32,
        thin: i32::from(longest_slab(scene, step) <= 1.0),
        visible: useful,
        ..march_params(blocks, scene.settings.culling)
    }
}

/// Difference of the ray parameter between adjacent planes; equal for all rays.
fn slab_parameter(scene: &Scene, step: f64) -> f64 {
    let Scene { rays, field, .. } = *scene;
    let spacing = field.grid().spacing();
    // World distance along the central ray per unit of the ray parameter.
    let depth_per_parameter = -(rays.direction[0] * spacing).dot(rays.to_eye);
    step * spacing.min_element() / depth_per_parameter
}

/// Longest path of any ray through a slab along any axis, in voxels. Directions are affine in pixels, so a corner ray has it.
pub(super) fn longest_slab(scene: &Scene, step: f64) -> f64 {
    let longest = scene.rays.corners(scene.viewport).iter().map(|ray| ray.direction.abs().max_element()).fold(0.0, f64::max);
    longest * slab_parameter(scene, step)
}
