//! The only room that knows OpenGL: its functions, as the caller's loader finds them, and textures that pictures go to.
//!
//! With the feature `gl-interop`. Which OpenGL shares what with which OpenCL is in docs/gl.md.

mod bound;
mod functions;

pub use crate::error::GlError;
pub use functions::GlFunctions;
