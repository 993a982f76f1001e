//! Launchers of warp.cl and present.cl.

use super::{launch, params::Float4, params::WarpParams};
use crate::device::{Buffer, Device, program::source};
use crate::error::Error;
use opencl3::kernel::Kernel;
use std::marker::PhantomData;

/// Brings a composited lattice onto the screen, as a frame of floats (`T` = [`Float4`]) or as the 8-bit picture.
pub(crate) struct WarpKernel<T>(Kernel, PhantomData<T>);

/// A kind of pixel that [`WarpKernel`] makes.
pub(crate) trait WarpedPixel: Copy {
    const DEFINES: &str;
}

impl WarpedPixel for Float4 {
    const DEFINES: &str = "";
}

impl WarpedPixel for [u8; 4] {
    const DEFINES: &str = "-DPRESENT";
}

/// What [`WarpKernel`] reads.
pub(crate) struct WarpArguments<'a> {
    pub lattice: &'a Buffer<Float4>,
    /// `params.counts` per tile.
    pub active_samples: &'a Buffer<u32>,
    pub params: WarpParams,
    /// See [`PresentKernel::launch`]; of no use to floats.
    pub background: Float4,
}

impl<T: WarpedPixel> WarpKernel<T> {
    pub fn new(device: &Device) -> Result<Self, Error> {
        let [columns, rows] = device.tuning().block;
        let defines = format!("-DBLOCK_COLUMNS={columns} -DBLOCK_ROWS={rows} {}", T::DEFINES);
        Ok(Self(device.kernel(&source!("warp", "elementary", "display"), &defines)?, PhantomData))
    }

    pub fn launch(&self, device: &Device, a: &WarpArguments, picture: &Buffer<T>) -> Result<(), Error> {
        let [columns, rows] = device.tuning().block;
        let blocks = (a.params.frame[0] as u32).div_ceil(columns) as usize * (a.params.frame[1] as u32).div_ceil(rows) as usize;
        let group = device.tuning().tile_group;
        launch(device, "warp", &self.0, blocks, group, &[a.lattice, a.active_samples, &a.params, &a.background, picture])
    }
}

/// Makes the 8-bit picture.
pub(crate) struct PresentKernel(Kernel);

impl PresentKernel {
    pub fn new(device: &Device) -> Result<Self, Error> {
        Ok(Self(device.kernel(&source!("present", "elementary", "display"), "")?))
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
