//! Frames of several processes: each composites its layers, and rank 0 receives the picture.

use super::{Renderer, Source};
use crate::camera::Camera;
use crate::distributed::report::Totals;
use crate::error::Error;
use crate::image::Frame;
use crate::renderer::{Accumulation, DistributedReport, Jitter, LatticeView};
use crate::settings::Settings;
use crate::viewport::Viewport;
use std::time::Instant;

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
        self.render_jittered(camera, viewport, settings, None)
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
        accumulation.extend(|viewport, jitter| self.render_jittered(camera, viewport, settings, Some(jitter)))
    }

    fn render_jittered(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
        jitter: Option<Jitter>,
    ) -> Result<(Option<Frame>, DistributedReport), Error> {
        let views = self.group.agree(LatticeView::all_jittered(self.description(), camera, viewport, settings, jitter))?;
        let read_bytes = match &self.source {
            Source::Host(volume) => volume.read_bytes(),
            Source::Device(_) => 0,
        };
        let mut totals = Totals { read_bytes, ..Totals::default() };
        let (mut composed, mut compose_ms) = (Vec::new(), 0.0);
        self.shares.begin();
        for (view, share) in &views {
            let exchanged = self.hold(view, settings)?;
            totals.exchanged.sent_bytes += exchanged.sent_bytes;
            totals.exchanged.received_bytes += exchanged.received_bytes;
            let (longest, cancel) = (self.longest, self.cancel.clone());
            self.renderers().for_each(|renderer| {
                renderer.limit(longest);
                renderer.set_cancel(cancel.clone());
            });
            let Self { group, composer, partitions, shares, .. } = self;
            let partition = partitions[view.axis().index()].as_mut().expect("`hold` has set it");
            let (layers, started) = (partition.ranges[group.rank()].clone(), Instant::now());
            let samples = partition.raw(view);
            totals.layers += layers.len();
            totals.render_ms += milliseconds(started);
            let mut samples = group.agree(samples)?;
            let started = Instant::now();
            composed.push(composer.compose(group, view, !layers.is_empty(), &mut samples));
            compose_ms += milliseconds(started);
            let added = if group.leads() { shares.add(partition.renderer(), view, *share, &samples) } else { Ok(()) };
            group.agree(added)?;
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
        Ok((frame, report))
    }
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
