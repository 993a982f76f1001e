//! Sampling along rays: steps, samples per layer, and the segments between samples.

use crate::device::launch::structs::SegmentParams;
use crate::layers::{AxisFrame, Kernel, LayerSlabs, lighting_curve, segment_ends};
use crate::settings::{Classification, Settings};
use glam::DVec3;

/// World lengths of voxel steps along the grid axes x, y, z, in unit distances, divided by the samples per layer.
#[derive(Clone, Copy)]
pub(super) struct Steps(pub DVec3);

impl Steps {
    /// The shortest of the three steps.
    pub fn shortest(self) -> f64 {
        self.0.min_element()
    }

    /// Length of a sample along rays of this shear, in unit distances.
    pub fn sample_length(self, frame: AxisFrame, shear: [f64; 2]) -> f64 {
        (DVec3::new(shear[0], shear[1], 1.0) * frame.local(self.0)).length()
    }
}

impl SegmentParams {
    /// One sample per layer, or steps independent of layers.
    pub(super) fn single(settings: &Settings, steps: Steps, frame: AxisFrame) -> Self {
        Self {
            samples_per_layer: [1, 0, 0],
            step: frame.local(steps.0).as_vec3().to_array(),
            ends: [[0.0; 2]; Classification::MAX_POINTS as usize],
            curve: 0.0,
            opaque: if settings.early_termination { Settings::OPAQUE as f32 } else { 0.0 },
        }
    }

    /// Segments between point samples of a kernel's field, `per_layer` per layer.
    pub(super) fn between_points(settings: &Settings, steps: Steps, frame: AxisFrame, kernel: Kernel, per_layer: u32) -> Self {
        let mut ends = [[0.0; 2]; Classification::MAX_POINTS as usize];
        for (n, ends) in (0..per_layer).zip(&mut ends) {
            *ends = segment_ends(kernel, per_layer, n).map(|w| w as f32);
        }
        Self {
            samples_per_layer: [per_layer as i32, 0, 0],
            ends,
            curve: lighting_curve(kernel, per_layer) as f32,
            ..Self::single(settings, steps, frame)
        }
    }

    /// Sub-slabs of splatted layers.
    pub(super) fn sub_slabs(settings: &Settings, steps: Steps, frame: AxisFrame, slabs: &LayerSlabs) -> Self {
        let LayerSlabs { inner, front, back } = slabs;
        Self { samples_per_layer: [inner, front, back].map(|slabs| slabs.len() as i32), ..Self::single(settings, steps, frame) }
    }
}
