//! Pictures in host memory and in files.

use crate::boundary::{Failure, borrowed, copy, guard, require_capacity, text, values};
use crate::renderer::{self, AnyRenderer};
use crate::{Camera, Renderer, Settings, Status, settings};
use layersplat::{Background, Frame, Viewport};
use std::ffi::c_char;

/// Only distributed renderers return no picture, and the C API has none.
const ONE_PROCESS: &str = "a single-process renderer returns the picture";

/// The checked arguments that all render calls share.
pub(crate) struct View {
    pub camera: layersplat::Camera,
    pub viewport: Viewport,
    pub settings: layersplat::Settings,
}

impl View {
    pub unsafe fn new(camera: *const Camera, width: u32, height: u32, settings: *const Settings) -> Result<Self, Failure> {
        // SAFETY: upheld by the caller, here and below.
        let camera = unsafe { borrowed(camera, "camera") }?.checked()?;
        let settings = unsafe { settings::checked(settings) }?;
        Ok(Self { camera, viewport: Viewport::new(width, height)?, settings })
    }
}

/// A background of three floats; null is transparent.
pub(crate) unsafe fn background(color: *const f32) -> Result<Background, Failure> {
    // SAFETY: upheld by the caller: a non-null pointer points to three floats.
    match unsafe { color.cast::<[f32; 3]>().as_ref() } {
        Some(color) if color.iter().all(|c| (0.0..=1.0).contains(c)) => Ok(Background::Color(*color)),
        Some(color) => Err(Failure::invalid(format!("background is {color:?}: expected three numbers from 0 to 1"))),
        None => Ok(Background::Transparent),
    }
}

/// Renders a picture of `width` x `height` pixels with 8 bits per channel: red, green, blue, alpha, contiguous, row by row from the
/// top. `background` is an opaque colour (three floats, 0 to 1), or null for straight alpha. `bytes` is the size of `pixels`: at
/// least 4 * width * height. Null settings are those of the standard quality. The call blocks until the picture is complete.
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
        // SAFETY: upheld by the caller, here and below.
        let view = unsafe { View::new(camera, width, height, settings) }?;
        require_capacity(4 * view.viewport.pixels(), pixels, bytes, "pixels")?;
        let background = unsafe { self::background(background) }?;
        let draw = |renderer: &mut AnyRenderer| {
            Ok(renderer.render_rgba8(&view.camera, view.viewport, &view.settings, background)?.0.expect(ONE_PROCESS))
        };
        let picture = unsafe { renderer::with(renderer, draw) }?;
        unsafe { copy(&picture, pixels, bytes, "pixels") }
    })
}

/// Renders a picture of floats: premultiplied red, green, blue, and alpha, without a background, contiguous, row by row from the top.
/// `floats` is the number of elements of `pixels`: at least 4 * width * height. The other arguments are those of
/// layersplat_render_rgba8().
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
        // SAFETY: upheld by the caller, here and below.
        let view = unsafe { View::new(camera, width, height, settings) }?;
        require_capacity(4 * view.viewport.pixels(), pixels, floats, "pixels")?;
        let draw =
            |renderer: &mut AnyRenderer| Ok(renderer.render(&view.camera, view.viewport, &view.settings)?.0.expect(ONE_PROCESS));
        let frame = unsafe { renderer::with(renderer, draw) }?;
        unsafe { copy(frame.pixels().as_flattened(), pixels, floats, "pixels") }
    })
}

/// Renders depth maps: distances from the eye along the view direction in world units, row by row from the top, infinite where
/// nothing is visible. `first` is the first visible depth: where the accumulated opacity reaches 1/256, or at the iso-surface.
/// `mean` is the mean depth weighted by opacity. `floats` is the number of elements of each: at least width * height. Depths are
/// always computed by ray casting. Only the blend modes composite and iso are supported. The other arguments are those of
/// layersplat_render_rgba8().
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
        // SAFETY: upheld by the caller, here and below.
        let view = unsafe { View::new(camera, width, height, settings) }?;
        require_capacity(view.viewport.pixels(), first, floats, "first")?;
        require_capacity(view.viewport.pixels(), mean, floats, "mean")?;
        let find = |renderer: &mut AnyRenderer| Ok(renderer.depths(&view.camera, view.viewport, &view.settings)?);
        let depths = unsafe { renderer::with(renderer, find) }?;
        unsafe { copy(depths.first(), first, floats, "first") }?;
        unsafe { copy(depths.mean(), mean, floats, "mean") }
    })
}

/// Writes a picture of layersplat_render_floats() to a file: .png, .jpg, .tif or .webp (8 bit), .exr or .npy (float32). `settings`: those of
/// the picture, whose exposure, tone curve and gamma go into files of 8 bit; null: those of the default, which has none.
/// `background` is an opaque colour (three floats, 0 to 1), or null to keep alpha. `floats` is 4 * width * height. The file is
/// written completely or not at all.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_save(
    pixels: *const f32,
    floats: usize,
    width: u32,
    height: u32,
    settings: *const Settings,
    background: *const f32,
    path: *const c_char,
) -> Status {
    guard(|| {
        let viewport = Viewport::new(width, height)?;
        let expected = 4 * viewport.pixels();
        if floats != expected {
            return Err(Failure::invalid(format!("a picture of {width}x{height} has {expected} floats, but floats is {floats}")));
        }
        // SAFETY: upheld by the caller, here and below.
        let pixels = unsafe { values(pixels, floats, "pixels") }?;
        let path = unsafe { text(path, "path") }?;
        let background = unsafe { self::background(background) }?;
        let curve = unsafe { settings::checked(settings) }?.curve();
        Frame::new(viewport, pixels.as_chunks::<4>().0.to_vec()).with_curve(curve).save(path, Some(background))?;
        Ok(())
    })
}
