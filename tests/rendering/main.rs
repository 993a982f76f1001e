//! Renderers: the same bits however a frame is made (reused, streamed, in parts, culled), limits of time and memory.

mod accumulation;
mod banded_frames;
mod cancelled_frames;
mod check;
#[path = "../common/mod.rs"]
mod common;
mod culling;
mod one_renderer;
mod parts;
mod properties;
mod soak;
mod streamed;
mod streamed_light;
mod streamed_surfaces;
mod time_limits;
