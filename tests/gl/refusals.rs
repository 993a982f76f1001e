//! Unsuitable textures and contexts, and their errors.

use crate::common;
use crate::context::{OpenGl, SIZE, scene};
use glow::HasContext;
use layersplat::gl::{GlError, GlFunctions};
use layersplat::renderer::GlTexture;
use layersplat::{Background, Device, DeviceChoice, Error, Settings, Viewport};
use std::num::NonZeroU32;

fn refused(opengl: &OpenGl, device: &Device, name: NonZeroU32) -> Error {
    let error = GlTexture::new(device, &opengl.functions, name).map(|_| ()).unwrap_err();
    // SAFETY: the context is current.
    assert_eq!(unsafe { opengl.gl.get_error() }, glow::NO_ERROR, "a rejected texture must not leave an OpenGL error");
    error
}

#[test]
fn other_textures_are_refused() {
    let (opengl, device) = (OpenGl::new(), common::device());
    let floats = refused(&opengl, &device, opengl.texture(glow::TEXTURE_2D, glow::RGBA32F, SIZE));
    assert!(matches!(floats, Error::Gl(GlError::Format { format: glow::RGBA32F, .. })), "{floats}");
    assert!(floats.to_string().contains("0x8814") && floats.to_string().contains("GL_RGBA8"), "{floats}");
    let square = Viewport { width: 8, height: 8 };
    let cube = refused(&opengl, &device, opengl.texture(glow::TEXTURE_CUBE_MAP, glow::RGBA8, square));
    assert!(matches!(cube, Error::Gl(GlError::Target { .. })), "{cube}");
    let nothing = refused(&opengl, &device, NonZeroU32::new(123_456).unwrap());
    assert!(matches!(nothing, Error::Gl(GlError::NoTexture { .. })) && nothing.to_string().contains("123456"), "{nothing}");
    let empty = refused(&opengl, &device, opengl.picture(Viewport { width: 0, height: 0 }));
    assert_eq!(empty.fields(), ["viewport"], "{empty}");
}

#[test]
fn a_texture_whose_storage_changed_is_refused() {
    let (opengl, device) = (OpenGl::new(), common::device());
    let (mut renderer, camera) = scene(&device);
    let name = opengl.picture(SIZE);
    let texture = GlTexture::new(&device, &opengl.functions, name).unwrap();
    // SAFETY: the context is current.
    unsafe {
        opengl.gl.bind_texture(glow::TEXTURE_2D, Some(glow::NativeTexture(name)));
        let nothing = glow::PixelUnpackData::Slice(None);
        let (format, kind) = (glow::RGBA, glow::UNSIGNED_BYTE);
        opengl.gl.tex_image_2d(glow::TEXTURE_2D, 0, glow::RGBA8 as i32, 64, 32, 0, format, kind, nothing);
    }
    let mut render = |texture: &GlTexture| {
        renderer.render_into_texture(&camera, &Settings::default(), Background::Transparent, texture).map(|_| ())
    };
    let error = render(&texture).unwrap_err();
    assert!(matches!(error, Error::Gl(GlError::Changed { .. })), "{error}");
    assert!(error.to_string().contains("45x38") && error.to_string().contains("64x32"), "{error}");
    render(&GlTexture::new(&device, &opengl.functions, name).unwrap()).unwrap();
}

#[test]
fn without_a_context_nothing_is_done() {
    let (opengl, device) = (OpenGl::new(), common::device());
    let (mut renderer, camera) = scene(&device);
    let texture = GlTexture::new(&device, &opengl.functions, opengl.picture(SIZE)).unwrap();
    opengl.make_current(false);
    let errors = [
        opengl.load().map(|_| ()).map_err(Error::from),
        GlTexture::new(&device, &opengl.functions, NonZeroU32::MIN).map(|_| ()),
        renderer.render_into_texture(&camera, &Settings::default(), Background::Transparent, &texture).map(|_| ()),
        Device::open_with_gl(&DeviceChoice::Default).map(|_| ()),
    ];
    for error in errors.map(Result::unwrap_err) {
        assert!(matches!(error, Error::Gl(GlError::NoContext)), "{error}");
        assert!(error.to_string().contains("current"), "{error}");
    }
    opengl.make_current(true);
    renderer.render_into_texture(&camera, &Settings::default(), Background::Transparent, &texture).unwrap();
}

#[test]
fn a_loader_that_finds_nothing_is_refused() {
    let _opengl = OpenGl::new();
    // SAFETY: null is allowed.
    let error = unsafe { GlFunctions::load(|_| std::ptr::null()) }.map(|_| ()).unwrap_err();
    assert!(matches!(&error, GlError::Function { function } if function.starts_with("gl")), "{error}");
}
