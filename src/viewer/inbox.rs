//! What a page wants, between the thread that listens to it and the thread that draws for it. Only the newest view, look and transfer
//! function are kept, so a page can ask as often as it likes.

use super::look::Look;
use super::page_camera::PageCamera;
use super::requests::Film;
use super::requests::SlicesView;
use super::requests::{Pick, SavedFormat, View};
use crate::device::Cancel;
use crate::transfer::{FileFormat, TransferFunction};
use crate::viewport::Viewport;
use std::collections::{BTreeMap, VecDeque};
use std::mem::take;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Pictures that the page has not acknowledged yet. A second one is drawn while the first travels.
const MOST_IN_FLIGHT: u32 = 2;
/// Jobs that wait. A page that asks for more has to wait for answers.
const MOST_JOBS: usize = 8;

/// Work that is answered once, in order.
pub(super) enum Job {
    Fit { camera: PageCamera, size: Viewport },
    Save(Saving),
    Film(Film),
    CancelFilm(u32),
    Command(Saving),
    Pick(Pick),
    Write { field: usize, name: String, format: FileFormat },
}

/// A picture to save.
#[derive(Clone, Copy)]
pub(super) struct Saving {
    pub camera: PageCamera,
    pub size: Viewport,
    pub samples: u32,
    pub format: SavedFormat,
}

/// What is new for the drawing thread.
#[derive(Default)]
pub(super) struct News {
    pub look: Option<Look>,
    /// Transfer functions by number of the field.
    pub transfers: BTreeMap<usize, TransferFunction>,
    pub view: Option<View>,
    pub slices: Option<SlicesView>,
    pub job: Option<Job>,
    pub ready: Option<bool>,
}

#[derive(Default)]
struct State {
    ready: Option<bool>,
    look: Option<Look>,
    transfers: BTreeMap<usize, TransferFunction>,
    view: Option<View>,
    slices: Option<SlicesView>,
    jobs: VecDeque<Job>,
    in_flight: u32,
    is_closed: bool,
    /// Whether the current frame ends when something new arrives.
    gives_way: bool,
}

impl State {
    /// Whether a picture would not be what the page wants.
    fn is_changed(&self) -> bool {
        self.look.is_some() || !self.transfers.is_empty() || self.view.is_some() || self.slices.is_some()
    }

    /// What is new but slices and jobs.
    fn take_news(&mut self) -> News {
        News { look: self.look.take(), transfers: take(&mut self.transfers), view: self.view.take(), ..News::default() }
    }
}

/// The newest requests of a page.
pub(super) struct Inbox {
    state: Mutex<State>,
    changed: Condvar,
    cancel: Cancel,
}

