//! Ray casting, with and without pre-integrated segments, and slicing.

use super::channels::{CHANNELS, FieldInputs, Together, declare_channels};
use super::classification::{SLAB_VALUES, Table, TableSizes};
use super::frame::{Declaring, Resources};
use super::region::Region;
use super::scene::Scene;
use super::screen::screen_params;
use super::tiles::{Drawn, Target, Tiles, declare_target};
use crate::device::launch::rays::{
    CastSegments, CastSegmentsArguments, CastValues, CastValuesArguments, ChannelRaycast, ChannelRaycastArguments, ColorRaycast,
    ColorRaycastArguments, Raycast, RaycastArguments, Slicing, SlicingArguments,
};
use crate::device::launch::structs::{ClassificationParams, MarchParams, SegmentParams};
use crate::device::launch::tinted::TintLauncher;
use crate::device::launch::{Launcher, PerChannel, Rendering};
use crate::error::Error;
use crate::layers::{Axis, Kernel};
use std::sync::Arc;

/// Layer axis of the uploaded layout, in which rays are marched.
const AXIS: Axis = Axis::Z;
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
    raycast: TintLauncher<Raycast>,
    slicing: Launcher<Slicing>,
    segments: TintLauncher<CastSegments>,
    values: TintLauncher<CastValues>,
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

/// Declares the resources of [`MarchedRays::slice`].
pub(super) fn declare_slicing(declaring: &Declaring, resources: &mut Resources) {
    declare_segments(declaring, Kernel::Linear, resources);
    resources.kept(("the table of slicing", None, None, 0), [TableSizes::slicing()]);
}

/// Declares the resources of [`MarchedRays::cast_segments`].
pub(super) fn declare_segments(declaring: &Declaring, kernel: Kernel, resources: &mut Resources) {
    declare_casting(declaring, kernel, resources);
    declaring.integrals(None, kernel, resources);
}

fn declare_rays(declaring: &Declaring, resources: &mut Resources) {
    declare_target(declaring.viewport.pixels(), Tiles::for_screen(declaring.viewport, declaring.tuning), resources);
}

/// What rays cast through a field read.
struct RaycastInputs {
    field: FieldInputs,
    table: Arc<Table>,
}

