//! Frames of several processes: each composites its layers, and rank 0 receives the picture.

use super::{Renderer, Source};
use crate::camera::Camera;
use crate::distributed::report::Totals;
use crate::error::Error;
use crate::image::Frame;
use crate::renderer::{Accumulation, DistributedReport, Jitter, LatticeView, Measured};
use crate::settings::Settings;
use crate::viewport::Viewport;
use std::time::Instant;

/// The report of a frame, and its statistics if measured: stage times of this process, active samples of all.
pub(super) type MeasuredReport = (DistributedReport, Option<Measured>);

impl Renderer<'_> {
    /// Renders a frame of premultiplied floats without a background. Rank 0 receives it; other ranks get `None`.
    ///
    /// # Errors
    /// Views without a lattice; errors of any process.
    pub fn render(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
    ) -> Result<(Option<Frame>, DistributedReport), Error> {
        let (frame, (report, _)) = self.render_jittered(camera, viewport, settings, None)?;
        Ok((frame, report))
    }

    /// Renders the next frame of an accumulation, and adds it on rank 0; other ranks count it. Collective, with accumulations of the
    /// same number of frames.
    ///
    /// # Errors
    /// Those of [`render`](Self::render). The accumulations are then unchanged.
    pub fn accumulate(
        &mut self,
        camera: &Camera,
        settings: &Settings,
        accumulation: &mut Accumulation,
    ) -> Result<DistributedReport, Error> {
        Ok(self.accumulate_measured(camera, settings, accumulation)?.0)
    }

    /// [`accumulate`](Self::accumulate), with the statistics of the frame.
    pub(super) fn accumulate_measured(
        &mut self,
        camera: &Camera,
        settings: &Settings,
        accumulation: &mut Accumulation,
    ) -> Result<MeasuredReport, Error> {
        accumulation.extend(|viewport, jitter| self.render_jittered(camera, viewport, settings, Some(jitter)))
    }

    /// Renders a frame, whose rays may be moved within their pixels.
    pub(super) fn render_jittered(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
        jitter: Option<Jitter>,
    ) -> Result<(Option<Frame>, MeasuredReport), Error> {
        let views = self.group.agree(LatticeView::all_jittered(self.seen(), camera, viewport, settings, jitter))?;
        let read_bytes = match &self.source {
            Source::Host(volume) => volume.read_bytes(),
            Source::Device(_) => 0,
        };
        let measured = self.measuring.then(Measured::default);
        let mut totals = Totals { read_bytes, measured, ..Totals::default() };
        let (mut composed, mut compose_ms) = (Vec::new(), 0.0);
        self.shares.begin();
        for (view, share) in &views {
            totals.exchanged += self.hold(view, settings)?;
            if settings.sweeps_light() {
                totals.exchanged += self.hold_light(view)?;
            }
            let (measuring, longest, cancel) = (self.measuring, self.longest, self.cancel.clone());
            self.renderers().for_each(|renderer| {
                renderer.measure(measuring);
                renderer.limit(longest);
                renderer.set_cancel(cancel.clone());
            });
            let Self { group, composer, partitions, shares, .. } = self;
            let partition = partitions[view.axis().index()].as_mut().expect("`hold` has set it");
            let (layers, started) = (partition.ranges[group.rank()].clone(), Instant::now());
            let samples = partition.raw(view, totals.measured.as_mut());
            totals.layers += layers.len();
            totals.render_ms += milliseconds(started);
            let mut samples = group.agree(samples)?;
            let started = Instant::now();
            composed.push(composer.compose(group, view, !layers.is_empty(), &mut samples));
            compose_ms += milliseconds(started);
            let leads = group.leads();
            let light = partition.light.take();
            let stages = leads.then(|| shares.add(partition.renderer(), view, *share, &samples, light.as_ref())).transpose();
            partition.light = light;
            // The warp reads how many samples are visible in each tile; these counts are not samples of layers.
            if let (Some(measured), Some(stages)) = (&mut totals.measured, group.agree(stages)?) {
                measured.add_stages(stages);
            }
        }
        let (first, _) = &views[0];
        // The voxels of earlier axes may have been released.
        let Self { group, partitions, shares, .. } = self;
        let last =
            views.last().and_then(|(view, _)| partitions[view.axis().index()].as_mut()).expect("the last view was rendered");
        let frame = group.leads().then(|| shares.frame(last.renderer(), first)).transpose();
        let frame = self.group.agree(frame)?;
        let axes = views.iter().map(|(view, _)| view.axis()).collect();
        let report = DistributedReport { lattice: first.report(), axes, ranks: totals.gather(&self.group), composed, compose_ms };
        let all = report.ranks.iter().filter_map(|rank| rank.measured.as_ref()).map(|measured| measured.active_samples).sum();
        let measured = totals.measured.map(|own| Measured { active_samples: all, ..own });
        Ok((frame, (report, measured)))
    }
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
