//! The thread that draws for a page: frames that follow the hand, and the refinement of a picture at rest.

use super::encoding::encoded;
use super::inbox::{Inbox, Job, News};
use super::look::Look;
use super::pace::Pace;
use super::protocol::{Picture, Reply, Step, View, shown_size};
use super::scene::{First, Scene};
use super::session::Outgoing;
use crate::camera::Camera;
use crate::device::Cancel;
use crate::error::Error;
use crate::image::Background;
use crate::renderer::{Accumulation, VolumeRenderer};
use crate::settings::{LightGrid, Quality, Settings};
use crate::viewport::Viewport;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Accumulated frames after which a picture is shown: the mean of fewer than eight is noisier than one frame of `high`.
const SHOWN_AFTER: [u32; 2] = [8, Accumulation::FRAMES];

/// Rest before frames are accumulated. Each of them may take longer than a moving one may wait, and a hand often moves on soon.
const REST: Duration = Duration::from_millis(600);
/// Frames are not accumulated if one takes longer: a hand that moves meanwhile would wait as long.
const LONGEST_ACCUMULATED: Duration = Duration::from_millis(900);

/// Draws for one page.
pub(super) struct Painter {
    pub scene: Arc<Scene>,
    pub inbox: Arc<Inbox>,
    pub outgoing: Outgoing,
    pub renderer: Box<dyn VolumeRenderer<'static> + Send>,
    pub look: Look,
    pace: Pace,
    current: Option<Current>,
}

/// The view that is shown, and how far it is.
struct Current {
    view: View,
    camera: Camera,
    page: Viewport,
    since: Instant,
    progress: Progress,
}

/// What has been drawn of a view.
enum Progress {
    Nothing,
    Standard,
    High,
    Accumulating(Accumulation),
    All,
}

impl Current {
    /// When the next picture of the view is drawn. `None` if there is none.
    fn goes_on(&self) -> Option<Instant> {
        match self.progress {
            Progress::All => None,
            Progress::High => Some(self.since + REST),
            _ => Some(self.since),
        }
    }
}

impl Painter {
    pub fn new(scene: Arc<Scene>, inbox: Arc<Inbox>, outgoing: Outgoing, first: &First, cancel: Cancel) -> Result<Self, Error> {
        let mut renderer = scene.renderer(&first.transfer)?;
        renderer.set_cancel(Some(cancel));
        let look = first.look.clone();
        Ok(Self { scene, inbox, outgoing, renderer, look, pace: Pace::default(), current: None })
    }

    /// Draws until the page is gone.
    pub fn run(mut self) {
        loop {
            let Some(news) = self.inbox.wait(self.current.as_ref().and_then(Current::goes_on)) else { return };
            if let Err(error) = self.work(news) {
                match error {
                    Error::Cancelled { .. } => {}
                    error => self.report(&error),
                }
            }
        }
    }

    fn work(&mut self, news: News) -> Result<(), Error> {
        let News { look, transfer, view, slices, job, ready } = news;
        if let Some(ready) = ready {
            self.outgoing.reply(&Reply::Ready { ready });
            return Ok(());
        }
        if look.is_some() || transfer.is_some() {
            // The view that follows is drawn.
            self.current = None;
        }
        if let Some(transfer) = transfer {
            self.renderer.set_transfer_function(&transfer);
        }
        if let Some(look) = look {
            match self.scene.host.settings(&look, None) {
                Ok(_) => self.look = look,
                // The view is drawn as it was.
                Err(error) => self.report(&error),
            }
        }
        if let Some(view) = view {
            let page = shown_size(view.width, view.height)?;
            let camera = self.scene.camera(&view.camera)?;
            self.current = Some(Current { view, camera, page, since: Instant::now(), progress: Progress::Nothing });
        }
        if let Some(slices) = slices {
            // Before the view: they take milliseconds.
            match self.show_slices(&slices) {
                Ok(()) | Err(Error::Cancelled { .. }) => {}
                Err(error) => self.report(&error),
            }
        }
        match job {
            Some(job) => self.do_job(job),
            None => self.draw(),
        }
    }

    /// Draws the next picture of the current view.
    fn draw(&mut self) -> Result<(), Error> {
        let Some(mut current) = self.current.take() else { return Ok(()) };
        let drawn = if current.view.moving { self.draw_moving(&mut current) } else { self.refine(&mut current) };
        if drawn.as_ref().is_err_and(|error| !matches!(error, Error::Cancelled { .. })) {
            // Said once; the same frame would fail again.
            current.progress = Progress::All;
        }
        self.current = Some(current);
        drawn
    }

    fn draw_moving(&mut self, current: &mut Current) -> Result<(), Error> {
        let started = Instant::now();
        let (quality, size) = self.pace.choose(current.page);
        let mut settings = self.scene.host.settings(&self.look, Some(quality))?;
        if settings.sweeps_light() {
            settings.light_grid = LightGrid::Half;
        }
        self.use_general_programs(true);
        self.show(current, Step::Moving, size, &settings)?;
        self.pace.record(current.page, started.elapsed());
        current.progress = Progress::All;
        Ok(())
    }

