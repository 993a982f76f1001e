//! `layersplat view`, by raw HTTP and WebSocket: access, what pages get, and that they cannot disturb others.

mod client;
mod fields;
mod files;
mod films;
mod limits;
mod pictures;
mod python;
mod reading;
mod safety;
mod slices;
mod time;
