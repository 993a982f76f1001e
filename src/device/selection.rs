//! Lists devices and selects one.

use super::cache;
use super::kind::DeviceKind;
use super::loader;
use super::tuning::Tuning;
use crate::error::Error;
use opencl3::device::{CL_DEVICE_TYPE_ALL, Device as ClDevice};
use opencl3::error_codes::{DLOPEN_FUNCTION_NOT_AVAILABLE, DLOPEN_RUNTIME_LOAD_FAILED};
use opencl3::platform::get_platforms;
use serde::Serialize;
use std::sync::{Mutex, PoisonError};

/// Which device to open.
///
/// ```
/// use layersplat::{Device, DeviceChoice};
///
/// let name = Device::open(&DeviceChoice::Default)?.info().name.clone();
/// assert!(Device::open(&DeviceChoice::Named(name)).is_ok());
/// assert!(Device::open(&DeviceChoice::Named("no such device".into())).is_err());
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum DeviceChoice {
    /// The first GPU if there is one, else PoCL's CPU, else the first CPU, else the first device.
    #[default]
    Default,
    /// An index into [`Device::list`](super::Device::list), or a case-insensitive part of a platform or device name. Selects the
    /// first device of a matching platform, else the first matching device. `pocl` matches PoCL, whose platform name is Portable
    /// Computing Language.
    Named(String),
}

/// Properties of a device, and its default tuning.
///
/// ```
/// for device in layersplat::Device::list()? {
///     println!("{}: {} compute units, {} MiB", device.name, device.compute_units, device.memory_bytes >> 20);
/// }
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct DeviceInfo {
    /// Index in [`Device::list`](super::Device::list); `None` for a device opened from a caller's queue.
    pub index: Option<usize>,
    /// Device name.
    pub name: String,
    /// CPU, GPU or other.
    pub kind: DeviceKind,
    /// Platform name (the OpenCL implementation).
    pub platform: String,
    /// Supported OpenCL version.
    pub version: String,
    /// Driver version.
    pub driver: String,
    /// Number of compute units, such as cores.
    pub compute_units: u32,
    /// Device memory in bytes.
    pub memory_bytes: u64,
    /// Maximum size of a single buffer in bytes.
    pub largest_buffer_bytes: u64,
    /// Default tuning values.
    pub tuning: Tuning,
}

/// CL_PLATFORM_NOT_FOUND_KHR: a loader without any implementation.
const NO_PLATFORM: i32 = -1001;

pub(super) fn list() -> Result<Vec<DeviceInfo>, Error> {
    Ok(all()?.into_iter().map(|(_, info)| info).collect())
}

pub(super) fn choose(choice: &DeviceChoice) -> Result<(ClDevice, DeviceInfo), Error> {
    let mut devices = all()?;
    let position = match choice {
        DeviceChoice::Default => {
            devices.iter().map(|(_, info)| info).enumerate().min_by_key(|(_, info)| rank(info)).map_or(0, |(n, _)| n)
        }
        DeviceChoice::Named(name) => find(name, devices.iter().map(|(_, info)| info))?,
    };
    Ok(devices.swap_remove(position))
}

/// Preference of a device as the default; lower is better.
fn rank(info: &DeviceInfo) -> u32 {
    match info.kind {
        DeviceKind::Gpu => 0,
        // Intel's runtime takes 1.7 times as long on the same CPU.
        DeviceKind::Cpu if cache::is_pocl(&info.platform) => 1,
        DeviceKind::Cpu => 2,
        DeviceKind::Other => 3,
    }
}

/// The index of the device selected by an index or a name.
fn find<'a>(name: &str, devices: impl Iterator<Item = &'a DeviceInfo> + Clone) -> Result<usize, Error> {
    let wanted = name.to_lowercase();
    let platform = |info: &DeviceInfo| {
        // The short name occurs neither in the platform name nor in the device name.
        info.platform.to_lowercase().contains(&wanted) || (wanted == "pocl" && cache::is_pocl(&info.platform))
    };
    let device = |info: &DeviceInfo| info.name.to_lowercase().contains(&wanted);
    let found = match name.parse::<usize>() {
        Ok(index) => (index < devices.clone().count()).then_some(index),
        Err(_) if wanted.is_empty() => None,
        // "intel" selects Intel's runtime rather than PoCL on an Intel CPU.
        Err(_) => devices.clone().position(platform).or_else(|| devices.clone().position(device)),
    };
    found.ok_or_else(|| {
        let known = devices.enumerate().map(|(index, info)| format!("{index} ({}, {})", info.name, info.platform));
        // The wanted implementation may be installed without a library that it needs.
        let known = known.chain(loader::failures().into_iter().map(|f| format!("or repair {f}"))).collect::<Vec<_>>().join(", ");
        Error::UnknownName { what: "device", name: name.into(), known }
    })
}

