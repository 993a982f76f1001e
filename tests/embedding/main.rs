//! Embedding: contexts, queues, buffers and events of the caller.

#[path = "../common/mod.rs"]
mod common;

mod frames;
mod handles;
mod host;
mod scratch;
mod surfaces;
#[path = "../gl/told.rs"]
mod told;
mod volumes;
