//! Layered rendering: on a lattice, or per screen pixel.

mod pixels;
mod points;
mod splats;

pub(super) use points::PointLayers;
pub(super) use splats::SplatLayers;
