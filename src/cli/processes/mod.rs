//! The processes of a run: one, or several that MPI started together.

#[cfg(not(feature = "mpi"))]
mod alone;
#[cfg(feature = "mpi")]
mod several;

#[cfg(not(feature = "mpi"))]
pub(super) use alone::{Processes, TeamOptions};
#[cfg(feature = "mpi")]
pub(super) use several::{Processes, TeamOptions};

/// How many processes MPI started, as far as it says so in the environment: Open MPI, and others by PMI.
fn started() -> Option<usize> {
    ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE"].iter().find_map(|name| std::env::var(name).ok()?.parse().ok())
}
