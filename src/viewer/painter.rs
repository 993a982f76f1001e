//! The thread that draws for a page: frames that follow the hand, and the refinement of a picture at rest.

use super::drawn::{CurrentLook, PageRenderer};
use super::encoding::encoded;
use super::first::First;
use super::inbox::{Inbox, News};
use super::keeper::Keeper;
use super::look::Look;
use super::outgoing::Outgoing;
use super::pace::Pace;
use super::replies::{Picture, Reply, Step, Work};
use super::requests::{View, shown_size};
use super::scene::SharedScene;
use super::sharpening::Sharpening;
use super::survey::Question;
use super::time::Moment;
use super::turns::{Taken, Turn, Turns};
use super::warming;
use crate::camera::Camera;
use crate::device::Bands;
use crate::error::Error;
use crate::image::Background;
use crate::memory;
use crate::renderer::Renderer;
use crate::settings::{LightGrid, Quality, Settings};
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use std::time::{Duration, Instant};

/// Bytes on the device besides the voxels that pages at rest keep together. Above, a page that comes to rest, or waits for its turn, frees its own.
const MOST_AT_REST: u64 = 1 << 30;
/// Time after which a page asks again whether it is its turn.
const TURN: Duration = Duration::from_millis(20);

/// Draws for one page.
pub(super) struct Painter {
    pub scene: Arc<SharedScene>,
    pub inbox: Arc<Inbox>,
    pub keeper: Arc<Keeper>,
    pub questions: SyncSender<Question>,
    pub outgoing: Outgoing,
    pub renderer: Box<PageRenderer>,
    pub look: Look,
    /// The transfer functions of all fields.
    pub transfers: Vec<TransferFunction>,
    /// The step of a sequence that the renderer has.
    pub moment: Moment,
    pace: Pace,
    current: Option<Current>,
}

/// Where requests come from, and where those go that other threads answer.
pub(super) struct Ways {
    pub inbox: Arc<Inbox>,
    pub keeper: Arc<Keeper>,
    pub questions: SyncSender<Question>,
}

/// The view that is shown, and how far it is.
struct Current {
    view: View,
    camera: Camera,
    page: Viewport,
    since: Instant,
    /// When it asks for its turn again, if another page has it.
    asks_again: Option<Instant>,
    progress: Progress,
}

/// What has been drawn of a view.
enum Progress {
    Nothing,
    Standard,
    /// Pictures with several samples per pixel, as many as there are.
    High(usize),
    Sharpening {
        picture: Sharpening,
        _turn: Taken,
    },
    All,
}

impl Current {
    /// When the next picture of the view is drawn. `None` if there is none.
    fn goes_on(&self) -> Option<Instant> {
        (!matches!(self.progress, Progress::All)).then_some(self.asks_again.unwrap_or(self.since))
    }
}

impl Painter {
    pub fn new(scene: Arc<SharedScene>, ways: Ways, outgoing: Outgoing, first: &First) -> Result<Self, Error> {
        let (look, transfers) = (first.look.clone(), first.transfers());
        let mut renderer = scene.page_renderer(&scene.opening.volume, CurrentLook { look: &look, transfers: &transfers })?;
        renderer.set_cancel(Some(ways.inbox.cancel()));
        let Ways { inbox, keeper, questions } = ways;
        let (moment, pace) = (Moment::new(&scene), Pace::default());
        Ok(Self { scene, inbox, keeper, questions, outgoing, renderer, look, transfers, moment, pace, current: None })
    }

