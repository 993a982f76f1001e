//! Pictures rendered into shared textures. `scripts/gl` runs these tests if a device supports `cl_khr_gl_sharing`, and prints NOT RUN
//! otherwise; it also runs them with a stand-in (stand_in.c).

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
    // scripts/gl searches for this message.
    assert!(device.shares_gl(), "no device shares with OpenGL: {} does not", device.info().name);
    device
}

/// A device opens with any current context, with or without sharing.
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

/// EGL contexts, detected by layersplat, and GLX contexts, detected by ocl-interop.
#[test]
#[ignore = "needs a device that shares with OpenGL: scripts/gl"]
fn pictures_have_the_bits_of_rendered_ones_in_glx() {
    let opengl = crate::glx::opengl();
    let device = sharing_device();
    println!("on the device, GLX: {} to {}", device.info().name, opengl.name());
    let (mut renderer, camera) = scene(&device);
    assert_same_bits(&opengl, &device, &mut renderer, &camera, true);
}

/// A caller's out-of-order queue, in a context that the caller created for sharing.
#[test]
#[ignore = "needs a device that shares with OpenGL: scripts/gl"]
fn pictures_have_the_bits_of_rendered_ones_in_a_callers_queue() {
    let opengl = OpenGl::new();
    let callers = sharing_device();
    // SAFETY: context and device outlive `callers`, and the queue belongs to them.
    let device = unsafe {
        let queue = create_command_queue(callers.context(), callers.id(), CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE).unwrap();
        Device::from_queue(&CommandQueue::new(queue, 1)).unwrap()
    };
    assert!(device.shares_gl());
    let (mut renderer, camera) = scene(&device);
    assert_same_bits(&opengl, &device, &mut renderer, &camera, true);
}

/// A texture belongs to its context: a renderer of another device rejects it without changing it.
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