impl RaycastInputs {
    fn new(scene: &mut Scene, kernel: Kernel, step: f64) -> Result<Self, Error> {
        let visible = scene.visible_blocks(AXIS, kernel)?;
        let table = scene.table(kernel)?;
        let layout = match kernel {
            Kernel::Gaussian => scene.gaussian_layout()?,
            _ => scene.weighted(AXIS, kernel)?,
        };
        let gradients = scene.gradient_voxels(AXIS, kernel, &layout)?;
        let steps = scene.steps(1);
        let sample = scene.table_samples(&table, steps, AXIS.frame());
        let (region, length) = (Region::marched(scene, kernel, step), steps.shortest());
        Ok(Self { field: FieldInputs { layout, gradients, visible, sample, region, length }, table })
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
        let Scene { device, settings, viewport, .. } = *scene;
        let tiles = Tiles::for_screen(viewport, device.tuning());
        let Drawn { samples: frame, active_samples, .. } = &target.prepare(tiles);
        let steps = scene.steps(1);
        let s = screen_params(scene, steps, AXIS.frame(), tiles);
        let depths = gathers == RayOutput::Depths;
        let params = |blocks| MarchParams { length: (step * steps.shortest()) as f32, ..march_params(blocks, settings.culling) };
        if scene.channels() > 1 {
            let inputs = scene.for_each_channel(|scene| RaycastInputs::new(scene, kernel, step))?;
            let together = Together::new(inputs.iter().map(|inputs| &inputs.field).collect())?;
            let tables: Vec<_> = inputs.iter().map(|inputs| &inputs.table.entries).collect();
            let rendering = Rendering { depths, ..together.rendering };
            let illumination = scene.illumination()?;
            let [light, sky] = illumination.arguments(together.unused());
            let arguments = ChannelRaycastArguments {
                voxels: together.voxels(),
                gradient_voxels: together.gradient_voxels(),
                visible: together.visible(),
                tables: PerChannel::new(&tables),
                channel_params: &together.params(device, CHANNELS.name)?,
                count: together.count() as i32,
                light,
                sky,
                s,
                p: params(together.blocks()),
                clip: together.region.for_kernels(AXIS.frame()),
                frame,
                active_samples,
            };
            let variant = (together.kind, kernel, rendering, together.channels());
            return self.channels.launch(device, variant, &arguments);
        }
        let RaycastInputs { field: inputs, table } = RaycastInputs::new(scene, kernel, step)?;
        let FieldInputs { layout, gradients, visible, sample, region, .. } = &inputs;
        let illumination = scene.illumination()?;
        let [light, sky] = illumination.arguments(&visible.flags);
        if scene.has_colors() {
            let colors = scene.color_layouts(AXIS, kernel)?;
            let arguments = ColorRaycastArguments {
                red: &colors[0].voxels,
                green: &colors[1].voxels,
                blue: &colors[2].voxels,
                extinction: &layout.voxels,
                view: layout.view,
                gradient_voxels: &gradients.layout.voxels,
                gradient_view: gradients.layout.view,
                light,
                sky,
                visible: &visible.flags,
                s,
                p: params(visible.blocks),
                sample: *sample,
                clip: region.for_kernels(AXIS.frame()),
                frame,
                active_samples,
            };
            let rendering = Rendering { depths, ..region.rendering_from(gradients) };
            return self.colors.launch(device, (layout.voxels.kind(), kernel, rendering), &arguments);
        }
        // Depths have no colours.
        let tint = if depths { None } else { scene.tint(AXIS.frame())? };
        self.raycast.launch(
            device,
            (layout.voxels.kind(), kernel, Rendering { depths, ..region.rendering_from(gradients) }),
            RaycastArguments {
                voxels: &layout.voxels,
                view: layout.view,
                gradient_voxels: &gradients.layout.voxels,
                gradient_view: gradients.layout.view,
                light,
                sky,
                visible: &visible.flags,
                table: &table.entries,
                s,
                p: params(visible.blocks),
                sample: *sample,
                clip: region.for_kernels(AXIS.frame()),
                frame,
                active_samples,
            },
            tint,
        )
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
        let Scene { device, settings, viewport, .. } = *scene;
        let visible = scene.visible_blocks(AXIS, kernel)?;
        let table = scene.table(kernel)?;
        let mut layout = scene.weighted(AXIS, kernel)?;
        layout.view.background = scene.field.background_for(settings.blend);
        let gradients = scene.gradient_voxels(AXIS, kernel, &layout)?;
        let illumination = scene.illumination()?;
        let [light, sky] = illumination.arguments(&visible.flags);
        let steps = scene.steps(1);
        let sample = scene.table_samples(&table, steps, AXIS.frame());
        let region = Region::marched(scene, kernel, longest_slab(scene, step));
        let tiles = Tiles::for_screen(viewport, device.tuning());
        let Drawn { samples: frame, active_samples, .. } = &target.prepare(tiles);
        let useful = scene.field.useful_values(settings.blend).unwrap_or([f32::NEG_INFINITY, f32::INFINITY]);
        let tint = scene.tint(AXIS.frame())?;
        self.values.launch(
            device,
            (
                layout.voxels.kind(),
                kernel,
                Rendering { depths: gathers == RayOutput::Depths, ..region.rendering_from(&gradients) },
            ),
            CastValuesArguments {
                voxels: &layout.voxels,
                view: layout.view,
                gradient_voxels: &gradients.layout.voxels,
                gradient_view: gradients.layout.view,
                light,
                sky,
                visible: &visible.flags,
                table: &table.entries,
                s: screen_params(scene, steps, AXIS.frame(), tiles),
                p: slab_params(scene, step, useful, visible.blocks),
                sample,
                clip: region.for_kernels(AXIS.frame()),
                frame,
                active_samples,
            },
            tint,
        )
    }

