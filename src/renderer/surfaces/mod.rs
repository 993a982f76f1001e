//! Surfaces in and around volumes: their fragments, and the volume between them.

mod pass;
mod uploaded;
mod view;

pub(super) use pass::{DeclaredSurfaces, Pending, SurfacePass};
pub(super) use uploaded::UploadedSurfaces;
