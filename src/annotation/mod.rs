//! Annotations of finished pictures: colour bar, scale bar, bounding box and axes.
//!
//! They are drawn on the host, over (and parts of the box under) a frame of premultiplied floats, so every file format supports them.

mod axes;
mod canvas;
mod legend;
mod outline;
mod scale_bar;
mod screen;
mod ticks;

use crate::camera::Camera;
use crate::error::Error;
use crate::image::{Background, Frame};
use crate::memory;
use crate::settings::Blend;
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::Grid;
use canvas::Canvas;
use rayon::prelude::*;
use screen::Screen;

/// Annotations to draw.
///
/// ```
/// use layersplat::annotation::Annotations;
///
/// let annotations = Annotations { legend: true, units: Some("HU".into()), ..Annotations::default() };
/// assert!(!annotations.is_empty() && Annotations::default().is_empty());
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Annotations {
    /// A colour bar with the colours, opacities and values of the transfer function; in parallel projections also a scale bar.
    pub legend: bool,
    /// The bounding box of the voxels. Edges of front faces are drawn over the volume, the other edges under it.
    pub bounding_box: bool,
    /// The world axes, in the lower left corner.
    pub axes: bool,
    /// Unit of the values, shown above the colour bar.
    pub units: Option<String>,
    /// Unit of length, shown at the scale bar.
    pub length_units: Option<String>,
}

/// The scene in a picture, as annotations need it.
///
/// ```
/// use layersplat::annotation::{Annotations, Shown};
/// use layersplat::settings::Blend;
/// use layersplat::{Background, Camera, Frame, Orbit, OpenOptions, TransferFunction, Viewport, Volume};
///
/// let volume = Volume::open("builtin:cube@8", &OpenOptions::default())?;
/// let (grid, transfer, viewport) = (volume.grid(), TransferFunction::builtin("fire", &volume)?, Viewport::new(96, 64)?);
/// let camera = Camera::fit_parallel(grid.centre(), grid.diagonal(), viewport, Orbit::default());
/// let empty = Frame::new(viewport, vec![[0.0; 4]; viewport.pixels()]);
/// let shown = Shown { camera: &camera, grid, transfer: &transfer, blend: Blend::Composite, background: Background::BLACK };
/// let annotations = Annotations { bounding_box: true, ..Annotations::default() };
/// assert!(annotations.drawn(empty, shown)?.pixels().iter().any(|pixel| pixel[3] > 0.0));
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy)]
pub struct Shown<'a> {
    /// Camera of the frame.
    pub camera: &'a Camera,
    /// Grid of the volume.
    pub grid: &'a Grid,
    /// Transfer function, for the colour bar.
    pub transfer: &'a TransferFunction,
    /// Blend mode. The colour bar shows opacities for compositing and marks an iso-value.
    pub blend: Blend,
    /// Background of the picture. Lines and text are light on dark backgrounds and dark on light ones.
    pub background: Background,
}

impl Annotations {
    /// Whether no annotation is enabled.
    pub fn is_empty(&self) -> bool {
        !(self.legend || self.bounding_box || self.axes)
    }

    /// Draws the annotations on a frame.
    ///
    /// # Errors
    /// If the camera is invalid, or memory is insufficient.
    pub fn drawn(&self, frame: Frame, shown: Shown) -> Result<Frame, Error> {
        if self.is_empty() {
            return Ok(frame);
        }
        let viewport = Viewport::new(frame.width(), frame.height())?;
        // Two RGBA8 canvases and a float frame.
        memory::require("annotations", viewport.pixels() as u64 * (4 + 4 + 16))?;
        let screen = Screen::new(shown.camera, viewport)?;
        let [mut under, mut over] = [Canvas::new(viewport, shown.background)?, Canvas::new(viewport, shown.background)?];
        if self.bounding_box {
            outline::draw(&screen, shown.grid, &mut under, &mut over);
        }
        if self.axes {
            axes::draw(&screen, &mut over);
        }
        if self.legend {
            legend::draw(shown.transfer, shown.blend, self.units.as_deref(), &mut over);
            scale_bar::draw(&screen, self.length_units.as_deref(), &mut over);
        }
        Ok(composed(frame, viewport, &under, &over))
    }
}

/// Draws a label in the upper left corner of a picture.
///
/// ```
/// use layersplat::{Background, Frame, Viewport};
///
/// let viewport = Viewport::new(64, 32)?;
/// let empty = Frame::new(viewport, vec![[0.0; 4]; viewport.pixels()]);
/// let labelled = layersplat::annotation::labelled(empty, "front", Background::BLACK)?;
/// assert!(labelled.pixels().iter().any(|pixel| pixel[3] > 0.0));
/// # Ok::<(), layersplat::Error>(())
/// ```
///
/// # Errors
/// If memory is insufficient.
pub fn labelled(frame: Frame, label: &str, background: Background) -> Result<Frame, Error> {
    let viewport = Viewport::new(frame.width(), frame.height())?;
    let [under, mut over] = [Canvas::new(viewport, background)?, Canvas::new(viewport, background)?];
    let margin = f64::from(over.scale()) * 8.0;
    over.text([margin, margin], label);
    Ok(composed(frame, viewport, &under, &over))
}

/// Composites `over` on the frame on `under`.
fn composed(frame: Frame, viewport: Viewport, under: &Canvas, over: &Canvas) -> Frame {
    let mut pixels = frame.into_pixels();
    pixels.par_iter_mut().enumerate().for_each(|(n, pixel)| {
        *pixel = on(over.pixel(n), on(*pixel, under.pixel(n)));
    });
    Frame::new(viewport, pixels)
}

/// Composites a premultiplied pixel over another. A transparent pixel leaves the other one bit-identical.
fn on(above: [f32; 4], below: [f32; 4]) -> [f32; 4] {
    let through = 1.0 - above[3];
    std::array::from_fn(|i| above[i] + through * below[i])
}

#[cfg(test)]
mod tests;
