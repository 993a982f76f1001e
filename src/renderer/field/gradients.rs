//! The scale of a field's gradients.

use super::Field;
use crate::device::launch::structs::FieldParams;
use crate::layers::{AxisFrame, GradientEstimator};
use glam::DVec3;

impl Field {
    /// Range of the stored numbers, the unit of gradients.
    fn gradient_range(&self) -> f64 {
        let (lo, hi) = self.stored().range;
        if hi > lo { hi - lo } else { 1.0 }
    }

    /// A gradient of one value per world unit, in value ranges per voxel of the smallest spacing.
    pub fn gradient_per_value(&self) -> f64 {
        let stored_per_value = (self.stored_value(1.0) - self.stored_value(0.0)).abs();
        stored_per_value * self.grid().spacing().min_element() / self.gradient_range()
    }

    /// Kernel argument, in the axes of `frame`, for gradients of this estimator.
    pub fn params(&self, estimator: Option<GradientEstimator>, frame: AxisFrame) -> FieldParams {
        let spacing = self.grid().spacing();
        let gradient = spacing.min_element() / spacing / self.gradient_range();
        // Estimates are made among the field's own voxels.
        let smoothing = estimator.map_or(DVec3::ZERO, |estimator| estimator.smoothing_across(self.own_grid().spacing()));
        let own = self.own_axis(frame.layer_axis()).frame();
        let narrow = |frame: AxisFrame, v: DVec3| frame.local(v).as_vec3().to_array();
        FieldParams { gradient: narrow(frame, gradient), smoothing: narrow(own, smoothing), range: self.voxel_values() }
    }
}
