//! What can go wrong where several processes are one renderer.

use super::Error;

/// What fails between processes.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DistributedError {
    /// MPI may be called from one thread only.
    #[error("MPI was initialised for {found} threads: initialise it with Threading::Serialized or Multiple")]
    Threads {
        /// What it was initialised for.
        found: String,
    },
    /// Something failed on one of the processes; all have this error.
    #[error("rank {rank}: {message}")]
    Rank {
        /// The process.
        rank: usize,
        /// What it said.
        message: String,
        /// Its error, on that process itself.
        own: Option<Box<Error>>,
    },
}
