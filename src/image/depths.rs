//! How far away is what a picture shows.

use super::{Background, Frame, ImageFormat, file};
use crate::error::Error;
use crate::memory;
use crate::viewport::Viewport;
use std::path::Path;

/// Per pixel, what stands between a frame with depths and its file: a background's picture, channels, and both encoded.
const BYTES: u64 = 16 + 2 * (16 + 8);

/// Depths of a picture's pixels: distances from the eye along the view's direction, in world units, row by row, row 0 on top; infinite where
/// less than 1/256 of the light is stopped. In a perspective they are distances from the plane through the eye, as compositing programs
/// and depth buffers have them, not along rays.
///
/// Made by [`Renderer::depths`](crate::Renderer::depths).
///
/// ```
/// use layersplat::{Renderer, Settings};
/// # let volume = layersplat::Volume::open("builtin:hydrogen@16", &layersplat::OpenOptions::default())?;
/// # let transfer = layersplat::TransferFunction::automatic(&volume);
/// # let device = layersplat::Device::open(&layersplat::DeviceChoice::Default)?;
/// # let viewport = layersplat::Viewport::new(32, 24)?;
/// # let orbit = layersplat::Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
/// # let camera = layersplat::Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, orbit);
///
/// let depths = Renderer::new(&device, &volume, &transfer)?.depths(&camera, viewport, &Settings::default())?;
/// assert!(depths.first().iter().zip(depths.mean()).all(|(first, mean)| first <= mean));
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Depths {
    viewport: Viewport,
    first: Vec<f32>,
    mean: Vec<f32>,
}

impl Depths {
    /// Of `viewport.pixels()` depths each.
    pub(crate) fn new(viewport: Viewport, first: Vec<f32>, mean: Vec<f32>) -> Self {
        assert_eq!((first.len(), mean.len()), (viewport.pixels(), viewport.pixels()));
        Self { viewport, first, mean }
    }

    /// Columns and rows.
    pub fn viewport(&self) -> Viewport {
        self.viewport
    }

    /// Where something is seen first: where 1/256 of the light is stopped, or at the iso-surface.
    pub fn first(&self) -> &[f32] {
        &self.first
    }

    /// The mean of all depths, each weighted by what it adds to the pixel's opacity; never less than the first.
    pub fn mean(&self) -> &[f32] {
        &self.mean
    }
}

impl Frame {
    /// Writes an `.exr` file with depths beside the picture, whole or not at all: the channels `Z`, where something is seen first, and
    /// `mean.Z`. Without a background, the picture stays bare.
    ///
    /// # Errors
    /// Of other endings, depths of another size, and files that cannot be written.
    pub fn save_with_depths(&self, path: impl AsRef<Path>, background: Option<Background>, depths: &Depths) -> Result<(), Error> {
        let path = path.as_ref();
        ImageFormat::with_depths(path)?;
        if depths.viewport != self.viewport {
            let Viewport { width, height, .. } = depths.viewport;
            let problem = format!("depths of {width}x{height} do not fit a picture of {}x{}", self.width(), self.height());
            return Err(Error::Settings { field: "depth", problem });
        }
        memory::require("the picture to write", self.pixels().len() as u64 * BYTES)?;
        file::write_exr(path, &self.standing_on(background), Some(depths))
    }
}
