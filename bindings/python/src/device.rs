//! Devices: opened by name, or made from the caller's context, device and queue.

use crate::argument::{Argument, accepted, either, extract, refused};
use crate::calls::{abandonable, detached};
use crate::errors::{Result, conflict};
use crate::handles::{failed, handle};
use layersplat::opencl3::command_queue::{CL_QUEUE_PROFILING_ENABLE, CommandQueue, create_command_queue};
use layersplat::opencl3::context::context::{CL_CONTEXT_DEVICES, get_context_info};
use layersplat::opencl3::types::{cl_context, cl_device_id};
use layersplat::{Device as Ours, DeviceChoice};
use pyo3::Borrowed;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// An OpenCL device with a context and a queue.
///
/// name: index of the device to open, or part of its name. Alternatively context, device and queue of the caller, as objects with
/// int_ptr (pyopencl) or integer handles. They are retained, and released with the last renderer. A queue alone is enough. In a context
/// without a queue, a queue is created for the first device or the given one. Without arguments: the first GPU, otherwise the CPU.
///
/// memory: a memory budget in bytes for the buffers of all renderers of this Device. Volumes that do not fit are streamed in parts; the
/// picture is identical. Streaming supports layers on a lattice. Views and settings that need all voxels at once raise OutOfMemory, and
/// the message states how many bytes are enough. Renderer.enqueue and Renderer.volume_changed do not support streaming.
///
/// Integers that are not handles of live objects crash the process.
#[pyclass(frozen, module = "layersplat")]
pub struct Device(Ours);

impl Device {
    pub fn from_library(device: Ours) -> Self {
        Self(device)
    }

    pub fn ours(&self) -> &Ours {
        &self.0
    }
}

/// A device by index, or by part of its name.
enum Name {
    Index(usize),
    Part(String),
}

accepted! {
    Name: "the index of a device, or part of its name";
}

impl<'a, 'py> FromPyObject<'a, 'py> for Name {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        either(object, Name::Index, Name::Part)
    }
}

impl Name {
    fn choice(self) -> DeviceChoice {
        match self {
            Name::Index(index) => DeviceChoice::Named(index.to_string()),
            Name::Part(name) => DeviceChoice::Named(name),
        }
    }
}

#[pymethods]
impl Device {
    #[new]
    #[pyo3(signature = (name = None, *, context = None, device = None, queue = None, memory = None))]
    fn new(
        py: Python,
        name: Option<Argument<Name>>,
        context: Option<&Bound<PyAny>>,
        device: Option<&Bound<PyAny>>,
        queue: Option<&Bound<PyAny>>,
        memory: Option<Argument<u64>>,
    ) -> Result<Self> {
        extract!(name, memory);
        prepare_loader(py)?;
        if name.is_some() && [context, device, queue].iter().any(Option::is_some) {
            return Err(conflict("device", "give either a name, or context, device and queue"));
        }
        let opened = match name {
            Some(name) => abandonable(py, move || Ok(Ours::open(&name.choice())?))?,
            None => device_from_handles(py, context, device, queue)?,
        };
        Ok(Self(match memory {
            Some(bytes) => opened.with_memory(bytes),
            None => opened,
        }))
    }

