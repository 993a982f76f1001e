//! Device kinds.

use opencl3::device::{CL_DEVICE_TYPE_CPU, CL_DEVICE_TYPE_GPU};
use serde::Serialize;

/// Kind of a device.
///
/// ```
/// use layersplat::Device;
/// use layersplat::device::DeviceKind;
///
/// let cpus = Device::list()?.into_iter().filter(|device| device.kind == DeviceKind::Cpu);
/// println!("{} CPU devices", cpus.count());
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum DeviceKind {
    /// The CPU of the host.
    Cpu,
    /// A GPU.
    Gpu,
    /// Any other device.
    Other,
}

impl DeviceKind {
    /// The kind for OpenCL's CL_DEVICE_TYPE on a platform.
    pub(super) fn from_device_type(device_type: u64, platform: &str) -> Self {
        match device_type {
            // Oclgrind reports all device types, but interprets kernels to check them. A CPU is preferable.
            _ if platform.contains("Oclgrind") => DeviceKind::Other,
            t if t & CL_DEVICE_TYPE_GPU != 0 => DeviceKind::Gpu,
            t if t & CL_DEVICE_TYPE_CPU != 0 => DeviceKind::Cpu,
            _ => DeviceKind::Other,
        }
    }
}
