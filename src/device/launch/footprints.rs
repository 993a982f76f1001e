//! Launchers of footprints.cl and footprint_set.cl.

use super::{launch, params::LayerOffset};
use crate::device::{Buffer, Device, program::source};
use crate::error::Error;
use opencl3::kernel::Kernel;

/// Makes the weights of a parallel lattice.
pub(crate) struct FootprintsKernel(Kernel);

impl FootprintsKernel {
    /// Weights per layer and phase.
    pub const WEIGHTS: usize = 16;

    pub fn new(device: &Device) -> Result<Self, Error> {
        Ok(Self(device.kernel(&source!("footprints", "footprint"), "")?))
    }

    /// `offsets` along u and v hold m values per layer; `layers` counts the two outer ones.
    pub fn launch(
        &self,
        device: &Device,
        offsets: [&Buffer<LayerOffset>; 2],
        shear: [f32; 2],
        samples_per_voxel: [i32; 2],
        layers: i32,
        weights: &Buffer<f32>,
    ) -> Result<(), Error> {
        let [m_u, m_v] = samples_per_voxel;
        let items = m_u as usize * m_v as usize * layers as usize;
        let arguments: [&dyn super::Argument; 8] = [offsets[0], offsets[1], &shear[0], &shear[1], &m_u, &m_v, &layers, weights];
        launch(device, "footprints", &self.0, items, device.tuning().pixel_group, &arguments)
    }
}

/// Makes the set of oriented footprint images.
pub(crate) struct FootprintSetKernel(Kernel);

impl FootprintSetKernel {
    pub fn new(device: &Device) -> Result<Self, Error> {
        Ok(Self(device.kernel(&source!("footprint_set", "footprint"), "")?))
    }

    /// `images` takes 64² bytes per entry of `shears`.
    pub fn launch(&self, device: &Device, shears: &Buffer<[f32; 2]>, images: &Buffer<u8>) -> Result<(), Error> {
        let count = images.len() as i32;
        launch(device, "footprint set", &self.0, images.len(), device.tuning().pixel_group, &[shears, &count, images])
    }
}
