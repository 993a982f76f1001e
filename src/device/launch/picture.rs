//! Launchers of warp.cl and present.cl.

use super::{launch, params::Float4, params::WarpParams};
use crate::device::{Buffer, Device, program::source};
use crate::error::Error;
use opencl3::kernel::Kernel;

/// Brings a composited lattice onto the screen.
pub(crate) struct WarpKernel(Kernel);

impl WarpKernel {
    pub fn new(device: &Device) -> Result<Self, Error> {
        Ok(Self(device.kernel(&source!("warp"), "")?))
    }

    pub fn launch(
        &self,
        device: &Device,
        lattice: &Buffer<Float4>,
        params: &WarpParams,
        frame: &Buffer<Float4>,
    ) -> Result<(), Error> {
        let pixels = params.frame[0] as usize * params.frame[1] as usize;
        launch(device, "warp", &self.0, pixels, device.tuning().pixel_group, &[lattice, params, frame])
    }
}

/// Makes the 8-bit picture.
pub(crate) struct PresentKernel(Kernel);

impl PresentKernel {
    pub fn new(device: &Device) -> Result<Self, Error> {
        Ok(Self(device.kernel(&source!("present"), "")?))
    }

    /// `background` is red, green, blue and 1, or four zeros for a transparent picture.
    pub fn launch(
        &self,
        device: &Device,
        frame: &Buffer<Float4>,
        background: Float4,
        pixels: usize,
        rgba: &Buffer<[u8; 4]>,
    ) -> Result<(), Error> {
        let count = pixels as i32;
        launch(device, "present", &self.0, pixels, device.tuning().pixel_group, &[frame, &background, &count, rgba])
    }
}
