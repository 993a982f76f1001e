//! Pictures in textures of OpenGL's, without a screen: EGL without a surface, on llvmpipe or whatever draws there.

#[path = "../common/mod.rs"]
mod common;

mod context;
mod glx;
mod host;
mod refusals;
mod sharing;
mod time;
mod told;
