//! Sweeps of light through the layers.

use super::super::field::Layout;
use super::super::region::Region;
use super::super::scene::{GradientVoxels, Scene};
use super::coarse::Coarse;
use super::grid::ValueGrid;
use super::sources::Source;
use super::{KERNEL, extinction_estimator};
use crate::device::launch::light::{FinishLightArguments, LightSweep, LightSweepArguments, WHOLE_SUM};
use crate::device::launch::structs::{ClassificationParams, LayerOffset, LightSweepParams, SampleParams, SegmentParams};
use crate::device::{Buffer, LatticeSchedule};
use crate::error::Error;
use crate::layers::{Axis, AxisFrame, LightRays, disc_directions, sky_directions};
use glam::DVec3;

const OFFSETS: &str = "the offsets of rays from a light";
const SUMS: &str = "the sums of light";

/// One sweep, and its share of the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sweep {
    /// Unit vector towards the light, in grid axes (world scale).
    to_light: DVec3,
    axis: Axis,
    share: f64,
}

/// Where the light of a sweep goes.
#[derive(Clone, Copy)]
enum Sum {
    /// To the bytes.
    None = 0,
    /// To the sums.
    Store = 1,
    /// It is added to the sums.
    Add = 2,
}

/// The sweeps of a light: one, or several of a light with an angular diameter or near 45°, where the axis of the sweep fades as that of
/// views does.
pub(super) fn of_light(source: &Source, spacing: DVec3) -> Vec<Sweep> {
    let directions = disc_directions(source.to_light, source.angle);
    let share = 1.0 / directions.len() as f64;
    let by_axis = |to_light: DVec3| Axis::shares(to_light / spacing).into_iter().map(move |(axis, part)| (to_light, axis, part));
    directions.into_iter().flat_map(by_axis).map(|(to_light, axis, part)| Sweep { to_light, axis, share: share * part }).collect()
}

/// The sweeps of the ambient light.
pub(super) fn of_sky(spacing: DVec3) -> Vec<Sweep> {
    let sweep = |(to_light, share): (DVec3, f64)| Sweep { to_light, axis: Axis::most_parallel(to_light / spacing), share };
    sky_directions().into_iter().map(sweep).collect()
}

/// Bytes of the sums of several sweeps.
pub(super) fn sums(values: ValueGrid) -> (&'static str, usize) {
    (SUMS, size_of::<u16>() * values.values())
}

/// Upper limit of the bytes of the offsets of rays, for a volume of `dims` voxels.
pub(super) fn offsets(dims: [usize; 3]) -> (&'static str, usize) {
    (OFFSETS, 2 * size_of::<LayerOffset>() * (dims.into_iter().max().unwrap_or(0) + 2))
}

