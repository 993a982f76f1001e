//! Which devices there are, and which one to take.

use super::tuning::Tuning;
use crate::error::Error;
use opencl3::device::{CL_DEVICE_TYPE_ALL, CL_DEVICE_TYPE_CPU, CL_DEVICE_TYPE_GPU, Device as ClDevice};
use opencl3::platform::get_platforms;
use serde::Serialize;
use std::sync::{Mutex, PoisonError};

/// Kind of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum DeviceKind {
    /// The host's processors.
    Cpu,
    /// A graphics processor.
    Gpu,
    /// Anything else.
    Other,
}

/// Which device to open.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum DeviceChoice {
    /// The first GPU if there is one, else the first CPU, else the first device.
    #[default]
    Default,
    /// An index into [`Device::list`](super::Device::list), or part of a device's or platform's name in any case.
    Named(String),
}

/// What a device is, and how it would be used.
#[derive(Clone, Debug, Serialize)]
pub struct DeviceInfo {
    /// Position in the list of all devices.
    pub index: usize,
    /// Name of the device.
    pub name: String,
    /// CPU or GPU.
    pub kind: DeviceKind,
    /// Name of the platform (the OpenCL implementation).
    pub platform: String,
    /// OpenCL version that the device supports.
    pub version: String,
    /// Version of the driver.
    pub driver: String,
    /// Cores or the like.
    pub compute_units: u32,
    /// Bytes of memory.
    pub memory_bytes: u64,
    /// Bytes that a single buffer may have.
    pub largest_buffer_bytes: u64,
    /// Tuning that would be used.
    pub tuning: Tuning,
}

/// CL_PLATFORM_NOT_FOUND_KHR: there is a loader, but no implementation.
const NO_PLATFORM: i32 = -1001;

pub(super) fn list() -> Result<Vec<DeviceInfo>, Error> {
    Ok(all()?.into_iter().map(|(_, info)| info).collect())
}

pub(super) fn choose(choice: &DeviceChoice) -> Result<(ClDevice, DeviceInfo), Error> {
    let mut devices = all()?;
    let position = match choice {
        DeviceChoice::Default => {
            let first = |kind| devices.iter().position(|(_, info)| info.kind == kind);
            first(DeviceKind::Gpu).or(first(DeviceKind::Cpu)).unwrap_or(0)
        }
        DeviceChoice::Named(name) => find(name, &devices)?,
    };
    Ok(devices.swap_remove(position))
}

fn find(name: &str, devices: &[(ClDevice, DeviceInfo)]) -> Result<usize, Error> {
    let wanted = name.to_lowercase();
    let named = |info: &DeviceInfo| info.name.to_lowercase().contains(&wanted) || info.platform.to_lowercase().contains(&wanted);
    let found = match name.parse::<usize>() {
        Ok(index) => (index < devices.len()).then_some(index),
        Err(_) if wanted.is_empty() => None,
        Err(_) => devices.iter().position(|(_, info)| named(info)),
    };
    found.ok_or_else(|| {
        let known = devices.iter().map(|(_, info)| format!("{} ({})", info.index, info.name)).collect::<Vec<_>>().join(", ");
        Error::UnknownName { what: "device", name: name.into(), known }
    })
}

/// PoCL makes its devices at the first query, and threads that ask at the same time may find none.
static QUERY: Mutex<()> = Mutex::new(());

fn all() -> Result<Vec<(ClDevice, DeviceInfo)>, Error> {
    let _one_at_a_time = QUERY.lock().unwrap_or_else(PoisonError::into_inner);
    let platforms = match get_platforms() {
        Ok(platforms) => platforms,
        Err(e) if e.0 == NO_PLATFORM => Vec::new(),
        Err(_) => {
            return Err(Error::NoOpenCl { missing: "library (libOpenCL.so.1)" });
        }
    };
    if platforms.is_empty() {
        return Err(Error::NoOpenCl { missing: "platform" });
    }
    let mut devices = Vec::new();
    for platform in platforms {
        let platform_name = platform.name().unwrap_or_default();
        for id in platform.get_devices(CL_DEVICE_TYPE_ALL).unwrap_or_default() {
            let device = ClDevice::new(id);
            let info = describe(&device, devices.len(), &platform_name);
            devices.push((device, info));
        }
    }
    if devices.is_empty() { Err(Error::NoOpenCl { missing: "device" }) } else { Ok(devices) }
}

fn describe(device: &ClDevice, index: usize, platform: &str) -> DeviceInfo {
    let kind = match device.dev_type().unwrap_or(0) {
        t if t & CL_DEVICE_TYPE_GPU != 0 => DeviceKind::Gpu,
        t if t & CL_DEVICE_TYPE_CPU != 0 => DeviceKind::Cpu,
        _ => DeviceKind::Other,
    };
    let text = |value: opencl3::Result<String>| value.unwrap_or_default().trim().to_owned();
    DeviceInfo {
        index,
        name: text(device.name()),
        kind,
        platform: platform.trim().to_owned(),
        version: text(device.version()),
        driver: text(device.driver_version()),
        compute_units: device.max_compute_units().unwrap_or(0),
        memory_bytes: device.global_mem_size().unwrap_or(0),
        largest_buffer_bytes: device.max_mem_alloc_size().unwrap_or(0),
        tuning: Tuning::new(kind, platform, device.native_vector_width_float().unwrap_or(0)),
    }
}
