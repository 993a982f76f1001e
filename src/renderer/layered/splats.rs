//! Splatted layers, post-classified: the algorithm of the paper.

use super::super::channels::{CHANNELS, FieldInputs, MergedInputs};
use super::super::classification::Table;
use super::super::frame::{Declaring, Resources, Slot};
use super::super::range::LayerRange;
use super::super::region::Region;
use super::super::sampling::Steps;
use super::super::scene::Scene;
use super::super::tiles::{Drawn, Target, Tiles, declare_target};
use super::footprint_set::FootprintSet;
use super::pixels::{PixelInputs, layer_axes};
use super::point_inputs::lattice_params;
use crate::device::launch::Launcher;
use crate::device::launch::layered::{
    self as kernels, FootprintsArguments, OpacityTable, OpacityTableArguments, SplatDirect, SplatDirectArguments, SplatLattice,
    SplatLatticeArguments, SplatPerspective, SplatPerspectiveArguments, SplatSamples, SplatSamplesArguments,
};
use crate::device::launch::structs::{
    ClassificationParams, Float4, LayerOffset, RayEnds, RayLatticeParams, SampleParams, SegmentParams, SplatLatticeParams,
};
use crate::device::{Buffer, Device, LatticeSchedule, Tuning};
use crate::error::Error;
use crate::layers::{Axis, AxisFrame, Correction, Kernel, Lattice, LayerSlabs, Phases, SubSlab, quadrature_nodes};
use crate::settings::Footprints;
use crate::transfer::Extinction;
use std::sync::Arc;

/// Renders splatted layers.
#[derive(Default)]
pub(in crate::renderer) struct SplatLayers {
    lattice: Launcher<SplatLattice>,
    perspective: Launcher<SplatPerspective>,
    samples: Launcher<SplatSamples>,
    direct: Launcher<SplatDirect>,
    footprints: Launcher<kernels::Footprints>,
    opacity_table: Launcher<OpacityTable>,
    footprint_set: FootprintSet,
}

const OFFSETS: [Slot<LayerOffset>; 2] = [Slot::new("the lattice offsets along u"), Slot::new("the lattice offsets along v")];
const WEIGHTS: Slot<f32> = Slot::new("the footprint weights");
const OPACITY_TABLE: Slot<Float4> = Slot::new("the opacity table");
const SUB_SLABS: Slot<Float4> = Slot::new("the sub-slabs");
const NODES: Slot<[f32; 2]> = Slot::new("the quadrature nodes");

/// Declares the resources of [`SplatLayers::draw_lattice`].
pub(in crate::renderer) fn declare_lattice(
    declaring: &Declaring,
    lattice: &Lattice,
    correction: Correction,
    resources: &mut Resources,
) {
    let schedule = schedule(declaring.is_tiled, declaring.tuning);
    declare_target(lattice.samples(), tiles(declaring.is_tiled, lattice, declaring.tuning), resources);
    resources.host(&CHANNELS, 1 + declaring.others.len());
    let axis = lattice.frame.layer_axis();
    declaring.for_each_channel(|declaring| {
        declaring.visibility(axis, Kernel::Cubic, resources);
        declaring.gradients(axis, Kernel::Cubic, resources);
        declaring.table(Kernel::Cubic, resources);
    });
    resources.host(&SUB_SLABS, slab_count(correction));
    match (schedule, lattice.phases) {
        (LatticeSchedule::Samples, _) => {}
        (LatticeSchedule::Tiles, None) => resources.host(&NODES, quadrature_nodes().len()),
        (LatticeSchedule::Tiles, Some(Phases { samples_per_voxel, .. })) => {
            let layers = lattice.dims[2] + 2;
            let columns = kernels::Footprints::columns(samples_per_voxel[0], declaring.tuning);
            let rows = samples_per_voxel[1] as usize;
            resources.frame(&WEIGHTS, layers * rows * columns * kernels::Footprints::WEIGHTS);
            resources.frame(&OPACITY_TABLE, declaring.tables.entries(Kernel::Cubic));
            OFFSETS.iter().zip([columns, rows]).for_each(|(slot, offsets)| resources.host(slot, layers * offsets));
        }
    }
}

/// Schedule of kernels. `is_tiled`: of several fields, which have a work-item per tile on every device.
fn schedule(is_tiled: bool, tuning: &Tuning) -> LatticeSchedule {
    if is_tiled { LatticeSchedule::Tiles } else { tuning.lattice_schedule }
}

