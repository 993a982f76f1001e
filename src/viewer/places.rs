//! Places of connections. Those that have shown neither cookie nor token never take a place from others: the oldest of them makes way.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::Notify;

/// Most connections that have shown nothing, silent ones included.
const MOST_UNKNOWN: usize = 256;
/// Most connections of browsers that have access.
const MOST_ADMITTED: usize = 512;

#[derive(Default)]
struct State {
    /// Those that have shown nothing, the oldest first, and what ends them.
    unknown: VecDeque<(u64, Arc<Notify>)>,
    admitted: usize,
    last: u64,
}

/// All places of a server.
#[derive(Default)]
pub(super) struct Places(Mutex<State>);

/// The place of a connection, free again when this is dropped.
pub(super) struct Place {
    places: Arc<Places>,
    number: u64,
    is_admitted: AtomicBool,
}

impl Places {
    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A place for a new connection, and what tells it to end. `None` if connections with access take all.
    pub fn take(self: &Arc<Self>) -> Option<(Arc<Place>, Arc<Notify>)> {
        let mut state = self.state();
        if state.admitted >= MOST_ADMITTED {
            return None;
        }
        if state.unknown.len() >= MOST_UNKNOWN
            && let Some((_, oldest)) = state.unknown.pop_front()
        {
            oldest.notify_one();
        }
        state.last += 1;
        let (number, ended) = (state.last, Arc::new(Notify::new()));
        state.unknown.push_back((number, ended.clone()));
        Some((Arc::new(Place { places: self.clone(), number, is_admitted: AtomicBool::new(false) }), ended))
    }
}

impl Place {
    /// The connection has access: it makes way for no other.
    pub fn admit(&self) {
        if !self.is_admitted.swap(true, Ordering::SeqCst) {
            let mut state = self.places.state();
            state.unknown.retain(|(number, _)| *number != self.number);
            state.admitted += 1;
        }
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut state = self.places.state();
        match *self.is_admitted.get_mut() {
            true => state.admitted -= 1,
            false => state.unknown.retain(|(number, _)| *number != self.number),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a connection was told to end.
    fn is_ended(ended: &Notify) -> bool {
        use std::future::Future;
        let mut told = std::pin::pin!(ended.notified());
        told.as_mut().poll(&mut std::task::Context::from_waker(std::task::Waker::noop())).is_ready()
    }

    #[test]
    fn connections_without_access_make_way() {
        let places = Arc::new(Places::default());
        let (known, known_ended) = places.take().unwrap();
        known.admit();
        known.admit();
        let silent: Vec<_> = (0..MOST_UNKNOWN).map(|_| places.take().unwrap()).collect();
        let (place, ended) = places.take().unwrap();
        assert!(is_ended(&silent[0].1) && !is_ended(&silent[1].1) && !is_ended(&known_ended) && !is_ended(&ended));
        drop((silent, place));
        assert!(places.state().unknown.is_empty());
        let admitted: Vec<_> = (1..MOST_ADMITTED).map(|_| places.take().unwrap().0).collect();
        admitted.iter().for_each(|place| place.admit());
        assert!(places.take().is_none());
        drop(known);
        assert!(places.take().is_some());
    }
}