/// Serialises queries: PoCL creates its devices at the first query, and concurrent queries may find none.
static QUERY: Mutex<()> = Mutex::new(());

pub(super) fn all() -> Result<Vec<(ClDevice, DeviceInfo)>, Error> {
    let _one_at_a_time = QUERY.lock().unwrap_or_else(PoisonError::into_inner);
    let platforms = match get_platforms() {
        Ok(platforms) => platforms,
        Err(e) if e.0 == NO_PLATFORM => Vec::new(),
        Err(e) if [DLOPEN_RUNTIME_LOAD_FAILED, DLOPEN_FUNCTION_NOT_AVAILABLE].contains(&e.0) => {
            return Err(Error::NoOpenCl { missing: "library", failures: vec![loader::loader_error()] });
        }
        Err(source) => return Err(Error::OpenCl { call: "clGetPlatformIDs", device: "this machine".into(), source }),
    };
    if platforms.is_empty() {
        return Err(Error::NoOpenCl { missing: "platform", failures: loader::failures() });
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

/// The error for a system without devices. `answers`: the number of devices or the error of each platform.
fn no_device(answers: &[(String, Result<usize, String>)]) -> Error {
    if let Some(error) = answers.iter().find_map(|(name, _)| cache::unusable_cache(name)) {
        return error;
    }
    let describe = |(name, answer): &(String, Result<usize, String>)| match answer {
        Ok(_) => format!("{name} has no device"),
        Err(code) => format!("{name} returned {code}"),
    };
    Error::NoDevice { platforms: answers.iter().map(describe).collect::<Vec<_>>().join(", ") }
}

pub(super) fn describe(device: &ClDevice, index: Option<usize>, platform: &str) -> DeviceInfo {
    let kind = DeviceKind::from_device_type(device.dev_type().unwrap_or(0), platform);
    let text = |value: opencl3::Result<String>| value.unwrap_or_default().trim().to_owned();
    let compute_units = device.max_compute_units().unwrap_or(0);
    DeviceInfo {
        index,
        name: text(device.name()),
        kind,
        platform: platform.trim().to_owned(),
        version: text(device.version()),
        driver: text(device.driver_version()),
        compute_units,
        memory_bytes: device.global_mem_size().unwrap_or(0),
        largest_buffer_bytes: device.max_mem_alloc_size().unwrap_or(0),
        tuning: Tuning::new(kind, platform, device.native_vector_width_float().unwrap_or(0), compute_units),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use opencl3::device::CL_DEVICE_TYPE_GPU;

    fn device(kind: DeviceKind, platform: &str) -> DeviceInfo {
        DeviceInfo {
            index: Some(0),
            name: String::new(),
            kind,
            platform: platform.into(),
            version: String::new(),
            driver: String::new(),
            compute_units: 0,
            memory_bytes: 0,
            largest_buffer_bytes: 0,
            tuning: Tuning::new(kind, platform, 16, 1),
        }
    }

    #[test]
    fn devices_are_found_by_index_platform_and_name() {
        let named = |platform, name: &str| DeviceInfo { name: name.into(), ..device(DeviceKind::Cpu, platform) };
        let devices = [
            named("NVIDIA CUDA", "NVIDIA H100"),
            named("Portable Computing Language", "cpu-skylake-Intel(R) Xeon(R)"),
            named("Intel(R) OpenCL", "Intel(R) Xeon(R)"),
        ];
        let found = |name: &str| find(name, devices.iter()).ok();
        for name in ["pocl", "PoCL", "portable", "1", "SKYLAKE"] {
            assert_eq!(found(name), Some(1), "{name}");
        }
        assert_eq!((found("intel"), found("h100"), found("nvidia"), found("xeon")), (Some(2), Some(0), Some(0), Some(1)));
        assert_eq!((found("3"), found(""), found("rusticl")), (None, None, None));
        let message = find("rusticl", devices.iter()).unwrap_err().to_string();
        assert!(message.contains("0 (NVIDIA H100, NVIDIA CUDA)") && message.contains("Portable"), "{message}");
    }

    #[test]
    fn a_gpu_is_preferred_to_pocl_and_pocl_to_other_cpus() {
        let in_order = [
            device(DeviceKind::Gpu, "NVIDIA CUDA"),
            device(DeviceKind::Cpu, "Portable Computing Language"),
            device(DeviceKind::Cpu, "Intel(R) OpenCL"),
            device(DeviceKind::from_device_type(CL_DEVICE_TYPE_GPU, "Oclgrind"), "Oclgrind"),
        ];
        assert!(in_order.iter().is_sorted_by(|a, b| rank(a) < rank(b)), "{:?}", in_order.each_ref().map(rank));
    }
}
