//! When a frame is given up: after a time, or when another thread cancels it.

use super::Device;
use crate::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Cancels frames from another thread. Clones share one state: give one clone to [`Renderer::set_cancel`](crate::Renderer::set_cancel)
/// and keep another.
///
/// A frame looks at it before each of its kernels, while the kernel before is still running, so that the device never waits. A running
/// kernel ends first. The state stays cancelled until [`reset`](Self::reset).
///
/// ```
/// use layersplat::Cancel;
///
/// let cancel = Cancel::new();
/// let other = cancel.clone();
/// std::thread::spawn(move || other.cancel()).join().unwrap();
/// assert!(cancel.is_cancelled());
/// cancel.reset();
/// assert!(!cancel.is_cancelled());
/// ```
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// Not cancelled.
    pub fn new() -> Self {
        Self::default()
    }

    /// Gives up the frame in progress and all later ones, until [`reset`](Self::reset): they return [`Error::Cancelled`].
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Release);
    }

    /// Lets later frames be drawn again.
    pub fn reset(&self) {
        self.0.store(false, Ordering::Release);
    }

    /// Whether frames are given up.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Acquire)
    }
}

/// What ends a frame early.
#[derive(Clone, Debug, Default)]
pub(crate) struct Limits {
    /// Longest time that a frame may take.
    pub longest: Option<Duration>,
    pub cancel: Option<Cancel>,
}

/// The limits of a frame that has begun.
#[derive(Clone, Debug)]
pub(super) struct Begun {
    at: Instant,
    limits: Limits,
}

impl Device {
    /// A handle for a frame that begins now: its kernels are refused once a limit is reached.
    pub(crate) fn with_limits(self, limits: &Limits) -> Self {
        let limited = limits.longest.is_some() || limits.cancel.is_some();
        Self { begun: limited.then(|| Begun { at: Instant::now(), limits: limits.clone() }), ..self }
    }

    /// Refuses a kernel of a frame that has reached a limit. One earlier command may still be running: the device never idles for this
    /// check, and at most two kernels end after a limit is reached.
    pub(super) fn check_limits(&self, stage: &'static str) -> Result<(), Error> {
        let Some(Begun { at, limits }) = &self.begun else { return Ok(()) };
        self.wait_for_all_but_last()?;
        if limits.cancel.as_ref().is_some_and(Cancel::is_cancelled) {
            return Err(Error::Cancelled { stage });
        }
        match limits.longest {
            Some(longest) if at.elapsed() > longest => Err(Error::TooLong { stage, longest }),
            _ => Ok(()),
        }
    }
}
