//! Transfer functions.

use crate::boundary::{Out, borrowed, free, guard, text, values};
use crate::{Status, Volume};
use layersplat::TransferFunction;
use layersplat::glam::DVec3;
use layersplat::volume::{Grid, Voxels};
use std::ffi::c_char;

/// A transfer function: colour and opacity by data value. It is immutable, and several threads may use it at the same time.
pub struct Transfer(pub(crate) TransferFunction);

/// A data value and its colour.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ColorPoint {
    /// The data value.
    pub value: f64,
    /// Red, green and blue, 0 to 1.
    pub color: [f64; 3],
}

/// A data value and its opacity.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct OpacityPoint {
    /// The data value.
    pub value: f64,
    /// Opacity per unit distance (layersplat_settings), 0 to 1.
    pub opacity: f64,
}

/// A default transfer function from the histogram of a volume. To be freed by layersplat_transfer_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_transfer_automatic(volume: *const Volume, transfer: *mut *mut Transfer) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(transfer, "transfer") }?;
        let volume = unsafe { borrowed(volume, "volume") }?;
        out.set_handle(Transfer(TransferFunction::automatic(&volume.0)));
        Ok(())
    })
}

/// Opens a built-in transfer function by name, or a ParaView colour map: FILE or FILE#PRESET. The error message for an unknown name
/// lists the built-in ones. These span the range of `volume`, or 0 to 1 if it is null (see layersplat_transfer_stretched()). To be
/// freed by layersplat_transfer_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_transfer_open(
    source: *const c_char,
    volume: *const Volume,
    transfer: *mut *mut Transfer,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(transfer, "transfer") }?;
        let source = unsafe { text(source, "source") }?;
        let opened = match unsafe { volume.as_ref() } {
            Some(volume) => TransferFunction::open(source, &volume.0),
            None => TransferFunction::open(source, &unit_range()?),
        }?;
        out.set_handle(Transfer(opened));
        Ok(())
    })
}

/// A dummy volume with the range 0 to 1, to which built-in functions are fitted.
fn unit_range() -> Result<layersplat::Volume<'static>, layersplat::Error> {
    layersplat::Volume::new("0 to 1", Grid::new([2, 1, 1], DVec3::ONE)?, Voxels::Uint8(vec![0, 1]))
}

/// Creates a piecewise linear transfer function, constant beyond its end points. At least one point each, ascending by value. Two
/// points at the same value make a step. To be freed by layersplat_transfer_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_transfer_points(
    colors: *const ColorPoint,
    color_count: usize,
    opacities: *const OpacityPoint,
    opacity_count: usize,
    transfer: *mut *mut Transfer,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(transfer, "transfer") }?;
        let colors = unsafe { values(colors, color_count, "colors") }?;
        let opacities = unsafe { values(opacities, opacity_count, "opacities") }?;
        let colors = colors.iter().map(|point| (point.value, point.color)).collect();
        let opacities = opacities.iter().map(|point| (point.value, point.opacity)).collect();
        out.set_handle(Transfer(TransferFunction::new("points", colors, opacities)?));
        Ok(())
    })
}

/// A copy of a transfer function, mapped linearly to the range from `smallest` to `largest`. To be freed by
/// layersplat_transfer_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_transfer_stretched(
    transfer: *const Transfer,
    smallest: f64,
    largest: f64,
    stretched: *mut *mut Transfer,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(stretched, "stretched") }?;
        let transfer = unsafe { borrowed(transfer, "transfer") }?;
        out.set_handle(Transfer(transfer.0.stretched(smallest, largest)?));
        Ok(())
    })
}

/// Frees a transfer function. Renderers keep a copy. Null is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_transfer_free(transfer: *mut Transfer) {
    // SAFETY: upheld by the caller.
    unsafe { free(transfer) }
}
