//! Everything that determines what a driver compiles for a kernel.

use super::{Argument, Launch, Launcher, Permutation};
use crate::device::Tuning;
use std::borrow::Cow;

/// A kernel to build: its program, and the launch parameters for which some drivers compile separately.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct KernelRequest {
    /// File in kernels/.
    pub file: &'static str,
    /// Name of the kernel function.
    pub kernel: Cow<'static, str>,
    /// `-D` options of its program.
    pub defines: String,
    /// Work-group size, unless the kernel allows less.
    pub group: usize,
    /// Whether there are more than [`KernelRequest::SMALL_GRID`] work-items. PoCL compiles small and large launches separately.
    pub wide: bool,
    /// Size of each argument in bytes; 0 for buffers.
    pub arguments: Vec<usize>,
}

impl KernelRequest {
    /// Maximum work-items of a launch that PoCL considers small.
    pub const SMALL_GRID: usize = u16::MAX as usize - 1;

    /// For a launch with `items` work-items.
    pub(super) fn new<K: Launch>(tuning: &Tuning, permutation: Permutation<K>, items: usize) -> Self {
        let group = K::ITEMS.group(tuning);
        let declared = K::Arguments::parameters("", permutation.1).into_iter();
        Self {
            file: K::FILE,
            kernel: K::NAME.into(),
            defines: Launcher::<K>::defines(tuning, permutation),
            group,
            wide: items.next_multiple_of(group) > Self::SMALL_GRID,
            arguments: declared.map(|parameter| parameter.bytes).chain([size_of::<u64>()]).collect(),
        }
    }

    /// All compiler options of the program.
    #[cfg(test)]
    pub fn options(&self) -> String {
        crate::device::program::options(&self.defines)
    }
}
