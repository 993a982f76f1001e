//! Progressive accumulation: the mean of frames with different sub-pixel offsets of the rays.

use super::report::FrameReport;
use super::{Renderer, StreamedRenderer};
use crate::camera::Camera;
use crate::color::Curve;
use crate::error::Error;
use crate::image::Frame;
use crate::layers::Rays;
use crate::memory;
use crate::settings::Settings;
use crate::viewport::Viewport;
use std::ops::Range;

/// The mean of the frames of one view so far. Each frame has another sub-pixel offset of its rays, so the picture of a static
/// view improves with each frame. 16 frames have the rays of a picture with 4 × 4 supersampling.
///
/// All frames must have the same camera and settings: start a new accumulation when either changes. A frame has one
/// unfiltered ray per pixel: where voxels are smaller than pixels, the mean of fewer than eight is noisier than one plain frame.
///
/// ```
/// use layersplat::renderer::Accumulation;
/// use layersplat::{Renderer, Settings};
/// # let volume = layersplat::Volume::open("builtin:hydrogen@16", &layersplat::OpenOptions::default())?;
/// # let transfer = layersplat::TransferFunction::automatic(&volume);
/// # let device = layersplat::Device::open(&layersplat::DeviceChoice::Default)?;
/// # let viewport = layersplat::Viewport::new(32, 24)?;
/// # let orbit = layersplat::Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
/// # let camera = layersplat::Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, orbit);
///
/// let mut renderer = Renderer::new(&device, &volume, &transfer)?;
/// let mut picture = Accumulation::new(viewport)?;
/// while picture.frames() < Accumulation::FRAMES {
///     renderer.accumulate(&camera, &Settings::default(), &mut picture)?;
/// }
/// assert_eq!(picture.mean()?.width(), 32);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Accumulation {
    viewport: Viewport,
    /// Premultiplied RGBA, row by row.
    sums: Vec<[f64; 4]>,
    frames: u32,
    /// That of the frames.
    curve: Curve,
}

/// Sub-pixel positions per axis.
const GRID: u32 = 4;

impl Accumulation {
    /// Number of frames that cover all sub-pixel positions. Later frames repeat them.
    pub const FRAMES: u32 = GRID * GRID;

    /// An accumulation without frames.
    ///
    /// # Errors
    /// If the picture does not fit into host memory.
    pub fn new(viewport: Viewport) -> Result<Self, Error> {
        Ok(Self { viewport, sums: memory::zeroed("the accumulated picture", viewport.pixels())?, frames: 0, curve: Curve::NONE })
    }

    /// Number of accumulated frames.
    pub fn frames(&self) -> u32 {
        self.frames
    }

    /// The current mean as premultiplied floats, without a background. Transparent before the first frame, and in processes that do
    /// not get pictures.
    ///
    /// # Errors
    /// If the picture does not fit into host memory.
    pub fn mean(&self) -> Result<Frame, Error> {
        let mut pixels: Vec<[f32; 4]> = memory::zeroed("the accumulated picture", self.sums.len())?;
        let count = f64::from(self.frames.max(1));
        for (pixel, sum) in pixels.iter_mut().zip(&self.sums) {
            *pixel = sum.map(|channel| (channel / count) as f32);
        }
        Ok(Frame::new(self.viewport, pixels).with_curve(self.curve))
    }

    /// Renders the next frame by `render`, and adds it. A process that does not get pictures only counts the frame, so that all
    /// processes move the rays in the same order.
    ///
    /// # Errors
    /// Those of `render`. The accumulation is then unchanged.
    pub(crate) fn extend<Report>(
        &mut self,
        render: impl FnOnce(Viewport, Jitter) -> Result<(Option<Frame>, Report), Error>,
    ) -> Result<Report, Error> {
        let (frame, report) = render(self.viewport, Jitter { offset: offset(self.frames), parts: GRID })?;
        self.curve = frame.as_ref().map_or(self.curve, Frame::curve);
        for (sum, pixel) in self.sums.iter_mut().zip(frame.iter().flat_map(Frame::pixels)) {
            (0..4).for_each(|channel| sum[channel] += f64::from(pixel[channel]));
        }
        self.frames += 1;
        Ok(report)
    }
}

/// Sub-pixel offset of frame `n`, in pixels from the pixel centre. The order of the 16 positions of the 4 × 4 grid spreads any
/// first few over the pixel: the first of two bits of `n` chooses the half of the column, the other that of the row, and so on.
fn offset(n: u32) -> [f64; 2] {
    let n = n % Accumulation::FRAMES;
    let bit = |i: u32| (n >> i) & 1;
    // The exclusive or places the first two frames on a diagonal.
    let (column, row) = (2 * bit(0) + bit(2), 2 * (bit(0) ^ bit(1)) + (bit(2) ^ bit(3)));
    [column, row].map(|place| (f64::from(place) + 0.5) / f64::from(GRID) - 0.5)
}

