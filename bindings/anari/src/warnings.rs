//! Warnings of the library, which it logs by `tracing`, as messages.

use crate::worker::locked;
use std::fmt::{Debug, Write};
use std::sync::{Arc, Mutex};
use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id, Record};
use tracing::{Event, Level, Metadata, Subscriber};

/// Gathers the texts of warnings and errors.
#[derive(Clone, Default)]
struct Gathered(Arc<Mutex<Vec<String>>>);

impl Subscriber for Gathered {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        *metadata.level() <= Level::WARN
    }

    fn event(&self, event: &Event<'_>) {
        let mut text = Text(String::new());
        event.record(&mut text);
        locked(&self.0).push(text.0);
    }

    // Spans are of no interest.
    fn new_span(&self, _: &Attributes<'_>) -> Id {
        Id::from_u64(1)
    }
    fn record(&self, _: &Id, _: &Record<'_>) {}
    fn record_follows_from(&self, _: &Id, _: &Id) {}
    fn enter(&self, _: &Id) {}
    fn exit(&self, _: &Id) {}
}

/// The message of an event.
struct Text(String);

impl Visit for Text {
    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        if field.name() == "message" {
            let _ = write!(self.0, "{value:?}");
        }
    }
}

/// Runs a function. Returns what the library warned of on this thread, too.
pub fn gathered<R>(act: impl FnOnce() -> R) -> (R, Vec<String>) {
    let gathered = Gathered::default();
    let result = tracing::subscriber::with_default(gathered.clone(), act);
    let warnings = std::mem::take(&mut *locked(&gathered.0));
    (result, warnings)
}
