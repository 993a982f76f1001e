//! Everything a picture needs, from the shared options.

use super::options::{CameraOptions, DeviceOptions, QualityOptions, TransferOptions, VolumeOptions};
use crate::camera::{Camera, Orbit, Projection};
use crate::device::Device;
use crate::error::Error;
use crate::renderer::{Renderer, Settings};
use crate::transfer::TransferFunction;
use crate::volume::{Grid, Volume};
use clap::Args;

/// Options of `render`, `rotate` and `bench`.
#[derive(Args)]
pub(super) struct SceneOptions {
    #[command(flatten)]
    pub volume: VolumeOptions,
    #[command(flatten)]
    pub transfer: TransferOptions,
    #[command(flatten)]
    pub camera: CameraOptions,
    #[command(flatten)]
    pub device: DeviceOptions,
    #[command(flatten)]
    pub quality: QualityOptions,
}

/// A volume with its transfer function, and how it is to be rendered.
pub(super) struct Scene {
    pub volume: Volume,
    pub transfer: TransferFunction,
    pub settings: Settings,
    pub device: Device,
}

impl Scene {
    /// Checks the options, opens the device and reads the volume.
    pub fn open(options: &SceneOptions) -> Result<Self, Error> {
        let settings = options.quality.settings()?;
        let volume = Volume::open(&options.volume.volume, &options.volume.raw())?;
        let transfer = open_transfer(&options.transfer, &volume)?;
        let choice = options.device.choice();
        let device = Device::open(&choice)?;
        Ok(Self { volume, transfer, settings, device })
    }

    pub fn renderer(&self) -> Result<Renderer, Error> {
        Renderer::new(&self.device, &self.volume, &self.transfer)
    }
}

/// The wanted transfer function, or one from the histogram.
pub(super) fn open_transfer(options: &TransferOptions, volume: &Volume) -> Result<TransferFunction, Error> {
    let transfer = match &options.transfer {
        Some(source) => TransferFunction::open(source, volume)?,
        None => TransferFunction::automatic(volume),
    };
    match options.transfer_range {
        Some((lo, hi)) => transfer.stretched(lo, hi),
        None => Ok(transfer),
    }
}

/// The camera that the options ask for, on an orbit.
pub(super) fn camera(options: &CameraOptions, grid: &Grid, orbit: Orbit) -> Camera {
    let centre = options.center.unwrap_or_else(|| grid.centre());
    match (options.perspective, options.parallel_scale, options.distance) {
        (Some(field_of_view), _, Some(distance)) => {
            Camera::orbit(centre, distance, orbit, Projection::Perspective { field_of_view })
        }
        (Some(field_of_view), _, None) => Camera::fit_perspective(centre, grid.diagonal(), field_of_view, orbit),
        (None, Some(scale), _) => Camera::orbit(centre, grid.diagonal(), orbit, Projection::Parallel { scale }),
        (None, None, _) => Camera::fit_parallel(centre, grid.diagonal(), options.size, orbit),
    }
}
