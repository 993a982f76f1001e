//! The OpenGL functions used to write pictures to textures.

use super::bound::{Bound, Unpacked};
use crate::error::{Error, GlError};
use crate::viewport::Viewport;
use glow::HasContext;
use std::ffi::{CStr, c_char, c_void};
use std::num::NonZeroU32;
use std::sync::Arc;

/// Names of the functions used.
const NEEDED: [&CStr; 10] = [
    c"glBindBuffer",
    c"glBindTexture",
    c"glFinish",
    c"glGetError",
    c"glGetIntegerv",
    c"glGetString",
    c"glGetTexLevelParameteriv",
    c"glIsTexture",
    c"glPixelStorei",
    c"glTexSubImage2D",
];

/// OpenGL functions from the caller's loader. Cheap to clone.
///
/// Must be used in the thread in which the context is current. Each call checks that a context is current.
///
/// ```
/// use layersplat::gl::GlFunctions;
///
/// // This loader finds no function.
/// let error = unsafe { GlFunctions::load(|_| std::ptr::null()) }.err().expect("no function");
/// println!("{error}");
/// ```
#[derive(Clone)]
pub struct GlFunctions(Arc<Loaded>);

struct Loaded {
    gl: glow::Context,
    get_string: GetString,
}

type GetString = unsafe extern "system" fn(u32) -> *const c_char;

impl GlFunctions {
    /// Loads the functions of the context that is current in this thread. The loader is `eglGetProcAddress`, glutin's
    /// `get_proc_address` or similar.
    ///
    /// # Errors
    /// [`GlError::NoContext`] without a current context, [`GlError::Version`] for an old one, [`GlError::Function`] if the loader
    /// lacks a function.
    ///
    /// # Safety
    /// The loader must return null or OpenGL's function of the given name. The functions must be valid for every context, in any
    /// thread, in which the result is used.
    pub unsafe fn load(mut loader: impl FnMut(&CStr) -> *const c_void) -> Result<Self, GlError> {
        for name in NEEDED {
            if loader(name).is_null() {
                return Err(GlError::Function { function: name.to_string_lossy().into() });
            }
        }
        // SAFETY: not null, and OpenGL's function by the caller's guarantee.
        let get_string = unsafe { std::mem::transmute::<*const c_void, GetString>(loader(c"glGetString")) };
        // SAFETY: may be called without a context, and returns null then.
        let version = unsafe { get_string(glow::VERSION) };
        if version.is_null() {
            return Err(GlError::NoContext);
        }
        // SAFETY: OpenGL strings are null-terminated and live as long as the context.
        let version = unsafe { CStr::from_ptr(version) }.to_string_lossy().into_owned();
        // SAFETY: a context is current, and the caller guarantees the loader.
        let gl = unsafe { glow::Context::from_loader_function_cstr(loader) };
        let number = gl.version();
        if (number.major, number.minor) < if number.is_embedded { (3, 1) } else { (3, 0) } {
            return Err(GlError::Version { version });
        }
        Ok(Self(Arc::new(Loaded { gl, get_string })))
    }

    /// The functions, after a check that a context is current.
    fn current(&self) -> Result<&glow::Context, GlError> {
        // SAFETY: may be called without a context, and returns null then.
        let version = unsafe { (self.0.get_string)(glow::VERSION) };
        if version.is_null() { Err(GlError::NoContext) } else { Ok(&self.0.gl) }
    }

    /// Size of a texture that can receive pictures.
    pub(crate) fn size(&self, texture: NonZeroU32) -> Result<Viewport, Error> {
        let gl = self.current()?;
        // SAFETY: the context is current.
        let [width, height, format] = unsafe {
            let _bound = Bound::new(gl, texture)?;
            [glow::TEXTURE_WIDTH, glow::TEXTURE_HEIGHT, glow::TEXTURE_INTERNAL_FORMAT]
                .map(|parameter| gl.get_tex_level_parameter_i32(glow::TEXTURE_2D, 0, parameter) as u32)
        };
        if format != glow::RGBA8 && width > 0 {
            return Err(GlError::Format { texture, format }.into());
        }
        Viewport::new(width, height)
    }

    /// Writes an RGBA8 picture of the texture's size, first row first.
    pub(crate) fn write(&self, texture: NonZeroU32, size: Viewport, picture: &[u8]) -> Result<(), GlError> {
        assert_eq!(picture.len(), 4 * size.pixels(), "picture and texture differ in size");
        let gl = self.current()?;
        let [width, height] = [size.width, size.height].map(|n| n as i32);
        let pixels = glow::PixelUnpackData::Slice(Some(picture));
        // SAFETY: the context is current, and the slice holds all pixels, tightly packed.
        unsafe {
            let _bound = Bound::new(gl, texture)?;
            let _unpacked = Unpacked::new(gl);
            gl.tex_sub_image_2d(glow::TEXTURE_2D, 0, 0, 0, width, height, glow::RGBA, glow::UNSIGNED_BYTE, pixels);
        }
        Ok(())
    }

    /// Waits until OpenGL has finished all commands.
    pub(crate) fn finish(&self) -> Result<(), GlError> {
        // SAFETY: the context is current.
        unsafe { self.current()?.finish() };
        Ok(())
    }
}
