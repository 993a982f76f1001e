//! Layered rendering: on a lattice, or per screen pixel.

mod channels;
mod colors;
mod footprint_set;
mod pixels;
mod point_inputs;
pub(super) mod points;
pub(super) mod splats;

pub(super) use points::PointLayers;
pub(super) use splats::SplatLayers;
