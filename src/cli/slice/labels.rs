//! Slices of labels.

use crate::error::Error;
use crate::image::Frame;
use crate::slice::{Slice, SliceValues};
use crate::viewport::Viewport;
use crate::volume::{Label, Labels};
use glam::DVec3;
use rayon::prelude::*;

/// Share of a label's opacity where it lies over a slice of a scan, which shows through.
const OVERLAY: f64 = 0.5;

/// A slice of labels: the colours of those nearest to its pixels, with their opacities.
///
/// # Errors
/// If the directions of the slice are invalid.
pub(super) fn slice_of_labels(labels: &Labels, slice: &Slice, viewport: Viewport) -> Result<Frame, Error> {
    let color = |label: &Label| [label.color[0], label.color[1], label.color[2], label.drawn_opacity()];
    let colors = on_slice(slice, viewport, |point| labels.label_at(point).map_or([0.0; 4], color))?;
    let premultiplied = |[r, g, b, opacity]: [f64; 4]| [r * opacity, g * opacity, b * opacity, opacity].map(|c| c as f32);
    Ok(Frame::new(viewport, colors.into_iter().map(premultiplied).collect()))
}

/// Ids of the labels nearest to the pixels of a slice; 0 where there is none.
///
/// # Errors
/// As [`slice_of_labels`].
pub(super) fn ids_on_slice(labels: &Labels, slice: &Slice, viewport: Viewport) -> Result<SliceValues, Error> {
    let ids = on_slice(slice, viewport, |point| labels.label_at(point).map_or(0.0, |label| label.id as f32))?;
    Ok(SliceValues::new(viewport, ids))
}

/// A slice of a scan with labels over it, in half of their opacity.
///
/// # Errors
/// As [`slice_of_labels`].
pub(super) fn slice_under_labels(scan: &Frame, labels: &Labels, slice: &Slice) -> Result<Frame, Error> {
    let viewport = Viewport::new(scan.width(), scan.height())?;
    let above = slice_of_labels(labels, slice, viewport)?;
    let on = |(below, above): (&[f32; 4], &[f32; 4])| {
        // Beside the scan nothing is drawn.
        let share = OVERLAY as f32 * below[3];
        std::array::from_fn(|i| above[i] * share + (1.0 - share * above[3]) * below[i])
    };
    Ok(Frame::new(viewport, scan.pixels().iter().zip(above.pixels()).map(on).collect()))
}

/// Results of `at` for the world points of a slice's pixels.
fn on_slice<T: Send>(slice: &Slice, viewport: Viewport, at: impl Fn(DVec3) -> T + Sync) -> Result<Vec<T>, Error> {
    let (pixels, width) = (slice.pixels(viewport)?, viewport.width as usize);
    let point = |n: usize| pixels.point((n % width) as f64 + 0.5, (n / width) as f64 + 0.5);
    Ok((0..viewport.pixels()).into_par_iter().map(|n| at(point(n))).collect())
}
