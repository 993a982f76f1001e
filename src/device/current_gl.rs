//! Which context of OpenGL is current in this thread, as OpenCL takes it.

use crate::error::GlError;
use dlopen2::raw::Library;
use std::ffi::c_void;

/// Properties of an OpenCL context, keys before values.
pub(super) const GL_CONTEXT: isize = 0x2008;
const EGL_DISPLAY: isize = 0x2009;
const CGL_SHAREGROUP: isize = 0x200c;

/// What of OpenGL's an OpenCL context has to share: properties without a platform, and without the zero at the end.
///
/// EGL is asked first: ocl-interop asks GLX alone on Linux, which knows no context of EGL's, as all are on Wayland.
pub(super) fn properties() -> Result<Vec<isize>, GlError> {
    if let Some(of_egl) = of_egl() {
        return Ok(of_egl.to_vec());
    }
    let mut properties = ocl_interop::get_properties_list().to_raw();
    properties.truncate(properties.len() / 2 * 2);
    if names_context(&properties) { Ok(properties) } else { Err(GlError::NoContext) }
}

/// Whether properties name a context of OpenGL's that is not null.
pub(super) fn names_context(properties: &[isize]) -> bool {
    properties.as_chunks::<2>().0.iter().any(|&[key, value]| [GL_CONTEXT, CGL_SHAREGROUP].contains(&key) && value != 0)
}

/// EGL's, where it is there and a context of its own is current. A program that uses EGL has loaded it, under this name.
fn of_egl() -> Option<[isize; 4]> {
    type Current = unsafe extern "system" fn() -> *const c_void;
    let egl = Library::open(if cfg!(windows) { "libEGL.dll" } else { "libEGL.so.1" }).ok()?;
    let current = |name| {
        // SAFETY: both of EGL's functions are of this type, and may be called at any time.
        let handle = unsafe { egl.symbol::<Current>(name).ok()?() };
        (!handle.is_null()).then_some(handle as isize)
    };
    Some([GL_CONTEXT, current("eglGetCurrentContext")?, EGL_DISPLAY, current("eglGetCurrentDisplay")?])
}
