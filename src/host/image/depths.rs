//! Depth images.

use super::{Background, Encoding, Frame};
use crate::camera::{Basis, Camera, Projection};
use crate::error::Error;
use crate::viewport::Viewport;
use glam::DVec3;
use rayon::prelude::*;
use std::path::Path;

/// Depths of the pixels of a picture, row by row, row 0 at the top.
///
/// Depths are distances from the plane through the eye along the view direction, in world units, as in depth buffers; in a perspective
/// they are not distances along rays. They are infinite where less than 1/256 of the light is absorbed.
///
/// Computed by `Renderer::depths`.
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
    ids: Option<Vec<u32>>,
}

impl Depths {
    /// `first` and `mean` have `viewport.pixels()` depths each.
    #[doc(hidden)]
    pub fn new(viewport: Viewport, first: Vec<f32>, mean: Vec<f32>) -> Self {
        assert_eq!((first.len(), mean.len()), (viewport.pixels(), viewport.pixels()));
        Self { viewport, first, mean, ids: None }
    }

    /// Places the depths in the upper left corner of infinite ones of `size`, as [`Frame::within`] places the picture.
    #[doc(hidden)]
    pub fn within(self, size: Viewport) -> Result<Self, Error> {
        if self.viewport == size {
            return Ok(self);
        }
        let placed = |depths: &[f32]| super::placed("the depths", depths, self.viewport, size, f32::INFINITY);
        let ids = self.ids.as_deref().map(|ids| super::placed("the ids", ids, self.viewport, size, 0)).transpose()?;
        Ok(Self { viewport: size, first: placed(&self.first)?, mean: placed(&self.mean)?, ids })
    }

    /// Size of the picture.
    pub fn viewport(&self) -> Viewport {
        self.viewport
    }

    /// Depth of the first visible surface: where the accumulated opacity reaches 1/256, or of the iso-surface.
    pub fn first(&self) -> &[f32] {
        &self.first
    }

    /// Adds the ids of labels that `id_at` finds at the world positions of the first depths, along the rays of `camera` through the pixel
    /// centres. Where depths are infinite they are 0.
    ///
    /// # Errors
    /// If the camera is invalid.
    pub fn with_ids(self, camera: &Camera, id_at: impl Fn(DVec3) -> u32 + Sync) -> Result<Self, Error> {
        let Basis { right, up, forward } = camera.basis()?;
        let (width, height) = (self.viewport.width as usize, f64::from(self.viewport.height));
        let (is_parallel, half_height) = match camera.projection {
            Projection::Parallel { scale } => (true, scale),
            Projection::Perspective { field_of_view } => (false, (field_of_view.to_radians() / 2.0).tan()),
        };
        let pixel = 2.0 * half_height / height;
        let position = |n: usize, depth: f64| {
            let x = ((n % width) as f64 + 0.5 - width as f64 / 2.0) * pixel;
            let y = (height / 2.0 - (n / width) as f64 - 0.5) * pixel;
            let beside = right * x + up * y;
            camera.position + if is_parallel { beside + forward * depth } else { (forward + beside) * depth }
        };
        let id = |(n, &depth): (usize, &f32)| if depth.is_finite() { id_at(position(n, f64::from(depth))) } else { 0 };
        let ids = self.first.par_iter().enumerate().map(id).collect();
        Ok(Self { ids: Some(ids), ..self })
    }

    /// Ids of labels at the first depths, if they are known.
    pub fn ids(&self) -> Option<&[u32]> {
        self.ids.as_deref()
    }

    /// Fails unless the depths are those of a picture of this size.
    pub(super) fn check_size(&self, viewport: Viewport) -> Result<(), Error> {
        if self.viewport == viewport {
            return Ok(());
        }
        let Viewport { width, height, .. } = self.viewport;
        let problem = format!("depths of {width}x{height} do not fit a picture of {}x{}", viewport.width, viewport.height);
        Err(Error::Settings { field: "depth", problem })
    }

    /// Mean depth, weighted by the contribution to the pixel's opacity; at least the first depth.
    pub fn mean(&self) -> &[f32] {
        &self.mean
    }
}

impl Frame {
    /// Writes an `.exr` file with depth channels atomically: `Z` is the first visible depth, `mean.Z` the mean depth, and `id`, of
    /// unsigned integers, the ids of labels if there are any. Without a background, the picture keeps its alpha.
    ///
    /// # Errors
    /// If the extension is not `.exr`, the depths have another size, or the file cannot be written.
    pub fn save_with_depths(&self, path: impl AsRef<Path>, background: Option<Background>, depths: &Depths) -> Result<(), Error> {
        self.save_encoded(path, background, &Encoding::default(), Some(depths))
    }
}
