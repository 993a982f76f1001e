//! Voxels that memory is not to hold, in a temporary file that is mapped.
//!
//! Who streams looks at voxels several times, in parts along any axis. What is packed is unpacked from its first byte on, slices in files of
//! their own are decoded whole: that is done once, and what comes of it is kept where any part of it can be looked at.

use crate::error::Error;
use crate::files::temporary_failed;
use memmap2::Mmap;
use std::fs::File;
use std::io::Write;

/// A temporary file without a name: it is gone when nobody has it open, however the process ends.
pub(super) struct Spool(File);

impl Spool {
    /// For so many bytes of what `name` holds. They are not set aside: a disk that is full is noticed when they are written.
    pub fn new(name: &str, bytes: u64) -> Result<Self, Error> {
        let folder = std::env::temp_dir();
        tracing::info!("{name}: {bytes} bytes of voxels go to a temporary file in {}, which is mapped", folder.display());
        Ok(Self(tempfile::tempfile().map_err(temporary_failed)?))
    }

    pub fn put(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.0.write_all(bytes).map_err(temporary_failed)
    }

    pub fn finish(self) -> File {
        self.0
    }

    /// All that was put there, of which there must be something.
    pub fn mapped(self) -> Result<Mmap, Error> {
        // SAFETY: nobody else can reach the file, and nobody here writes to it from now on.
        unsafe { Mmap::map(&self.0) }.map_err(temporary_failed)
    }
}
