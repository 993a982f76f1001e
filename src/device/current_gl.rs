//! The current OpenGL context of this thread, as OpenCL context properties.

use crate::error::GlError;
use dlopen2::raw::Library;
use std::ffi::c_void;

/// Keys of OpenCL context properties.
pub(super) const GL_CONTEXT: isize = 0x2008;
const EGL_DISPLAY: isize = 0x2009;
const CGL_SHAREGROUP: isize = 0x200c;

/// Properties for an OpenCL context that shares with the current OpenGL context, without the platform and the terminating zero.
///
/// EGL is queried first. On Linux, ocl-interop queries only GLX, which does not know EGL contexts, as Wayland uses.
pub(super) fn properties() -> Result<Vec<isize>, GlError> {
    if let Some(properties) = egl_properties() {
        return Ok(properties.to_vec());
    }
    let mut properties = ocl_interop::get_properties_list().to_raw();
    properties.truncate(properties.len() / 2 * 2);
    if names_context(&properties) { Ok(properties) } else { Err(GlError::NoContext) }
}

/// Whether properties name an OpenGL context that is not null.
pub(super) fn names_context(properties: &[isize]) -> bool {
    properties.as_chunks::<2>().0.iter().any(|&[key, value]| [GL_CONTEXT, CGL_SHAREGROUP].contains(&key) && value != 0)
}

/// Properties of the current EGL context, if any. A program that uses EGL has already loaded the library under this name.
fn egl_properties() -> Option<[isize; 4]> {
    type Current = unsafe extern "system" fn() -> *const c_void;
    let egl = Library::open(if cfg!(windows) { "libEGL.dll" } else { "libEGL.so.1" }).ok()?;
    let current = |name| {
        // SAFETY: both EGL functions have this type and may be called at any time.
        let handle = unsafe { egl.symbol::<Current>(name).ok()?() };
        (!handle.is_null()).then_some(handle as isize)
    };
    Some([GL_CONTEXT, current("eglGetCurrentContext")?, EGL_DISPLAY, current("eglGetCurrentDisplay")?])
}
