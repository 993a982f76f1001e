//! How much of a device's memory may be taken.

use super::Device;
use crate::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Counts the bytes of buffers that are made through a handle of a device and its clones, and holds them to a limit.
pub(super) struct Budget {
    bytes: u64,
    largest_buffer: u64,
    taken: AtomicU64,
    peak: AtomicU64,
}

/// Bytes of a budget, given back when this is dropped.
pub(super) struct Taken {
    budget: Arc<Budget>,
    bytes: u64,
}

impl Budget {
    /// No limit but the device's own.
    pub fn unlimited() -> Arc<Self> {
        Self::of(u64::MAX, u64::MAX)
    }

    fn of(bytes: u64, largest_buffer: u64) -> Arc<Self> {
        Arc::new(Self { bytes, largest_buffer, taken: AtomicU64::new(0), peak: AtomicU64::new(0) })
    }

    /// Refuses bytes for `what` that are more than what is left.
    pub fn require(&self, what: &str, needed: u64) -> Result<(), Error> {
        let taken = self.taken.load(Ordering::Relaxed);
        if taken.checked_add(needed).is_some_and(|sum| sum <= self.bytes) {
            return Ok(());
        }
        Err(Error::MemoryBudget { what: what.into(), needed, taken, budget: self.bytes })
    }

    /// Takes bytes for `what`, unless they are more than what is left.
    pub fn take(self: &Arc<Self>, what: &str, bytes: u64) -> Result<Taken, Error> {
        let more = |taken: u64| taken.checked_add(bytes).filter(|&sum| sum <= self.bytes);
        match self.taken.fetch_update(Ordering::Relaxed, Ordering::Relaxed, more) {
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
    /// The same device with a budget: buffers made through this handle and its clones take at most so many bytes together; those made
    /// through other handles are not counted. What does not fit is refused with [`Error::MemoryBudget`];
    /// [`StreamedRenderer`](crate::renderer::StreamedRenderer) renders volumes that do not.
    pub fn with_memory(&self, bytes: u64) -> Self {
        Self { budget: Budget::of(bytes, self.budget.largest_buffer), ..self.clone() }
    }

    /// The same device where a single buffer may have at most so many bytes, if it allows no fewer itself; with a count of buffers of
    /// its own, as [`with_memory`](Self::with_memory).
    pub fn with_largest_buffer(&self, bytes: u64) -> Self {
        Self { budget: Budget::of(self.budget.bytes, bytes), ..self.clone() }
    }

    /// Bytes that buffers made through this handle may take together; `None` if no budget was given.
    pub fn memory_budget(&self) -> Option<u64> {
        (self.budget.bytes < u64::MAX).then_some(self.budget.bytes)
    }

    /// Bytes that a single buffer may have.
    pub fn largest_buffer_bytes(&self) -> u64 {
        self.info().largest_buffer_bytes.min(self.budget.largest_buffer)
    }

    /// Most bytes that buffers made through this handle and its clones ever had together.
    pub fn peak_bytes(&self) -> u64 {
        self.budget.peak.load(Ordering::Relaxed)
    }

    /// Bytes that buffers made through this handle have at the moment.
    pub(crate) fn taken_bytes(&self) -> u64 {
        self.budget.taken.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Buffer, DeviceChoice};
    use super::*;

    #[test]
    fn buffers_of_one_handle_are_bounded_together() {
        let device = Device::open(&DeviceChoice::Default).expect("the tests need an OpenCL device: scripts/test installs PoCL");
        let bounded = device.with_memory(1000);
        assert_eq!((device.memory_budget(), bounded.memory_budget()), (None, Some(1000)));
        let beside = Buffer::<u8>::new(&device, 5000, "another's").unwrap();
        let first = Buffer::<u8>::new(&bounded.clone(), 600, "the first").unwrap();
        let message = Buffer::<f32>::new(&bounded, 101, "the second").err().expect("too much").to_string();
        for words in ["the second needs 404 bytes", "600", "1000", "1004"] {
            assert!(message.contains(words), "{message} does not say '{words}'");
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
