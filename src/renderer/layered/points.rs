//! Point-sampled layers with pre-integrated segments.

use super::super::channels::declare_channels;
use super::super::frame::{Declaring, Resources};
use super::super::range::LayerRange;
use super::super::region::Region;
use super::super::scene::Scene;
use super::super::tiles::{Target, Tiles, declare_target};
use super::channels::ChannelLayers;
use super::colors::ColorLayers;
use super::pixels::{PixelInputs, layer_axes};
use super::point_inputs::{LatticeView, PointInputs, point_params, segments};
use crate::device::launch::Launcher;
use crate::device::launch::layered::{PointDirect, PointDirectArguments, PointLattice, PointLatticeArguments, PointSamples};
use crate::device::{LatticeSchedule, Tuning};
use crate::error::Error;
use crate::layers::{Axis, Density, Kernel, Lattice};
use crate::settings::{Classification, Evaluation};

/// Renders point-sampled layers.
#[derive(Default)]
pub(in crate::renderer) struct PointLayers {
    lattice: Launcher<PointLattice>,
    samples: Launcher<PointSamples>,
    direct: Launcher<PointDirect>,
    channels: ChannelLayers,
    colors: ColorLayers,
}

/// Layer thicknesses in pixels from which a layer gets one and two additional samples.
const MAGNIFIED: [f64; 2] = [6.0, 12.0];

/// Most additional samples of layers that are thicker than the smallest spacing.
const MOST_FOR_THICKNESS: u32 = 3;

/// Samples per layer for layers of this thickness, in pixels and in smallest spacings. Lattices that adapt to the screen also adapt the
/// sampling along rays. At high magnification few voxels are in view, and what happens between layers becomes visible. Thick layers get a
/// sample per smallest spacing, rounded: otherwise pictures along two layer axes differ in brightness (docs/dev/fidelity.md). Lattices that follow
/// the screen have a sample per pixel along rays, too, rounded up.
fn adapted(samples_per_layer: u32, evaluation: Evaluation, pixels: f64, smallest_spacings: f64) -> u32 {
    let for_magnification = match evaluation {
        Evaluation::Lattice(Density::Relaxed | Density::Fine) => {
            MAGNIFIED.iter().filter(|&&limit| pixels >= limit).count() as u32
        }
        Evaluation::Lattice(Density::Screen) => (pixels.ceil() as u32).saturating_sub(samples_per_layer),
        Evaluation::Lattice(Density::AtLeast(_) | Density::Fixed(_)) | Evaluation::Direct => return samples_per_layer,
    };
    (samples_per_layer + for_magnification.max(for_thickness(smallest_spacings))).min(Classification::MAX_POINTS)
}

/// Additional samples of layers of this thickness in smallest spacings.
fn for_thickness(smallest_spacings: f64) -> u32 {
    (smallest_spacings.round() as u32 - 1).min(MOST_FOR_THICKNESS)
}

/// Declares the resources of [`PointLayers::draw_lattice`].
pub(in crate::renderer) fn declare_lattice(
    declaring: &Declaring,
    (lattice, evaluation): (&Lattice, Evaluation),
    kernel: Kernel,
    resources: &mut Resources,
) {
    declare_target(lattice.samples(), tiles(declaring.is_tiled, lattice, declaring.tuning), resources);
    declare_channels(declaring, resources);
    // Lattices that share a frame have tables of their own if they differ in samples per layer.
    let axis = lattice.frame.layer_axis();
    let own = evaluation == Evaluation::Lattice(Density::Screen) || for_thickness(declaring.shape.thickness(axis)) > 0;
    declaring.for_each_channel(|declaring| {
        declaring.visibility(axis, kernel, resources);
        declaring.gradients(axis, kernel, resources);
        declaring.integrals(Some(axis).filter(|_| own), kernel, resources);
    });
}

/// Tiles of a lattice. `is_tiled`: of several fields or of colours.
fn tiles(is_tiled: bool, lattice: &Lattice, tuning: &Tuning) -> Tiles {
    if is_tiled { Tiles::for_tiled_points(lattice, tuning) } else { Tiles::for_points(lattice, tuning) }
}

