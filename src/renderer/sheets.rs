//! Frames by axis-aligned and by image-aligned sheets.

use super::Renderer;
use super::settings::Settings;
use super::splat_list::Splatted;
use super::splats::splat_params;
use super::tables::PointReach;
use crate::device::Buffer;
use crate::device::launch::params::{SampleParams, ScreenParams, SplatParams};
use crate::device::launch::{SheetArguments, ViewSheetsKernel};
use crate::error::Error;
use crate::layers::{Axis, GAUSSIAN_RADIUS, Rays, SplatProjection, SplatSlabs, Viewport};
use glam::DVec3;

impl Renderer {
    /// Splats onto one sheet per layer, into `scratch.frame`.
    pub(super) fn run_axis_sheets(
        &mut self,
        axis: Axis,
        rays: &Rays,
        viewport: Viewport,
        settings: &Settings,
    ) -> Result<(), Error> {
        let Self { device, kernels, kept, .. } = self;
        kept.prepare_axis_splats(device, kernels, axis, &self.transfer, settings.extinction)?;
        let frame = axis.frame();
        let axes = self.sample_axes(rays, settings);
        let sample = self.sample_params(&axes, frame, settings);
        let projection = SplatProjection::new(rays, viewport, &self.grid);
        let (background, _) = self.kept.background();
        let backwards = i32::from(rays.central_direction()[axis.index()] < 0.0);
        let params = SplatParams { backwards, ..splat_params(&projection, frame, background) };
        let screen = self.begin_screen(rays, viewport, &axes, frame)?;
        self.sort_splats(|kept| kept.axis_splats(axis), Splatted::Visible, params, sample, &screen)?;
        let kernel = self.kernels.axis_sheets(&self.device)?;
        kernel.launch(&self.device, &self.sheet_arguments(screen, params, sample))
    }

    /// Splats slabs onto sheets across the view, `distance` voxels apart, into `scratch.frame`.
    pub(super) fn run_view_sheets(
        &mut self,
        distance: f64,
        rays: &Rays,
        viewport: Viewport,
        settings: &Settings,
    ) -> Result<(), Error> {
        const AXIS: Axis = Axis::Z;
        let Self { device, kernels, kept, scratch, .. } = self;
        let splatted = if settings.culling { Splatted::InReach } else { Splatted::All };
        kept.prepare_view_splats(device, kernels, &self.transfer, settings.extinction, splatted)?;
        let slabs = SplatSlabs { distance };
        if scratch.slab_weights.as_ref().is_none_or(|(made_for, _)| *made_for != slabs) {
            let weights = Buffer::from_slice(device, &slab_weights(slabs), "the slabs of a splat")?;
            scratch.slab_weights = Some((slabs, weights));
        }
        let axes = self.sample_axes(rays, settings);
        let sample = self.sample_params(&axes, AXIS.frame(), settings);
        let projection = SplatProjection::new(rays, viewport, &self.grid);
        let background = self.kept.gaussian_background();
        let params = SplatParams {
            sheet_distance: distance as f32,
            sheets: self.sheets(&projection, distance),
            ..splat_params(&projection, AXIS.frame(), background)
        };
        let screen = self.begin_screen(rays, viewport, &axes, AXIS.frame())?;
        self.sort_splats(|kept| kept.view_splats(), splatted, params, sample, &screen)?;
        let kernel = self.kernels.view_sheets(&self.device, slabs.count(), settings.shading.is_some())?;
        let (_, view) = self.kept.layout_for(AXIS, PointReach::Gaussian);
        let (_, weights) = self.scratch.slab_weights.as_ref().expect("made above");
        let arguments = self.sheet_arguments(screen, params, sample);
        kernel.launch(&self.device, &view, weights, &self.kept.table().entries, &arguments)
    }

    /// First and last sheet that any voxel's splat can reach.
    fn sheets(&self, projection: &SplatProjection, distance: f64) -> [i32; 2] {
        let size = DVec3::from_array(self.grid.dims().map(|n| n as f64 - 1.0));
        let deepest = (projection.along.abs().dot(size) / 2.0 + GAUSSIAN_RADIUS) / distance;
        [(-deepest - 1.5).floor() as i32, (deepest + 1.5).ceil() as i32]
    }

    fn sheet_arguments(&self, screen: ScreenParams, params: SplatParams, sample: SampleParams) -> SheetArguments<'_> {
        let made = "sort_splats() and begin_screen() made them";
        let scratch = &self.scratch;
        SheetArguments {
            sorted: scratch.sorted.as_ref().expect(made),
            ends: scratch.tile_ends.as_ref().expect(made),
            lists: scratch.lists.as_ref().expect(made),
            screen,
            params,
            sample,
            frame: scratch.frame.as_ref().expect(made),
            active_samples: scratch.active_samples.as_ref().expect(made),
        }
    }
}

/// Weights of all sheets that a splat reaches, for evenly spaced fractions.
fn slab_weights(slabs: SplatSlabs) -> Vec<f32> {
    let steps = ViewSheetsKernel::SLAB_STEPS;
    let at = |i: usize| (0..slabs.count()).map(move |n| slabs.weight(n, i as f64 / steps as f64) as f32);
    (0..=steps).flat_map(at).collect()
}
