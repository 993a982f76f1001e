//! The interface that all renderers of volumes share.

use super::Renderer;
use super::frames::MeasuredReport;
use crate::camera::Camera;
use crate::device::Cancel;
use crate::error::Error;
use crate::image::{Depths, Frame};
use crate::renderer::{Accumulation, FrameReport, LatticeView, StreamPlan, VolumeRenderer};
use crate::settings::Settings;
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Grid, Volume};
use std::time::Duration;

impl<'v> VolumeRenderer<'v> for Renderer<'v> {
    fn set_transfer_function(&mut self, transfer: &TransferFunction) {
        self.set_transfer_function(transfer);
    }

    fn transfer_function(&self) -> &TransferFunction {
        &self.transfer
    }

    fn set_volume(&mut self, volume: &Volume<'v>) -> Result<(), Error> {
        self.set_volume(volume)
    }

    fn grid(&self) -> &Grid {
        self.description().grid()
    }

    fn measure(&mut self, measuring: bool) {
        self.measure(measuring);
    }

    fn limit(&mut self, longest: Option<Duration>) {
        self.limit(longest);
    }

    fn set_cancel(&mut self, cancel: Option<Cancel>) {
        self.set_cancel(cancel);
    }

    fn stream_plan(&self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Option<StreamPlan>, Error> {
        LatticeView::all(self.seen(), camera, viewport, settings).map(|_| None)
    }

    fn render(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
    ) -> Result<(Option<Frame>, FrameReport), Error> {
        let (frame, report) = self.render_jittered(camera, viewport, settings, None)?;
        Ok((frame, frame_report(report)))
    }

    fn accumulate(
        &mut self,
        camera: &Camera,
        settings: &Settings,
        accumulation: &mut Accumulation,
    ) -> Result<FrameReport, Error> {
        self.accumulate_measured(camera, settings, accumulation).map(frame_report)
    }

    fn depths(&mut self, _: &Camera, _: Viewport, _: &Settings) -> Result<Depths, Error> {
        let problem = "depths need the whole volume on one device: render them in one process".into();
        Err(Error::Settings { field: "depth", problem })
    }
}

fn frame_report((report, measured): MeasuredReport) -> FrameReport {
    FrameReport { lattice: Some(report.lattice), measured, general_program: false, processes: Some(report) }
}
