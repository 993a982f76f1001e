//! What requests of browsers need.

use super::access::Access;
use super::drops::Drops;
use super::scene::SharedScene;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// What requests need.
pub(super) struct Served {
    pub access: Access,
    pub scenes: Arc<Scenes>,
    pub drops: Drops,
    /// Number of open pages.
    pub sessions: AtomicUsize,
}

impl Served {
    pub fn new(access: Access, scene: SharedScene) -> Self {
        let scenes = Arc::new(Scenes { last: Mutex::new(Arc::new(scene)), earlier: Mutex::default(), number: AtomicU32::new(0) });
        Self { access, scenes, drops: Drops::default(), sessions: AtomicUsize::new(0) }
    }
}

/// The scenes of a run. New pages show the one that was opened last; others keep theirs.
pub(super) struct Scenes {
    last: Mutex<Arc<SharedScene>>,
    earlier: Mutex<Vec<Weak<SharedScene>>>,
    number: AtomicU32,
}

impl Scenes {
    pub fn last(&self) -> Arc<SharedScene> {
        self.last.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub fn open(&self, scene: Arc<SharedScene>) {
        let before = std::mem::replace(&mut *self.last.lock().unwrap_or_else(PoisonError::into_inner), scene);
        let mut earlier = self.earlier.lock().unwrap_or_else(PoisonError::into_inner);
        earlier.retain(|scene| scene.strong_count() > 0);
        earlier.push(Arc::downgrade(&before));
    }

    pub fn next_number(&self) -> u32 {
        self.number.fetch_add(1, Ordering::Relaxed) + 1
    }

    /// Whether a thread still draws one of them.
    pub fn are_in_use(&self) -> bool {
        let last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let earlier = self.earlier.lock().unwrap_or_else(PoisonError::into_inner);
        Arc::strong_count(&last) > 1 || earlier.iter().any(|scene| scene.strong_count() > 0)
    }
}

/// Does work on voxels or files on a thread of its own: that of requests carries all connections. `None` if it panicked.
pub(super) async fn aside<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Option<T> {
    tokio::task::spawn_blocking(work).await.ok()
}
