//! Host memory: requests are checked against available memory before allocation.

use crate::error::Error;
use bytemuck::Zeroable;
use sysinfo::{MemoryRefreshKind, RefreshKind, System};

/// Smallest request in bytes that is checked. Below, the check takes longer than the allocation.
const MIN_CHECKED_BYTES: u64 = 1 << 24;

/// Bytes that can be allocated without swapping or being killed: free or reclaimable memory, within container limits.
pub fn available() -> u64 {
    let system = System::new_with_specifics(RefreshKind::nothing().with_memory(MemoryRefreshKind::nothing().with_ram()));
    let container = system.cgroup_limits().map_or(u64::MAX, |limits| limits.total_memory.saturating_sub(limits.rss));
    system.available_memory().min(container)
}

/// Returns freed memory to the system. glibc keeps blocks of many megabytes once such a block was freed; a server whose frames come from
/// threads that end would grow by what each of them leaves.
pub fn return_freed() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: it takes no pointers, and locks what it changes.
    unsafe {
        libc::malloc_trim(0);
    }
}

/// Gives large blocks to the system as soon as they are freed, from now on. glibc otherwise takes blocks of up to 32 MB from a heap once such
/// a block was freed: where blocks of many sizes come and go, as light volumes of turning views do, the heap grows for minutes.
pub fn return_large_blocks() {
    /// Blocks of this many bytes are mapped on their own: about a millisecond per block.
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    const LARGE: libc::c_int = 4 << 20;
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: it takes no pointers, and locks what it changes.
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE);
    }
}

/// Fails if `bytes` exceed the available memory or the limit of this process (`ulimit -v`).
///
/// # Errors
/// [`Error::HostMemory`], which names `what`.
pub fn require(what: &str, bytes: u64) -> Result<(), Error> {
    if bytes < MIN_CHECKED_BYTES {
        return Ok(());
    }
    let available = available();
    // A reservation that is released untouched costs nothing, and reveals limits that the system does not report.
    let reserved = usize::try_from(bytes).is_ok_and(|len| Vec::<u8>::new().try_reserve_exact(len).is_ok());
    if bytes <= available && reserved { Ok(()) } else { Err(Error::HostMemory { what: what.into(), needed: bytes, available }) }
}

/// Allocates `len` zeros.
///
/// # Errors
/// [`Error::HostMemory`], which names `what`.
pub fn zeroed<T: Zeroable>(what: &str, len: usize) -> Result<Vec<T>, Error> {
    let needed = len as u64 * size_of::<T>() as u64;
    require(what, needed)?;
    bytemuck::try_zeroed_vec(len).map_err(|()| Error::HostMemory { what: what.into(), needed, available: available() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn too_large_requests_fail() {
        assert!(available() > 0);
        let message = require("the volume", 1 << 50).unwrap_err().to_string();
        assert!(message.contains("the volume") && message.contains("1125899906842624"), "{message}");
        assert!(zeroed::<f32>("the picture", 1 << 48).is_err());
        assert_eq!(zeroed::<u16>("three numbers", 3).unwrap(), [0; 3]);
    }
}
