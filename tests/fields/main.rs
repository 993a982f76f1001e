//! Several fields, colours and labels in one picture, against the converged integral.

mod channel_splats;
mod channels;
mod colors;
#[path = "../common/mod.rs"]
mod common;
mod label_colors;
mod label_surfaces;
mod methods;
mod mixed;
mod sheared;
mod studio;
mod surfaces;
