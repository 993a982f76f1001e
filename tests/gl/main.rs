//! Pictures in OpenGL textures, without a screen: EGL without a surface, on llvmpipe or any other renderer.

#[path = "../common/mod.rs"]
mod common;

mod context;
mod glx;
mod host;
mod refusals;
mod sharing;
mod time;
mod told;
