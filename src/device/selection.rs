//! Which devices there are, and which one to take.

use super::cache;
use super::kind::DeviceKind;
use super::tuning::Tuning;
use crate::error::Error;
use opencl3::device::{CL_DEVICE_TYPE_ALL, Device as ClDevice};
use opencl3::error_codes::{DLOPEN_FUNCTION_NOT_AVAILABLE, DLOPEN_RUNTIME_LOAD_FAILED};
use opencl3::platform::get_platforms;
use serde::Serialize;
use std::sync::{Mutex, PoisonError};

/// Which device to open.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum DeviceChoice {
    /// The first GPU if there is one, else the first CPU, else the first device.
    #[default]
    Default,
    /// An index into [`Device::list`](super::Device::list), or part of a device's or platform's name in any case.
    Named(String),
}

/// What a device is, and how it would be used.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct DeviceInfo {
    /// Position in the list of all devices; of one whose queue was handed over, none.
    pub index: Option<usize>,
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
        let known = devices
            .iter()
            .enumerate()
            .map(|(index, (_, info))| format!("{index} ({})", info.name))
            .collect::<Vec<_>>()
            .join(", ");
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
        Err(e) if [DLOPEN_RUNTIME_LOAD_FAILED, DLOPEN_FUNCTION_NOT_AVAILABLE].contains(&e.0) => {
            return Err(Error::NoOpenCl { missing: "library (libOpenCL.so.1)" });
        }
        Err(source) => return Err(Error::OpenCl { call: "clGetPlatformIDs", device: "this machine".into(), source }),
    };
    if platforms.is_empty() {
        return Err(Error::NoOpenCl { missing: "platform" });
    }
    let mut devices = Vec::new();
    let mut answers = Vec::new();
    for platform in platforms {
        let platform_name = platform.name().unwrap_or_default();
        let ids = platform.get_devices(CL_DEVICE_TYPE_ALL);
        answers.push((platform_name.clone(), ids.as_ref().map(Vec::len).map_err(ToString::to_string)));
        for id in ids.unwrap_or_default() {
            let device = ClDevice::new(id);
            let info = describe(&device, Some(devices.len()), &platform_name);
            devices.push((device, info));
        }
    }
    if devices.is_empty() { Err(no_device(&answers)) } else { Ok(devices) }
}

/// Why there is no device, from what each platform answered.
fn no_device(answers: &[(String, Result<usize, String>)]) -> Error {
    if let Some(folder) = cache::unwritable_folder().filter(|_| answers.iter().any(|(name, _)| cache::is_pocl(name))) {
        return Error::KernelCache { folder };
    }
    let said = |(name, answer): &(String, Result<usize, String>)| match answer {
        Ok(_) => format!("{name} has none"),
        Err(code) => format!("{name} answers {code}"),
    };
    Error::NoDevice { platforms: answers.iter().map(said).collect::<Vec<_>>().join(", ") }
}

pub(super) fn describe(device: &ClDevice, index: Option<usize>, platform: &str) -> DeviceInfo {
    let kind = DeviceKind::of(device.dev_type().unwrap_or(0));
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
