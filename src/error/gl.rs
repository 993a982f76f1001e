//! What can go wrong with OpenGL.

use std::num::NonZeroU32;

/// OpenGL, or a texture of the caller's, that pictures cannot go to.
///
/// ```
/// use layersplat::gl::{GlError, GlFunctions};
///
/// let loaded = unsafe { GlFunctions::load(|_| std::ptr::null()) };
/// assert!(matches!(loaded, Err(GlError::Function { .. })));
/// ```
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GlError {
    /// There is no context to work with.
    #[error("no OpenGL context is current in this thread: make the texture's current before")]
    NoContext,
    /// The loader does not know a function.
    #[error(
        "the loader finds no {function}: give the one of the context that is current, of OpenGL 3.0 or OpenGL ES 3.1 at least"
    )]
    Function {
        /// What was asked for.
        function: String,
    },
    /// A version that cannot tell what a texture is.
    #[error("the context is of {version}: pictures need OpenGL 3.0 or OpenGL ES 3.1 at least")]
    Version {
        /// What the context says of itself.
        version: String,
    },
    /// A name of no texture.
    #[error("{texture} is no texture of the current context: bind it there once, or make its own context current")]
    NoTexture {
        /// The name.
        texture: NonZeroU32,
    },
    /// A texture of another shape.
    #[error("texture {texture} is of another target: pictures go to a GL_TEXTURE_2D")]
    Target {
        /// The texture.
        texture: NonZeroU32,
    },
    /// A texture of other pixels.
    #[error("texture {texture} is of internal format 0x{format:04x}: pictures go to GL_RGBA8 (0x8058), as by glTexStorage2D")]
    Format {
        /// The texture.
        texture: NonZeroU32,
        /// Its internal format.
        format: u32,
    },
    /// A texture whose size has changed.
    #[error("texture {texture} is {found} and was {expected}: make the GlTexture anew whenever the texture's storage is")]
    Changed {
        /// The texture.
        texture: NonZeroU32,
        /// What it was when it was handed over.
        expected: String,
        /// What it is now.
        found: String,
    },
}
