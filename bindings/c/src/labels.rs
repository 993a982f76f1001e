//! Volumes of labels, and scans in the colours of labels.

use crate::boundary::{Failure, Out, borrowed, free, guard, text, values};
use crate::choices::chosen;
use crate::renderer::with_whole;
use crate::volume::checked;
use crate::{Colors, Device, Grid, Renderer, Status};
use layersplat::OpenOptions;
use layersplat::renderer::{self, UploadedColors, UploadedVolume};
use layersplat::volume::{Label as OurLabel, LabelChange, LabelLayer, LabelTable, Labels, ScalarType, VoxelType};
use std::ffi::{c_char, c_void};
use std::path::Path;

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

/// Colours of labels on a device, for layersplat_renderer_set_label_colors(). It is immutable, and several threads may use it at the same time.
pub struct LabelColors(renderer::LabelColors);

/// Labels of the caller's voxels, which must stay while they are used.
///
/// # Errors
/// Null pointers, voxels of other types, and labels that are none.
unsafe fn labels_in_memory(
    voxels: *const c_void,
    bytes: usize,
    voxel_type: i32,
    grid: *const Grid,
    labels: *const Label,
    label_count: usize,
) -> Result<Labels, Failure> {
    // SAFETY: upheld by the caller, here and below.
    let labels = unsafe { values(labels, label_count, "labels") }?;
    let (voxels, voxel_type, grid) = unsafe { checked(voxels, bytes, voxel_type, 1, grid) }?;
    let scalar = match voxel_type {
        VoxelType::Uint8 => ScalarType::Uint8,
        VoxelType::Uint16 => ScalarType::Uint16,
        other => return Err(Failure::invalid(format!("voxel_type is {other}: labels are uint8 or uint16"))),
    };
    let label = |label: &Label| OurLabel { color: label.color, opacity: label.opacity, ..OurLabel::new(label.id) };
    let table = LabelTable::new(labels.iter().map(label))?;
    Ok(Labels::from_numbers("labels in memory", grid, voxels, scalar, table)?)
}

/// Labels of a file, after changes.
///
/// # Errors
/// Null pointers, and those of the library.
unsafe fn labels_of_file(
    source: *const c_char,
    table: *const c_char,
    changes: *const *const c_char,
    change_count: usize,
) -> Result<Labels, Failure> {
    // SAFETY: upheld by the caller, here and below.
    let source = unsafe { text(source, "source") }?;
    let table = (!table.is_null()).then(|| unsafe { text(table, "table") }).transpose()?;
    let changes = unsafe { values(changes, change_count, "changes") }?;
    let change = |(n, &change): (usize, &*const c_char)| -> Result<LabelChange, Failure> {
        Ok(unsafe { text(change, &format!("change {n} of changes")) }?.parse()?)
    };
    let changes: Vec<LabelChange> = changes.iter().enumerate().map(change).collect::<Result<_, _>>()?;
    let mut labels = Labels::open(source, &OpenOptions::default(), table.map(Path::new))?;
    changes.iter().try_for_each(|change| labels.change(change))?;
    Ok(labels)
}

/// Uploads labels that are drawn by themselves.
fn uploaded(device: &Device, labels: &Labels) -> Result<Colors, Failure> {
    let upload = |layer: &LabelLayer| UploadedVolume::new(&device.0, &layer.indices(None)?);
    let uploaded = labels.layers().iter().map(upload).collect::<Result<Vec<_>, _>>()?;
    let palettes: Vec<_> = labels.layers().iter().map(LabelLayer::palette).collect();
    let layers: Vec<_> = uploaded.iter().zip(palettes.iter().map(Vec::as_slice)).collect();
    Ok(Colors(UploadedColors::from_labels(&layers, labels.surfaces())?))
}

/// Uploads labels, which are drawn with `surfaces`, a layersplat_label_surfaces. Voxels are ids, of LAYERSPLAT_VOXEL_TYPE_UINT8 or _UINT16, contiguous and x fastest;
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
    surfaces: i32,
    colors: *mut *mut Colors,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(colors, "colors") }?;
        let device = unsafe { borrowed(device, "device") }?;
        let surfaces = chosen(surfaces)?;
        let labels = unsafe { labels_in_memory(voxels, bytes, voxel_type, grid, labels, label_count) }?;
        out.set_handle(uploaded(device, &labels.with_surfaces(surfaces))?);
        Ok(())
    })
}