impl Inbox {
    /// `cancel` ends the current frame of the drawing thread.
    pub fn new(cancel: Cancel) -> Self {
        Self { state: Mutex::default(), changed: Condvar::new(), cancel }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What ends the current frame.
    pub fn cancel(&self) -> Cancel {
        self.cancel.clone()
    }

    /// Changes the requests. A frame that gives way is cancelled.
    fn post(&self, change: impl FnOnce(&mut State)) {
        let mut state = self.state();
        change(&mut state);
        if state.gives_way || state.is_closed {
            self.cancel.cancel();
        }
        self.changed.notify_all();
    }

    pub fn post_look(&self, look: Look) {
        self.post(|state| state.look = Some(look));
    }

    pub fn post_transfer(&self, field: usize, transfer: TransferFunction) {
        self.post(|state| drop(state.transfers.insert(field, transfer)));
    }

    pub fn post_view(&self, view: View) {
        self.post(|state| state.view = Some(view));
    }

    pub fn post_slices(&self, slices: SlicesView) {
        self.post(|state| state.slices = Some(slices));
    }

    /// Adds a job; returns false if too many wait.
    pub fn post_job(&self, job: Job) -> bool {
        let mut is_added = false;
        self.post(|state| {
            is_added = state.jobs.len() < MOST_JOBS;
            if is_added {
                state.jobs.push_back(job);
            }
        });
        is_added
    }

    /// The page has drawn a picture. This is no input: refinement goes on.
    pub fn acknowledge(&self) {
        let mut state = self.state();
        state.in_flight = state.in_flight.saturating_sub(1);
        self.changed.notify_all();
    }

    /// Whether programs are ready. This is no input either.
    pub fn post_ready(&self, ready: bool) {
        self.state().ready = Some(ready);
        self.changed.notify_all();
    }

    /// The page is gone.
    pub fn close(&self) {
        self.post(|state| state.is_closed = true);
    }

    /// A picture is on its way to the page.
    pub fn sent(&self) {
        self.state().in_flight += 1;
    }

    /// Waits for a view, or for a job, or until the refinement goes on. A new look and a new transfer function
    /// come with the view that follows them, or with a job. `work`: when the refinement goes on, if there is one. `None` if the page is gone.
    pub fn wait(&self, work: Option<Instant>) -> Option<News> {
        let mut state = self.state();
        loop {
            if state.is_closed {
                return None;
            }
            if let Some(ready) = state.ready.take() {
                return Some(News { ready: Some(ready), ..News::default() });
            }
            let may_draw = state.in_flight < MOST_IN_FLIGHT;
            if state.view.is_some() {
                if may_draw {
                    return Some(News { slices: state.slices.take(), ..state.take_news() });
                }
            } else if let Some(slices) = state.slices.take_if(|_| may_draw) {
                // A look or a transfer function waits for its view.
                return Some(News { slices: Some(slices), ..News::default() });
            } else if let Some(job) = state.jobs.pop_front() {
                return Some(News { job: Some(job), ..state.take_news() });
            }
            let pause = match work.filter(|_| may_draw && !state.is_changed()) {
                Some(at) => at.saturating_duration_since(Instant::now()),
                None => Duration::MAX,
            };
            if pause.is_zero() {
                return Some(News::default());
            }
            state = match pause {
                Duration::MAX => self.changed.wait(state).unwrap_or_else(PoisonError::into_inner),
                pause => self.changed.wait_timeout(state, pause).unwrap_or_else(PoisonError::into_inner).0,
            };
        }
    }

    /// Whether a picture would not be what the page wants, or the page is gone.
    pub fn is_changed(&self) -> bool {
        let state = self.state();
        state.is_closed || state.is_changed()
    }

    /// Whether the page wants another look, or is gone.
    pub fn has_look(&self) -> bool {
        let state = self.state();
        state.is_closed || state.look.is_some()
    }

    /// Runs work that gives way: it is cancelled when something new arrives. `None` if something new is there already.
    pub fn giving_way<T>(&self, work: impl FnOnce() -> T) -> Option<T> {
        {
            let mut state = self.state();
            if state.is_closed || state.is_changed() {
                return None;
            }
            state.gives_way = true;
        }
        let done = work();
        let mut state = self.state();
        state.gives_way = false;
        if !state.is_closed {
            self.cancel.reset();
        }
        Some(done)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Background;
    use crate::settings::Settings;
    use crate::viewer::PageProjection;
    use crate::viewer::readiness::Readiness;
    use std::sync::Arc;

    fn camera() -> PageCamera {
        PageCamera { azimuth: 0.0, elevation: 0.0, roll: 0.0, center: [0.0; 3], projection: PageProjection::ParallelScale(1.0) }
    }

    fn view(id: u32) -> View {
        View { id, camera: camera(), width: 4, height: 4, moving: true, playing: false }
    }

    fn look() -> Look {
        Look::of(&Settings::default(), Background::BLACK, 0.0, [1; 3])
    }

    fn job() -> Job {
        Job::Fit { camera: camera(), size: Viewport { width: 4, height: 4 } }
    }

    #[test]
    fn the_newest_wins() {
        let inbox = Inbox::new(Cancel::new());
        (0..1000).for_each(|id| inbox.post_view(view(id)));
        assert_eq!(inbox.wait(None).unwrap().view, Some(view(999)));
        // A look waits for its view.
        inbox.post_look(look());
        inbox.post_view(view(1000));
        let news = inbox.wait(Some(Instant::now())).unwrap();
        assert!(news.look.is_some() && news.view == Some(view(1000)));
    }

    /// Slices wait neither for a look nor for a job, but for acknowledgements.
    #[test]
    fn the_newest_slices_win() {
        let slices = |id: u32| -> SlicesView {
            let plane = r#"{"right":[1,0,0],"up":[0,1,0]}"#;
            let text = format!(
                r#"{{"id":{id},"point":[0,0,0],"planes":[{plane},{plane},{plane}],"width":4,"height":4,"kernel":"cubic","window":null,
                "thickness":null,"moving":true}}"#
            );
            serde_json::from_str(&text).unwrap()
        };
        let inbox = Inbox::new(Cancel::new());
        (0..100).for_each(|id| inbox.post_slices(slices(id)));
        inbox.post_look(look());
        assert!(inbox.post_job(job()));
        let news = inbox.wait(None).unwrap();
        assert!(news.slices == Some(slices(99)) && news.look.is_none() && news.job.is_none());
        (0..MOST_IN_FLIGHT).for_each(|_| inbox.sent());
        inbox.post_slices(slices(100));
        assert!(inbox.wait(None).unwrap().job.is_some(), "the page has not drawn the last pictures");
        inbox.acknowledge();
        inbox.post_view(view(1));
        let news = inbox.wait(None).unwrap();
        assert!(news.slices == Some(slices(100)) && news.view == Some(view(1)) && news.look.is_none());
    }

