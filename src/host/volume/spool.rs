//! Voxels in a memory-mapped temporary file, for volumes larger than the memory limit.
//!
//! Streaming reads the voxels several times, in parts along any axis. Compressed data and slice files only decode sequentially or as a
//! whole. Decoding them once into a file provides random access.

use crate::error::Error;
use crate::files::temporary_failed;
use memmap2::{Mmap, MmapMut};
use std::fs::File;
use std::io::Write;
use std::ops::{Deref, DerefMut};

/// A temporary file without a name. The system deletes it when it is closed, even if the process is killed.
pub(super) struct Spool(File);

impl Spool {
    /// Creates a file for `bytes` bytes. Space is not reserved; a full disk is detected on writing.
    pub fn new(name: &str, bytes: u64) -> Result<Self, Error> {
        let folder = std::env::temp_dir();
        tracing::info!("{name}: writing {bytes} bytes of voxels to a temporary file in {}, which is mapped", folder.display());
        Ok(Self(tempfile::tempfile().map_err(temporary_failed)?))
    }

    pub fn put(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.0.write_all(bytes).map_err(temporary_failed)
    }

    pub fn finish(self) -> File {
        self.0
    }

    /// Maps the file, which must not be empty.
    pub fn mapped(self) -> Result<Mmap, Error> {
        // SAFETY: no other process can open the file, and nothing writes to it from now on.
        unsafe { Mmap::map(&self.0) }.map_err(temporary_failed)
    }
}

/// Bytes in a mapped temporary file, for values that are written in any order and need not stay in memory.
#[doc(hidden)]
pub struct MappedBytes(MmapMut);

impl MappedBytes {
    /// `bytes` zeros, at least one. They are written, so that a full disk is found here.
    pub fn zeroed(bytes: usize) -> Result<Self, Error> {
        const PIECE: usize = 1 << 20;
        let (mut file, zeros) = (tempfile::tempfile().map_err(temporary_failed)?, vec![0; PIECE.min(bytes.max(1))]);
        let mut left = bytes.max(1);
        while left > 0 {
            let piece = left.min(PIECE);
            file.write_all(&zeros[..piece]).map_err(temporary_failed)?;
            left -= piece;
        }
        // SAFETY: no other process can open the file, and nothing else in this one writes to it.
        Ok(Self(unsafe { MmapMut::map_mut(&file) }.map_err(temporary_failed)?))
    }
}

impl Deref for MappedBytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.0
    }
}

impl DerefMut for MappedBytes {
    fn deref_mut(&mut self) -> &mut [u8] {
        &mut self.0
    }
}
