//! Memory budget of a device handle.

use super::Device;
use crate::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Counts the bytes of buffers created through a device handle and its clones, and enforces a limit.
pub(super) struct Budget {
    bytes: u64,
    largest_buffer: u64,
    taken: AtomicU64,
    peak: AtomicU64,
}

/// Bytes taken from a budget, returned when this is dropped.
pub(super) struct Taken {
    budget: Arc<Budget>,
    bytes: u64,
}

impl Budget {
    /// No limits besides those of the device.
    pub fn unlimited() -> Arc<Self> {
        Self::new(u64::MAX, u64::MAX)
    }

    fn new(bytes: u64, largest_buffer: u64) -> Arc<Self> {
        Arc::new(Self { bytes, largest_buffer, taken: AtomicU64::new(0), peak: AtomicU64::new(0) })
    }

    /// Checks that `needed` bytes for `what` are left.
    pub fn require(&self, what: &str, needed: u64) -> Result<(), Error> {
        let taken = self.taken.load(Ordering::Relaxed);
        if taken.checked_add(needed).is_some_and(|sum| sum <= self.bytes) {
            return Ok(());
        }
        Err(Error::MemoryBudget { what: what.into(), needed, taken, budget: self.bytes })
    }

    /// Takes bytes for `what`, if they are left.
    pub fn take(self: &Arc<Self>, what: &str, bytes: u64) -> Result<Taken, Error> {
        let add = |taken: u64| taken.checked_add(bytes).filter(|&sum| sum <= self.bytes);
        match self.taken.fetch_update(Ordering::Relaxed, Ordering::Relaxed, add) {
            Ok(before) => {
                self.peak.fetch_max(before + bytes, Ordering::Relaxed);
                Ok(Taken { budget: self.clone(), bytes })
            }
            Err(taken) => Err(Error::MemoryBudget { what: what.into(), needed: bytes, taken, budget: self.bytes }),
        }
    }
}

impl Drop for Taken {
    fn drop(&mut self) {
        self.budget.taken.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

impl Device {
    /// The same device with a memory budget: the total size in bytes of all buffers created through the returned handle and its
    /// clones. Buffers of other handles do not count. Exceeding the budget fails with [`Error::MemoryBudget`].
    /// [`StreamedRenderer`](crate::renderer::StreamedRenderer) renders volumes larger than the budget.
    pub fn with_memory(&self, bytes: u64) -> Self {
        Self { budget: Budget::new(bytes, self.budget.largest_buffer), ..self.clone() }
    }

    /// The same device with a maximum size per buffer, in bytes, if that is below the device's own limit. As with
    /// [`with_memory`](Self::with_memory), the returned handle counts its buffers separately.
    pub fn with_largest_buffer(&self, bytes: u64) -> Self {
        Self { budget: Budget::new(self.budget.bytes, bytes), ..self.clone() }
    }

    /// Memory budget of this handle in bytes; `None` if unlimited.
    pub fn memory_budget(&self) -> Option<u64> {
        (self.budget.bytes < u64::MAX).then_some(self.budget.bytes)
    }

    /// Maximum bytes of a single buffer.
    pub fn largest_buffer_bytes(&self) -> u64 {
        self.info().largest_buffer_bytes.min(self.budget.largest_buffer)
    }

    /// Peak total bytes of the buffers created through this handle and its clones.
    pub fn peak_bytes(&self) -> u64 {
        self.budget.peak.load(Ordering::Relaxed)
    }

    /// Current total bytes of the buffers created through this handle and its clones.
    pub(crate) fn taken_bytes(&self) -> u64 {
        self.budget.taken.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Buffer, DeviceChoice};
    use super::*;

    #[test]
    fn buffers_of_one_handle_share_a_budget() {
        let device = Device::open(&DeviceChoice::Default).expect("the tests need an OpenCL device: scripts/test installs PoCL");
        let bounded = device.with_memory(1000);
        assert_eq!((device.memory_budget(), bounded.memory_budget()), (None, Some(1000)));
        let beside = Buffer::<u8>::new(&device, 5000, "another's").unwrap();
        let first = Buffer::<u8>::new(&bounded.clone(), 600, "the first").unwrap();
        let message = Buffer::<f32>::new(&bounded, 101, "the second").err().expect("too much").to_string();
        for words in ["the second needs 404 bytes", "600", "1000", "1004"] {
            assert!(message.contains(words), "{message} lacks '{words}'");
        }
        let second = Buffer::<f32>::new(&bounded, 100, "the second").unwrap();
        assert_eq!((bounded.taken_bytes(), device.allocated_bytes()), (1000, 6000));
        drop((first, second));
        let third = Buffer::<u8>::new(&bounded, 700, "the third").unwrap();
        assert_eq!((bounded.taken_bytes(), bounded.peak_bytes(), device.peak_bytes()), (700, 1000, 5000));
        drop((beside, third));
        let small = bounded.with_largest_buffer(500);
        assert_eq!((small.memory_budget(), small.largest_buffer_bytes()), (Some(1000), 500));
        let message = Buffer::<u8>::new(&small, 501, "the fourth").err().expect("too large").to_string();
        assert!(message.contains("501") && message.contains("500 in one buffer"), "{message}");
    }
}
