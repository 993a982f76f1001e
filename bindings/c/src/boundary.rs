//! The FFI boundary of every call: checks arguments, catches panics and stores the last error of each thread.

use crate::Status;
use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    static LAST_ERROR: RefCell<CString> = RefCell::default();
}

/// A status and a message for `layersplat_last_error`.
#[derive(Debug)]
pub(crate) struct Failure {
    pub status: Status,
    pub message: String,
}

impl Failure {
    pub fn new(status: Status, message: impl Into<String>) -> Self {
        Self { status, message: message.into() }
    }

    /// An invalid argument.
    pub fn invalid(message: impl Into<String>) -> Self {
        Self::new(Status::InvalidArgument, message)
    }
}

impl From<layersplat::Error> for Failure {
    fn from(error: layersplat::Error) -> Self {
        Self::new(Status::from_error(&error), error.to_string())
    }
}

/// Runs the body of a call. Returns its status and stores the message of an error or a panic.
pub(crate) fn guard(call: impl FnOnce() -> Result<(), Failure>) -> Status {
    // Unwind safety: only renderers are mutable, and a panic poisons their lock.
    let failure = match catch_unwind(AssertUnwindSafe(call)) {
        Ok(Ok(())) => return Status::Ok,
        Ok(Err(failure)) => failure,
        Err(panic) => Failure::new(Status::Panic, format!("layersplat panicked: {}", panic_message(&*panic))),
    };
    let message = CString::new(failure.message.replace('\0', "\u{fffd}")).unwrap_or_default();
    // Fails only while the thread's locals are destroyed.
    let _ = LAST_ERROR.try_with(|last| last.replace(message));
    failure.status
}

/// Frees a handle made by [`Out::set_handle`]. Null is ignored.
pub(crate) unsafe fn free<T>(handle: *mut T) {
    guard(|| {
        if !handle.is_null() {
            // SAFETY: upheld by the caller: it comes from `Out::set_handle`, and is not used again.
            drop(unsafe { Box::from_raw(handle) });
        }
        Ok(())
    });
}

fn panic_message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or(panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("without a message")
}

/// Message of the last failed call on this thread: UTF-8, empty if no call has failed. The text stays valid until the next failed
/// call on this thread, or until the thread ends. Do not free it.
#[unsafe(no_mangle)]
pub extern "C" fn layersplat_last_error() -> *const c_char {
    LAST_ERROR.try_with(|last| last.borrow().as_ptr()).unwrap_or(c"".as_ptr())
}

fn null(name: &str) -> Failure {
    Failure::new(Status::NullArgument, format!("{name} is null"))
}

/// The value that an argument points to.
///
/// # Errors
/// `NullArgument`.
pub(crate) unsafe fn borrowed<'a, T>(pointer: *const T, name: &str) -> Result<&'a T, Failure> {
    // SAFETY: upheld by the caller: a non-null pointer is valid, and its value does not change during the call.
    unsafe { pointer.as_ref() }.ok_or_else(|| null(name))
}

/// The elements of an array. Null is accepted if `count` is 0.
pub(crate) unsafe fn values<'a, T>(pointer: *const T, count: usize, name: &str) -> Result<&'a [T], Failure> {
    match (pointer.is_null(), count) {
        (_, 0) => Ok(&[]),
        (true, _) => Err(null(name)),
        _ if count > isize::MAX as usize / size_of::<T>() => Err(Failure::invalid(format!("{name} has {count} values"))),
        // SAFETY: upheld by the caller: there are `count` elements, which do not change during the call.
        _ => Ok(unsafe { std::slice::from_raw_parts(pointer, count) }),
    }
}

/// A UTF-8 string.
///
/// # Errors
/// `NullArgument`, `NotUtf8`.
pub(crate) unsafe fn text<'a>(pointer: *const c_char, name: &str) -> Result<&'a str, Failure> {
    if pointer.is_null() {
        return Err(null(name));
    }
    // SAFETY: upheld by the caller: a non-null pointer is a zero-terminated string.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map_err(|e| Failure::new(Status::NotUtf8, format!("{name} is not UTF-8: {e}")))
}

/// An output argument.
pub(crate) struct Out<T>(*mut T);

impl<T> Out<T> {
    /// A required output.
    pub unsafe fn new(pointer: *mut T, name: &str) -> Result<Self, Failure> {
        if pointer.is_null() { Err(null(name)) } else { Ok(Self(pointer)) }
    }

    pub fn set(self, value: T) {
        // SAFETY: upheld by the caller: it is valid for writes. It may be uninitialised.
        unsafe { self.0.write(value) }
    }

