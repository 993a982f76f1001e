//! At home in other people's programs: contexts, queues, buffers and events of a caller's own.

#[path = "../common/mod.rs"]
mod common;

mod frames;
mod handles;
mod host;
mod scratch;
#[path = "../gl/told.rs"]
mod told;
mod volumes;
