//! The device, as a client of the API sees it.

mod client;
mod frames;
mod introspection;
mod lifetimes;
mod pictures;
mod random;
mod scene;
