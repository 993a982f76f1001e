//! The processes of a run: one, or several started by MPI.

#[cfg(not(feature = "mpi"))]
mod alone;
#[cfg(feature = "mpi")]
mod several;

#[cfg(not(feature = "mpi"))]
pub(super) use alone::{Processes, TeamOptions};
#[cfg(feature = "mpi")]
pub(super) use several::{Processes, TeamOptions};

/// Number of processes that MPI started, from the environment variables of Open MPI and PMI.
fn started() -> Option<usize> {
    ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE"].iter().find_map(|name| std::env::var(name).ok()?.parse().ok())
}