/// Rays beside the middles of pixels.
#[derive(Clone, Copy)]
pub(crate) struct Jitter {
    /// Pixels to the right and down.
    offset: [f64; 2],
    /// Rays per side of a pixel, in all frames together.
    parts: u32,
}

impl Jitter {
    /// Rays of the part of a picture whose first pixel is in this column and row.
    fn from_pixel(column: u32, row: u32) -> Self {
        Self { offset: [column.into(), row.into()], parts: 1 }
    }

    /// Moves rays through the middles of pixels.
    pub(super) fn apply(self, rays: Rays) -> Rays {
        rays.through_parts(self.offset, self.parts)
    }
}

impl Renderer {
    /// Renders the next frame of an accumulation and adds it.
    ///
    /// # Errors
    /// Those of [`render`](Self::render). The accumulation is then unchanged.
    pub fn accumulate(
        &mut self,
        camera: &Camera,
        settings: &Settings,
        accumulation: &mut Accumulation,
    ) -> Result<FrameReport, Error> {
        accumulation.extend(|viewport, jitter| {
            let (frame, report) = self.render_jittered(camera, viewport, settings, jitter)?;
            Ok((Some(frame), report))
        })
    }

    /// Renders a part of a picture of `viewport`: these columns and rows, from the top left. So a picture that is too large for memory is
    /// rendered in parts. Rays and quality are those of the whole picture; lattices may have other places, so colours differ by rounding and
    /// interpolation. Parts that are about square take the least time.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a part that is empty or outside the picture, and those of [`render`](Self::render).
    pub fn render_part(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        [columns, rows]: [Range<u32>; 2],
        settings: &Settings,
    ) -> Result<(Frame, FrameReport), Error> {
        let part = Viewport::new(length("columns", &columns, viewport.width)?, length("rows", &rows, viewport.height)?)?;
        let (rays, settings) = self.engine.normalised_view(camera, viewport, settings)?;
        let rays = Jitter::from_pixel(columns.start, rows.start).apply(rays);
        let planned = self.planned_for(rays, part, settings)?;
        self.render_planned(&planned)
    }

    pub(super) fn render_jittered(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
        jitter: Jitter,
    ) -> Result<(Frame, FrameReport), Error> {
        let (rays, settings) = self.engine.normalised_view(camera, viewport, settings)?;
        let planned = self.planned_for(jitter.apply(rays), viewport, settings)?;
        self.render_planned(&planned)
    }
}

/// Number of these columns or rows of a picture that has `all` of them.
fn length(name: &'static str, range: &Range<u32>, all: u32) -> Result<u32, Error> {
    if range.is_empty() || range.end > all {
        let value = format!("{} to {}", range.start, range.end);
        return Err(Error::OutOfRange { name, value, expected: "a part of the picture" });
    }
    Ok(range.end - range.start)
}

impl StreamedRenderer<'_> {
    /// Renders the next frame of an accumulation and adds it.
    ///
    /// # Errors
    /// Those of [`render`](Self::render). The accumulation is then unchanged.
    pub fn accumulate(
        &mut self,
        camera: &Camera,
        settings: &Settings,
        accumulation: &mut Accumulation,
    ) -> Result<FrameReport, Error> {
        accumulation.extend(|viewport, jitter| {
            let (frame, report) = self.render_jittered(camera, viewport, settings, Some(jitter))?;
            Ok((Some(frame), report))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_place_has_its_ray_and_the_first_are_spread() {
        let places = |n: u32| (0..n).map(offset).map(|[x, y]| [x, y].map(|p| (p * 8.0) as i32)).collect::<BTreeSet<_>>();
        assert_eq!(places(Accumulation::FRAMES).len(), Accumulation::FRAMES as usize);
        assert_eq!(offset(0), offset(Accumulation::FRAMES));
        let quarters = |n: u32| (0..n).map(|n| offset(n).map(|p| p > 0.0)).collect::<BTreeSet<_>>();
        assert_eq!(quarters(4).len(), 4, "the first four lie in different quarters of the pixel");
        let sum = (0..Accumulation::FRAMES).map(offset).fold([0.0; 2], |[a, b], [x, y]| [a + x, b + y]);
        assert!(sum.iter().all(|s: &f64| s.abs() < 1e-12), "the mean place is the middle: {sum:?}");
    }
}
