//! What devices are there for.

use opencl3::device::{CL_DEVICE_TYPE_CPU, CL_DEVICE_TYPE_GPU};
use serde::Serialize;

/// Kind of a device.
///
/// ```
/// use layersplat::Device;
/// use layersplat::device::DeviceKind;
///
/// let processors = Device::list()?.into_iter().filter(|device| device.kind == DeviceKind::Cpu);
/// println!("{} processors", processors.count());
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum DeviceKind {
    /// The host's processors.
    Cpu,
    /// A graphics processor.
    Gpu,
    /// Anything else.
    Other,
}

impl DeviceKind {
    /// The kind that OpenCL's CL_DEVICE_TYPE says, on a platform.
    pub(super) fn of(device_type: u64, platform: &str) -> Self {
        match device_type {
            // It calls itself all there is, and interprets kernels to check them: nothing to take before a processor.
            _ if platform.contains("Oclgrind") => DeviceKind::Other,
            t if t & CL_DEVICE_TYPE_GPU != 0 => DeviceKind::Gpu,
            t if t & CL_DEVICE_TYPE_CPU != 0 => DeviceKind::Cpu,
            _ => DeviceKind::Other,
        }
    }
}
