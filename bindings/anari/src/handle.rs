//! Handles of objects. They are numbers, not addresses: a handle of an object that is gone is only unknown.

/// An object, as the application knows it. Handles are never used again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Handle(pub usize);

impl Handle {
    pub const NULL: Self = Self(0);
    /// Distance of handles, so that they look like addresses of objects.
    pub const STEP: usize = 16;
}
