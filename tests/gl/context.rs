//! A program with its own OpenGL context.

use crate::common::{self, random_volume, smooth_transfer};
use glam::DVec3;
use glow::HasContext;
use glutin::api::egl::{device::Device as EglDevice, display::Display};
use glutin::config::{ConfigSurfaceTypes, ConfigTemplateBuilder};
use glutin::context::{ContextApi, ContextAttributesBuilder, Version};
use glutin::prelude::*;
use layersplat::gl::{GlError, GlFunctions};
use layersplat::renderer::GlTexture;
use layersplat::settings::{Algorithm, LayerAxis};
use layersplat::{Background, Camera, Device, Renderer, Settings, TransferFunction, Viewport, Volume};
use std::ffi::{CStr, c_void};
use std::num::NonZeroU32;

/// Rows of 45 pixels have a 4-byte alignment only.
pub const SIZE: Viewport = Viewport { width: 45, height: 38 };

/// A context that is current in its creating thread.
pub struct OpenGl {
    pub functions: GlFunctions,
    pub gl: glow::Context,
    loader: Box<Loader>,
    make_current: Box<dyn Fn(bool)>,
}

type Loader = dyn Fn(&CStr) -> *const c_void;

impl OpenGl {
    /// An EGL context without a surface.
    pub fn new() -> Self {
        let device = EglDevice::query_devices().expect("EGL: scripts/gl installs Mesa's").next().expect("a device of EGL's");
        // SAFETY: no handle is passed.
        let display = unsafe { Display::with_device(&device, None) }.unwrap();
        let template = ConfigTemplateBuilder::new().with_surface_type(ConfigSurfaceTypes::empty()).build();
        // SAFETY: the template names no window.
        let config = unsafe { display.find_configs(template) }.unwrap().next().unwrap();
        let api = ContextApi::OpenGl(Some(Version::new(3, 3)));
        let attributes = ContextAttributesBuilder::new().with_context_api(api).build(None);
        // SAFETY: the attributes name no window.
        let context = unsafe { display.create_context(&config, &attributes) }.unwrap();
        let context = context.make_current_surfaceless().unwrap();
        let make_current = move |current| match current {
            true => context.make_current_surfaceless().unwrap(),
            false => context.make_not_current_in_place().unwrap(),
        };
        Self::of(Box::new(move |name| display.get_proc_address(name)), Box::new(make_current))
    }

    /// A context by its function loader; it must be current.
    pub fn of(loader: Box<Loader>, make_current: Box<dyn Fn(bool)>) -> Self {
        // SAFETY: the context is current.
        let gl = unsafe { glow::Context::from_loader_function_cstr(&loader) };
        // SAFETY: as above.
        let functions = unsafe { GlFunctions::load(&loader) }.unwrap();
        Self { functions, gl, loader, make_current }
    }

    /// Loads the OpenGL functions.
    pub fn load(&self) -> Result<GlFunctions, GlError> {
        // SAFETY: the loader is that of the context.
        unsafe { GlFunctions::load(&self.loader) }
    }

    /// Makes the context current, or no context.
    pub fn make_current(&self, current: bool) {
        (self.make_current)(current);
    }

    /// Name of the renderer.
    pub fn name(&self) -> String {
        // SAFETY: the context is current.
        unsafe { self.gl.get_parameter_string(glow::RENDERER) }
    }

    /// A texture with some storage, not bound.
    pub fn texture(&self, target: u32, format: u32, size: Viewport) -> NonZeroU32 {
        let [width, height] = [size.width, size.height].map(|n| n as i32);
        // SAFETY: the context is current.
        unsafe {
            let texture = self.gl.create_texture().unwrap();
            self.gl.bind_texture(target, Some(texture));
            self.gl.tex_parameter_i32(target, glow::TEXTURE_MIN_FILTER, glow::LINEAR as i32);
            // OpenGL 3.3 has no glTexStorage2D.
            let kind = if format == glow::RGBA8 { glow::UNSIGNED_BYTE } else { glow::FLOAT };
            let faces = if target == glow::TEXTURE_CUBE_MAP { 0..6 } else { 0..1 };
            for face in faces {
                let target = if target == glow::TEXTURE_CUBE_MAP { glow::TEXTURE_CUBE_MAP_POSITIVE_X + face } else { target };
                self.gl.tex_image_2d(
                    target,
                    0,
                    format as i32,
                    width,
                    height,
                    0,
                    glow::RGBA,
                    kind,
                    glow::PixelUnpackData::Slice(None),
                );
            }
            self.gl.bind_texture(target, None);
            texture.0
        }
    }

    /// A texture for pictures.
    pub fn picture(&self, size: Viewport) -> NonZeroU32 {
        self.texture(glow::TEXTURE_2D, glow::RGBA8, size)
    }

    /// Content of a texture, row by row.
    pub fn read(&self, texture: NonZeroU32, size: Viewport) -> Vec<u8> {
        let [width, height] = [size.width, size.height].map(|n| n as i32);
        let mut pixels = vec![0; 4 * size.pixels()];
        // SAFETY: the context is current, and the buffer has as many pixels.
        unsafe {
            let frame = self.gl.create_framebuffer().unwrap();
            self.gl.bind_framebuffer(glow::FRAMEBUFFER, Some(frame));
            let texture = Some(glow::NativeTexture(texture));
            self.gl.framebuffer_texture_2d(glow::FRAMEBUFFER, glow::COLOR_ATTACHMENT0, glow::TEXTURE_2D, texture, 0);
            assert_eq!(self.gl.check_framebuffer_status(glow::FRAMEBUFFER), glow::FRAMEBUFFER_COMPLETE);
            let onto = glow::PixelPackData::Slice(Some(&mut pixels));
            self.gl.read_pixels(0, 0, width, height, glow::RGBA, glow::UNSIGNED_BYTE, onto);
            self.gl.bind_framebuffer(glow::FRAMEBUFFER, None);
            self.gl.delete_framebuffer(frame);
            assert_eq!(self.gl.get_error(), glow::NO_ERROR);
        }
        pixels
    }
}

/// A volume on a device, and its view.
pub fn scene(device: &Device) -> (Renderer, Camera) {
    let volume: Volume = random_volume([21, 18, 24], DVec3::new(1.0, 0.8, 1.1), 5);
    let camera = common::parallel(&volume, SIZE, 25.0, 15.0);
    let transfer: TransferFunction = smooth_transfer();
    (Renderer::new(device, &volume, &transfer).unwrap(), camera)
}

/// Asserts that textures receive the bits of `render_rgba8`, also with sheets, which read back their number of splats.
pub fn assert_same_bits(opengl: &OpenGl, device: &Device, renderer: &mut Renderer, camera: &Camera, shared: bool) {
    let name = opengl.picture(SIZE);
    let texture = GlTexture::new(device, &opengl.functions, name).unwrap();
    assert_eq!((texture.size(), texture.is_shared()), (SIZE, shared));
    for settings in [Settings::default(), Algorithm::AxisSheets { layer_axis: LayerAxis::Auto }.into()] {
        for background in [Background::Transparent, Background::Color([0.2, 0.5, 1.0])] {
            let (expected, _) = renderer.render_rgba8(camera, SIZE, &settings, background).unwrap();
            assert!(expected.chunks(4).any(|pixel| pixel[3] > 100) && expected.chunks(4).any(|pixel| pixel != &expected[..4]));
            assert!(opengl.read(name, SIZE) != expected, "the previous picture must differ");
            renderer.render_into_texture(camera, &settings, background, &texture).unwrap();
            assert!(opengl.read(name, SIZE) == expected, "{settings:?} {background:?}");
        }
    }
}
