//! The functions that pictures need, and nothing else of OpenGL.

use super::bound::{Bound, Unpacked};
use crate::error::{Error, GlError};
use crate::viewport::Viewport;
use glow::HasContext;
use std::ffi::{CStr, c_char, c_void};
use std::num::NonZeroU32;
use std::sync::Arc;

/// Those that are called.
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

/// OpenGL, as the caller's loader finds it. Cheap to clone.
///
/// It is used by the thread that has the context current: each call looks whether one is.
///
/// ```
/// use layersplat::gl::GlFunctions;
///
/// // A loader that finds nothing is told so.
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
    /// Loads the functions of the context that is current in this thread: `eglGetProcAddress`, glutin's `get_proc_address` and the like.
    ///
    /// # Errors
    /// No context that is current, an old one, and a loader that does not know what is needed.
    ///
    /// # Safety
    /// What the loader returns for a name is null or OpenGL's function of that name, for every context of this thread and others in
    /// which what is loaded here will be used.
    pub unsafe fn load(mut loader: impl FnMut(&CStr) -> *const c_void) -> Result<Self, GlError> {
        for name in NEEDED {
            if loader(name).is_null() {
                return Err(GlError::Function { function: name.to_string_lossy().into() });
            }
        }
        // SAFETY: the caller's promise; it is not null.
        let get_string = unsafe { std::mem::transmute::<*const c_void, GetString>(loader(c"glGetString")) };
        // SAFETY: it may be asked without a context, and answers null then.
        let version = unsafe { get_string(glow::VERSION) };
        if version.is_null() {
            return Err(GlError::NoContext);
        }
        // SAFETY: OpenGL's strings end in zero and live as long as the context.
        let version = unsafe { CStr::from_ptr(version) }.to_string_lossy().into_owned();
        // SAFETY: the caller's promise; a context is current.
        let gl = unsafe { glow::Context::from_loader_function_cstr(loader) };
        let number = gl.version();
        if (number.major, number.minor) < if number.is_embedded { (3, 1) } else { (3, 0) } {
            return Err(GlError::Version { version });
        }
        Ok(Self(Arc::new(Loaded { gl, get_string })))
    }

    /// Of the current context, which there has to be.
    fn current(&self) -> Result<&glow::Context, GlError> {
        // SAFETY: it may be asked without a context, and answers null then.
        let version = unsafe { (self.0.get_string)(glow::VERSION) };
        if version.is_null() { Err(GlError::NoContext) } else { Ok(&self.0.gl) }
    }

    /// How large a texture is that pictures can go to.
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

    /// Writes a picture of the texture's size, its first row first.
    pub(crate) fn write(&self, texture: NonZeroU32, size: Viewport, picture: &[u8]) -> Result<(), GlError> {
        assert_eq!(picture.len(), 4 * size.pixels(), "a picture of another size than its texture");
        let gl = self.current()?;
        let [width, height] = [size.width, size.height].map(|n| n as i32);
        let pixels = glow::PixelUnpackData::Slice(Some(picture));
        // SAFETY: the context is current, and there are as many pixels, without gaps.
        unsafe {
            let _bound = Bound::new(gl, texture)?;
            let _unpacked = Unpacked::new(gl);
            gl.tex_sub_image_2d(glow::TEXTURE_2D, 0, 0, 0, width, height, glow::RGBA, glow::UNSIGNED_BYTE, pixels);
        }
        Ok(())
    }

    /// Waits until OpenGL is done with all that it was told.
    pub(crate) fn finish(&self) -> Result<(), GlError> {
        // SAFETY: the context is current.
        unsafe { self.current()?.finish() };
        Ok(())
    }
}
