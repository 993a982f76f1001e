//! The machine's memory: what is asked for is compared with what there is before it is allocated.

use crate::error::Error;
use bytemuck::Zeroable;
use sysinfo::{MemoryRefreshKind, RefreshKind, System};

/// Bytes from which on it is worth asking what there is: below, asking takes longer than allocating.
const WORTH_ASKING: u64 = 1 << 24;

/// Bytes that can be allocated and used without anything being killed: what is free or can be freed, within the limits of a container.
pub(crate) fn available() -> u64 {
    let system = System::new_with_specifics(RefreshKind::nothing().with_memory(MemoryRefreshKind::nothing().with_ram()));
    let container = system.cgroup_limits().map_or(u64::MAX, |limits| limits.total_memory.saturating_sub(limits.rss));
    system.available_memory().min(container)
}

/// Refuses what would not fit into memory: more than there is, or than this process may have (`ulimit -v`).
pub(crate) fn require(what: &str, bytes: u64) -> Result<(), Error> {
    if bytes < WORTH_ASKING {
        return Ok(());
    }
    let available = available();
    let refused = || Error::HostMemory { what: what.into(), needed: bytes, available };
    // Asked for and given back untouched: that costs nothing, and tells limits that are not in any table.
    let reserved = usize::try_from(bytes).is_ok_and(|len| Vec::<u8>::new().try_reserve_exact(len).is_ok());
    if bytes <= available && reserved { Ok(()) } else { Err(refused()) }
}

/// Zeros, or an error where there is no memory for them.
pub(crate) fn zeroed<T: Zeroable>(what: &str, len: usize) -> Result<Vec<T>, Error> {
    let needed = len as u64 * size_of::<T>() as u64;
    require(what, needed)?;
    bytemuck::try_zeroed_vec(len).map_err(|()| Error::HostMemory { what: what.into(), needed, available: available() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_there_is_not_is_refused() {
        assert!(available() > 0);
        let message = require("the volume", 1 << 50).unwrap_err().to_string();
        assert!(message.contains("the volume") && message.contains("1125899906842624"), "{message}");
        assert!(zeroed::<f32>("the picture", 1 << 48).is_err());
        assert_eq!(zeroed::<u16>("little", 3).unwrap(), [0; 3]);
    }
}
