//! What a page wants, between the thread that listens to it and the thread that draws for it. Only the newest view, look and transfer
//! function are kept, so a page can ask as often as it likes.

use super::look::Look;
use super::protocol::{PageCamera, View};
use crate::device::Cancel;
use crate::transfer::{FileFormat, TransferFunction};
use crate::viewport::Viewport;
use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Pictures that the page has not acknowledged yet. A second one is drawn while the first travels.
const MOST_IN_FLIGHT: u32 = 2;
/// Jobs that wait. A page that asks for more has to wait for answers.
const MOST_JOBS: usize = 8;

/// Work that is answered once, in order.
pub(super) enum Job {
    Fit { camera: PageCamera, size: Viewport },
    Save { camera: PageCamera, size: Viewport, samples: u32 },
    Command { camera: PageCamera, size: Viewport, samples: u32 },
    Write { name: String, format: FileFormat },
}

/// What is new for the drawing thread.
#[derive(Default)]
pub(super) struct News {
    pub look: Option<Look>,
    pub transfer: Option<TransferFunction>,
    pub view: Option<View>,
    pub job: Option<Job>,
    /// Whether the page takes another picture.
    pub may_draw: bool,
}

#[derive(Default)]
struct State {
    look: Option<Look>,
    transfer: Option<TransferFunction>,
    view: Option<View>,
    jobs: VecDeque<Job>,
    in_flight: u32,
    is_closed: bool,
    /// Whether the current frame ends when something new arrives.
    gives_way: bool,
}

/// The newest wishes of a page.
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

    /// Changes the wishes. A frame that gives way is cancelled.
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

    pub fn post_transfer(&self, transfer: TransferFunction) {
        self.post(|state| state.transfer = Some(transfer));
    }

    pub fn post_view(&self, view: View) {
        self.post(|state| state.view = Some(view));
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

    /// The page is gone.
    pub fn close(&self) {
        self.post(|state| state.is_closed = true);
    }

    /// A picture is on its way to the page.
    pub fn sent(&self) {
        self.state().in_flight += 1;
    }

    /// Puts a job back that gave way.
    pub fn put_back(&self, job: Job) {
        self.state().jobs.push_front(job);
    }

    /// Waits for something new, or until a picture may be drawn if there is one to draw (`has_work`). `None` if the page is gone. A job comes
    /// alone, and only when no hand moves or when it is short.
    pub fn wait(&self, has_work: bool, is_moving: bool) -> Option<News> {
        let mut state = self.state();
        loop {
            if state.is_closed {
                return None;
            }
            let may_draw = state.in_flight < MOST_IN_FLIGHT;
            let is_new = state.look.is_some() || state.transfer.is_some() || (state.view.is_some() && may_draw);
            if is_new || (has_work && may_draw && (is_moving || state.jobs.is_empty())) {
                let State { look, transfer, .. } = &mut *state;
                let (look, transfer) = (look.take(), transfer.take());
                let view = if may_draw { state.view.take() } else { None };
                return Some(News { look, transfer, view, job: None, may_draw });
            }
            // A job before the view would give way to it at once.
            if state.view.is_none()
                && let Some(job) = state.jobs.pop_front()
            {
                return Some(News { job: Some(job), ..News::default() });
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Runs work that gives way: it is cancelled when something new arrives. `None` if something new is there already.
    pub fn giving_way<T>(&self, work: impl FnOnce() -> T) -> Option<T> {
        {
            let mut state = self.state();
            if state.is_closed || state.look.is_some() || state.transfer.is_some() || state.view.is_some() {
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
    use crate::viewer::protocol::PageProjection;

    fn camera() -> PageCamera {
        PageCamera { azimuth: 0.0, elevation: 0.0, roll: 0.0, center: [0.0; 3], projection: PageProjection::ParallelScale(1.0) }
    }

    fn view(id: u32) -> View {
        View { id, camera: camera(), width: 4, height: 4, moving: true }
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
        let news = inbox.wait(false, false).unwrap();
        assert_eq!((news.view, news.may_draw), (Some(view(999)), true));
    }

    #[test]
    fn two_pictures_are_on_their_way_at_most() {
        let inbox = Inbox::new(Cancel::new());
        inbox.sent();
        inbox.post_view(view(1));
        assert!(inbox.wait(false, false).unwrap().view.is_some());
        inbox.sent();
        assert!(inbox.post_job(job()));
        // Nothing to do but the job.
        assert!(inbox.wait(true, true).unwrap().job.is_some());
        inbox.post_view(view(2));
        inbox.post_look(look());
        let news = inbox.wait(true, true).unwrap();
        assert!(news.look.is_some() && news.view.is_none() && !news.may_draw);
        inbox.acknowledge();
        assert_eq!(inbox.wait(false, false).unwrap().view, Some(view(2)));
        // More acknowledgements than pictures do not add up.
        (0..9).for_each(|_| inbox.acknowledge());
        inbox.sent();
        inbox.sent();
        inbox.post_view(view(3));
        inbox.post_look(look());
        assert!(inbox.wait(false, false).unwrap().view.is_none());
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
        assert!(cancel.is_cancelled() && inbox.wait(true, true).is_none() && inbox.giving_way(|| ()).is_none());
    }

    #[test]
    fn jobs_are_bounded_and_wait_for_the_hand() {
        let inbox = Inbox::new(Cancel::new());
        assert_eq!((0..20).filter(|_| inbox.post_job(job())).count(), MOST_JOBS);
        assert!(inbox.wait(true, true).unwrap().job.is_none());
        assert!(inbox.wait(true, false).unwrap().job.is_some());
    }
}