/// Tiles of a lattice.
fn tiles(is_tiled: bool, lattice: &Lattice, tuning: &Tuning) -> Tiles {
    match (schedule(is_tiled, tuning), lattice.phases) {
        (LatticeSchedule::Tiles, _) => Tiles::for_tiled_splats(lattice, tuning),
        (LatticeSchedule::Samples, _) => Tiles::for_splats(lattice, tuning),
    }
}

/// Declares the resources of [`SplatLayers::draw_pixels`].
pub(in crate::renderer) fn declare_pixels(
    declaring: &Declaring,
    axis: Option<Axis>,
    correction: Correction,
    footprints: Footprints,
    resources: &mut Resources,
) {
    declare_target(declaring.viewport.pixels(), Tiles::for_pixels(declaring.viewport), resources);
    layer_axes(axis).into_iter().for_each(|axis| declaring.visibility(axis, Kernel::Cubic, resources));
    declaring.gradients(Axis::Z, Kernel::Cubic, resources);
    declaring.table(Kernel::Cubic, resources);
    resources.host(&SUB_SLABS, slab_count(correction));
    resources.frame(&NODES, 1);
    if footprints == Footprints::Set {
        resources.kept(("the footprint set", None, None, 0), FootprintSet::buffers());
    }
}

impl SplatLayers {
    /// Renders a lattice.
    pub fn draw_lattice(
        &mut self,
        scene: &mut Scene,
        lattice: &Lattice,
        correction: Correction,
        range: &LayerRange,
        target: &mut Target,
    ) -> Result<(), Error> {
        let tuning = scene.device.tuning();
        let tiles = tiles(scene.is_tiled(), lattice, tuning);
        let drawn = target.prepare(tiles);
        if lattice.samples() == 0 {
            return Ok(());
        }
        let phases = match schedule(scene.is_tiled(), tuning) {
            LatticeSchedule::Tiles => lattice.phases.map(|phases| self.phase_weights(scene.device, lattice, phases, target)),
            LatticeSchedule::Samples => None,
        };
        let phases = phases.transpose()?;
        let slabs = slab_table(&LayerSlabs::new(correction));
        let slabs = target.arena.fill(scene.device, &SUB_SLABS, &slabs)?;
        let layers = SplattedLayers { lattice, correction, range, tiles, slabs, drawn };
        match phases {
            Some(phases) => self.draw_phases(scene, &layers, &phases, target),
            None => match schedule(scene.is_tiled(), tuning) {
                LatticeSchedule::Tiles => self.draw_rays(scene, &layers, target),
                LatticeSchedule::Samples => self.draw_samples(scene, &layers),
            },
        }
    }

    /// Computes the footprint weights of a lattice in phases.
    fn phase_weights(
        &mut self,
        device: &Device,
        lattice: &Lattice,
        phases: Phases,
        target: &mut Target,
    ) -> Result<PhaseWeights, Error> {
        let per_voxel = phases.samples_per_voxel.map(|m| m as i32);
        let shear = lattice.shear().map(|s| s as f32);
        let columns = kernels::Footprints::columns(phases.samples_per_voxel[0], device.tuning());
        let offsets = [columns, phases.samples_per_voxel[1] as usize];
        let offsets = [0, 1].map(|i| layer_offsets(lattice, phases, i, offsets[i]));
        let offsets_u = target.arena.fill(device, &OFFSETS[0], &offsets[0])?;
        let offsets_v = target.arena.fill(device, &OFFSETS[1], &offsets[1])?;
        let weights = target.arena.get(&WEIGHTS);
        let arguments = FootprintsArguments {
            offsets_u: &offsets_u,
            offsets_v: &offsets_v,
            shear_u: shear[0],
            shear_v: shear[1],
            per_voxel_u: per_voxel[0],
            per_voxel_v: per_voxel[1],
            columns: columns as i32,
            layers: lattice.dims[2] as i32 + 2,
            weights: &weights,
        };
        self.footprints.launch(device, (), &arguments)?;
        Ok(PhaseWeights { phases, offsets: [offsets_u, offsets_v], weights })
    }

