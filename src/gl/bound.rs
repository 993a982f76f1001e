//! Guards that change OpenGL state and restore the caller's state when dropped.

use crate::error::GlError;
use glow::HasContext;
use std::num::NonZeroU32;

/// Binds a texture to `GL_TEXTURE_2D`.
pub(super) struct Bound<'a> {
    gl: &'a glow::Context,
    before: Option<glow::NativeTexture>,
}

impl<'a> Bound<'a> {
    /// # Safety
    /// The context is current.
    pub unsafe fn new(gl: &'a glow::Context, texture: NonZeroU32) -> Result<Self, GlError> {
        let name = glow::NativeTexture(texture);
        // SAFETY: the caller guarantees a current context.
        unsafe {
            if !gl.is_texture(name) {
                return Err(GlError::NoTexture { texture });
            }
            let before = gl.get_parameter_texture(glow::TEXTURE_BINDING_2D);
            gl.bind_texture(glow::TEXTURE_2D, Some(name));
            if gl.get_parameter_texture(glow::TEXTURE_BINDING_2D) != Some(name) {
                // Clears the OpenGL error of the failed bind, which is reported here.
                gl.get_error();
                return Err(GlError::Target { texture });
            }
            Ok(Self { gl, before })
        }
    }
}

impl Drop for Bound<'_> {
    fn drop(&mut self) {
        // SAFETY: the guard lives within one call, for which the context is current.
        unsafe { self.gl.bind_texture(glow::TEXTURE_2D, self.before) };
    }
}

/// Parameters of the layout of pixels in host memory.
const LAYOUT: [u32; 4] = [glow::UNPACK_ALIGNMENT, glow::UNPACK_ROW_LENGTH, glow::UNPACK_SKIP_ROWS, glow::UNPACK_SKIP_PIXELS];

/// Sets texture uploads to read tightly packed pixels from host memory.
pub(super) struct Unpacked<'a> {
    gl: &'a glow::Context,
    layout: [i32; 4],
    buffer: Option<glow::NativeBuffer>,
}

impl<'a> Unpacked<'a> {
    /// # Safety
    /// The context is current.
    pub unsafe fn new(gl: &'a glow::Context) -> Self {
        // SAFETY: the caller guarantees a current context.
        unsafe {
            let layout = LAYOUT.map(|parameter| gl.get_parameter_i32(parameter));
            let buffer = gl.get_parameter_buffer(glow::PIXEL_UNPACK_BUFFER_BINDING);
            let before = Self { gl, layout, buffer };
            before.set([4, 0, 0, 0], None);
            before
        }
    }

    /// # Safety
    /// The context is current.
    unsafe fn set(&self, layout: [i32; 4], buffer: Option<glow::NativeBuffer>) {
        // SAFETY: the caller guarantees a current context.
        unsafe {
            for (parameter, value) in LAYOUT.into_iter().zip(layout) {
                self.gl.pixel_store_i32(parameter, value);
            }
            self.gl.bind_buffer(glow::PIXEL_UNPACK_BUFFER, buffer);
        }
    }
}

impl Drop for Unpacked<'_> {
    fn drop(&mut self) {
        // SAFETY: the guard lives within one call, for which the context is current.
        unsafe { self.set(self.layout, self.buffer) };
    }
}
