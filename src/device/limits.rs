//! Time limit and cancellation of frames.

use super::{Bands, Device};
use crate::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Cancels frames from another thread. Clones share one state: pass one clone to
/// [`Renderer::set_cancel`](crate::Renderer::set_cancel) and keep another.
///
/// A frame checks the state before each kernel launch, while the previous kernel still runs, so that the device never idles. A
/// running kernel is not interrupted; [`Bands`] make kernels short. The state stays cancelled until [`reset`](Self::reset).
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
    /// A state that is not cancelled.
    pub fn new() -> Self {
        Self::default()
    }

    /// Cancels the current frame and all later ones until [`reset`](Self::reset). They return [`Error::Cancelled`].
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Release);
    }

    /// Allows later frames again.
    pub fn reset(&self) {
        self.0.store(false, Ordering::Release);
    }

    /// Whether frames are cancelled.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Acquire)
    }
}

/// Conditions that abort or divide a frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct Limits {
    /// Time limit per frame.
    pub longest: Option<Duration>,
    pub cancel: Option<Cancel>,
    pub bands: Option<Bands>,
}

/// The limits of a frame, and its start time.
#[derive(Clone, Debug)]
pub(super) struct Begun {
    at: Instant,
    /// Nanoseconds that the frame was paused.
    paused: Arc<AtomicU64>,
    pub(super) limits: Limits,
}

impl Device {
    /// A handle for a frame that begins now. Once a limit is reached, no further kernels are launched.
    pub(crate) fn with_limits(self, limits: &Limits) -> Self {
        let limited = limits.longest.is_some() || limits.cancel.is_some() || limits.bands.is_some();
        Self { begun: limited.then(|| Begun { at: Instant::now(), paused: Arc::default(), limits: limits.clone() }), ..self }
    }

    /// Checks the limits before a kernel is launched. Waits for all earlier commands except the last one: the device never idles
    /// for this check, and at most two kernels end after a limit is reached. Waits while frames in bands are paused, and returns that time,
    /// which does not count for the limit.
    pub(super) fn check_limits(&self, stage: &'static str) -> Result<Duration, Error> {
        let Some(Begun { at, paused, limits }) = &self.begun else { return Ok(Duration::ZERO) };
        self.wait_for_all_but_last()?;
        let is_cancelled = || limits.cancel.as_ref().is_some_and(Cancel::is_cancelled);
        let waited = limits.bands.as_ref().map_or(Duration::ZERO, |bands| bands.wait(is_cancelled));
        let before = paused.fetch_add(waited.as_nanos() as u64, Ordering::Relaxed);
        if is_cancelled() {
            return Err(Error::Cancelled { stage });
        }
        match limits.longest {
            Some(longest) if at.elapsed().saturating_sub(waited + Duration::from_nanos(before)) > longest => {
                Err(Error::TooLong { stage, longest })
            }
            _ => Ok(waited),
        }
    }
}
