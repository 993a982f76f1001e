//! How long the stages of a frame take.

use opencl3::event::Event;
use std::sync::{Mutex, PoisonError};

/// Milliseconds per stage of a frame, in the order in which stages first ran.
pub type StageTimes = Vec<(&'static str, f64)>;

/// Kernels that were started for a frame.
#[derive(Default)]
pub(super) struct Stopwatch {
    running: Mutex<Vec<Launched>>,
}

/// A kernel on its way: its event, or its wall time where the device's events say nothing.
pub(super) struct Launched {
    pub stage: &'static str,
    pub event: Event,
    pub wall_ms: Option<f64>,
}

impl Launched {
    fn milliseconds(&self) -> f64 {
        self.wall_ms.unwrap_or_else(|| {
            let start = self.event.profiling_command_start().unwrap_or(0);
            self.event.profiling_command_end().unwrap_or(0).saturating_sub(start) as f64 / 1e6
        })
    }
}

impl Stopwatch {
    pub fn push(&self, launched: Launched) {
        self.running.lock().unwrap_or_else(PoisonError::into_inner).push(launched);
    }

    /// Times of everything pushed, which has ended.
    pub fn stage_times(&self) -> StageTimes {
        let mut times = StageTimes::new();
        for launched in self.running.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
            let ms = launched.milliseconds();
            match times.iter_mut().find(|(stage, _)| *stage == launched.stage) {
                Some((_, total)) => *total += ms,
                None => times.push((launched.stage, ms)),
            }
        }
        times
    }
}
