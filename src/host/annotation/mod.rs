//! Annotations of finished pictures: colour bar or list of names, scale bar, bounding box and axes.
//!
//! They are drawn on the host, over (and parts of the box under) a frame of premultiplied floats, so every file format supports them.

mod axes;
mod canvas;
mod extent;
mod key;
mod legend;
mod list;
mod outline;
mod scale_bar;
mod screen;
mod ticks;
mod vector;

use crate::camera::Camera;
use crate::error::Error;
use crate::image::{Background, Frame};
use crate::memory;
use crate::settings::Blend;
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::Grid;
use canvas::Canvas;
use extent::Extent;
use glam::DVec2;
use key::Key;
pub use list::{Legend, LegendEntry};
use rayon::prelude::*;
use screen::Screen;
pub use vector::VectorFormat;

/// Sizes of letters in pixels.
const FONT_SIZES: std::ops::RangeInclusive<f64> = 1.0..=1000.0;

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
    /// Labels or channels to list in place of the colour bar.
    pub list: Option<Legend>,
    /// The bounding box of the voxels. Edges of front faces are drawn over the volume, the other edges under it.
    pub bounding_box: bool,
    /// The world axes, in the lower left corner.
    pub axes: bool,
    /// Unit of the values, shown above the colour bar.
    pub units: Option<String>,
    /// Unit of length, shown at the scale bar.
    pub length_units: Option<String>,
    /// Height of the em square of letters in pixels, 1 to 1000; everything else is scaled with it. By default it follows the picture: 12 for
    /// each 480 pixels of the shorter side, in whole multiples.
    pub font_size: Option<f64>,
}

/// The scene in a picture, as annotations need it.
///
/// ```
/// use layersplat::annotation::{Annotations, AnnotatedView};
/// use layersplat::settings::Blend;
/// use layersplat::{Background, Camera, Frame, Orbit, OpenOptions, TransferFunction, Viewport, Volume};
///
/// let volume = Volume::open("builtin:cube@8", &OpenOptions::default())?;
/// let (grid, transfer, viewport) = (volume.grid(), TransferFunction::builtin("fire", &volume)?, Viewport::new(96, 64)?);
/// let camera = Camera::fit_parallel(grid.centre(), grid.diagonal(), viewport, Orbit::default());
/// let empty = Frame::new(viewport, vec![[0.0; 4]; viewport.pixels()]);
/// let shown = AnnotatedView { camera: &camera, grid, transfer: &transfer, blend: Blend::Composite, background: Background::BLACK };
/// let annotations = Annotations { bounding_box: true, ..Annotations::default() };
/// assert!(annotations.drawn(empty, shown)?.pixels().iter().any(|pixel| pixel[3] > 0.0));
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy)]
pub struct AnnotatedView<'a> {
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

    /// Checks the size of letters.
    ///
    /// # Errors
    /// If it is not 1 to 1000 pixels.
    pub fn check(&self) -> Result<(), Error> {
        let Some(given) = self.font_size.filter(|size| !FONT_SIZES.contains(size)) else { return Ok(()) };
        let problem =
            format!("letters of {given:.1} pixels cannot be drawn: use {} to {} pixels", FONT_SIZES.start(), FONT_SIZES.end());
        Err(Error::Settings { field: "font_size", problem })
    }

    /// Size of the frame to render for an annotated picture of `size`, so that legend and axes have room of their own: the legend to its
    /// right, the axes below it. At least half of each side is left; in smaller pictures, annotations lie over the frame.
    ///
    /// ```
    /// use layersplat::annotation::Annotations;
    /// use layersplat::settings::Blend;
    /// use layersplat::{TransferFunction, Viewport};
    ///
    /// let transfer = TransferFunction::new("t", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0), (9.0, 1.0)])?;
    /// let (size, legend) = (Viewport::new(300, 200)?, Annotations { legend: true, ..Annotations::default() });
    /// let inner = legend.inner(size, &transfer, Blend::Composite);
    /// assert!(inner.width < 300 && inner.height == 200);
    /// assert_eq!(Annotations::default().inner(size, &transfer, Blend::Composite), size);
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    pub fn inner(&self, size: Viewport, transfer: &TransferFunction, blend: Blend) -> Viewport {
        let left = |side: u32, room: f64| side.saturating_sub(room.ceil() as u32).max(side.div_ceil(2));
        let extent = self.extent(size);
        let column = if self.legend { self.column(extent, transfer, blend) } else { 0.0 };
        let strip = if self.axes { axes::room(extent) } else { 0.0 };
        Viewport { width: left(size.width, column), height: left(size.height, strip) }
    }

    /// Size and scale of annotations of a picture.
    fn extent(&self, size: Viewport) -> Extent {
        Extent::new(size, self.font_size.filter(|size| FONT_SIZES.contains(size)))
    }

    /// Width of the column of the legend.
    fn column(&self, extent: Extent, transfer: &TransferFunction, blend: Blend) -> f64 {
        let bar = Key::new(self, extent, transfer, blend).room(extent);
        bar.max(scale_bar::room(self.length_units.as_deref(), extent))
    }

    /// The colour bar or the list alone, as it is beside a picture of `size`, on transparent pixels.
    ///
    /// ```
    /// use layersplat::annotation::Annotations;
    /// use layersplat::settings::Blend;
    /// use layersplat::{Background, TransferFunction, Viewport};
    ///
    /// let transfer = TransferFunction::new("t", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0), (9.0, 1.0)])?;
    /// let (size, background) = (Viewport::new(300, 200)?, Background::Transparent);
    /// let bar = Annotations::default().legend_alone(size, &transfer, Blend::Composite, background)?;
    /// assert!(bar.width() < 100 && bar.height() < 200);
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    ///
    /// # Errors
    /// If the font size is invalid, or memory is insufficient.
    pub fn legend_alone(
        &self,
        size: Viewport,
        transfer: &TransferFunction,
        blend: Blend,
        background: Background,
    ) -> Result<Frame, Error> {
        self.check()?;
        let extent = self.extent(size);
        let key = Key::new(self, extent, transfer, blend);
        let width = key.room(extent).ceil() as u32;
        let viewport = Viewport::new(width, size.height)?;
        // An RGBA8 canvas and a float frame.
        memory::require("annotations", viewport.pixels() as u64 * (4 + 16))?;
        let mut canvas = Canvas::new(Extent { viewport, ..extent }, background)?;
        key.draw(&mut canvas);
        let rows = key.rows(extent);
        let pixels = (rows.start as usize * width as usize..rows.end as usize * width as usize).map(|n| canvas.pixel(n, false));
        Ok(Frame::new(Viewport::new(width, rows.end - rows.start)?, pixels.collect()))
    }

    /// Draws the annotations on a frame: in linear light, if its curve says that its colours are.
    ///
    /// # Errors
    /// If the camera is invalid, or memory is insufficient.
    pub fn drawn(&self, frame: Frame, shown: AnnotatedView) -> Result<Frame, Error> {
        let size = Viewport::new(frame.width(), frame.height())?;
        self.drawn_beside(frame, size, shown)
    }

    /// Places a frame of at most `size` in the upper left corner of a transparent picture of `size`, and draws the annotations: the legend
    /// along the right edge, the axes in the lower left corner, the box on the frame. See [`Annotations::inner`].
    ///
    /// # Errors
    /// If the frame is larger than `size`, the camera or the font size is invalid, or memory is insufficient.
    pub fn drawn_beside(&self, frame: Frame, size: Viewport, shown: AnnotatedView) -> Result<Frame, Error> {
        let inner = Viewport::new(frame.width(), frame.height())?;
        let curve = frame.curve();
        let frame = frame.within(size)?.with_curve(curve);
        if self.is_empty() {
            return Ok(frame);
        }
        // Two RGBA8 canvases and a float frame.
        memory::require("annotations", size.pixels() as u64 * (4 + 4 + 16))?;
        self.check()?;
        let (screen, extent) = (Screen::new(shown.camera, inner)?, self.extent(size));
        let [mut under, mut over] = [Canvas::new(extent, shown.background)?, Canvas::new(extent, shown.background)?];
        if self.bounding_box {
            over.clip(inner);
            under.clip(inner);
            outline::draw(&screen, shown.grid, &mut under, &mut over);
            over.clip(size);
        }
        if self.axes {
            axes::draw(&screen, inner.height < size.height, &mut over);
        }
        if self.legend {
            Key::new(self, extent, shown.transfer, shown.blend).draw(&mut over);
            let beside = size.width - inner.width;
            let column = if beside > 0 { f64::from(beside) } else { f64::from(size.width) };
            scale_bar::draw(&screen, self.length_units.as_deref(), column, &mut over);
        }
        Ok(composed(frame, size, &under, &over))
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
    let extent = Extent::new(viewport, None);
    let [under, mut over] = [Canvas::new(extent, background)?, Canvas::new(extent, background)?];
    let margin = extent.scale * 8.0;
    over.text([margin, margin], label);
    Ok(composed(frame, viewport, &under, &over))
}

