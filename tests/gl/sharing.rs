//! Pictures that go into textures on the device. `scripts/gl` runs these where a device offers `cl_khr_gl_sharing`, and says NOT RUN
//! elsewhere; it also runs them on a stand-in (stand_in.c).

use crate::common;
use crate::context::{OpenGl, SIZE, assert_same_bits, scene};
use crate::told::warnings;
use layersplat::renderer::GlTexture;
use layersplat::{Background, Device, DeviceChoice, Error, Settings};
use opencl3::command_queue::{CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, CommandQueue, create_command_queue};

/// The device that shares with the current context.
fn sharing_device() -> Device {
    let choice = std::env::var("LAYERSPLAT_DEVICE").map_or(DeviceChoice::Default, DeviceChoice::Named);
    let device = Device::open_with_gl(&choice).unwrap();
    // scripts/gl looks for these words.
    assert!(device.shares_gl(), "no device shares with OpenGL: {} does not", device.info().name);
    device
}

/// Everywhere: either it shares, or it is a device like any other.
#[test]
fn a_device_is_opened_with_any_current_context() {
    let _opengl = OpenGl::new();
    let device = Device::open_with_gl(&DeviceChoice::Default).unwrap();
    assert!(!device.info().name.is_empty());
    assert!(!common::device().shares_gl());
}

#[test]
#[ignore = "needs a device that shares with OpenGL: scripts/gl"]
fn pictures_have_the_bits_of_rendered_ones() {
    let opengl = OpenGl::new();
    let device = sharing_device();
    println!("on the device: {} to {}", device.info().name, opengl.name());
    let (mut renderer, camera) = scene(&device);
    assert_eq!(warnings(|| assert_same_bits(&opengl, &device, &mut renderer, &camera, true)), [""; 0]);
}

/// Of EGL, which is asked by layersplat, and GLX, which ocl-interop asks.
#[test]
#[ignore = "needs a device that shares with OpenGL: scripts/gl"]
fn pictures_have_the_bits_of_rendered_ones_in_glx() {
    let opengl = crate::glx::opengl();
    let device = sharing_device();
    println!("on the device, GLX: {} to {}", device.info().name, opengl.name());
    let (mut renderer, camera) = scene(&device);
    assert_same_bits(&opengl, &device, &mut renderer, &camera, true);
}

/// A caller's own queue, out of order, in a context that the caller made to share.
#[test]
#[ignore = "needs a device that shares with OpenGL: scripts/gl"]
fn pictures_have_the_bits_of_rendered_ones_in_a_callers_queue() {
    let opengl = OpenGl::new();
    let callers = sharing_device();
    // SAFETY: context and device live as long as `callers`, and the queue is handed over as its own.
    let device = unsafe {
        let queue = create_command_queue(callers.context(), callers.id(), CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE).unwrap();
        Device::of_queue(&CommandQueue::new(queue, 1)).unwrap()
    };
    assert!(device.shares_gl());
    let (mut renderer, camera) = scene(&device);
    assert_same_bits(&opengl, &device, &mut renderer, &camera, true);
}

/// A texture is memory of its context: another device's renderer says so, and the texture is as before.
#[test]
#[ignore = "needs a device that shares with OpenGL: scripts/gl"]
fn a_texture_of_another_device_is_refused() {
    let opengl = OpenGl::new();
    let name = opengl.picture(SIZE);
    let texture = GlTexture::new(&sharing_device(), &opengl.functions, name).unwrap();
    let (mut renderer, camera) = scene(&common::device());
    let error = renderer.render_into_texture(&camera, &Settings::default(), Background::Transparent, &texture).unwrap_err();
    assert!(matches!(error, Error::Memory { .. }) && error.to_string().contains("another context"), "{error}");
}
