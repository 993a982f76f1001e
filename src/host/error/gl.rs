//! Errors of OpenGL interoperability.

use std::num::NonZeroU32;

/// An OpenGL context, or a caller-owned texture, that cannot receive pictures.
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
    /// No OpenGL context is current in this thread.
    #[error("no OpenGL context is current in this thread: make the texture's context current first")]
    NoContext,
    /// The loader does not find a function.
    #[error(
        "the loader does not find {function}: pass the loader of the current context, which must be OpenGL 3.0, OpenGL ES 3.1 or later"
    )]
    Function {
        /// Name of the function.
        function: String,
    },
    /// An OpenGL version without queries of texture properties.
    #[error("the context is {version}: pictures need OpenGL 3.0, OpenGL ES 3.1 or later")]
    Version {
        /// Version string of the context.
        version: String,
    },
    /// A name that is not a texture.
    #[error("{texture} is not a texture of the current context: bind it there once, or make its own context current")]
    NoTexture {
        /// The name.
        texture: NonZeroU32,
    },
    /// A texture with another target than `GL_TEXTURE_2D`.
    #[error("texture {texture} has another target: pictures need a GL_TEXTURE_2D")]
    Target {
        /// The texture.
        texture: NonZeroU32,
    },
    /// A texture with another internal format than `GL_RGBA8`.
    #[error("texture {texture} has internal format 0x{format:04x}: pictures need GL_RGBA8 (0x8058), e.g. by glTexStorage2D")]
    Format {
        /// The texture.
        texture: NonZeroU32,
        /// Its internal format.
        format: u32,
    },
    /// A texture whose size has changed.
    #[error("texture {texture} is {found} but was {expected}: create a new GlTexture whenever the texture's storage changes")]
    Changed {
        /// The texture.
        texture: NonZeroU32,
        /// Size when the `GlTexture` was created.
        expected: String,
        /// Current size.
        found: String,
    },
}