/// Declares the resources of [`PointLayers::draw_pixels`].
pub(in crate::renderer) fn declare_pixels(declaring: &Declaring, axis: Option<Axis>, kernel: Kernel, resources: &mut Resources) {
    declare_target(declaring.viewport.pixels(), Tiles::for_pixels(declaring.viewport), resources);
    layer_axes(axis).into_iter().for_each(|axis| declaring.visibility(axis, kernel, resources));
    declaring.gradients(Axis::Z, kernel, resources);
    declaring.integrals(None, kernel, resources);
}

impl PointLayers {
    /// Renders a lattice.
    pub fn draw_lattice(
        &mut self,
        scene: &mut Scene,
        lattice: &Lattice,
        (kernel, samples_per_layer): (Kernel, u32),
        evaluation: Evaluation,
        range: &LayerRange,
        target: &mut Target,
    ) -> Result<(), Error> {
        let Scene { device, settings, .. } = *scene;
        let frame = lattice.frame;
        let axis = frame.layer_axis();
        let thickness = scene.field.shape().thickness(axis);
        let per_layer = adapted(samples_per_layer, evaluation, scene.rays.pixels_along(frame.a), thickness);
        let tiles = tiles(scene.is_tiled(), lattice, device.tuning());
        let drawn = target.prepare(tiles);
        let output = drawn.output();
        if lattice.samples() == 0 {
            return Ok(());
        }
        let view = LatticeView { lattice, range, tiles, axis, kernel, per_layer };
        if let Some(colors) = scene.colors() {
            return self.colors.draw(scene, colors, &view, output);
        }
        if scene.draws_fields_together() {
            return self.channels.draw(scene, &view, output);
        }
        let PointInputs { field, integrals, table, segments } = PointInputs::new(scene, &view)?;
        let illumination = scene.illumination()?;
        let variant = (field.layout.voxels.kind(), kernel, segments, view.rendering(field.rendering()));
        let arguments = PointLatticeArguments {
            field: field.shaded(illumination.arguments(&field.visible.flags)),
            visible: &field.visible.flags,
            shown_slabs: &field.visible.shown,
            integrals: &integrals.nodes,
            table: &table.entries,
            p: view.params(field.visible.blocks, settings.culling),
            sample: field.sample,
            ray_ends: field.region.for_layers(frame),
            output,
            tint: scene.tint(frame)?,
        };
        match device.tuning().lattice_schedule {
            LatticeSchedule::Tiles => self.lattice.launch(device, variant, &arguments),
            LatticeSchedule::Samples => self.samples.launch(device, variant, &arguments),
        }
    }

    /// Renders per screen pixel, with one layer axis for all rays or one per ray.
    pub fn draw_pixels(
        &mut self,
        scene: &mut Scene,
        axis: Option<Axis>,
        (kernel, samples_per_layer): (Kernel, u32),
        target: &mut Target,
    ) -> Result<(), Error> {
        let device = scene.device;
        let steps = scene.steps(samples_per_layer);
        let integrals = scene.integrals(kernel, steps.shortest(), samples_per_layer)?;
        let segments = segments(scene, &integrals, samples_per_layer);
        let table = scene.table(kernel)?;
        let sample = point_params(scene, (&integrals, &table), steps, Axis::Z.frame(), (kernel, samples_per_layer));
        let layout = scene.weighted(Axis::Z, kernel)?;
        let region = Region::new(scene, kernel, samples_per_layer);
        let field = PixelInputs::new(scene, (axis, kernel), layout, sample, region)?;
        let drawn = target.prepare(Tiles::for_pixels(scene.viewport));
        let arguments = PointDirectArguments {
            pixels: field.arguments(scene, drawn.output()),
            integrals: &integrals.nodes,
            table: &table.entries,
        };
        self.direct.launch(device, (field.kind(), kernel, segments, field.rendering()), &arguments)
    }
}
