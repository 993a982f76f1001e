//! What every call passes: arguments are looked at, panics end here, and what went wrong is kept for this thread.

use crate::Status;
use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    static LAST_ERROR: RefCell<CString> = RefCell::default();
}

/// Why a call does not do what it was asked to.
#[derive(Debug)]
pub(crate) struct Failure {
    pub status: Status,
    pub message: String,
}

impl Failure {
    pub fn new(status: Status, message: impl Into<String>) -> Self {
        Self { status, message: message.into() }
    }

    /// Of an argument that is not one of those accepted.
    pub fn invalid(message: impl Into<String>) -> Self {
        Self::new(Status::InvalidArgument, message)
    }
}

impl From<layersplat::Error> for Failure {
    fn from(error: layersplat::Error) -> Self {
        Self::new(Status::of(&error), error.to_string())
    }
}

/// Does what a call is for.
pub(crate) fn guard(call: impl FnOnce() -> Result<(), Failure>) -> Status {
    // What a panic leaves half done is a renderer at most, whose lock remembers it.
    let failure = match catch_unwind(AssertUnwindSafe(call)) {
        Ok(Ok(())) => return Status::Ok,
        Ok(Err(failure)) => failure,
        Err(panic) => Failure::new(Status::Panic, format!("layersplat panicked: {}", said(&*panic))),
    };
    let message = CString::new(failure.message.replace('\0', "\u{fffd}")).unwrap_or_default();
    // A thread that ends has no place for it any more.
    let _ = LAST_ERROR.try_with(|last| last.replace(message));
    failure.status
}

/// Frees what a pointer of [`Out::give`]'s owns.
pub(crate) unsafe fn free<T>(handle: *mut T) {
    guard(|| {
        if !handle.is_null() {
            // SAFETY: the caller's promise: it comes from `Out::give`, and is not used again.
            drop(unsafe { Box::from_raw(handle) });
        }
        Ok(())
    });
}

