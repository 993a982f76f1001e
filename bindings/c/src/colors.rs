//! Volumes of colours, and renderers of colours and of labels.

use crate::boundary::{Failure, Out, borrowed, free, guard, text};
use crate::channels::color_from;
use crate::renderer::with_whole;
use crate::volume::checked;
use crate::{ColorOpacityChoice, Device, Grid, Renderer, Status, Transfer};
use layersplat::renderer::{ColorOpacity, UploadedColors};
use layersplat::volume::{ColorChannels, OpenOptions, Storage, VoxelType};
use layersplat::{TransferFunction, Volume};
use std::ffi::{c_char, c_void};

/// A volume of colours or labels on a device. It is immutable, and several threads may use it at the same time.
pub struct Colors(pub(crate) UploadedColors);

/// How colours become opaque.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ColorOptions {
    /// A layersplat_color_opacity.
    pub opacity: i32,
    /// The transparent colour of LAYERSPLAT_COLOR_OPACITY_BACKGROUND, 0 to 1.
    pub background: [f64; 3],
    /// Opacities by luminance or by the difference from the background, in units of the components; null: from 0 to 0.3.
    pub transfer: *const Transfer,
}

/// Largest opacity of colours without alpha: of the brightest, or of those that differ most from the background.
const OPACITY: f64 = 0.3;

impl ColorOptions {
    /// The opacities of colours whose components reach `full`.
    unsafe fn checked(&self, full: f64) -> Result<(ColorOpacity, TransferFunction), Failure> {
        let opacity = match ColorOpacityChoice::from_number(self.opacity)? {
            ColorOpacityChoice::Alpha => ColorOpacity::Alpha,
            ColorOpacityChoice::Luminance => ColorOpacity::Luminance,
            ColorOpacityChoice::Background => ColorOpacity::FromBackground(color_from(&self.background)?),
        };
        // SAFETY: upheld by the caller.
        let transfer = match unsafe { self.transfer.as_ref() } {
            Some(transfer) => transfer.0.clone(),
            None => TransferFunction::new("colors", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0), (full, OPACITY)])?,
        };
        Ok((opacity, transfer))
    }
}

/// Uploads colours. The voxels have `components` values each, red, green, blue and possibly alpha, contiguous and x fastest. `voxel_type` is a
/// layersplat_voxel_type: UINT8, UINT16, or FLOAT32 from 0 to 1; `bytes` is the total size. `options` may be null: alpha if there is one, else
/// luminance. Extinction times colour, and extinction, are interpolated, so transparent voxels do not bleed their colour. To be freed by
/// layersplat_colors_free().
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)] // Those of layersplat_volume_copy(), and three more.
pub unsafe extern "C" fn layersplat_colors_new(
    device: *const Device,
    voxels: *const c_void,
    bytes: usize,
    voxel_type: i32,
    components: i32,
    grid: *const Grid,
    options: *const ColorOptions,
    colors: *mut *mut Colors,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(colors, "colors") }?;
        let device = unsafe { borrowed(device, "device") }?;
        let count = match components {
            3 => 3,
            4 => 4,
            other => return Err(Failure::invalid(format!("components is {other}: expected 3, or 4 with alpha"))),
        };
        let (voxels, voxel_type, grid) = unsafe { checked(voxels, bytes, voxel_type, count, grid) }?;
        let step = voxel_type.bytes();
        let [x, y, _] = grid.dims();
        let strides = [1, x, x * y].map(|voxels| (voxels * count * step) as isize);
        let component = |n: usize| {
            let storage = Storage::from_bytes(voxels, voxel_type).with_first(n * step).with_strides(strides);
            Volume::new("colours in memory", grid.clone(), storage)
        };
        let components: Vec<_> = (0..count).map(component).collect::<Result<_, _>>()?;
        out.set_handle(unsafe { uploaded(device, &components, options) }?);
        Ok(())
    })
}

/// Opens and uploads the colours of a file: red, green, blue and possibly alpha, its first three or four channels. Files of colours are PNG, TIFF
/// (RGB), NRRD, NIfTI (RGB24, RGBA32), DICOM and VTK; any other file of three channels or more is drawn so, too. `options` as in
/// layersplat_colors_new(). To be freed by layersplat_colors_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_colors_open(
    device: *const Device,
    source: *const c_char,
    options: *const ColorOptions,
    colors: *mut *mut Colors,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(colors, "colors") }?;
        let device = unsafe { borrowed(device, "device") }?;
        let source = unsafe { text(source, "source") }?;
        let components = ColorChannels::of_file(source, &OpenOptions::default())?.open(source, &OpenOptions::default())?;
        out.set_handle(unsafe { uploaded(device, &components, options) }?);
        Ok(())
    })
}

/// Uploads three or four components.
unsafe fn uploaded(device: &Device, components: &[Volume], options: *const ColorOptions) -> Result<Colors, Failure> {
    let full = match components[0].voxel_type() {
        VoxelType::Uint8 => 255.0,
        VoxelType::Uint16 => 65535.0,
        VoxelType::Float32 => 1.0,
        other => return Err(Failure::invalid(format!("voxel_type is {other}: colours are uint8, uint16 or float32"))),
    };
    let default = if components.len() == 4 { ColorOpacityChoice::Alpha } else { ColorOpacityChoice::Luminance };
    let default = ColorOptions { opacity: default as i32, background: [0.0; 3], transfer: std::ptr::null() };
    // SAFETY: upheld by the caller.
    let (opacity, transfer) = unsafe { options.as_ref().unwrap_or(&default).checked(full) }?;
    Ok(Colors(UploadedColors::new(&device.0, components, opacity, &transfer)?))
}

/// The grid of colours or labels, for layersplat_camera_fit_grid().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_colors_grid(colors: *const Colors, grid: *mut Grid) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let colors = unsafe { borrowed(colors, "colors") }?;
        unsafe { Out::new(grid, "grid") }?.set(Grid::from_library(colors.0.description().grid()));
        Ok(())
    })
}

/// Frees colours or labels. Renderers that draw them stay usable. Null is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_colors_free(colors: *mut Colors) {
    // SAFETY: upheld by the caller.
    unsafe { free(colors) }
}

/// Creates a renderer of colours or labels, on their device. They are drawn by layers, with LAYERSPLAT_BLEND_COMPOSITE. To be freed by
/// layersplat_renderer_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_from_colors(colors: *const Colors, renderer: *mut *mut Renderer) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(renderer, "renderer") }?;
        let colors = unsafe { borrowed(colors, "colors") }?;
        out.set_handle(Renderer::new(Box::new(layersplat::Renderer::from_colors(&colors.0)?)));
        Ok(())
    })
}

/// Replaces all that a renderer draws by colours or labels, effective from the next frame. Renderers that stream their volume return
/// LAYERSPLAT_STATUS_NEEDS_WHOLE_VOLUME.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_set_colors(renderer: *mut Renderer, colors: *const Colors) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let colors = unsafe { borrowed(colors, "colors") }?;
        let set = |renderer: &mut layersplat::Renderer| Ok(renderer.set_colors(&colors.0)?);
        unsafe { with_whole(renderer, "layersplat_renderer_set_colors", set) }
    })
}