    #[test]
    fn two_pictures_are_on_their_way_at_most() {
        let inbox = Inbox::new(Cancel::new());
        inbox.sent();
        inbox.post_view(view(1));
        assert!(inbox.wait(None).unwrap().view.is_some());
        inbox.sent();
        assert!(inbox.post_job(job()));
        // Nothing to do but the job.
        assert!(inbox.wait(Some(Instant::now())).unwrap().job.is_some());
        inbox.post_view(view(2));
        inbox.acknowledge();
        assert_eq!(inbox.wait(None).unwrap().view, Some(view(2)));
        // More acknowledgements than pictures do not add up.
        (0..9).for_each(|_| inbox.acknowledge());
        inbox.sent();
        inbox.sent();
        inbox.post_view(view(3));
        let waited = std::thread::scope(|threads| {
            let waiting = threads.spawn(|| inbox.wait(Some(Instant::now())));
            std::thread::sleep(std::time::Duration::from_millis(30));
            let is_waiting = !waiting.is_finished();
            inbox.close();
            is_waiting && waiting.join().unwrap().is_none()
        });
        assert!(waited);
    }

    #[test]
    fn refinement_gives_way_to_input_but_not_to_acknowledgements() {
        let cancel = Cancel::new();
        let inbox = Inbox::new(cancel.clone());
        assert_eq!(inbox.giving_way(|| inbox.acknowledge()).map(|()| cancel.is_cancelled()), Some(false));
        let cancelled = inbox.giving_way(|| {
            inbox.post_view(view(1));
            cancel.is_cancelled()
        });
        assert_eq!((cancelled, cancel.is_cancelled()), (Some(true), false));
        assert!(inbox.giving_way(|| ()).is_none(), "the view is there already");
        // A moving frame is not cancelled by the next one.
        inbox.post_view(view(2));
        assert!(!cancel.is_cancelled());
        inbox.close();
        assert!(cancel.is_cancelled() && inbox.wait(Some(Instant::now())).is_none() && inbox.giving_way(|| ()).is_none());
    }

    #[test]
    fn refinement_may_wait_for_its_time_but_views_do_not() {
        let inbox = Inbox::new(Cancel::new());
        let at = Instant::now() + Duration::from_millis(30);
        assert!(inbox.wait(Some(at)).unwrap().view.is_none() && Instant::now() >= at);
        inbox.post_view(view(1));
        assert!(inbox.wait(Some(Instant::now() + Duration::from_secs(3600))).unwrap().view.is_some());
    }

    #[test]
    fn readiness_is_told_before_pictures_and_ends_no_frame() {
        let (readiness, cancel) = (Readiness::default(), Cancel::new());
        let inbox = Arc::new(Inbox::new(cancel.clone()));
        readiness.watch(&inbox);
        inbox.post_view(view(1));
        let news = inbox.wait(None).unwrap();
        assert!(news.ready == Some(false) && news.view.is_none());
        assert!(inbox.wait(None).unwrap().view.is_some());
        inbox.giving_way(|| readiness.skip());
        assert!(!cancel.is_cancelled());
        assert_eq!(inbox.wait(None).unwrap().ready, Some(true));
    }

    #[test]
    fn jobs_are_bounded_and_wait_for_the_view() {
        let inbox = Inbox::new(Cancel::new());
        assert_eq!((0..20).filter(|_| inbox.post_job(job())).count(), MOST_JOBS);
        inbox.post_view(view(1));
        assert!(inbox.wait(Some(Instant::now())).unwrap().job.is_none());
        inbox.post_look(look());
        let news = inbox.wait(Some(Instant::now())).unwrap();
        assert!(news.job.is_some() && news.look.is_some());
    }
}
