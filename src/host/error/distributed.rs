//! Errors of distributed rendering.

use super::Error;

/// An error in distributed rendering.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DistributedError {
    /// MPI does not provide the required level of thread support.
    #[error("MPI was initialised for {found} threads: initialise it with Threading::Serialized or Multiple")]
    Threads {
        /// The provided level.
        found: String,
    },
    /// A failure on one process. All processes receive this error.
    #[error("rank {rank}: {message}")]
    Rank {
        /// Rank of the process.
        rank: usize,
        /// Its error message.
        message: String,
        /// The error itself, on that process only.
        own: Option<Box<Error>>,
    },
}