    /// How the fields are shown.
    pub fn now(&self) -> CurrentLook<'_> {
        CurrentLook { look: &self.look, transfers: &self.transfers }
    }

    /// Draws until the page is gone.
    pub fn run(mut self) {
        loop {
            let Some(news) = self.inbox.wait(self.current.as_ref().and_then(Current::goes_on)) else { return };
            if let Err(error) = self.work(news) {
                match error {
                    Error::Cancelled { .. } => {}
                    error => self.outgoing.problem(&self.scene, &error),
                }
            }
        }
    }

    fn work(&mut self, news: News) -> Result<(), Error> {
        let News { look, transfers, view, slices, job, ready } = news;
        if let Some(ready) = ready {
            self.outgoing.reply(&Reply::Ready { ready });
            return Ok(());
        }
        if look.is_some() || !transfers.is_empty() {
            // The view that follows is drawn.
            self.current = None;
            self.change(look, transfers);
        }
        if let Some(view) = view {
            let page = shown_size(view.width, view.height)?;
            let camera = self.scene.camera(&view.camera)?;
            let (since, asks_again, progress) = (Instant::now(), None, Progress::Nothing);
            self.current = Some(Current { view, camera, page, since, asks_again, progress });
        }
        if let Some(slices) = slices {
            // Before the view: they take milliseconds.
            match self.show_slices(&slices) {
                Ok(()) | Err(Error::Cancelled { .. }) => {}
                Err(error) => self.outgoing.problem(&self.scene, &error),
            }
        }
        match job {
            Some(job) => self.do_job(job),
            None => self.draw(),
        }
    }

    /// Takes a new look and new transfer functions. The view is drawn as it was if they do not go with it.
    fn change(&mut self, look: Option<Look>, transfers: BTreeMap<usize, TransferFunction>) {
        let mut is_changed = !transfers.is_empty();
        for (field, transfer) in transfers {
            self.transfers[field] = transfer;
        }
        if let Some(look) = look {
            let settings = self.scene.host.settings(&look, None);
            let checked =
                settings.and_then(|settings| self.scene.check_look(&look, &settings)).and_then(|()| self.go(look.frame));
            match checked {
                Ok(()) => {
                    is_changed |= (&look.channels, &look.labels) != (&self.look.channels, &self.look.labels);
                    self.look = look;
                }
                Err(error) => self.outgoing.refuse(&self.scene, &error),
            }
        }
        if is_changed {
            let (scene, now) = (&self.scene, CurrentLook { look: &self.look, transfers: &self.transfers });
            if let Err(error) = scene.update(self.renderer.as_mut(), now) {
                self.outgoing.refuse(scene, &error);
            }
        }
    }

    /// Gives the renderer another step of a sequence.
    fn go(&mut self, step: usize) -> Result<(), Error> {
        if step == self.moment.step() {
            return Ok(());
        }
        self.moment.go(&self.scene, step)?;
        self.renderer.set_volume(self.moment.volume())
    }

    /// Draws the next picture of the current view.
    fn draw(&mut self) -> Result<(), Error> {
        let Some(mut current) = self.current.take() else { return Ok(()) };
        let is_fast = current.view.moving || current.view.playing;
        let drawn = if is_fast { self.draw_moving(&mut current) } else { self.refine(&mut current) };
        if drawn.is_ok() {
            // After the first picture, which waits for no other programs than its own.
            warming::begin(self);
        }
        if drawn.as_ref().is_err_and(|error| !matches!(error, Error::Cancelled { .. })) {
            // Said once; the same frame would fail again.
            current.progress = Progress::All;
            self.outgoing.reply(&Reply::Failed { id: current.view.id });
        }
        let is_at_rest = !is_fast && matches!(current.progress, Progress::All);
        self.current = Some(current);
        if is_at_rest {
            self.rest_lightly();
        }
        drawn
    }

    /// Bytes that pages keep on the device besides the voxels.
    fn kept_by_all(&self) -> u64 {
        self.scene.opening.device.allocated_bytes().saturating_sub(self.scene.voxel_bytes())
    }

    /// Frees what frames of this page keep on the device, if all pages keep too much. The next frame makes it again.
    fn rest_lightly(&mut self) {
        let kept = self.kept_by_all();
        // A volume that is streamed would be read again.
        if kept > MOST_AT_REST && self.renderer.whole().is_some() {
            match self.scene.page_renderer(self.moment.volume(), self.now()) {
                Ok(mut renderer) => {
                    renderer.set_cancel(Some(self.inbox.cancel()));
                    self.renderer = renderer;
                }
                Err(error) => tracing::info!("a page keeps {kept} bytes: {error}"),
            }
        }
        memory::return_freed();
    }

    fn draw_moving(&mut self, current: &mut Current) -> Result<(), Error> {
        let started = Instant::now();
        let (quality, size) = self.pace.choose(current.page);
        let mut settings = self.scene.host.settings(&self.look, Some(quality))?;
        if settings.sweeps_light() {
            settings.light_grid = if settings.studio.is_some() { LightGrid::Quarter } else { LightGrid::Half };
        }
        self.use_general_programs(true);
        self.renderer.set_bands(None);
        self.require_checked(&current.camera, size, &settings)?;
        self.build_programs(Inbox::has_look, |renderer| renderer.rehearse(&current.camera, size, &settings))?;
        let background = self.look.background()?;
        if let Some(rgba) = self.drawn(&current.camera, size, &settings, background)? {
            self.send(current, Step::Moving, size, background, &rgba)?;
        }
        self.pace.record(current.page, started.elapsed());
        current.progress = Progress::All;
        Ok(())
    }

    /// Draws one step of the refinement, unless something new arrives.
    fn refine(&mut self, current: &mut Current) -> Result<(), Error> {
        let inbox = self.inbox.clone();
        self.use_general_programs(false);
        // A hand waits for two bands at most.
        self.renderer.set_bands(Some(Bands::new()));
        inbox.giving_way(|| self.refine_once(current)).unwrap_or(Ok(()))
    }

    /// The turn of this page, to be dropped before anything is sent: a page that takes nothing holds up no other. Fails if another page has it,
    /// and asks again then.
    fn turn(&mut self, current: &mut Current, of: fn(&Turns) -> &Turn) -> Result<Taken, Error> {
        if let Some(turn) = of(&self.scene.turns).take() {
            current.asks_again = None;
            return Ok(turn);
        }
        if current.asks_again.is_none() {
            self.rest_lightly();
        }
        current.asks_again = Some(Instant::now() + TURN);
        Err(Error::Cancelled { stage: "turn" })
    }

    /// Frames that follow the hand do not wait for a program while a more general one is there. Others have the bits of the command.
    fn use_general_programs(&mut self, allowed: bool) {
        if let Some(renderer) = self.renderer.whole() {
            renderer.use_general_programs(allowed);
        }
    }

    /// Builds the programs of a frame before it is drawn, and tells the page how far that is. Gives up when the page wants something else.
    pub(super) fn build_programs(
        &mut self,
        gives_up: fn(&Inbox) -> bool,
        frame: impl FnOnce(&mut Renderer) -> Result<(), Error>,
    ) -> Result<(), Error> {
        /// Time after which it is asked again whether the page wants something else.
        const STEP: Duration = Duration::from_millis(100);
        let Some(renderer) = self.renderer.whole().filter(|_| self.scene.host.builds_ahead()) else { return Ok(()) };
        // A frame that cannot be rehearsed says itself why.
        let Some(builds) = renderer.build_first(frame).ok().flatten() else { return Ok(()) };
        loop {
            let (done, of) = builds.progress();
            self.outgoing.reply(&Reply::Work { what: Work::Programs, done, of: of.unwrap_or_default() });
            if builds.wait_for_next(STEP) {
                return Ok(());
            }
            if gives_up(&self.inbox) {
                return Err(Error::Cancelled { stage: "programs" });
            }
        }
    }

    /// Fails if the device may not draw such pictures, before their programs are built: some drivers crash. Tells the page that this takes a while.
    pub(super) fn require_checked(&self, camera: &Camera, size: Viewport, settings: &Settings) -> Result<(), Error> {
        let host = &self.scene.host;
        if !host.is_checked(camera, size, settings) {
            self.outgoing.reply(&Reply::Work { what: Work::Check, done: 0, of: 0 });
        }
        host.require_checked(camera, size, settings)
    }

    fn refine_once(&mut self, current: &mut Current) -> Result<(), Error> {
        let page = current.page;
        let is_fixed = self.look.quality.is_some() || self.scene.host.settings(&self.look, None)?.layered().is_none();
        let turn = match current.progress {
            Progress::Sharpening { .. } => Some(self.turn(current, |turns| &turns.step)?),
            _ => None,
        };
        match &mut current.progress {
            Progress::Nothing if is_fixed => {
                let settings = self.scene.host.settings(&self.look, None)?;
                self.show_refined(current, Step::Last, &settings)?;
                current.progress = Progress::All;
            }
            Progress::Nothing => {
                let settings = self.scene.host.settings(&self.look, Some(Quality::Standard))?;
                self.show_refined(current, Step::Standard, &settings)?;
                current.progress = Progress::Standard;
            }
            Progress::Standard => {
                let settings = self.scene.host.settings(&self.look, Some(Quality::High))?;
                self.show_refined(current, Step::High, &settings)?;
                current.progress = Progress::High(0);
            }
            // A volume that is streamed would be read again for every block.
            Progress::High(_) if self.renderer.whole().is_none() => self.rest(current),
            &mut Progress::High(round) => {
                let turn = self.turn(current, |turns| &turns.sharpening)?;
                let Ok(picture) = Sharpening::new(page, round) else {
                    self.rest(current);
                    return Ok(());
                };
                let settings = self.scene.host.settings(&self.look, Some(Quality::High))?;
                let (camera, large) = (current.camera, picture.large());
                self.build_programs(Inbox::is_changed, |renderer| renderer.rehearse(&camera, large, &settings))?;
                current.progress = Progress::Sharpening { picture, _turn: turn };
            }
            Progress::Sharpening { picture, .. } => {
                let settings = self.scene.host.settings(&self.look, Some(Quality::High))?;
                let renderer = self.renderer.require_whole("refinement")?;
                if picture.draw_block(renderer, &current.camera, &settings)? {
                    let (frame, next) = (picture.frame(), picture.next());
                    let background = self.look.background()?;
                    let rgba = self.annotated(frame, &current.camera, settings.blend)?.to_rgba8(background);
                    let step = if next.is_some() { Step::Half } else { Step::Last };
                    // Gives the turn to the next page.
                    current.progress = next.map_or(Progress::All, Progress::High);
                    drop(turn);
                    self.send(current, step, page, background, &rgba)?;
                }
            }
            Progress::All => {}
        }
        Ok(())
    }

    /// A step of the refinement at rest, with its programs.
    fn show_refined(&mut self, current: &mut Current, step: Step, settings: &Settings) -> Result<(), Error> {
        let (camera, page) = (current.camera, current.page);
        self.require_checked(&camera, page, settings)?;
        self.build_programs(Inbox::is_changed, |renderer| renderer.rehearse(&camera, page, settings))?;
        // The first picture waits for no other page, if memory allows.
        let needs_turn = !matches!(current.progress, Progress::Nothing) || self.kept_by_all() > MOST_AT_REST;
        let turn = if needs_turn { Some(self.turn(current, |turns| &turns.step)?) } else { None };
        let background = self.look.background()?;
        let drawn = self.drawn(&camera, page, settings, background)?;
        drop(turn);
        drawn.map_or(Ok(()), |rgba| self.send(current, step, page, background, &rgba))
    }

    /// No better picture of the view follows.
    fn rest(&self, current: &mut Current) {
        current.progress = Progress::All;
        self.outgoing.reply(&Reply::Refined { id: current.view.id });
    }

    /// Renders a frame.
    fn drawn(
        &mut self,
        camera: &Camera,
        size: Viewport,
        settings: &Settings,
        background: Background,
    ) -> Result<Option<Vec<u8>>, Error> {
        if !self.has_annotations() {
            return Ok(self.renderer.render_rgba8(camera, size, settings, background)?.0);
        }
        let (frame, _) = self.renderer.render(camera, size, settings)?;
        let drawn = frame.map(|frame| self.annotated(frame, camera, settings.blend));
        Ok(drawn.transpose()?.map(|frame| frame.to_rgba8(background)))
    }

    fn send(&self, current: &Current, step: Step, size: Viewport, background: Background, rgba: &[u8]) -> Result<(), Error> {
        let (format, bytes) = encoded(rgba, size, background, step == Step::Moving)?;
        let milliseconds = current.since.elapsed().as_secs_f32() * 1e3;
        self.inbox.sent();
        self.outgoing.picture(&Picture { step, format, id: current.view.id, size, milliseconds, bytes });
        Ok(())
    }
}