    /// All devices, one dict each: index, name, kind, platform, version, driver, compute_units, memory_bytes.
    #[staticmethod]
    fn list(py: Python<'_>) -> Result<Vec<Bound<'_, PyDict>>> {
        prepare_loader(py)?;
        let described = |info: layersplat::device::DeviceInfo| -> PyResult<_> {
            let dict = PyDict::new(py);
            dict.set_item("index", info.index)?;
            dict.set_item("name", info.name)?;
            dict.set_item("kind", format!("{:?}", info.kind).to_lowercase())?;
            dict.set_item("platform", info.platform)?;
            dict.set_item("version", info.version)?;
            dict.set_item("driver", info.driver)?;
            dict.set_item("compute_units", info.compute_units)?;
            dict.set_item("memory_bytes", info.memory_bytes)?;
            Ok(dict)
        };
        Ok(detached(py, || Ok(Ours::list()?))?.into_iter().map(described).collect::<PyResult<_>>()?)
    }

    /// Device name.
    #[getter]
    fn name(&self) -> &str {
        &self.0.info().name
    }

    /// Platform name: the OpenCL implementation.
    #[getter]
    fn platform(&self) -> &str {
        &self.0.info().platform
    }

    /// The cl_context, valid as long as this object: pyopencl.Context.from_int_ptr(device.context).
    #[getter]
    fn context(&self) -> usize {
        self.0.context() as usize
    }

    /// The cl_device_id.
    #[getter]
    fn id(&self) -> usize {
        self.0.id() as usize
    }

    /// The cl_command_queue, valid as long as this object.
    #[getter]
    fn queue(&self) -> usize {
        self.0.queue() as usize
    }

    /// The memory budget in bytes; None without one.
    #[getter]
    fn memory(&self) -> Option<u64> {
        self.0.memory_budget()
    }

    /// Bytes of buffers that renderers have allocated.
    #[getter]
    fn allocated_bytes(&self) -> u64 {
        self.0.allocated_bytes()
    }

    fn __repr__(&self) -> String {
        format!("<layersplat.Device {} ({})>", self.name(), self.platform())
    }
}

/// Prepares the environment for the OpenCL loader of another package, before a loader is opened.
fn prepare_loader(py: Python) -> PyResult<()> {
    py.import("layersplat._loader")?.call_method0("prepare")?;
    Ok(())
}

/// The device of a renderer's arguments: a Device, a name, or handles of the caller.
pub fn device_from_arguments(
    device: Option<&Bound<PyAny>>,
    context: Option<&Bound<PyAny>>,
    queue: Option<&Bound<PyAny>>,
) -> Result<Ours> {
    let Some(object) = device else {
        return match context.or(queue) {
            None => default(),
            Some(any) => {
                prepare_loader(any.py())?;
                device_from_handles(any.py(), context, None, queue)
            }
        };
    };
    let py = object.py();
    prepare_loader(py)?;
    let alone = context.is_none() && queue.is_none();
    if let Ok(ours) = object.cast::<Device>() {
        return if alone { Ok(ours.get().0.clone()) } else { Err(conflict("device", "it has a context and a queue already")) };
    }
    match object.extract::<Name>() {
        Ok(name) if alone => abandonable(py, move || Ok(Ours::open(&name.choice())?)),
        Err(error) if alone && !object.hasattr("int_ptr")? => {
            Err(refused("device", object, error, "a layersplat.Device, the index of a device, or part of its name"))
        }
        _ => device_from_handles(py, context, Some(object), queue),
    }
}

/// The default device. It is cached, with its kernels.
fn default() -> Result<Ours> {
    Python::attach(|py| {
        let device = py.import("layersplat._default")?.call_method0("device")?;
        Ok(device.cast::<Device>().map_err(PyErr::from)?.get().0.clone())
    })
}

/// A device from handles of the caller: of a queue, or of a context with a new queue.
fn device_from_handles(
    py: Python,
    context: Option<&Bound<PyAny>>,
    device: Option<&Bound<PyAny>>,
    queue: Option<&Bound<PyAny>>,
) -> Result<Ours> {
    let context = context.map(|object| handle("context", object)).transpose()?;
    let device = device.map(|object| handle("device", object)).transpose()?;
    let queue = queue.map(|object| handle("queue", object)).transpose()?;
    let Some(queue) = queue else {
        let Some(context) = context else {
            return match device {
                None => abandonable(py, || Ok(Ours::open(&DeviceChoice::Default)?)),
                Some(_) => Err(conflict("device", "a device alone is not enough: give a context with it, or a queue")),
            };
        };
        return with_own_queue(context as _, device.map(|device| device as _));
    };
    // SAFETY: the documentation requires handles of live objects.
    let opened = unsafe { Ours::from_raw_queue(queue as _) }?;
    if context.is_none() && device.is_none() {
        return Ok(opened);
    }
    let (context, device) = (context.unwrap_or(opened.context() as usize), device.unwrap_or(opened.id() as usize));
    // SAFETY: as above.
    Ok(unsafe { Ours::from_handles(context as _, device as _, queue as _) }?)
}

/// A device with a new queue in the caller's context, for its first device or the given one.
fn with_own_queue(context: cl_context, device: Option<cl_device_id>) -> Result<Ours> {
    let device = match device {
        Some(device) => device,
        None => {
            let devices = get_context_info(context, CL_CONTEXT_DEVICES).map_err(|code| failed("clGetContextInfo", code))?;
            let devices: Vec<isize> = devices.into();
            *devices.first().ok_or_else(|| conflict("context", "it has no device"))? as cl_device_id
        }
    };
    #[allow(deprecated)] // The replacement needs OpenCL 2.0.
    // SAFETY: the documentation requires handles of live objects.
    let queue = unsafe { create_command_queue(context, device, CL_QUEUE_PROFILING_ENABLE) };
    let queue = CommandQueue::new(queue.map_err(|code| failed("clCreateCommandQueue", code))?, 1);
    Ok(Ours::from_queue(&queue)?)
}