    /// Draws one step of the refinement, unless something new arrives.
    fn refine(&mut self, current: &mut Current) -> Result<(), Error> {
        let inbox = self.inbox.clone();
        self.use_general_programs(false);
        inbox.giving_way(|| self.refine_once(current)).unwrap_or(Ok(()))
    }

    /// Frames that follow the hand do not wait for a program while a more general one is there. Others have the bits of the command.
    pub(super) fn use_general_programs(&mut self, allowed: bool) {
        if let Some(renderer) = self.renderer.whole() {
            renderer.use_general_programs(allowed);
        }
    }

    fn refine_once(&mut self, current: &mut Current) -> Result<(), Error> {
        let page = current.page;
        let is_fixed = self.look.quality.is_some() || self.scene.host.settings(&self.look, None)?.layered().is_none();
        match &mut current.progress {
            Progress::Nothing if is_fixed => {
                let settings = self.scene.host.settings(&self.look, None)?;
                self.show(current, Step::Last, page, &settings)?;
                current.progress = Progress::All;
            }
            Progress::Nothing => {
                let settings = self.scene.host.settings(&self.look, Some(Quality::Standard))?;
                self.show(current, Step::Standard, page, &settings)?;
                current.progress = Progress::Standard;
            }
            Progress::Standard => {
                let settings = self.scene.host.settings(&self.look, Some(Quality::High))?;
                self.show(current, Step::High, page, &settings)?;
                current.progress = Progress::High;
            }
            Progress::High => current.progress = Progress::Accumulating(Accumulation::new(page)?),
            Progress::Accumulating(accumulation) => {
                let started = Instant::now();
                let settings = self.scene.host.settings(&self.look, Some(Quality::High))?;
                self.renderer.accumulate(&current.camera, &settings, accumulation)?;
                let frames = accumulation.frames();
                if SHOWN_AFTER.contains(&frames) {
                    let background = self.look.background()?;
                    let mean = accumulation.mean()?;
                    let rgba = match self.annotations() {
                        None => mean,
                        Some(annotations) => self.annotated(mean, &annotations, &current.camera, settings.blend)?,
                    };
                    let rgba = rgba.to_rgba8(background);
                    let step = if frames == Accumulation::FRAMES { Step::Last } else { Step::Half };
                    if step == Step::Last {
                        current.progress = Progress::All;
                    }
                    self.send(current, step, page, background, &rgba)?;
                } else if started.elapsed() > LONGEST_ACCUMULATED {
                    current.progress = Progress::All;
                    self.outgoing.reply(&Reply::Refined { id: current.view.id });
                }
            }
            Progress::All => {}
        }
        Ok(())
    }

    /// Renders a frame and sends it.
    fn show(&mut self, current: &Current, step: Step, size: Viewport, settings: &Settings) -> Result<(), Error> {
        self.scene.host.require_checked(&current.camera, size, settings)?;
        let background = self.look.background()?;
        let rgba = match self.annotations() {
            None => self.renderer.render_rgba8(&current.camera, size, settings, background)?.0,
            Some(annotations) => {
                let (frame, _) = self.renderer.render(&current.camera, size, settings)?;
                let drawn = frame.map(|frame| self.annotated(frame, &annotations, &current.camera, settings.blend));
                drawn.transpose()?.map(|frame| frame.to_rgba8(background))
            }
        };
        rgba.map_or(Ok(()), |rgba| self.send(current, step, size, background, &rgba))
    }

    fn send(&self, current: &Current, step: Step, size: Viewport, background: Background, rgba: &[u8]) -> Result<(), Error> {
        let (format, bytes) = encoded(rgba, size, background, step == Step::Moving)?;
        let milliseconds = current.since.elapsed().as_secs_f32() * 1e3;
        self.inbox.sent();
        self.outgoing.picture(&Picture { step, format, id: current.view.id, size, milliseconds, bytes });
        Ok(())
    }

    fn do_job(&mut self, job: Job) -> Result<(), Error> {
        let transfer = self.renderer.transfer_function().clone();
        match job {
            Job::Fit { camera, size } => {
                self.scene.camera(&camera)?;
                let settings = self.scene.host.settings(&self.look, None)?;
                let camera = self.scene.fitted(&camera, size, &settings, &transfer);
                self.outgoing.reply(&Reply::Fitted { camera });
                Ok(())
            }
            Job::Write { name, format } => {
                self.outgoing.reply(&Reply::Written { name: &name, text: &transfer.to_text(format) });
                Ok(())
            }
            Job::Command(saving) => self.say_command(&saving),
            Job::Pick(pick) => {
                let point = self.pick(&pick)?;
                self.outgoing.reply(&Reply::Picked { id: pick.id, point });
                Ok(())
            }
            Job::Save(saving) => {
                let inbox = self.inbox.clone();
                match inbox.giving_way(|| self.save(&saving)) {
                    Some(Err(Error::Cancelled { .. })) | None => {
                        self.inbox.put_back(Job::Save(saving));
                        Ok(())
                    }
                    Some(saved) => saved,
                }
            }
        }
    }

    /// Reports an error to the page.
    fn report(&self, error: &Error) {
        tracing::info!("reported to a page: {error}");
        self.outgoing.reply(&Reply::Problem { sentence: &self.scene.host.sentence(error) });
    }
}
