//! OpenGL via GLX, on an X server: scripts/gl starts Xvfb.

use crate::common;
use crate::context::{OpenGl, assert_same_bits, scene};
use dlopen2::raw::Library;
use layersplat::{Device, DeviceChoice};
use std::ffi::{c_char, c_int, c_ulong, c_void};
use std::ptr::{null, null_mut};

type Handle = *mut c_void;
const GLX_RGBA_TYPE: c_int = 0x8014;
const DRAWABLE_TYPE: [c_int; 3] = [0x8010, 4, 0];
const PBUFFER_SIZE: [c_int; 5] = [0x8041, 8, 0x8040, 8, 0];

/// A context with a small pbuffer, current in this thread. Its objects live until the process ends.
pub fn opengl() -> OpenGl {
    let library = |name| &*Box::leak(Box::new(Library::open(name).expect("scripts/gl installs it")));
    let (x11, glx) = (library("libX11.so.6"), library("libGL.so.1"));
    // SAFETY: the types are those of Xlib.h and glx.h; the arguments are returned handles, which are never destroyed.
    unsafe {
        let open: unsafe extern "C" fn(*const c_char) -> Handle = x11.symbol("XOpenDisplay").unwrap();
        let choose: unsafe extern "C" fn(Handle, c_int, *const c_int, *mut c_int) -> *mut Handle =
            glx.symbol("glXChooseFBConfig").unwrap();
        let new: unsafe extern "C" fn(Handle, Handle, c_int, Handle, c_int) -> Handle =
            glx.symbol("glXCreateNewContext").unwrap();
        let pbuffer: unsafe extern "C" fn(Handle, Handle, *const c_int) -> c_ulong = glx.symbol("glXCreatePbuffer").unwrap();
        let make: unsafe extern "C" fn(Handle, c_ulong, c_ulong, Handle) -> c_int = glx.symbol("glXMakeContextCurrent").unwrap();
        let address: unsafe extern "C" fn(*const c_char) -> *const c_void = glx.symbol("glXGetProcAddress").unwrap();
        let display = open(null());
        assert!(!display.is_null(), "an X server: scripts/gl starts Xvfb");
        let mut count = 0;
        let configs = choose(display, 0, DRAWABLE_TYPE.as_ptr(), &mut count);
        assert!(count > 0);
        let context = new(display, *configs, GLX_RGBA_TYPE, null_mut(), 1);
        let drawable = pbuffer(display, *configs, PBUFFER_SIZE.as_ptr());
        let make_current = move |current| match current {
            true => assert_eq!(make(display, drawable, drawable, context), 1),
            false => assert_eq!(make(display, 0, 0, null_mut()), 1),
        };
        make_current(true);
        OpenGl::of(Box::new(move |name| address(name.as_ptr())), Box::new(make_current))
    }
}

/// ocl-interop detects GLX contexts.
#[test]
#[ignore = "needs an X server: scripts/gl starts Xvfb"]
fn a_context_of_glx_is_found() {
    let opengl = opengl();
    Device::open_with_gl(&DeviceChoice::Default).unwrap();
    let device = common::device();
    println!("through the host, GLX: {} to {}", device.info().name, opengl.name());
    let (mut renderer, camera) = scene(&device);
    assert_same_bits(&opengl, &device, &mut renderer, &camera, false);
    opengl.make_current(false);
    assert!(Device::open_with_gl(&DeviceChoice::Default).is_err());
}

/// ocl-interop does not detect EGL contexts, so layersplat queries EGL itself. If this test fails, ocl-interop has gained support.
#[test]
fn ocl_interop_finds_no_context_of_egl() {
    let _opengl = OpenGl::new();
    let found = ocl_interop::get_properties_list().to_raw();
    assert!(found.as_chunks::<2>().0.iter().all(|&[_, value]| value == 0), "{found:?}");
    Device::open_with_gl(&DeviceChoice::Default).unwrap();
}

/// ocl-interop links OpenCL. Programs still start without it and say what to install.
#[test]
fn opencl_is_loaded_at_run_time() {
    let output =
        std::process::Command::new("readelf").arg("-d").arg(std::env::current_exe().unwrap()).output().expect("binutils");
    let needed = String::from_utf8_lossy(&output.stdout);
    assert!(needed.contains("libGL.so.1") && !needed.contains("OpenCL"), "{needed}");
}
