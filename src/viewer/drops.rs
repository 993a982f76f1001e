//! Files that were dropped onto a page.

use crate::files::Scratch;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use tokio::sync::Semaphore;

/// A dropped file, removed with its folder when this is dropped.
pub(super) struct Dropped {
    number: u32,
    pub folder: Scratch,
    pub path: PathBuf,
}

/// Dropped files: one may arrive at a time, and the last one waits to be opened.
pub(super) struct Drops {
    last: Mutex<(u32, Option<Dropped>)>,
    pub arriving: Semaphore,
}

impl Default for Drops {
    fn default() -> Self {
        Self { last: Mutex::default(), arriving: Semaphore::new(1) }
    }
}

impl Drops {
    pub fn keep(&self, folder: Scratch, path: PathBuf) -> u32 {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let number = last.0.wrapping_add(1);
        *last = (number, Some(Dropped { number, folder, path }));
        number
    }

    pub fn take(&self, number: u32) -> Option<Dropped> {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        last.1.take_if(|dropped| dropped.number == number)
    }
}
