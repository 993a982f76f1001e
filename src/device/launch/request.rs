//! What a driver compiles before a kernel can start.

use super::{Arguments, Launch};
use crate::device::Tuning;
use std::borrow::Cow;

/// A kernel as it is started: its program, and what some drivers compile it for beyond that.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct KernelRequest {
    /// Its file in kernels/.
    pub file: &'static str,
    /// Its name in there.
    pub kernel: Cow<'static, str>,
    /// `-D` options of its program.
    pub defines: String,
    /// Work-items of a group, where the kernel leaves as many.
    pub group: usize,
    /// Whether it has more than [`KernelRequest::SMALL_GRID`] work-items: PoCL compiles kernels once for fewer and once for more.
    pub wide: bool,
    /// The bytes of each argument that is a value, and 0 of each buffer.
    pub arguments: Vec<usize>,
}

impl KernelRequest {
    /// Most work-items of a launch that PoCL calls small.
    pub const SMALL_GRID: usize = u16::MAX as usize - 1;

    /// Of a launch of a kernel with so many work-items.
    pub(super) fn new<K: Launch>(tuning: &Tuning, variant: K::Variant, items: usize) -> Self {
        let group = K::ITEMS.group(tuning);
        Self {
            file: K::FILE,
            kernel: K::NAME.into(),
            defines: K::defines(tuning, variant),
            group,
            wide: items.next_multiple_of(group) > Self::SMALL_GRID,
            arguments: K::Arguments::sizes(),
        }
    }

    /// All options of its program.
    #[cfg(test)]
    pub fn options(&self) -> String {
        crate::device::program::options(&self.defines)
    }
}