    /// Renders pre-integrated slices.
    pub fn slice(&mut self, scene: &mut Scene, step: f64, target: &mut Target) -> Result<(), Error> {
        check_steps(scene, step)?;
        let Scene { device, viewport, .. } = *scene;
        let steps = scene.steps(1);
        let thickness = step * steps.shortest();
        let visible = scene.visible_blocks(AXIS, Kernel::Linear)?;
        let (integrals, slabs) = scene.slicing_table(thickness)?;
        let table = scene.table(Kernel::Linear)?;
        let layout = scene.layout(AXIS)?;
        let sample = scene.table_samples(&table, steps, AXIS.frame());
        let region = Region::marched(scene, Kernel::Linear, longest_slab(scene, step));
        let tiles = Tiles::for_screen(viewport, device.tuning());
        let Drawn { samples: frame, active_samples, .. } = &target.prepare(tiles);
        self.slicing.launch(
            device,
            (layout.voxels.kind(), region.rendering),
            &SlicingArguments {
                voxels: &layout.voxels,
                view: layout.view,
                gradient_voxels: &layout.voxels,
                gradient_view: layout.view,
                light: &visible.flags,
                sky: &visible.flags,
                visible: &visible.flags,
                table: &slabs,
                s: screen_params(scene, steps, AXIS.frame(), tiles),
                p: MarchParams {
                    table_first: integrals.scale.first,
                    table_per_value: integrals.scale.per_value * (SLAB_VALUES - 1) as f32 / integrals.scale.last as f32,
                    table_size: SLAB_VALUES as i32,
                    cut: i32::from(integrals.cut),
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
        // Layers are divided by the ray step here, not by samples per layer.
        let steps = scene.steps(1);
        let per_layer = (1.0 / step).round() as u32;
        let thinnest = step * steps.shortest();
        let visible = scene.visible_blocks(AXIS, kernel)?;
        let integrals = scene.integrals(kernel, thinnest, per_layer)?;
        let layout = scene.weighted(AXIS, kernel)?;
        let gradients = scene.gradient_voxels(AXIS, kernel, &layout)?;
        let illumination = scene.illumination()?;
        let [light, sky] = illumination.arguments(&visible.flags);
        let classification = ClassificationParams::from_integrals(scene, &integrals);
        let segment_params = SegmentParams::between_points(scene, steps, AXIS.frame(), Kernel::Linear, 1);
        let sample = scene.sample(AXIS.frame(), classification, segment_params);
        let segments = integrals.segments(settings.extinction, 1);
        let region = Region::marched(scene, kernel, longest_slab(scene, step));
        let tiles = Tiles::for_screen(viewport, device.tuning());
        let Drawn { samples: frame, active_samples, .. } = &target.prepare(tiles);
        let tint = scene.tint(AXIS.frame())?;
        self.segments.launch(
            device,
            (layout.voxels.kind(), kernel, segments, region.rendering_from(&gradients)),
            CastSegmentsArguments {
                voxels: &layout.voxels,
                view: layout.view,
                gradient_voxels: &gradients.layout.voxels,
                gradient_view: gradients.layout.view,
                light,
                sky,
                visible: &visible.flags,
                table: &integrals.nodes,
                s: screen_params(scene, steps, AXIS.frame(), tiles),
                p: slab_params(scene, step, integrals.visible_values, visible.blocks),
                sample,
                clip: region.for_kernels(AXIS.frame()),
                frame,
                active_samples,
            },
            tint,
        )
    }
}

/// Rejects steps so short that a frame would take unreasonably long, or that floats could not count them.
fn check_steps(scene: &Scene, step: f64) -> Result<(), Error> {
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
fn slab_params(scene: &Scene, step: f64, useful: [f32; 2], blocks: [i32; 2]) -> MarchParams {
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
fn longest_slab(scene: &Scene, step: f64) -> f64 {
    let longest = scene.rays.corners(scene.viewport).iter().map(|ray| ray.direction.abs().max_element()).fold(0.0, f64::max);
    longest * slab_parameter(scene, step)
}
