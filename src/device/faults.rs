//! Fault injection into OpenCL calls, in tests only.

use super::Device;
use opencl3::error_codes::ClError;
use std::sync::{Mutex, PoisonError};

/// Kinds of calls that can fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Call {
    /// Creation of a buffer.
    Allocation,
    /// Build of a program.
    Build,
    /// Enqueueing, flushing or waiting.
    Command,
}

/// The next fault, if any.
#[derive(Default)]
pub(super) struct Faults(Mutex<Option<Fault>>);

struct Fault {
    /// Kind of the calls that count; `None` counts all.
    call: Option<Call>,
    /// Remaining calls before the fault.
    left: u64,
    code: i32,
    /// Whether all later calls fail, too.
    lasting: bool,
    struck: bool,
}

impl Faults {
    fn fault(&self) -> std::sync::MutexGuard<'_, Option<Fault>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Counts a call, and returns the error if it must fail.
    pub fn at(&self, call: Call) -> Result<(), ClError> {
        let mut fault = self.fault();
        let Some(fault) = fault.as_mut().filter(|fault| fault.call.is_none_or(|counted| counted == call)) else { return Ok(()) };
        if fault.left > 0 || (fault.struck && !fault.lasting) {
            fault.left = fault.left.saturating_sub(1);
            return Ok(());
        }
        fault.struck = true;
        Err(ClError(fault.code))
    }
}

impl Device {
    /// Makes one call fail, after `after` successful ones.
    pub(crate) fn fail(&self, call: Call, after: u64, code: i32) {
        *self.shared.programs.faults.fault() = Some(Fault { call: Some(call), left: after, code, lasting: false, struck: false });
    }

    /// Simulates a lost device: all calls fail after the first `after` ones.
    pub(crate) fn lose(&self, after: u64, code: i32) {
        *self.shared.programs.faults.fault() = Some(Fault { call: None, left: after, code, lasting: true, struck: false });
    }

    /// Removes the fault. Returns whether it occurred.
    pub(crate) fn recover(&self) -> bool {
        self.shared.programs.faults.fault().take().is_some_and(|fault| fault.struck)
    }
}
