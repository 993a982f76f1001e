//! Slices, evaluated point by point.

use super::compositing::{opacity_over, picture};
use super::field::Field;
use crate::error::Error;
use crate::image::Frame;
use crate::layers::Kernel;
use crate::settings::Blend;
use crate::slice::{Slice, SliceColors};
use crate::transfer::{Extinction, TransferFunction};
use crate::viewport::Viewport;
use crate::volume::{Grid, Volume};
use glam::DVec3;

/// Slices of a kernel's field in `f64`, without a table.
pub struct Slices<'a> {
    field: Field,
    grid: &'a Grid,
    transfer: &'a TransferFunction,
}

impl<'a> Slices<'a> {
    /// Slices of the field that continues at the edges of the volume.
    pub fn new(volume: &'a Volume<'a>, transfer: &'a TransferFunction, kernel: Kernel) -> Self {
        Self { field: Field::new(volume, transfer, Blend::Average, kernel), grid: volume.grid(), transfer }
    }

    /// Data value at a world point; `None` outside the boxes of the voxels.
    pub fn value(&self, point: DVec3) -> Option<f64> {
        let p = self.grid.world_to_voxel(point);
        let end = DVec3::from_array(self.field.dims().map(|n| n as f64 - 0.5));
        (p.cmpge(DVec3::splat(-0.5)) & p.cmple(end)).all().then(|| self.field.classified(p))
    }

    /// Data value of each pixel, row by row.
    ///
    /// # Errors
    /// If the slice is invalid.
    pub fn values(&self, slice: &Slice, viewport: Viewport) -> Result<Vec<Option<f64>>, Error> {
        let pixels = slice.pixels(viewport)?;
        let each = (0..viewport.height).flat_map(|y| (0..viewport.width).map(move |x| (x, y)));
        Ok(each.map(|(x, y)| self.value(pixels.point(f64::from(x) + 0.5, f64::from(y) + 0.5))).collect())
    }

    /// The picture of a slice.
    ///
    /// # Errors
    /// If the slice is invalid.
    pub fn render(&self, slice: &Slice, viewport: Viewport, colors: SliceColors) -> Result<Frame, Error> {
        let pixels = slice.pixels(viewport)?;
        Ok(picture(viewport, |x, y| self.value(pixels.point(x, y)).map_or([0.0; 4], |value| self.color(value, colors))))
    }

    /// Premultiplied colour of a value.
    fn color(&self, value: f64, colors: SliceColors) -> [f64; 4] {
        match colors {
            SliceColors::Window { level, width } => {
                let grey = ((value - level) / width + 0.5).clamp(0.0, 1.0);
                [grey, grey, grey, 1.0]
            }
            SliceColors::Transfer { thickness } => {
                let opacity = match (self.transfer.opacity(value) > 0.0, thickness.is_finite()) {
                    (false, _) => 0.0,
                    (true, false) => 1.0,
                    (true, true) => opacity_over(self.transfer, value, thickness, Extinction::Exponential),
                };
                let [r, g, b] = self.transfer.color(value).map(|c| c * opacity);
                [r, g, b, opacity]
            }
        }
    }
}
