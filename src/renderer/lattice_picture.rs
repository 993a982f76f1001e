//! The composited lattice before the warp.

use super::Renderer;
use super::frame::Output;
use super::plan::Plan;
use super::tiles::read_samples;
use crate::camera::Camera;
use crate::error::Error;
use crate::layers::{Lattice, Ray};
use crate::settings::Settings;
use crate::viewport::Viewport;

/// A composited lattice before the warp.
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
/// let mut renderer = Renderer::new(&device, &volume, &transfer)?;
/// let lattice = renderer.lattice_picture(&camera, viewport, &Settings::default())?.expect("a view with a lattice");
/// assert_eq!(lattice.samples.len(), (lattice.size[0] * lattice.size[1]) as usize);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct LatticePicture {
    lattice: Lattice,
    /// Number of samples along u and v.
    pub size: [u32; 2],
    /// Premultiplied RGBA, row by row.
    pub samples: Vec<[f32; 4]>,
}

impl LatticePicture {
    /// The ray of a sample.
    pub fn ray(&self, column: u32, row: u32) -> Ray {
        self.lattice.ray(column, row)
    }
}

impl Renderer {
    /// Renders the composited lattice before the warp to the screen, with the ray of each sample; `None` if the view has no
    /// lattice. If several layer axes contribute to the picture, this is the lattice of the most parallel one.
    pub fn lattice_picture(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
    ) -> Result<Option<LatticePicture>, Error> {
        let mut planned = self.planned(camera, viewport, settings)?;
        let lattice = match &planned.plan {
            Plan::Lattice(lattice, _) => lattice.clone(),
            Plan::Shared(parts, layered) => {
                let (lattice, layered) = (parts[0].0.clone(), *layered);
                planned.plan = Plan::Lattice(lattice.clone(), layered);
                lattice
            }
            _ => return Ok(None),
        };
        let (samples, _) =
            self.run(&planned, Output::Samples, |device, finished| read_samples(finished.floats(), device, lattice.samples()))?;
        Ok(Some(LatticePicture { size: lattice.size, lattice, samples }))
    }
}
