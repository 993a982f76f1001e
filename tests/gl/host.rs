//! Pictures that are copied through the host.

use crate::common;
use crate::context::{OpenGl, SIZE, assert_same_bits, scene};
use crate::told::warnings;
use glow::HasContext;
use layersplat::renderer::GlTexture;
use layersplat::{Background, Settings};

#[test]
fn pictures_have_the_bits_of_rendered_ones() {
    let (opengl, device) = (OpenGl::new(), common::device());
    println!("through the host: {} to {}", device.info().name, opengl.name());
    let (mut renderer, camera) = scene(&device);
    assert_same_bits(&opengl, &device, &mut renderer, &camera, false);
}

/// OpenGL state is preserved, with any bindings and pixel store parameters of the caller.
#[test]
fn state_is_as_before() {
    let (opengl, device) = (OpenGl::new(), common::device());
    let (mut renderer, camera) = scene(&device);
    let name = opengl.picture(SIZE);
    let other = glow::NativeTexture(opengl.picture(SIZE));
    let gl = &opengl.gl;
    let layout =
        [(glow::UNPACK_ALIGNMENT, 8), (glow::UNPACK_ROW_LENGTH, 64), (glow::UNPACK_SKIP_ROWS, 2), (glow::UNPACK_SKIP_PIXELS, 3)];
    // SAFETY: the context is current.
    let buffer = unsafe {
        let buffer = gl.create_buffer().unwrap();
        gl.bind_buffer(glow::PIXEL_UNPACK_BUFFER, Some(buffer));
        gl.active_texture(glow::TEXTURE3);
        gl.bind_texture(glow::TEXTURE_2D, Some(other));
        layout.into_iter().for_each(|(parameter, value)| gl.pixel_store_i32(parameter, value));
        buffer
    };
    let background = Background::Color([0.4, 0.1, 0.2]);
    let (expected, _) = renderer.render_rgba8(&camera, SIZE, &Settings::default(), background).unwrap();
    let texture = GlTexture::new(&device, &opengl.functions, name).unwrap();
    renderer.render_into_texture(&camera, &Settings::default(), background, &texture).unwrap();
    // SAFETY: the context is current.
    unsafe {
        assert_eq!(gl.get_error(), glow::NO_ERROR);
        assert_eq!(gl.get_parameter_buffer(glow::PIXEL_UNPACK_BUFFER_BINDING), Some(buffer));
        assert_eq!(gl.get_parameter_i32(glow::ACTIVE_TEXTURE) as u32, glow::TEXTURE3);
        assert_eq!(gl.get_parameter_texture(glow::TEXTURE_BINDING_2D), Some(other));
        assert_eq!(layout.map(|(parameter, _)| gl.get_parameter_i32(parameter)), layout.map(|(_, value)| value));
    }
    assert!(opengl.read(name, SIZE) == expected);
}

#[test]
fn that_pictures_go_through_the_host_is_said_once() {
    let opengl = OpenGl::new();
    // A separate device, because warnings are logged once per device.
    let device = common::own_device();
    let name = opengl.picture(SIZE);
    let (mut renderer, camera) = scene(&device);
    let said = warnings(|| {
        for _ in 0..2 {
            let texture = GlTexture::new(&device.clone(), &opengl.functions, name).unwrap();
            for _ in 0..2 {
                renderer.render_into_texture(&camera, &Settings::default(), Background::Transparent, &texture).unwrap();
            }
        }
    });
    let [said] = said.as_slice() else { panic!("{said:?}") };
    assert!(
        said.contains(&device.info().name) && said.contains("through the host") && said.contains("cl_khr_gl_sharing"),
        "{said}"
    );
}
