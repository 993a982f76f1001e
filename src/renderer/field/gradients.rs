//! The scale of a field's gradients.

use super::Field;
use crate::device::launch::structs::FieldParams;
use crate::layers::{AxisFrame, GradientEstimator};
use glam::DVec3;

impl Field {
    /// A gradient of one value per normalised world unit, as a share of the [steepness](crate::volume::Description::steepness).
    pub fn gradient_per_value(&self) -> f64 {
        1.0 / (self.description().steepness() * self.world().unit())
    }

    /// Kernel argument, in the axes of `frame`, for gradients of this estimator.
    pub fn params(&self, estimator: Option<GradientEstimator>, frame: AxisFrame) -> FieldParams {
        let gradient = self.gradient_per_value() * self.description().rescale().slope().abs() / self.grid().spacing();
        // Estimates are made among the field's own voxels.
        let smoothing = estimator.map_or(DVec3::ZERO, |estimator| estimator.smoothing_across(self.own_grid().spacing()));
        let own = self.own_axis(frame.layer_axis()).frame();
        let narrow = |frame: AxisFrame, v: DVec3| frame.local(v).as_vec3().to_array();
        FieldParams { gradient: narrow(frame, gradient), smoothing: narrow(own, smoothing), range: self.voxel_values() }
    }
}
