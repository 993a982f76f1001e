//! Panics of the code that decodes files, such as failed assertions of other crates, become errors that name the file.

use crate::error::Error;
use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

thread_local! {
    static CAUGHT: Cell<bool> = const { Cell::new(false) };
}

/// Whether a panic of this thread would become an error, so that a hook need not report it.
pub fn are_caught() -> bool {
    CAUGHT.get()
}

/// Reads a file. A panic is returned as an error.
pub fn caught<T>(path: &Path, read: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
    let before = CAUGHT.replace(true);
    // What the panic leaves half done is dropped with the closure.
    let result = catch_unwind(AssertUnwindSafe(read));
    CAUGHT.set(before);
    result.unwrap_or_else(|panic| {
        let problem = format!(
            "reading it failed unexpectedly ({}): it is damaged or of an unusual kind; save it with another program, and report the file to the \
             developers of layersplat",
            message(&*panic)
        );
        Err(Error::volume(path, problem))
    })
}

fn message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panics_become_errors_that_name_the_file() {
        let path = Path::new("odd.tif");
        let read = |fails: bool| {
            caught(path, || {
                assert!(are_caught());
                assert!(!fails, "index {} out of bounds", 7);
                caught(path, || Ok(3))
            })
        };
        assert_eq!(read(false).unwrap(), 3);
        let message = read(true).unwrap_err().to_string();
        assert!(message.starts_with("odd.tif: reading it failed unexpectedly (index 7 out of bounds)"), "{message}");
        assert!(!are_caught());
        let other: Result<(), Error> = caught(path, || std::panic::panic_any(5));
        assert!(other.unwrap_err().to_string().contains("(no message)"));
    }
}
