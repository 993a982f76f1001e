//! Status messages to the application.

use crate::handle::Handle;
use crate::types::DataType;
use anari_sys::{
    ANARI_SEVERITY_ERROR, ANARI_SEVERITY_FATAL_ERROR, ANARI_SEVERITY_INFO, ANARI_SEVERITY_WARNING, ANARI_STATUS_INVALID_ARGUMENT,
    ANARI_STATUS_INVALID_OPERATION, ANARI_STATUS_NO_ERROR, ANARI_STATUS_OUT_OF_MEMORY, ANARI_STATUS_UNKNOWN_ERROR,
    ANARIStatusCode, ANARIStatusSeverity,
};
use std::any::Any;
use std::ffi::{CString, c_char, c_int, c_void};

/// The application's function for messages.
pub type Callback =
    unsafe extern "C" fn(user: *const c_void, device: usize, source: usize, DataType, c_int, c_int, text: *const c_char);

/// A message about an object.
#[derive(Clone, Debug)]
pub struct Message {
    pub source: Handle,
    pub source_type: DataType,
    pub severity: ANARIStatusSeverity,
    pub code: ANARIStatusCode,
    pub text: String,
}

/// What happened, without the object that it happened to.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    pub severity: ANARIStatusSeverity,
    pub code: ANARIStatusCode,
    pub text: String,
}

impl Problem {
    /// A wrong or unsupported argument. The call had no effect, or the effect that the text tells.
    pub fn argument(text: impl Into<String>) -> Self {
        Self { severity: ANARI_SEVERITY_WARNING, code: ANARI_STATUS_INVALID_ARGUMENT, text: text.into() }
    }

    /// A call that is not possible now, or with this object.
    pub fn operation(text: impl Into<String>) -> Self {
        Self { severity: ANARI_SEVERITY_ERROR, code: ANARI_STATUS_INVALID_OPERATION, text: text.into() }
    }

    /// Insufficient memory.
    pub fn memory(text: impl Into<String>) -> Self {
        Self { severity: ANARI_SEVERITY_ERROR, code: ANARI_STATUS_OUT_OF_MEMORY, text: text.into() }
    }

    /// A frame that could not be drawn.
    pub fn drawing(text: impl Into<String>) -> Self {
        Self { severity: ANARI_SEVERITY_ERROR, code: ANARI_STATUS_UNKNOWN_ERROR, text: text.into() }
    }

    /// A fault of this library.
    pub fn panic(panic: &(dyn Any + Send)) -> Self {
        let text = panic.downcast_ref::<&str>().copied();
        let text = text.or(panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("without a message");
        let (severity, code) = (ANARI_SEVERITY_FATAL_ERROR, ANARI_STATUS_UNKNOWN_ERROR);
        Self { severity, code, text: format!("layersplat panicked: {text}") }
    }

    /// Something worth knowing that is no error.
    pub fn information(text: impl Into<String>) -> Self {
        Self { severity: ANARI_SEVERITY_INFO, code: ANARI_STATUS_NO_ERROR, text: text.into() }
    }

    /// The message about an object.
    pub fn of(self, source: Handle, source_type: DataType) -> Message {
        Message { source, source_type, severity: self.severity, code: self.code, text: self.text }
    }
}

/// Where messages go.
#[derive(Clone, Copy)]
pub struct Reporter {
    /// The device, as the application knows it.
    pub device: usize,
    pub callback: Option<Callback>,
    pub user: usize,
}

impl Reporter {
    /// Calls the application's function. No lock may be held, because it may call the device.
    pub fn report(&self, message: &Message) {
        let Some(callback) = self.callback else { return };
        let text = CString::new(message.text.replace('\0', "\u{fffd}")).unwrap_or_default();
        // SAFETY: the application gave the function and its argument for this call.
        unsafe {
            callback(
                self.user as *const c_void,
                self.device,
                message.source.0,
                message.source_type,
                message.severity,
                message.code,
                text.as_ptr(),
            );
        }
    }
}
