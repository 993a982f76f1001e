//! Frames for which all voxels are on the device.

use super::super::accumulation::Jitter;
use super::super::classification::TableSizes;
use super::super::field::FieldShape;
use super::super::frame::{Declaring, Output, Stage};
use super::super::plan::Plan;
use super::super::report::FrameReport;
use super::super::{Renderer, UploadedVolume};
use super::{StreamedRenderer, plan};
use crate::camera::Camera;
use crate::error::Error;
use crate::image::Frame;
use crate::settings::Settings;
use crate::viewport::Viewport;

impl StreamedRenderer<'_> {
    /// Renders with all voxels on the device, and keeps the renderer for the next frame.
    pub(super) fn render_whole(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
        jitter: Option<Jitter>,
    ) -> Result<(Frame, FrameReport), Error> {
        let mut renderer = self.whole_renderer()?;
        let rendered = match jitter {
            None => renderer.render(camera, viewport, settings),
            Some(jitter) => renderer.render_jittered(camera, viewport, settings, jitter),
        };
        self.kept = Some(renderer);
        rendered
    }

    /// A renderer of all voxels: the kept one, or a new one.
    pub(super) fn whole_renderer(&mut self) -> Result<Renderer, Error> {
        let mut renderer = match self.kept.take() {
            Some(kept) => kept,
            None => Renderer::from_uploaded(&self.whole()?, &self.transfer)?,
        };
        renderer.measure(self.measuring);
        renderer.engine.limits = self.limits.clone();
        Ok(renderer)
    }

    /// Uploads all voxels on first use.
    pub(super) fn whole(&mut self) -> Result<UploadedVolume, Error> {
        match &self.whole {
            Some(uploaded) => Ok(uploaded.clone()),
            None => Ok(self.whole.insert(UploadedVolume::new(&self.device, &self.volume)?).clone()),
        }
    }

    /// Rejects a plan that needs the whole volume if that does not fit together with the other resources of the frame.
    pub(super) fn require_whole(&self, plan: &Plan, viewport: Viewport, settings: &Settings) -> Result<(), Error> {
        let tables = TableSizes::new(&self.transfer, self.volume.description());
        let shape = FieldShape::new(self.volume.description(), self.grid.dims());
        let gradient = settings.needed_gradient();
        let declaring = Declaring { shape, tables: &tables, tuning: self.device.tuning(), viewport, gradient };
        let (needed, limits) =
            (Stage::from_plan(plan, Output::Floats, false, &declaring).resources.bytes(), self.memory_limits());
        if limits.fits(needed) {
            return Ok(());
        }
        // The device counts the splats of sheets, so the size of their lists is not known before.
        let unknown = if matches!(plan, Plan::AxisSheets(_) | Plan::ViewSheets(_)) { ", and more for its splats" } else { "" };
        let what = format!(
            "this view ({plan}), which needs the whole volume at once because only layers on a lattice can be streamed{unknown},"
        );
        Err(plan::out_of_memory(&self.device, &what, needed, limits))
    }
}
