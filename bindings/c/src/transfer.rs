//! Transfer functions.

use crate::border::{Out, borrowed, free, guard, text, values};
use crate::{Status, Volume};
use layersplat::TransferFunction;
use layersplat::glam::DVec3;
use layersplat::volume::{Grid, Voxels};
use std::ffi::c_char;

/// Colour and opacity of a data value. Nothing changes it: any thread may use it, several at a time.
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

/// A sensible first transfer function, from the histogram of a volume. To be freed by layersplat_transfer_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_transfer_automatic(volume: *const Volume, transfer: *mut *mut Transfer) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let out = unsafe { Out::handle(transfer, "transfer") }?;
        let volume = unsafe { borrowed(volume, "volume") }?;
        out.give(Transfer(TransferFunction::automatic(&volume.0)));
        Ok(())
    })
}

/// A built-in transfer function (an unknown name's message lists them), or one of a ParaView colour-map file: FILE, or FILE#PRESET.
/// Built-in ones reach over the values of `volume`; where that is null, from 0 to 1 (see layersplat_transfer_stretched()).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_transfer_open(
    source: *const c_char,
    volume: *const Volume,
    transfer: *mut *mut Transfer,
) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let out = unsafe { Out::handle(transfer, "transfer") }?;
        let source = unsafe { text(source, "source") }?;
        let opened = match unsafe { volume.as_ref() } {
            Some(volume) => TransferFunction::open(source, &volume.0),
            None => TransferFunction::open(source, &from_0_to_1()?),
        }?;
        out.give(Transfer(opened));
        Ok(())
    })
}

/// Stands for volumes whose range is not known here.
fn from_0_to_1() -> Result<layersplat::Volume<'static>, layersplat::Error> {
    layersplat::Volume::new("0 to 1", Grid::new([2, 1, 1], DVec3::ONE)?, Voxels::Uint8(vec![0, 1]))
}

/// Colours and opacities that are linear between points and constant beyond them: at least one of each, ascending by value. Two at one
/// value make a step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_transfer_points(
    colors: *const ColorPoint,
    color_count: usize,
    opacities: *const OpacityPoint,
    opacity_count: usize,
    transfer: *mut *mut Transfer,
) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let out = unsafe { Out::handle(transfer, "transfer") }?;
        let colors = unsafe { values(colors, color_count, "colors") }?;
        let opacities = unsafe { values(opacities, opacity_count, "opacities") }?;
        let colors = colors.iter().map(|point| (point.value, point.color)).collect();
        let opacities = opacities.iter().map(|point| (point.value, point.opacity)).collect();
        out.give(Transfer(TransferFunction::new("points", colors, opacities)?));
        Ok(())
    })
}

/// The same function with its values mapped linearly onto those from `smallest` to `largest`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_transfer_stretched(
    transfer: *const Transfer,
    smallest: f64,
    largest: f64,
    stretched: *mut *mut Transfer,
) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let out = unsafe { Out::handle(stretched, "stretched") }?;
        let transfer = unsafe { borrowed(transfer, "transfer") }?;
        out.give(Transfer(transfer.0.stretched(smallest, largest)?));
        Ok(())
    })
}

/// Frees a transfer function. Renderers that it was given to keep a copy. Null is left alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_transfer_free(transfer: *mut Transfer) {
    // SAFETY: the caller's promise.
    unsafe { free(transfer) }
}