impl Scene<'_> {
    /// Sweeps light into volume number `n` of a buffer. `gain`: factor of the light before it is clamped to 1. `reach`: world distance over
    /// which shadows decrease to 1/e.
    pub(super) fn sweep_all(
        &mut self,
        sweeps: &[Sweep],
        coarse: Option<&Coarse>,
        values: ValueGrid,
        (volume, n): (&Buffer<u8>, usize),
        gain: f64,
        reach: Option<f64>,
    ) -> Result<(), Error> {
        let several = sweeps.len() > 1;
        let sums = Buffer::new(self.device, if several { values.values() } else { 1 }, SUMS)?;
        for (i, sweep) in sweeps.iter().enumerate() {
            let (sum, gain, steps) = match (several, i) {
                (false, _) => (Sum::None, gain, 255.0),
                (true, 0) => (Sum::Store, 1.0, f64::from(WHOLE_SUM) * sweep.share),
                (true, _) => (Sum::Add, 1.0, f64::from(WHOLE_SUM) * sweep.share),
            };
            let stored = Stored { volume, number: n as i32, sums: &sums, sum, gain, steps };
            self.sweep(sweep, coarse, values, &stored, reach)?;
        }
        if several {
            let arguments = FinishLightArguments {
                sums: &sums,
                values: values.values() as i32,
                whole: WHOLE_SUM,
                gain: gain as f32,
                volume: n as i32,
                light: volume,
            };
            self.light.finish.launch(self.device, (), &arguments)?;
        }
        Ok(())
    }

    fn sweep(
        &mut self,
        sweep: &Sweep,
        coarse: Option<&Coarse>,
        values: ValueGrid,
        stored: &Stored,
        reach: Option<f64>,
    ) -> Result<(), Error> {
        let frame = sweep.axis.frame();
        let spacing = self.field.grid().spacing() * values.voxels() as f64;
        let dims = values.inner();
        let rays = LightRays::new(dims, sweep.to_light / spacing, sweep.axis);
        // Lengths of a step from layer to layer, in world units and in unit distances.
        let world = (DVec3::new(rays.shear[0], rays.shear[1], 1.0) * frame.local(spacing)).length();
        let unit = self.settings.unit_distance.unwrap_or(self.field.grid().spacing().min_element());
        let step = world / unit;
        let integrals = self.integrals(KERNEL, self.steps(1).shortest(), 1)?;
        // Coarse media are small and are not culled.
        let visible = if coarse.is_none() { Some(self.visible_blocks(sweep.axis, KERNEL)?) } else { None };
        let offsets: Vec<_> = rays.offsets.iter().flatten().map(|o| LayerOffset { base: o.base, fraction: o.fraction }).collect();
        let offsets = Buffer::from_slice(self.device, &offsets, OFFSETS)?;
        let region = Region::for_light(self);
        let layout = match coarse {
            Some(coarse) => coarse.layout(sweep.axis),
            None => self.weighted(sweep.axis, KERNEL)?,
        };
        let gradients = self.extinction_gradients(sweep.axis, &layout)?;
        let local = |i: usize| dims[i] as i32;
        let toward = f64::from(rays.layer_step);
        let p = LightSweepParams {
            tiles: LightSweep::tiles(rays.size, self.device.tuning()),
            blocks: visible.as_ref().map_or([0; 2], |visible| visible.blocks),
            dims: [frame.u, frame.v, frame.a].map(local),
            layer_step: rays.layer_step,
            culling: i32::from(self.settings.culling && visible.is_some()),
            centre_layer: (dims[frame.a] as f32 - 1.0) / 2.0,
            along: rays.shear.map(|shear| (shear * toward) as f32),
            stride: values.strides(frame),
            volume: stored.number,
            volume_bytes: values.values() as i32,
            sum: stored.sum as i32,
            gain: stored.gain as f32,
            steps: stored.steps as f32,
            recovered: reach.map_or(1.0, |reach| (-0.5 * world / reach).exp() as f32),
            layer_length: step as f32 * integrals.unit,
            half_layer: coarse.map_or(0.0, |coarse| (0.5 * step / coarse.length) as f32),
        };
        let arguments = LightSweepArguments {
            voxels: &layout.voxels,
            view: layout.view,
            gradient_voxels: &gradients.layout.voxels,
            gradient_view: gradients.layout.view,
            visible: visible.as_ref().map_or(stored.volume, |visible| &visible.flags),
            integrals: &integrals.nodes,
            offsets: &offsets,
            p,
            sample: self.light_samples(frame, ClassificationParams::from_integrals(self, &integrals)),
            clip: region.for_kernels(frame),
            light: stored.volume,
            sums: stored.sums,
        };
        let variant = (layout.voxels.kind(), coarse.is_some(), region.rendering_from(&gradients));
        match self.device.tuning().lattice_schedule {
            LatticeSchedule::Tiles => self.light.sweep.launch(self.device, variant, &arguments),
            LatticeSchedule::Samples => self.light.rays.launch(self.device, variant, &arguments),
        }
    }

    /// The voxels from which gradients are estimated that change the opacity along rays from a light.
    pub(super) fn extinction_gradients(&mut self, axis: Axis, input: &Layout) -> Result<GradientVoxels, Error> {
        self.estimated_voxels(axis, (KERNEL, extinction_estimator(self.settings)), input)
    }

    /// Sample parameters of rays from a light.
    pub(super) fn light_samples(&self, frame: AxisFrame, classification: ClassificationParams) -> SampleParams {
        let segments = SegmentParams::single(self, self.steps(1), frame);
        let sample = self.sample(frame, classification, segments);
        SampleParams { field: self.field.params(extinction_estimator(self.settings), frame), ..sample }
    }
}

/// Where and how a sweep stores light.
struct Stored<'a> {
    volume: &'a Buffer<u8>,
    /// Number of the volume in the buffer.
    number: i32,
    sums: &'a Buffer<u16>,
    sum: Sum,
    gain: f64,
    /// Value of a light of 1.
    steps: f64,
}
