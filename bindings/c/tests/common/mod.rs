//! A small scene made with the C functions, shared by the tests.
#![allow(dead_code)] // Each test uses a part of it.

use layersplat_c::*;
use std::ffi::{CStr, CString};
use std::ptr::{null, null_mut};

pub const WIDTH: u32 = 40;
pub const HEIGHT: u32 = 30;
pub const FLOATS: usize = 4 * (WIDTH * HEIGHT) as usize;
pub const FROM: OrbitAngles = OrbitAngles { azimuth: 25.0, elevation: 15.0, roll: 0.0 };

pub fn last_error() -> String {
    // SAFETY: it is a string, and no other call is made meanwhile.
    unsafe { CStr::from_ptr(layersplat_last_error()) }.to_str().unwrap().into()
}

pub fn ok(status: Status) {
    assert_eq!(status, Status::Ok, "{}", last_error());
}

/// The message of a call that fails.
pub fn refused(status: Status, expected: Status) -> String {
    assert_eq!(status, expected, "{}", last_error());
    last_error()
}

/// The handle that a call creates.
pub fn made<T>(make: impl FnOnce(*mut *mut T) -> Status) -> *mut T {
    let mut handle = null_mut();
    ok(make(&mut handle));
    assert!(!handle.is_null());
    handle
}

/// A device, a volume, its automatic transfer function, a renderer and a camera.
pub struct Scene {
    pub device: *mut Device,
    pub volume: *mut Volume,
    pub transfer: *mut Transfer,
    pub renderer: *mut Renderer,
    pub camera: Camera,
}

pub const SOURCE: &str = "builtin:hydrogen@20";

impl Scene {
    pub fn new() -> Self {
        Self::open(SOURCE)
    }

    pub fn open(source: &str) -> Self {
        let source = CString::new(source).unwrap();
        // SAFETY: all arguments are alive.
        unsafe {
            let device = made(|out| layersplat_device_open(null(), out));
            let volume = made(|out| layersplat_volume_open(source.as_ptr(), out));
            let transfer = made(|out| layersplat_transfer_automatic(volume, out));
            let renderer = made(|out| layersplat_renderer_new(device, volume, transfer, out));
            Self { device, volume, transfer, renderer, camera: camera(volume) }
        }
    }

    pub fn floats(&self, settings: *const Settings) -> Vec<f32> {
        let mut pixels = vec![-1.0; FLOATS];
        // SAFETY: all arguments are alive.
        ok(unsafe {
            layersplat_render_floats(self.renderer, &self.camera, WIDTH, HEIGHT, settings, pixels.as_mut_ptr(), FLOATS)
        });
        pixels
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        // SAFETY: the handles are valid and freed once.
        unsafe {
            // Dependencies first: handles must be independent.
            layersplat_device_free(self.device);
            layersplat_volume_free(self.volume);
            layersplat_transfer_free(self.transfer);
            layersplat_renderer_free(self.renderer);
        }
    }
}

pub fn camera(volume: *const Volume) -> Camera {
    let mut grid = layersplat_grid_at_origin(0, 0, 0, 0.0, 0.0, 0.0);
    let mut camera = EMPTY;
    // SAFETY: all arguments are alive.
    unsafe {
        ok(layersplat_volume_grid(volume, &mut grid));
        ok(layersplat_camera_fit_grid(&grid, FROM, 0.0, WIDTH, HEIGHT, &mut camera));
    }
    camera
}

pub const EMPTY: Camera = Camera { position: [0.0; 3], focal_point: [0.0; 3], view_up: [0.0; 3], projection: 0, extent: 0.0 };

pub fn settings(quality: i32) -> Settings {
    let mut settings = std::mem::MaybeUninit::uninit();
    // SAFETY: the call initialises the struct.
    unsafe {
        ok(layersplat_settings_default(quality, settings.as_mut_ptr(), size_of::<Settings>()));
        settings.assume_init()
    }
}
