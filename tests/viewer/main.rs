//! `layersplat view`, by raw HTTP and WebSocket: who is let in, what pages get, and what they cannot do to others.

mod client;
mod limits;
mod pictures;
mod safety;
