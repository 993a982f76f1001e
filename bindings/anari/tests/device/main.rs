//! The device, as a client of the API sees it.

mod client;
mod pictures;
mod scene;
