//! OpenGL interoperability: functions from the caller's loader, and textures that receive pictures. No other module calls OpenGL.
//!
//! Requires the feature `gl-interop`. docs/dev/gl.md lists which OpenGL and OpenCL implementations share textures.

mod bound;
mod functions;

pub use crate::error::GlError;
pub use functions::GlFunctions;
