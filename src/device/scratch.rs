//! Scratch memory provided by the caller.

use super::{Device, DeviceMemory, MemoryKind};
use crate::error::Error;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

const WHAT: &str = "the scratch memory";

/// The caller's buffers, reused by each frame. Only whole buffers are used: PoCL 3.1 frees sub-buffers that commands still use.
pub(crate) struct ScratchMemory {
    /// Size in bytes and buffer, sorted by size.
    buffers: Vec<(usize, DeviceMemory)>,
    taken: Mutex<Vec<bool>>,
    frame: AtomicU64,
}

impl ScratchMemory {
    pub fn new(device: &Device, memory: &[DeviceMemory]) -> Result<Self, Error> {
        let mut buffers = Vec::new();
        for memory in memory {
            memory.check(device, WHAT, true)?;
            let MemoryKind::Buffer { bytes } = memory.kind() else {
                return Err(Error::Memory { what: WHAT, problem: "is an image: use a buffer".into() });
            };
            buffers.push((bytes, memory.clone()));
        }
        buffers.sort_by_key(|(bytes, _)| *bytes);
        let taken = Mutex::new(vec![false; buffers.len()]);
        Ok(Self { buffers, taken, frame: AtomicU64::new(0) })
    }

    /// Begins a frame, which may take all buffers again.
    pub fn begin(&self) {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner).fill(false);
        self.frame.fetch_add(1, Ordering::Relaxed);
    }

    /// Number of the current frame.
    pub fn frame(&self) -> u64 {
        self.frame.load(Ordering::Relaxed)
    }

    /// Takes the smallest free buffer of at least `bytes` bytes, for the current frame.
    pub(super) fn take(&self, bytes: usize, what: &str) -> Result<&DeviceMemory, Error> {
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        let fits = |n: &usize| !taken[*n] && self.buffers[*n].0 >= bytes;
        let Some(found) = (0..self.buffers.len()).find(fits) else {
            let problem = format!("has no free buffer of {bytes} bytes for {what}: provide the sizes that scratch_bytes returns");
            return Err(Error::Memory { what: WHAT, problem });
        };
        taken[found] = true;
        Ok(&self.buffers[found].1)
    }
}
