//! The device, as a client of the API sees it.

mod client;
mod frames;
mod introspection;
mod lifetimes;
mod lights;
mod pictures;
mod random;
mod scene;
mod settings;
mod several;
mod sheared;
