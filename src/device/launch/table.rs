//! Launcher of table.cl.

use super::{launch, params::Float4};
use crate::device::{Buffer, Device, program::source};
use crate::error::Error;
use opencl3::kernel::Kernel;

/// Turns extinction into opacity for one step length.
pub(crate) struct TableKernel(Kernel);

impl TableKernel {
    pub fn new(device: &Device) -> Result<Self, Error> {
        Ok(Self(device.kernel(&source!("table"), "")?))
    }

    /// `dt` is the length of a sample in unit distances.
    pub fn launch(
        &self,
        device: &Device,
        base: &Buffer<Float4>,
        dt: f32,
        linear: bool,
        entries: &Buffer<Float4>,
    ) -> Result<(), Error> {
        let (linear, count) = (i32::from(linear), base.len() as i32);
        launch(device, "table", &self.0, base.len(), device.tuning().pixel_group, &[base, &dt, &linear, &count, entries])
    }
}