/// Opens and uploads a file of labels: .seg.nrrd, NIfTI, OME-Zarr, or any volume of whole numbers up to 4294967295. Names and colours come from
/// the file `table`; null: from the volume's own metadata. `changes` are texts that change the table, such as 3,7-9:#ff0000:0.4 or liver:only:
/// colour, opacity, and show, hide, only or highlight. `surfaces`: as for layersplat_labels_new(). To be freed by layersplat_colors_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_labels_open(
    device: *const Device,
    source: *const c_char,
    table: *const c_char,
    changes: *const *const c_char,
    change_count: usize,
    surfaces: i32,
    colors: *mut *mut Colors,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(colors, "colors") }?;
        let device = unsafe { borrowed(device, "device") }?;
        let surfaces = chosen(surfaces)?;
        let labels = unsafe { labels_of_file(source, table, changes, change_count) }?;
        out.set_handle(uploaded(device, &labels.with_surfaces(surfaces))?);
        Ok(())
    })
}

/// Uploads the colours of labels, which a volume is drawn in: one or two bytes per voxel. The arguments are those of layersplat_labels_new(),
/// without surfaces. To be freed by layersplat_label_colors_free().
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)] // Those of layersplat_labels_new().
pub unsafe extern "C" fn layersplat_label_colors_new(
    device: *const Device,
    voxels: *const c_void,
    bytes: usize,
    voxel_type: i32,
    grid: *const Grid,
    labels: *const Label,
    label_count: usize,
    colors: *mut *mut LabelColors,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(colors, "colors") }?;
        let device = unsafe { borrowed(device, "device") }?;
        let labels = unsafe { labels_in_memory(voxels, bytes, voxel_type, grid, labels, label_count) }?;
        out.set_handle(LabelColors(renderer::LabelColors::from_labels(&device.0, &labels)?));
        Ok(())
    })
}

/// Opens a file of labels and uploads their colours, which a volume is drawn in. The arguments are those of layersplat_labels_open(),
/// without surfaces. To be freed by layersplat_label_colors_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_label_colors_open(
    device: *const Device,
    source: *const c_char,
    table: *const c_char,
    changes: *const *const c_char,
    change_count: usize,
    colors: *mut *mut LabelColors,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(colors, "colors") }?;
        let device = unsafe { borrowed(device, "device") }?;
        let labels = unsafe { labels_of_file(source, table, changes, change_count) }?;
        out.set_handle(LabelColors(renderer::LabelColors::from_labels(&device.0, &labels)?));
        Ok(())
    })
}

/// Frees colours of labels. Renderers that draw in them stay usable. Null is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_label_colors_free(colors: *mut LabelColors) {
    // SAFETY: upheld by the caller.
    unsafe { free(colors) }
}

/// Draws the volume of a renderer in the colours of labels, effective from the next frame; null: in its own again. Its opacities stay. The
/// colour C of the volume becomes (1 - w) C + w L where a label has the colour L and the opacity w, before lighting. Labels of the volume's size
/// at unit spacing and the origin lie where the volume does; those outside the volume return LAYERSPLAT_STATUS_FILE.
/// Pre-integrated layers and cast rays have them, with LAYERSPLAT_BLEND_COMPOSITE and _ISO; other frames, slices, and frames of several
/// channels or of colours return LAYERSPLAT_STATUS_INVALID_ARGUMENT. Renderers that stream their volume return
/// LAYERSPLAT_STATUS_NEEDS_WHOLE_VOLUME.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_set_label_colors(renderer: *mut Renderer, colors: *const LabelColors) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let colors = unsafe { colors.as_ref() }.map(|colors| &colors.0);
        let set = |renderer: &mut layersplat::Renderer| Ok(renderer.set_label_colors(colors)?);
        unsafe { with_whole(renderer, "layersplat_renderer_set_label_colors", set) }
    })
}
