//! Turns: pages refine their pictures one after another, so that the memory of all has a bound while they draw. It takes no longer than at the
//! same time, since all share the device.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// What one page at a time does.
#[derive(Default)]
pub(super) struct Turns {
    /// A step of the refinement.
    pub step: Turn,
    /// Pictures with several samples per pixel, whose pixels are kept from step to step.
    pub sharpening: Turn,
}

/// Work that one page at a time does.
#[derive(Default)]
pub(super) struct Turn(Arc<AtomicBool>);

/// A turn that was taken. The next page has it when this is dropped.
pub(super) struct Taken(Arc<AtomicBool>);

impl Turn {
    /// Takes the turn, unless another page has it.
    pub fn take(&self) -> Option<Taken> {
        let is_taken = self.0.swap(true, Ordering::SeqCst);
        (!is_taken).then(|| Taken(self.0.clone()))
    }
}

impl Drop for Taken {
    fn drop(&mut self) {
        self.0.store(false, Ordering::SeqCst);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_has_the_turn_at_a_time() {
        let turn = Turn::default();
        let taken = turn.take();
        assert!(taken.is_some() && turn.take().is_none() && turn.take().is_none());
        drop(taken);
        assert!(turn.take().is_some());
    }
}
