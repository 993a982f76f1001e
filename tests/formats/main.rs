//! Files that others wrote (the scripts in make) hold what they say, and what is damaged is refused.

mod damage;
mod files;
mod nrrd_axes;
mod refused;
#[cfg(feature = "npz")]
mod refused_archives;
mod refused_pictures;
mod written;
