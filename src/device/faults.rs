//! What a device under test is told to fail at. Only tests have it.

use super::Device;
use opencl3::error_codes::ClError;
use std::sync::{Mutex, PoisonError};

/// What can fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Call {
    /// A buffer is made.
    Allocation,
    /// A program is built.
    Build,
    /// Something is enqueued, flushed or waited for.
    Command,
}

/// What fails next, if anything does.
#[derive(Default)]
pub(super) struct Faults(Mutex<Option<Fault>>);

struct Fault {
    /// Which calls count; `None`: all.
    call: Option<Call>,
    /// How many of them go well before.
    left: u64,
    code: i32,
    /// Whether all that come after fail, too.
    lasting: bool,
    struck: bool,
}

impl Faults {
    fn fault(&self) -> std::sync::MutexGuard<'_, Option<Fault>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Counts a call, and fails it where it is its turn.
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
    /// One call fails, after so many that do not.
    pub(crate) fn fail(&self, call: Call, after: u64, code: i32) {
        *self.shared.programs.faults.fault() = Some(Fault { call: Some(call), left: after, code, lasting: false, struck: false });
    }

    /// The device is lost after so many calls: all that come then fail.
    pub(crate) fn lose(&self, after: u64, code: i32) {
        *self.shared.programs.faults.fault() = Some(Fault { call: None, left: after, code, lasting: true, struck: false });
    }

    /// Nothing fails any more. Whether something did.
    pub(crate) fn recover(&self) -> bool {
        self.shared.programs.faults.fault().take().is_some_and(|fault| fault.struck)
    }
}