    fn draw_phases(
        &mut self,
        scene: &mut Scene,
        layers: &SplattedLayers,
        phases: &PhaseWeights,
        target: &mut Target,
    ) -> Result<(), Error> {
        let Scene { device, settings, .. } = *scene;
        let inputs = scene.for_each_channel(|scene| SplatInputs::new(scene, layers))?;
        let merged = MergedInputs::new(inputs.iter().map(|inputs| &inputs.field).collect())?;
        let mut tables: Vec<_> = inputs.iter().map(|inputs| &inputs.table.entries).collect();
        let opacity_table = target.arena.get(&OPACITY_TABLE);
        if tables.len() == 1 && !merged.rendering.clipped {
            let arguments = OpacityTableArguments {
                base: tables[0],
                dt: inputs[0].steps.sample_length(layers.lattice.frame, layers.lattice.shear()) as f32,
                linear: i32::from(settings.extinction == Extinction::Linear),
                count: tables[0].len() as i32,
                entries: &opacity_table,
            };
            self.opacity_table.launch(device, (), &arguments)?;
            tables = vec![&opacity_table];
        }
        let (illumination, fields) = (scene.illumination()?, merged.params(device, CHANNELS.name)?);
        let light = illumination.arguments(merged.unused());
        let arguments = SplatLatticeArguments {
            channels: merged.shaded(&fields, &tables, light, layers.ray_ends(&merged), layers.drawn.output()),
            offsets_u: &phases.offsets[0],
            offsets_v: &phases.offsets[1],
            weights: &phases.weights,
            slabs: &layers.slabs,
            p: layers.phase_params(phases.phases, merged.blocks(), settings.culling),
        };
        self.lattice.launch(device, (merged.kind, merged.rendering, merged.channels()), &arguments)
    }

    fn draw_rays(&mut self, scene: &mut Scene, layers: &SplattedLayers, target: &mut Target) -> Result<(), Error> {
        let Scene { device, settings, .. } = *scene;
        let nodes = quadrature_nodes().map(|n| [n.z as f32, n.weight as f32]);
        let nodes = target.arena.fill(device, &NODES, &nodes)?;
        let inputs = scene.for_each_channel(|scene| SplatInputs::new(scene, layers))?;
        let merged = MergedInputs::new(inputs.iter().map(|inputs| &inputs.field).collect())?;
        let tables: Vec<_> = inputs.iter().map(|inputs| &inputs.table.entries).collect();
        let (illumination, fields) = (scene.illumination()?, merged.params(device, CHANNELS.name)?);
        let light = illumination.arguments(merged.unused());
        let arguments = SplatPerspectiveArguments {
            channels: merged.shaded(&fields, &tables, light, layers.ray_ends(&merged), layers.drawn.output()),
            nodes: &nodes,
            slabs: &layers.slabs,
            p: layers.ray_params(merged.blocks(), settings.culling),
        };
        self.perspective.launch(device, (merged.kind, merged.rendering, merged.channels()), &arguments)
    }

    fn draw_samples(&mut self, scene: &mut Scene, layers: &SplattedLayers) -> Result<(), Error> {
        let Scene { device, settings, .. } = *scene;
        let SplatInputs { field, table, .. } = SplatInputs::new(scene, layers)?;
        let illumination = scene.illumination()?;
        let arguments = SplatSamplesArguments {
            field: field.shaded(illumination.arguments(&field.visible.flags)),
            visible: &field.visible.flags,
            table: &table.entries,
            slabs: &layers.slabs,
            p: layers.ray_params(field.visible.blocks, settings.culling),
            sample: field.sample,
            ray_ends: field.region.for_kernels(layers.lattice.frame),
            output: layers.drawn.output(),
        };
        self.samples.launch(device, (field.layout.voxels.kind(), field.rendering()), &arguments)
    }

    /// Renders per screen pixel, with one layer axis for all rays or one per ray.
    pub fn draw_pixels(
        &mut self,
        scene: &mut Scene,
        axis: Option<Axis>,
        correction: Correction,
        footprints: Footprints,
        target: &mut Target,
    ) -> Result<(), Error> {
        let device = scene.device;
        let table = scene.table(Kernel::Cubic)?;
        let slabs = LayerSlabs::new(correction);
        let steps = scene.steps(correction.samples_per_layer());
        let sample = splat_params(scene, &table, steps, Axis::Z.frame(), &slabs);
        let layout = scene.layout(Axis::Z)?;
        let region = Region::new(scene, Kernel::Cubic, 1);
        let field = PixelInputs::new(scene, (axis, Kernel::Cubic), layout, sample, region)?;
        let set = footprints == Footprints::Set;
        let images = if set { Some(self.footprint_set.images(device)?) } else { None };
        // A kernel with exact footprints reads neither; pass any valid buffers.
        let no_shears = target.arena.get(&NODES);
        let (images, shears) = images.as_ref().map_or((&field.visible[0].flags, &*no_shears), |set| (&set.images, &set.shears));
        let slabs = &target.arena.fill(device, &SUB_SLABS, &slab_table(&slabs))?;
        let drawn = target.prepare(Tiles::for_pixels(scene.viewport));
        let pixels = field.arguments(scene, drawn.output());
        let arguments = SplatDirectArguments { pixels, table: &table.entries, slabs, images, shears };
        self.direct.launch(device, (field.kind(), set, field.rendering()), &arguments)
    }
}

