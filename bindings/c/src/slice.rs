//! Slices.

use crate::boundary::{Failure, Out, borrowed, copy, guard, require_capacity};
use crate::choices::{chosen, chosen_or_default};
use crate::renderer::{self, AnyRenderer};
use crate::{Renderer, Status, Volume};
use layersplat::glam::DVec3;
use layersplat::slice::{self, SliceAxis};
use layersplat::{Kernel, Viewport};

/// A rectangle of a plane through a volume, in world coordinates. Fill it in, or use layersplat_slice_at() or
/// layersplat_slice_facing().
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slice {
    /// The point at the centre of the picture.
    pub centre: [f64; 3],
    /// Direction that points right in the picture. Its length does not matter.
    pub right: [f64; 3],
    /// Any vector that points up in the picture.
    pub up: [f64; 3],
    /// Half the height of the picture in world units.
    pub scale: f64,
}

/// Colours of a slice: a window of grey, or those of the renderer's transfer function.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SliceColors {
    /// Value shown as middle grey.
    pub window_level: f64,
    /// Width of the window in data values: black below it, white above it. 0: colours of the transfer function.
    pub window_width: f64,
    /// Without a window: opacity of a layer this many unit distances thick. 0: opaque wherever there is any opacity.
    pub thickness: f64,
}

impl Slice {
    fn checked(&self) -> Result<slice::Slice, Failure> {
        let [centre, right, up] = [self.centre, self.right, self.up].map(DVec3::from_array);
        let slice = slice::Slice { centre, right, up, scale: self.scale };
        slice.basis()?;
        Ok(slice)
    }

    fn from_library(slice: &slice::Slice) -> Self {
        let [centre, right, up] = [slice.centre, slice.right, slice.up].map(|v| v.to_array());
        Self { centre, right, up, scale: slice.scale }
    }
}

impl SliceColors {
    fn checked(&self) -> Result<slice::SliceColors, Failure> {
        let Self { window_level: level, window_width: width, thickness } = *self;
        let colors = match (width, thickness) {
            (0.0, 0.0) => slice::SliceColors::TRANSFER,
            (0.0, thickness) => slice::SliceColors::Transfer { thickness },
            (width, _) => slice::SliceColors::Window { level, width },
        };
        colors.check()?;
        Ok(colors)
    }
}

fn kernel(number: i32) -> Result<Kernel, Failure> {
    Ok(chosen_or_default(number)?.unwrap_or(Kernel::Linear))
}

/// The slice perpendicular to an axis (a layersplat_slice_axis). `at`: for x, y and z the number of a slice of voxels, or any number
/// between two; for axial, coronal and sagittal the world coordinate along the axis. NaN: the middle. The slice shows the whole volume.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_slice_at(
    volume: *const Volume,
    axis: i32,
    at: f64,
    width: u32,
    height: u32,
    slice: *mut Slice,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::new(slice, "slice") }?;
        let grid = unsafe { borrowed(volume, "volume") }?.0.grid();
        let axis: SliceAxis = chosen(axis)?;
        let (lo, hi) = axis.range(grid)?;
        let at = if at.is_nan() { (lo + hi) / 2.0 } else { at };
        out.set(Slice::from_library(&slice::Slice::at(grid, axis, at, Viewport::new(width, height)?)?));
        Ok(())
    })
}

/// The slice through a world point (three numbers), seen from where `normal` points; `up` points up as far as possible. It shows the
/// whole section through the volume.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_slice_facing(
    volume: *const Volume,
    point: *const f64,
    normal: *const f64,
    up: *const f64,
    width: u32,
    height: u32,
    slice: *mut Slice,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below: each of them points to three numbers.
        let out = unsafe { Out::new(slice, "slice") }?;
        let grid = unsafe { borrowed(volume, "volume") }?.0.grid();
        let vector = |pointer: *const f64, name| unsafe { borrowed(pointer.cast::<[f64; 3]>(), name) };
        let [point, normal, up] =
            [vector(point, "point")?, vector(normal, "normal")?, vector(up, "up")?].map(|v| DVec3::from_array(*v));
        out.set(Slice::from_library(&slice::Slice::facing(grid, point, normal, up, Viewport::new(width, height)?)?));
        Ok(())
    })
}

/// Draws a slice as floats: premultiplied red, green, blue, and alpha, transparent outside the volume, contiguous, row by row from the
/// top. `kernel` is a layersplat_kernel; automatic is linear. Null colours are those of the transfer function, opaque. `floats` is the
/// number of elements of `pixels`: at least 4 * width * height. The call blocks until the picture is complete. The renderer must hold
/// the whole volume.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_render_slice(
    renderer: *mut Renderer,
    slice: *const Slice,
    width: u32,
    height: u32,
    kernel: i32,
    colors: *const SliceColors,
    pixels: *mut f32,
    floats: usize,
) -> Status {
    guard(|| {
        let viewport = Viewport::new(width, height)?;
        require_capacity(4 * viewport.pixels(), pixels, floats, "pixels")?;
        // SAFETY: upheld by the caller, here and below.
        let slice = unsafe { borrowed(slice, "slice") }?.checked()?;
        let colors = unsafe { colors.as_ref() }.map_or(Ok(slice::SliceColors::TRANSFER), SliceColors::checked)?;
        let kernel = self::kernel(kernel)?;
        let draw = |ours: &mut AnyRenderer| {
            Ok(ours.require_whole("layersplat_render_slice")?.slice(&slice, viewport, kernel, colors)?)
        };
        let frame = unsafe { renderer::with(renderer, draw) }?;
        unsafe { copy(frame.pixels().as_flattened(), pixels, floats, "pixels") }
    })
}

/// The data values of a slice, one per pixel, NaN outside the volume. `floats` is the number of elements of `values`: at least
/// width * height. The other arguments are those of layersplat_render_slice().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_slice_values(
    renderer: *mut Renderer,
    slice: *const Slice,
    width: u32,
    height: u32,
    kernel: i32,
    values: *mut f32,
    floats: usize,
) -> Status {
    guard(|| {
        let viewport = Viewport::new(width, height)?;
        require_capacity(viewport.pixels(), values, floats, "values")?;
        // SAFETY: upheld by the caller, here and below.
        let slice = unsafe { borrowed(slice, "slice") }?.checked()?;
        let kernel = self::kernel(kernel)?;
        let find =
            |ours: &mut AnyRenderer| Ok(ours.require_whole("layersplat_slice_values")?.slice_values(&slice, viewport, kernel)?);
        let found = unsafe { renderer::with(renderer, find) }?;
        unsafe { copy(found.values(), values, floats, "values") }
    })
}
