//! Pictures in the host's memory, and in files.

use crate::border::{Failure, borrowed, copy, guard, require_room, text, values};
use crate::renderer::{self, AnyRenderer};
use crate::{Camera, Renderer, Settings, Status, settings};
use layersplat::{Background, Frame, Viewport};
use std::ffi::c_char;

/// Renderers of this library run in one process, which has every picture.
const ONE_PROCESS: &str = "a renderer of one process has the picture";

/// What all pictures are made of.
pub(crate) struct View {
    pub camera: layersplat::Camera,
    pub viewport: Viewport,
    pub settings: layersplat::Settings,
}

impl View {
    pub unsafe fn new(camera: *const Camera, width: u32, height: u32, settings: *const Settings) -> Result<Self, Failure> {
        // SAFETY: the caller's promise, and below.
        let camera = unsafe { borrowed(camera, "camera") }?.checked()?;
        let settings = unsafe { settings::checked(settings) }?;
        Ok(Self { camera, viewport: Viewport::new(width, height)?, settings })
    }
}

/// An opaque colour; null is none.
pub(crate) unsafe fn background(color: *const f32) -> Result<Background, Failure> {
    // SAFETY: the caller's promise: what is not null are three floats.
    match unsafe { color.cast::<[f32; 3]>().as_ref() } {
        Some(color) if color.iter().all(|c| (0.0..=1.0).contains(c)) => Ok(Background::Color(*color)),
        Some(color) => Err(Failure::invalid(format!("background is {color:?}: expected three numbers from 0 to 1"))),
        None => Ok(Background::Transparent),
    }
}

/// Renders a picture of `width` x `height` pixels of 8 bits: red, green, blue, alpha; row by row from the top, without gaps, over an opaque
/// colour (three floats, 0 to 1), or where `background` is null, with straight alpha. `bytes` are those that `pixels` has room for:
/// 4 * width * height or more. Null settings are those of the standard quality. It returns when the picture is there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_render_rgba8(
    renderer: *mut Renderer,
    camera: *const Camera,
    width: u32,
    height: u32,
    settings: *const Settings,
    background: *const f32,
    pixels: *mut u8,
    bytes: usize,
) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let view = unsafe { View::new(camera, width, height, settings) }?;
        require_room(4 * view.viewport.pixels(), pixels, bytes, "pixels")?;
        let background = unsafe { self::background(background) }?;
        let draw = |renderer: &mut AnyRenderer| {
            Ok(renderer.render_rgba8(&view.camera, view.viewport, &view.settings, background)?.0.expect(ONE_PROCESS))
        };
        let picture = unsafe { renderer::with(renderer, draw) }?;
        unsafe { copy(&picture, pixels, bytes, "pixels") }
    })
}

/// Renders a picture of floats: red, green, blue, premultiplied, and alpha, without a background; row by row from the top, without gaps.
/// `floats` are those that `pixels` has room for: 4 * width * height or more. The rest is as in layersplat_render_rgba8().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_render_floats(
    renderer: *mut Renderer,
    camera: *const Camera,
    width: u32,
    height: u32,
    settings: *const Settings,
    pixels: *mut f32,
    floats: usize,
) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let view = unsafe { View::new(camera, width, height, settings) }?;
        require_room(4 * view.viewport.pixels(), pixels, floats, "pixels")?;
        let draw =
            |renderer: &mut AnyRenderer| Ok(renderer.render(&view.camera, view.viewport, &view.settings)?.0.expect(ONE_PROCESS));
        let frame = unsafe { renderer::with(renderer, draw) }?;
        unsafe { copy(frame.pixels().as_flattened(), pixels, floats, "pixels") }
    })
}

/// How far away is what a picture shows: distances from the eye along the view's direction, in world units, row by row from the top, infinite
/// where nothing is seen. `first`: where something is seen first, where 1/256 of the light is stopped or at the iso-surface; `mean`: of all
/// that is seen, weighted by opacity. Each has room for `floats` of them: width * height or more. Found by ray casting, whatever draws
/// pictures; refused for blend modes other than composite and iso. The rest is as in layersplat_render_rgba8().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_render_depths(
    renderer: *mut Renderer,
    camera: *const Camera,
    width: u32,
    height: u32,
    settings: *const Settings,
    first: *mut f32,
    mean: *mut f32,
    floats: usize,
) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let view = unsafe { View::new(camera, width, height, settings) }?;
        require_room(view.viewport.pixels(), first, floats, "first")?;
        require_room(view.viewport.pixels(), mean, floats, "mean")?;
        let find = |renderer: &mut AnyRenderer| Ok(renderer.depths(&view.camera, view.viewport, &view.settings)?);
        let depths = unsafe { renderer::with(renderer, find) }?;
        unsafe { copy(depths.first(), first, floats, "first") }?;
        unsafe { copy(depths.mean(), mean, floats, "mean") }
    })
}

/// Writes a picture of floats, as layersplat_render_floats() makes them, to a file: .png or .jpg (8 bit), .exr or .npy (float32),
/// over an opaque colour (three floats, 0 to 1), or where `background` is null, with its alpha. `floats` is 4 * width * height. The file
/// is written whole or not at all.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_save(
    pixels: *const f32,
    floats: usize,
    width: u32,
    height: u32,
    background: *const f32,
    path: *const c_char,
) -> Status {
    guard(|| {
        let viewport = Viewport::new(width, height)?;
        let expected = 4 * viewport.pixels();
        if floats != expected {
            return Err(Failure::invalid(format!("a picture of {width}x{height} has {expected} floats, and floats is {floats}")));
        }
        // SAFETY: the caller's promise, and below.
        let pixels = unsafe { values(pixels, floats, "pixels") }?;
        let path = unsafe { text(path, "path") }?;
        let background = unsafe { self::background(background) }?;
        Frame::new(viewport, pixels.as_chunks::<4>().0.to_vec()).save(path, Some(background))?;
        Ok(())
    })
}