/// A lattice of splatted layers, and the buffers that all of its kernels use.
struct SplattedLayers<'a> {
    lattice: &'a Lattice,
    correction: Correction,
    range: &'a LayerRange,
    tiles: Tiles,
    slabs: Arc<Buffer<Float4>>,
    drawn: Drawn,
}

/// The footprint weights of a lattice in phases.
struct PhaseWeights {
    phases: Phases,
    offsets: [Arc<Buffer<LayerOffset>>; 2],
    weights: Arc<Buffer<f32>>,
}

impl SplattedLayers<'_> {
    /// Kernel argument of a lattice in phases, for min-max blocks in these numbers.
    fn phase_params(&self, phases: Phases, blocks: [i32; 2], culling: bool) -> SplatLatticeParams {
        let Self { lattice, range, .. } = *self;
        SplatLatticeParams {
            per_voxel: phases.samples_per_voxel.map(|m| m as i32),
            columns: phases.columns.map(|c| c as i32),
            tiles: self.tiles.for_kernels(),
            blocks,
            layer_step: lattice.layer_step,
            culling: i32::from(culling),
            layers: range.layers(lattice),
            continues: i32::from(range.continues),
            raw: i32::from(range.raw),
            shear: lattice.shear().map(|s| s as f32),
        }
    }

    /// Kernel argument.
    fn ray_ends(&self, fields: &MergedInputs) -> RayEnds {
        fields.region.for_kernels(self.lattice.frame)
    }

    /// Kernel argument of a lattice of rays.
    fn ray_params(&self, blocks: [i32; 2], culling: bool) -> RayLatticeParams {
        lattice_params(self.lattice, self.range, self.tiles, blocks, culling)
    }
}

/// What layers of a field are splatted from and classified by.
struct SplatInputs {
    field: FieldInputs,
    /// (r, g, b, τ) per value.
    table: Arc<Table>,
    steps: Steps,
}

impl SplatInputs {
    fn new(scene: &mut Scene, layers: &SplattedLayers) -> Result<Self, Error> {
        let (frame, samples) = (layers.lattice.frame, layers.correction.samples_per_layer());
        let axis = frame.layer_axis();
        let table = scene.table(Kernel::Cubic)?;
        let steps = scene.steps(samples);
        let sample = splat_params(scene, &table, steps, frame, &LayerSlabs::new(layers.correction));
        let region = Region::new(scene, Kernel::Cubic, 1);
        let visible = scene.visible_blocks(axis, Kernel::Cubic)?;
        let layout = scene.layout(axis)?;
        let gradients = scene.gradient_voxels(axis, Kernel::Cubic, &layout)?;
        let length = steps.shortest() * f64::from(samples);
        let place = scene.placement(frame, Kernel::Cubic, &region, &visible);
        Ok(Self { field: FieldInputs { layout, gradients, visible, sample, region, place, length, colors: None }, table, steps })
    }
}

/// Offsets of the first columns (`i` = 0) or rows (1) of a lattice in phases, `count` for each layer.
fn layer_offsets(lattice: &Lattice, phases: Phases, i: usize, count: usize) -> Vec<LayerOffset> {
    let m = phases.samples_per_voxel[i] as usize;
    let of_layer = |layer: &[crate::layers::LayerOffset]| -> Vec<LayerOffset> {
        let offset = |n: usize| LayerOffset { base: layer[n % m].base + (n / m) as i32, fraction: layer[n % m].fraction };
        (0..count).map(offset).collect()
    };
    lattice.offsets(phases, i).chunks(m).flat_map(of_layer).collect()
}

/// Number of sub-slabs that the kernels read.
fn slab_count(correction: Correction) -> usize {
    let LayerSlabs { inner, front, back } = LayerSlabs::new(correction);
    inner.len() + front.len() + back.len()
}

/// Sub-slabs in the order of the kernels: inner, front, back.
fn slab_table(slabs: &LayerSlabs) -> Vec<Float4> {
    let entry = |s: &SubSlab| Float4([s.before, s.own, s.after, s.share].map(|w| w as f32));
    slabs.inner.iter().chain(&slabs.front).chain(&slabs.back).map(entry).collect()
}

/// Parameters of samples in the sub-slabs of splatted layers.
fn splat_params(scene: &Scene, table: &Table, steps: Steps, frame: AxisFrame, slabs: &LayerSlabs) -> SampleParams {
    let segments = SegmentParams::sub_slabs(scene.settings, steps, frame, slabs);
    scene.sample(frame, ClassificationParams::from_table(scene, table), segments)
}