/// Draws letters at the middle of the right, left, upper and lower edge of a picture, as of a patient's directions in a slice.
///
/// # Errors
/// If memory is insufficient.
pub fn with_letters(frame: Frame, [right, left, upper, lower]: &[String; 4], background: Background) -> Result<Frame, Error> {
    let viewport = Viewport::new(frame.width(), frame.height())?;
    let extent = Extent::new(viewport, None);
    let [under, mut over] = [Canvas::new(extent, background)?, Canvas::new(extent, background)?];
    let size = DVec2::new(viewport.width.into(), viewport.height.into());
    let margin = DVec2::splat(extent.scale * 6.0);
    // The share of the room beside the text that lies to its left, and above it.
    let places = [
        (right, DVec2::new(1.0, 0.5)),
        (left, DVec2::new(0.0, 0.5)),
        (upper, DVec2::new(0.5, 0.0)),
        (lower, DVec2::new(0.5, 1.0)),
    ];
    for (text, share) in places {
        let room = size - over.text_size(text) - 2.0 * margin;
        over.text((margin + room * share).to_array(), text);
    }
    Ok(composed(frame, viewport, &under, &over))
}

/// Composites `over` on the frame on `under`, in linear light if the frame is. It keeps its curve.
fn composed(frame: Frame, viewport: Viewport, under: &Canvas, over: &Canvas) -> Frame {
    let curve = frame.curve();
    let is_linear = curve.linear.is_some();
    let mut pixels = frame.into_pixels();
    pixels.par_iter_mut().enumerate().for_each(|(n, pixel)| {
        *pixel = on(over.pixel(n, is_linear), on(*pixel, under.pixel(n, is_linear)));
    });
    Frame::new(viewport, pixels).with_curve(curve)
}

/// Composites a premultiplied pixel over another. A transparent pixel leaves the other one bit-identical.
fn on(above: [f32; 4], below: [f32; 4]) -> [f32; 4] {
    let through = 1.0 - above[3];
    std::array::from_fn(|i| above[i] + through * below[i])
}

#[cfg(test)]
mod tests;
