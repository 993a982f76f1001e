//! Converts the library's logged warnings to Python warnings.

use crate::calls::abandonable;
use crate::errors::Result;
use pyo3::prelude::*;
use std::fmt::Debug;
use std::sync::{Arc, Mutex, PoisonError};
use tracing::field::{Field, Visit};
use tracing::level_filters::LevelFilter;
use tracing::span::{Attributes, Id, Record};
use tracing::{Dispatch, Event, Level, Metadata, Subscriber, dispatcher};

/// Runs `work` as [`abandonable`] does. Returns its value and the library's warnings.
pub fn warned<T: Send + 'static>(py: Python, work: impl FnOnce() -> Result<T> + Send + 'static) -> Result<(T, Vec<String>)> {
    let collected = Arc::new(Collected::default());
    let dispatch = Dispatch::new(collected.clone());
    let value = abandonable(py, move || dispatcher::with_default(&dispatch, work))?;
    let warnings = std::mem::take(&mut *collected.0.lock().unwrap_or_else(PoisonError::into_inner));
    Ok((value, warnings))
}

/// Emits Python warnings, attributed to the caller's line.
///
/// # Errors
/// The warning, if Python's filters turn it into an exception.
pub fn warn(py: Python, warnings: Vec<String>) -> Result<()> {
    let checks = py.import("layersplat._checks")?;
    for text in warnings {
        checks.call_method1("warn", (text,))?;
    }
    Ok(())
}

/// Collected warning messages.
#[derive(Default)]
struct Collected(Mutex<Vec<String>>);

impl Subscriber for Collected {
    fn enabled(&self, metadata: &Metadata) -> bool {
        *metadata.level() <= Level::WARN
    }

    fn max_level_hint(&self) -> Option<LevelFilter> {
        Some(LevelFilter::WARN)
    }

    fn event(&self, event: &Event) {
        event.record(&mut Message(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner)));
    }

    fn new_span(&self, _: &Attributes) -> Id {
        Id::from_u64(1)
    }

    fn record(&self, _: &Id, _: &Record) {}
    fn record_follows_from(&self, _: &Id, _: &Id) {}
    fn enter(&self, _: &Id) {}
    fn exit(&self, _: &Id) {}
}

struct Message<'a>(&'a mut Vec<String>);

impl Visit for Message<'_> {
    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        if field.name() == "message" {
            self.0.push(format!("{value:?}"));
        }
    }
}