fn said(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or(panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("without a message")
}

/// What went wrong in the last call of this thread that failed: UTF-8, empty if none did. It stays until the next call of this thread
/// that fails, or the thread's end; do not free it.
#[unsafe(no_mangle)]
pub extern "C" fn layersplat_last_error() -> *const c_char {
    LAST_ERROR.try_with(|last| last.borrow().as_ptr()).unwrap_or(c"".as_ptr())
}

fn null(name: &str) -> Failure {
    Failure::new(Status::NullArgument, format!("{name} is null"))
}

/// What an argument points to.
pub(crate) unsafe fn borrowed<'a, T>(pointer: *const T, name: &str) -> Result<&'a T, Failure> {
    // SAFETY: the caller's promise: what is not null points to such a value, which nothing changes during the call.
    unsafe { pointer.as_ref() }.ok_or_else(|| null(name))
}

/// The values of an array; null is one without values.
pub(crate) unsafe fn values<'a, T>(pointer: *const T, count: usize, name: &str) -> Result<&'a [T], Failure> {
    match (pointer.is_null(), count) {
        (_, 0) => Ok(&[]),
        (true, _) => Err(null(name)),
        _ if count > isize::MAX as usize / size_of::<T>() => Err(Failure::invalid(format!("{name} has {count} values"))),
        // SAFETY: the caller's promise: there are so many, and nothing changes them during the call.
        _ => Ok(unsafe { std::slice::from_raw_parts(pointer, count) }),
    }
}

/// A text.
pub(crate) unsafe fn text<'a>(pointer: *const c_char, name: &str) -> Result<&'a str, Failure> {
    if pointer.is_null() {
        return Err(null(name));
    }
    // SAFETY: the caller's promise: what is not null is a text that ends with a zero byte.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map_err(|e| Failure::new(Status::NotUtf8, format!("{name} is not UTF-8: {e}")))
}

/// Where a result goes.
pub(crate) struct Out<T>(*mut T);

impl<T> Out<T> {
    /// A result that a caller must want.
    pub unsafe fn new(pointer: *mut T, name: &str) -> Result<Self, Failure> {
        if pointer.is_null() { Err(null(name)) } else { Ok(Self(pointer)) }
    }

    pub fn set(self, value: T) {
        // SAFETY: the caller's promise: there is room for one; it need not be initialised.
        unsafe { self.0.write(value) }
    }
}

impl<T> Out<*mut T> {
    /// A handle that a caller must want: null until it is given.
    pub unsafe fn handle(pointer: *mut *mut T, name: &str) -> Result<Self, Failure> {
        // SAFETY: the caller's promise is passed on.
        let out = unsafe { Self::new(pointer, name) }?;
        Self(out.0).set(std::ptr::null_mut());
        Ok(out)
    }

    /// Makes it the caller's.
    pub fn give(self, value: T) {
        self.set(Box::into_raw(Box::new(value)));
    }
}

/// Copies values to where a caller has room for some.
pub(crate) unsafe fn copy<T: Copy>(from: &[T], to: *mut T, room: usize, name: &str) -> Result<(), Failure> {
    require_room(from.len(), to, room, name)?;
    // SAFETY: the caller's promise: there is as much room as is said, which was compared.
    unsafe { std::ptr::copy_nonoverlapping(from.as_ptr(), to, from.len()) };
    Ok(())
}

/// Refuses an array that is too small before anything is made for it.
pub(crate) fn require_room<T>(needed: usize, to: *const T, room: usize, name: &str) -> Result<(), Failure> {
    if to.is_null() {
        return Err(null(name));
    }
    if room < needed {
        return Err(Failure::new(Status::TooSmall, format!("{name} has room for {room} values, and {needed} are needed")));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn last_error() -> String {
        // SAFETY: it is a text, and no other call is made meanwhile.
        unsafe { CStr::from_ptr(layersplat_last_error()) }.to_str().unwrap().into()
    }

    /// A panic that went on through `extern "C"` would abort the test.
    #[test]
    fn a_panic_ends_at_the_border() {
        extern "C" fn call(n: usize) -> Status {
            guard(|| {
                assert!(n == 0, "{n} is not nothing");
                Ok(())
            })
        }
        assert_eq!((call(0), last_error().as_str()), (Status::Ok, ""));
        assert_eq!((call(7), last_error().as_str()), (Status::Panic, "layersplat panicked: 7 is not nothing"));
    }

    #[test]
    fn messages_are_of_the_thread_and_stay_until_the_next() {
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
    fn arguments_that_are_not_there_are_told_by_name() {
        let refused = |result: Result<(), Failure>| result.map_err(|f| (f.status, f.message)).unwrap_err();
        let nothing = (Status::NullArgument, String::from("it is null"));
        let bad = c"\xff\xfe";
        // SAFETY: what is not null is what it should be.
        unsafe {
            assert_eq!(refused(borrowed::<u8>(std::ptr::null(), "it").map(|_| ())), nothing);
            assert_eq!(refused(values::<u8>(std::ptr::null(), 1, "it").map(|_| ())), nothing);
            assert_eq!(refused(text(std::ptr::null(), "it").map(|_| ())), nothing);
            assert_eq!(refused(Out::<u8>::new(std::ptr::null_mut(), "it").map(|_| ())), nothing);
            assert_eq!(refused(copy(&[1u8], std::ptr::null_mut(), 1, "it")), nothing);
            assert_eq!(refused(text(bad.as_ptr(), "it").map(|_| ())).0, Status::NotUtf8);
            assert!(values::<u8>(std::ptr::null(), 0, "it").unwrap().is_empty());
            let mut room = [0u8; 2];
            assert_eq!(refused(copy(&[1, 2, 3], room.as_mut_ptr(), 2, "it")).0, Status::TooSmall);
            copy(&[1, 2], room.as_mut_ptr(), 2, "it").unwrap();
            assert_eq!(room, [1, 2]);
        }
    }
}
