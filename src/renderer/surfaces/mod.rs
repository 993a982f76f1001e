//! Surfaces in and around volumes: their fragments, and the volume between them.

mod cells;
mod pass;
mod uploaded;
mod view;

pub(super) use pass::{Pending, SurfacePass, declare_surfaces};
pub(super) use uploaded::{SurfaceSizes, UploadedSurfaces};