    /// Writes the first `size` bytes: those of an older version of a struct.
    pub fn set_first(self, value: T, size: usize)
    where
        T: Copy,
    {
        assert!(size <= size_of::<T>());
        // SAFETY: upheld by the caller: `size` bytes are valid for writes. They may be uninitialised.
        unsafe { (&raw const value).cast::<u8>().copy_to_nonoverlapping(self.0.cast(), size) }
    }
}

impl<T> Out<*mut T> {
    /// A required output for a handle. Sets it to null first.
    pub unsafe fn handle(pointer: *mut *mut T, name: &str) -> Result<Self, Failure> {
        // SAFETY: upheld by the caller.
        let out = unsafe { Self::new(pointer, name) }?;
        Self(out.0).set(std::ptr::null_mut());
        Ok(out)
    }

    /// Boxes a value and transfers its ownership to the caller.
    pub fn set_handle(self, value: T) {
        self.set(Box::into_raw(Box::new(value)));
    }
}

/// Copies values to the caller's array of `capacity` elements.
pub(crate) unsafe fn copy<T: Copy>(from: &[T], to: *mut T, capacity: usize, name: &str) -> Result<(), Failure> {
    require_capacity(from.len(), to, capacity, name)?;
    // SAFETY: upheld by the caller: the array has `capacity` elements, which was compared.
    unsafe { std::ptr::copy_nonoverlapping(from.as_ptr(), to, from.len()) };
    Ok(())
}

/// Rejects an output array that is too small, before any work is done.
pub(crate) fn require_capacity<T>(needed: usize, to: *const T, capacity: usize, name: &str) -> Result<(), Failure> {
    if to.is_null() {
        return Err(null(name));
    }
    if capacity < needed {
        return Err(Failure::new(
            Status::TooSmall,
            format!("{name} has a capacity of {capacity} values, and {needed} are needed"),
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn last_error() -> String {
        // SAFETY: it is a string, and no other call is made meanwhile.
        unsafe { CStr::from_ptr(layersplat_last_error()) }.to_str().unwrap().into()
    }

    /// A panic that unwinds out of `extern "C"` would abort the test.
    #[test]
    fn panics_are_caught_at_the_boundary() {
        extern "C" fn call(n: usize) -> Status {
            guard(|| {
                assert!(n == 0, "{n} is not zero");
                Ok(())
            })
        }
        assert_eq!((call(0), last_error().as_str()), (Status::Ok, ""));
        assert_eq!((call(7), last_error().as_str()), (Status::Panic, "layersplat panicked: 7 is not zero"));
    }

    #[test]
    fn messages_are_per_thread_and_stay_until_the_next_failure() {
        let fail = |message: &str| guard(|| Err(Failure::invalid(message)));
        assert_eq!(fail("here\0there"), Status::InvalidArgument);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                assert_eq!(last_error(), "");
                fail("elsewhere");
                assert_eq!(last_error(), "elsewhere");
            });
        });
        assert_eq!(guard(|| Ok(())), Status::Ok);
        assert_eq!(last_error(), "here\u{fffd}there");
    }

    #[test]
    fn missing_arguments_are_reported_by_name() {
        let refused = |result: Result<(), Failure>| result.map_err(|f| (f.status, f.message)).unwrap_err();
        let missing = (Status::NullArgument, String::from("it is null"));
        let bad = c"\xff\xfe";
        // SAFETY: pointers that are not null are valid.
        unsafe {
            assert_eq!(refused(borrowed::<u8>(std::ptr::null(), "it").map(|_| ())), missing);
            assert_eq!(refused(values::<u8>(std::ptr::null(), 1, "it").map(|_| ())), missing);
            assert_eq!(refused(text(std::ptr::null(), "it").map(|_| ())), missing);
            assert_eq!(refused(Out::<u8>::new(std::ptr::null_mut(), "it").map(|_| ())), missing);
            assert_eq!(refused(copy(&[1u8], std::ptr::null_mut(), 1, "it")), missing);
            assert_eq!(refused(text(bad.as_ptr(), "it").map(|_| ())).0, Status::NotUtf8);
            assert!(values::<u8>(std::ptr::null(), 0, "it").unwrap().is_empty());
            let mut output = [0u8; 2];
            assert_eq!(refused(copy(&[1, 2, 3], output.as_mut_ptr(), 2, "it")).0, Status::TooSmall);
            copy(&[1, 2], output.as_mut_ptr(), 2, "it").unwrap();
            assert_eq!(output, [1, 2]);
        }
    }
}
