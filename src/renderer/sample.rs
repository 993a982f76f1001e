//! Parameters of the step that classifies, shades and composites one sample.

use super::Renderer;
use super::algorithm::Algorithm;
use super::settings::{Classification, Settings};
use super::tables::Integrals;
use crate::device::launch::Stretches;
use crate::device::launch::params::{Float4, SampleParams};
use crate::layers::{AxisFrame, CURVE_SHARE, Correction, LayerSlabs, Rays, SubSlab, stretch_ends};
use crate::transfer::Extinction;
use glam::DVec3;

/// What a sample needs along the grid's axes x, y, z.
pub(super) struct SampleAxes {
    /// Voxel differences to gradients in value ranges per voxel of the smallest spacing.
    pub gradient: DVec3,
    /// Direction to the light.
    pub light: DVec3,
    /// Half-way between light and eye.
    pub half_way: DVec3,
    /// World size of a voxel step, in unit distances times samples per layer.
    pub step: DVec3,
}

impl SampleAxes {
    /// Length of a sample along rays of one direction, in unit distances.
    pub fn sample_length(&self, frame: AxisFrame, shear: [f64; 2]) -> f64 {
        (DVec3::new(shear[0], shear[1], 1.0) * frame.local(self.step)).length()
    }
}

impl Renderer {
    pub(super) fn sample_axes(&self, rays: &Rays, settings: &Settings) -> SampleAxes {
        let spacing = self.grid.spacing();
        let smallest = spacing.min_element();
        let range = self.value_range.1 - self.value_range.0;
        let range = if range > 0.0 { range } else { 1.0 };
        let light =
            settings.shading.and_then(|s| s.light).map_or(rays.to_eye, |l| self.grid.world_to_grid_axes() * l.normalize());
        let unit = settings.unit_distance.unwrap_or(smallest) * f64::from(settings.samples_per_layer());
        SampleAxes {
            gradient: smallest / spacing / range,
            light,
            half_way: (light + rays.to_eye).normalize_or(rays.to_eye),
            step: spacing / unit,
        }
    }

    /// Parameters for a layer axis; the direct kernel, whose rays may differ in theirs, sets the axes itself.
    pub(super) fn sample_params(&self, axes: &SampleAxes, frame: AxisFrame, settings: &Settings) -> SampleParams {
        let kept = &self.kept;
        let table = kept.table();
        let ((table_first, table_per_value, table_last), visible, table_unit, samples) = match settings.classification {
            _ if settings.algorithm != Algorithm::Layered => (table.scale, table.visible_entries, 0.0, [1, 0, 0]),
            Classification::Post(correction) => {
                let slabs = LayerSlabs::new(correction);
                (table.scale, table.visible_entries, 0.0, [slabs.inner.len(), slabs.front.len(), slabs.back.len()])
            }
            Classification::Preintegrated { samples_per_layer } => {
                let integrals = kept.integrals();
                (integrals.scale, [0; 2], integrals.unit, [samples_per_layer as usize, 0, 0])
            }
        };
        let shading = settings.shading.unwrap_or_default();
        let local = |v: DVec3| frame.local(v).as_vec3().to_array();
        SampleParams {
            table_first,
            table_per_value,
            table_last,
            visible,
            linear: i32::from(settings.extinction == Extinction::Linear),
            samples_per_layer: samples.map(|n| n as i32),
            background_visible: i32::from(self.transfer.opacity(self.field_range.0) > 0.0),
            opaque: if settings.early_termination { Settings::OPAQUE as f32 } else { 0.0 },
            shading: i32::from(settings.shading.is_some()),
            gradient: local(axes.gradient),
            light: local(axes.light),
            half_way: local(axes.half_way),
            ambient: shading.ambient as f32,
            diffuse: shading.diffuse as f32,
            specular: shading.specular as f32,
            power: shading.power as f32,
            step: local(axes.step),
            table_unit,
            ends: stretch_weights(settings),
            // Between layers gradients stay near theirs; nearer samples are as good as straight.
            curve: if settings.samples_per_layer() == 1 { CURVE_SHARE as f32 } else { 0.0 },
        }
    }
}

/// Weights of the ends of all stretches between two layers.
fn stretch_weights(settings: &Settings) -> [[f32; 2]; Classification::MAX_POINTS as usize] {
    let samples = settings.samples_per_layer();
    std::array::from_fn(|n| n as u32).map(|n| if n < samples { stretch_ends(samples, n).map(|w| w as f32) } else { [0.0; 2] })
}

/// How pre-integrated stretches are built from a table.
pub(super) fn stretches(integrals: &Integrals, settings: &Settings) -> Stretches {
    let curved = stretch_ends(settings.samples_per_layer(), 0) != [0.0; 2];
    let dimmed = integrals.dimmed && settings.extinction == Extinction::Exponential;
    Stretches { cut: integrals.cut, curved, dimmed }
}

/// Sub-slabs as the kernels read them: inner, front and back ones after each other.
pub(super) fn slab_table(correction: Correction) -> Vec<Float4> {
    let slabs = LayerSlabs::new(correction);
    let entry = |s: &SubSlab| Float4([s.before, s.own, s.after, s.share].map(|w| w as f32));
    slabs.inner.iter().chain(&slabs.front).chain(&slabs.back).map(entry).collect()
}
