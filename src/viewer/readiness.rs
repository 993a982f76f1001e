//! Whether the programs of usual frames are built, told to all pages.

use super::inbox::Inbox;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

#[derive(Default)]
struct State {
    is_ready: bool,
    inboxes: Vec<Weak<Inbox>>,
}

/// Whether programs are ready, and who is told.
#[derive(Default)]
pub(super) struct Readiness(Mutex<State>);

impl Readiness {
    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tells an inbox now, and when it changes.
    pub fn watch(&self, inbox: &Arc<Inbox>) {
        let mut state = self.state();
        state.inboxes.retain(|known| known.strong_count() > 0);
        state.inboxes.push(Arc::downgrade(inbox));
        inbox.post_ready(state.is_ready);
    }

    /// The programs are ready.
    pub fn set(&self) {
        let mut state = self.state();
        state.is_ready = true;
        state.inboxes.iter().filter_map(Weak::upgrade).for_each(|inbox| inbox.post_ready(true));
    }
}
