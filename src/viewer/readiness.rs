//! Whether the programs of usual frames are built, told to all pages.

use super::inbox::Inbox;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

#[derive(Default)]
struct State {
    has_begun: bool,
    /// Builds that have not ended.
    builds: u32,
    inboxes: Vec<Weak<Inbox>>,
}

impl State {
    fn is_ready(&self) -> bool {
        self.has_begun && self.builds == 0
    }
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
        inbox.post_ready(state.is_ready());
    }

    /// Programs are being built.
    pub fn begin(&self) {
        self.change(|state| (state.has_begun, state.builds) = (true, state.builds + 1));
    }

    /// One of the builds has ended.
    pub fn end(&self) {
        self.change(|state| state.builds -= 1);
    }

    /// Nothing is built ahead.
    pub fn skip(&self) {
        self.change(|state| state.has_begun = true);
    }

    fn change(&self, change: impl FnOnce(&mut State)) {
        let mut state = self.state();
        let before = state.is_ready();
        change(&mut state);
        let now = state.is_ready();
        if now != before {
            state.inboxes.iter().filter_map(Weak::upgrade).for_each(|inbox| inbox.post_ready(now));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::Cancel;

    #[test]
    fn it_is_ready_when_all_builds_have_ended() {
        let (readiness, inbox) = (Readiness::default(), Arc::new(Inbox::new(Cancel::new())));
        readiness.watch(&inbox);
        let told = || inbox.wait(Some(std::time::Instant::now())).unwrap().ready;
        assert_eq!(told(), Some(false));
        readiness.begin();
        readiness.begin();
        readiness.end();
        assert_eq!(told(), None);
        readiness.end();
        assert_eq!(told(), Some(true));
        // Shadows are switched on.
        readiness.begin();
        assert_eq!(told(), Some(false));
        readiness.end();
        assert_eq!(told(), Some(true));
    }
}
