//! Time measurement of the stages of a frame.

use opencl3::event::Event;
use std::sync::{Mutex, PoisonError};

/// Milliseconds per stage of a frame, in the order in which the stages first ran.
pub type StageTimes = Vec<(&'static str, f64)>;

/// Records the kernels launched for a frame.
#[derive(Default)]
pub(super) struct Stopwatch {
    running: Mutex<Vec<Launched>>,
}

/// A launched kernel: its event, and its wall time if events of the device report no times.
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

    /// Number of recorded kernels.
    #[cfg(test)]
    pub fn count(&self) -> usize {
        self.running.lock().unwrap_or_else(PoisonError::into_inner).len()
    }

    /// Total time per stage of all recorded kernels, which must have finished. Clears the record.
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
