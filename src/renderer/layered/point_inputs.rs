//! Inputs of the kernels of point-sampled layers.

use super::super::channels::FieldInputs;
use super::super::classification::{Integrals, Table};
use super::super::range::LayerRange;
use super::super::region::Region;
use super::super::sampling::Steps;
use super::super::scene::Scene;
use super::super::tiles::Tiles;
use crate::device::launch::Rendering;
use crate::device::launch::layered::Segments;
use crate::device::launch::structs::{ClassificationParams, RayLatticeParams, SampleParams, SegmentParams};
use crate::error::Error;
use crate::layers::{Axis, AxisFrame, Kernel, Lattice, Stagger};
use crate::settings::Blend;
use std::sync::Arc;

/// A lattice of point-sampled layers, and the samples that its layers have.
pub(super) struct LatticeView<'a> {
    pub lattice: &'a Lattice,
    pub range: &'a LayerRange,
    pub tiles: Tiles,
    pub axis: Axis,
    pub kernel: Kernel,
    pub per_layer: u32,
}

impl LatticeView<'_> {
    pub fn frame(&self) -> AxisFrame {
        self.lattice.frame
    }

    /// Kernel permutation of this lattice.
    pub fn rendering(&self, rendering: Rendering) -> Rendering {
        Rendering { pixel_rays: self.lattice.pixel_rays.is_some(), ..rendering }
    }

    /// Kernel argument, for min-max blocks in these numbers.
    pub fn params(&self, blocks: [i32; 2], culling: bool) -> RayLatticeParams {
        let Self { lattice, range, tiles, kernel, .. } = *self;
        RayLatticeParams {
            layers: range.slabs(lattice, kernel.radius()),
            ..lattice_params(lattice, range, tiles, blocks, culling)
        }
    }
}

/// What layers of a field are sampled from and classified by.
pub(super) struct PointInputs {
    pub field: FieldInputs,
    pub integrals: Arc<Integrals>,
    pub table: Arc<Table>,
    pub segments: Segments,
}

impl PointInputs {
    pub fn new(scene: &mut Scene, view: &LatticeView) -> Result<Self, Error> {
        let &LatticeView { axis, kernel, per_layer, .. } = view;
        let steps = scene.steps(per_layer);
        let visible = scene.visible_blocks(axis, kernel)?;
        let integrals = scene.integrals(kernel, steps.shortest(), per_layer)?;
        let layout = scene.weighted(axis, kernel)?;
        let gradients = scene.gradient_voxels(axis, kernel, &layout)?;
        let table = scene.table(kernel)?;
        let sample = point_params(scene, (&integrals, &table), steps, view.frame(), (kernel, per_layer));
        let (region, segments) = (Region::new(scene, kernel, per_layer), segments(scene, &integrals, per_layer));
        let length = steps.shortest() * f64::from(per_layer);
        let place = scene.placement(view.frame(), kernel, &region, &visible);
        let colors = scene.voxel_colors(axis);
        let field = FieldInputs { layout, gradients, visible, sample, region, place, length, colors };
        Ok(Self { field, integrals, table, segments })
    }
}

/// Segment permutation; integrals are needed only for compositing.
pub(super) fn segments(scene: &Scene, integrals: &Integrals, per_layer: u32) -> Segments {
    match scene.settings.blend {
        Blend::Composite => integrals.segments(scene.settings.extinction, per_layer),
        _ => Segments::default(),
    }
}

/// Parameters of point samples of a kernel's field, `per_layer` per layer, and of the segments between them.
pub(super) fn point_params(
    scene: &Scene,
    (integrals, table): (&Integrals, &Table),
    steps: Steps,
    frame: AxisFrame,
    (kernel, per_layer): (Kernel, u32),
) -> SampleParams {
    let classification = match scene.settings.blend {
        Blend::Composite => ClassificationParams::from_integrals(scene, integrals),
        _ => ClassificationParams::from_useful_values(scene, table),
    };
    // Where the layers are not the field's, no sample is known to lie on a voxel.
    let between = if scene.field.own_axis(Axis::X) == Axis::X { kernel } else { Kernel::Linear };
    scene.sample(frame, classification, SegmentParams::between_points(scene.settings, steps, frame, between, per_layer))
}

/// Maximum distance of a staggered column from its row, in voxel rows.
fn farthest(lattice: &Lattice) -> i32 {
    if let Some(pixel_rays) = &lattice.pixel_rays {
        return pixel_rays.most_behind.ceil() as i32;
    }
    let staggered = lattice.stagger != Stagger::default();
    if staggered { lattice.rays[1].crossing[1].ceil() as i32 } else { 0 }
}

/// Kernel argument for a lattice, without the fields of point samples.
pub(super) fn lattice_params(
    lattice: &Lattice,
    range: &LayerRange,
    tiles: Tiles,
    blocks: [i32; 2],
    culling: bool,
) -> RayLatticeParams {
    let affine = |i: usize| {
        let rays = lattice.rays[i];
        [rays.crossing, rays.shear].as_flattened().iter().map(|&x| x as f32).collect::<Vec<_>>().try_into().expect("four numbers")
    };
    let pixel_rays = lattice.pixel_rays.as_deref();
    let steps = |axis: usize| pixel_rays.map_or([0.0; 2], |p| p.steps.map(|step| step[axis] as f32));
    RayLatticeParams {
        u_steps: steps(0),
        v_steps: steps(1),
        depth_steps: pixel_rays.map_or([0.0; 2], |p| p.depth_steps.map(|step| step as f32)),
        spread: pixel_rays.map_or([0.0; 2], |p| p.spread.map(|spread| spread as f32)),
        drift: pixel_rays.map_or([0.0; 4], |p| p.drift_terms().map(|term| term as f32)),
        lead: tiles.lead as i32,
        size: lattice.size.map(|n| n as i32),
        tiles: tiles.for_kernels(),
        blocks,
        layer_step: lattice.layer_step,
        culling: i32::from(culling),
        centre_layer: lattice.centre_layer as f32,
        layers: range.layers(lattice),
        continues: i32::from(range.continues),
        raw: i32::from(range.raw),
        rays: [affine(0), affine(1)],
        stagger: [lattice.stagger.first, lattice.stagger.per_column],
        farthest: farthest(lattice),
        runs: tiles.runs(),
    }
}
