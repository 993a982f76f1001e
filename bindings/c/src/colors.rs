//! Volumes of colours and of labels.

use crate::boundary::{Failure, Out, borrowed, free, guard, text, values};
use crate::channels::color_from;
use crate::renderer::with_whole;
use crate::volume::checked;
use crate::{ColorOpacityChoice, Device, Grid, Renderer, Status, Transfer};
use layersplat::renderer::{ColorOpacity, UploadedColors, UploadedVolume};
use layersplat::volume::{Label as OurLabel, LabelChange, LabelTable, Labels, Storage, VoxelType};
use layersplat::{OpenOptions, TransferFunction, Volume};
use std::ffi::{c_char, c_void};
use std::path::Path;

/// A volume of colours or labels on a device. It is immutable, and several threads may use it at the same time.
pub struct Colors(UploadedColors);

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

/// A label.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Label {
    /// Number of its voxels, at least 1; 0 is the background.
    pub id: u32,
    /// Red, green and blue, 0 to 1.
    pub color: [f64; 3],
    /// Opacity per smallest spacing, 0 to 1; 0 hides it.
    pub opacity: f64,
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
        let full = match voxel_type {
            VoxelType::Uint8 => 255.0,
            VoxelType::Uint16 => 65535.0,
            VoxelType::Float32 => 1.0,
            other => return Err(Failure::invalid(format!("voxel_type is {other}: colours are uint8, uint16 or float32"))),
        };
        let default = if count == 4 { ColorOpacityChoice::Alpha } else { ColorOpacityChoice::Luminance };
        let default = ColorOptions { opacity: default as i32, background: [0.0; 3], transfer: std::ptr::null() };
        let (opacity, transfer) = unsafe { options.as_ref().unwrap_or(&default).checked(full) }?;
        let step = voxel_type.bytes();
        let [x, y, _] = grid.dims();
        let strides = [1, x, x * y].map(|voxels| (voxels * count * step) as isize);
        let component = |n: usize| {
            let storage = Storage::from_bytes(voxels, voxel_type).with_first(n * step).with_strides(strides);
            Volume::new("colours in memory", grid.clone(), storage)
        };
        let components: Vec<_> = (0..count).map(component).collect::<Result<_, _>>()?;
        out.set_handle(Colors(UploadedColors::new(&device.0, &components, opacity, &transfer)?));
        Ok(())
    })
}

/// Uploads labels, which are drawn as smooth surfaces. Voxels are ids, of LAYERSPLAT_VOXEL_TYPE_UINT8 or _UINT16, contiguous and x fastest;
/// `bytes` is the total size. Ids without a label are opaque, in a colour that depends on the id. To be freed by layersplat_colors_free().
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)] // Those of layersplat_volume_copy(), and three more.
pub unsafe extern "C" fn layersplat_labels_new(
    device: *const Device,
    voxels: *const c_void,
    bytes: usize,
    voxel_type: i32,
    grid: *const Grid,
    labels: *const Label,
    label_count: usize,
    colors: *mut *mut Colors,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(colors, "colors") }?;
        let device = unsafe { borrowed(device, "device") }?;
        let labels = unsafe { values(labels, label_count, "labels") }?;
        let (voxels, voxel_type, grid) = unsafe { checked(voxels, bytes, voxel_type, 1, grid) }?;
        if !matches!(voxel_type, VoxelType::Uint8 | VoxelType::Uint16) {
            return Err(Failure::invalid(format!("voxel_type is {voxel_type}: labels are uint8 or uint16")));
        }
        let label = |label: &Label| OurLabel { color: label.color, opacity: label.opacity, ..OurLabel::new(label.id) };
        let table = LabelTable::new(labels.iter().map(label))?;
        let ids = Volume::new("labels in memory", grid, Storage::from_bytes(voxels, voxel_type))?.with_background(0.0)?;
        let most = ids.range().1 as u32;
        let entry = |id: u32| {
            let label = table.get(id).cloned().unwrap_or_else(|| OurLabel::new(id));
            let [r, g, b] = label.color;
            [r, g, b, label.opacity]
        };
        let entries: Vec<_> = std::iter::once([0.0; 4]).chain((1..=most).map(entry)).collect();
        let uploaded = UploadedVolume::new(&device.0, &ids)?;
        out.set_handle(Colors(UploadedColors::from_labels(&[(&uploaded, &entries)])?));
        Ok(())
    })
}

/// Opens and uploads a file of labels: .seg.nrrd, NIfTI, OME-Zarr, or any volume of whole numbers up to 4294967295. Names and colours come from
/// the file `table`; null: from the volume's own metadata. `changes` are texts that change the table, such as 3,7-9:#ff0000:0.4 or liver:only:
/// colour, opacity, and show, hide, only or highlight. To be freed by layersplat_colors_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_labels_open(
    device: *const Device,
    source: *const c_char,
    table: *const c_char,
    changes: *const *const c_char,
    change_count: usize,
    colors: *mut *mut Colors,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(colors, "colors") }?;
        let device = unsafe { borrowed(device, "device") }?;
        let source = unsafe { text(source, "source") }?;
        let table = (!table.is_null()).then(|| unsafe { text(table, "table") }).transpose()?;
        let changes = unsafe { values(changes, change_count, "changes") }?;
        let change = |(n, &change): (usize, &*const c_char)| -> Result<LabelChange, Failure> {
            Ok(unsafe { text(change, &format!("change {n} of changes")) }?.parse()?)
        };
        let changes: Vec<LabelChange> = changes.iter().enumerate().map(change).collect::<Result<_, _>>()?;
        let mut labels = Labels::open(source, &OpenOptions::default(), table.map(Path::new))?;
        changes.iter().try_for_each(|change| labels.change(change))?;
        let upload = |layer: &layersplat::volume::LabelLayer| UploadedVolume::new(&device.0, &layer.indices(None)?);
        let uploaded = labels.layers().iter().map(upload).collect::<Result<Vec<_>, _>>()?;
        let palettes: Vec<_> = labels.layers().iter().map(|layer| layer.palette()).collect();
        let layers: Vec<_> = uploaded.iter().zip(palettes.iter().map(Vec::as_slice)).collect();
        out.set_handle(Colors(UploadedColors::from_labels(&layers)?));
        Ok(())
    })
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
