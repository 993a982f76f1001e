//! Renderers.

use crate::calls::abandonable;
use crate::camera::{Camera, around};
use crate::device::{Device, of_arguments};
use crate::device_volume::DeviceVolume;
use crate::errors::{Result, out_of_range};
use crate::event::Event;
use crate::exclusive::{AnyRenderer, Exclusive};
use crate::given::{Given, given};
use crate::handles::{events, memory};
use crate::names::{Over, Size, orbit, picture_format};
use crate::settings::Settings;
use crate::transfer::TransferFunction;
use crate::volume::Volume;
use layersplat::renderer::{PictureMemory, StreamPlan, volume_renderer};
use layersplat::{Renderer as Ours, Settings as OurSettings, TransferFunction as Transfer, Viewport};
use numpy::{Element, IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Renders one volume on one device; threads may share it.
///
/// volume: a Volume, or anything that Volume() takes, which is uploaded; or a DeviceVolume or a pyopencl.array.Array (z, y, x), whose voxels
/// stay where they are. transfer: a TransferFunction; by default, where the voxels were on the host, one from the histogram. device: a
/// Device, its name or index; or a caller's context, device and queue, see Device. time_limit: longest time of a frame in seconds, None
/// without a limit.
///
/// A Device with a memory budget, or whose largest buffer is smaller than the volume, gets the voxels during frames, in parts if they do not
/// fit: the renderer then keeps the Volume. See stream_plan.
///
/// On Python's main thread, Ctrl-C ends the constructor, render, render_float, depths and prepare: KeyboardInterrupt is raised at once. The
/// device ends the kernel that it is running; the next call waits for that.
#[pyclass(frozen, module = "layersplat")]
pub struct Renderer {
    shared: Arc<Exclusive>,
    time_limit: Mutex<Option<Duration>>,
}

/// Renderers of this package run in one process, which has every picture.
const ONE_PROCESS: &str = "a renderer of one process has the picture";

/// A picture's values as an array of (height, width, 4), without a copy.
fn picture<T: Element>(py: Python<'_>, values: Vec<T>, viewport: Viewport) -> PyResult<Bound<'_, PyArray3<T>>> {
    let values: Bound<PyArray1<T>> = values.into_pyarray(py);
    values.reshape([viewport.height as usize, viewport.width as usize, 4])
}

/// (height, width)
type Depths<'py> = Bound<'py, PyArray2<f32>>;

fn stream_plan<'py>(py: Python<'py>, plan: &StreamPlan) -> PyResult<Bound<'py, PyDict>> {
    let lattices = plan.lattices.iter().map(|lattice| {
        let dict = PyDict::new(py);
        dict.set_item("axis", format!("{:?}", lattice.axis).to_lowercase())?;
        dict.set_item("parts", lattice.parts)?;
        dict.set_item("held_layers", lattice.held_layers)?;
        Ok(dict)
    });
    let dict = PyDict::new(py);
    dict.set_item("lattices", lattices.collect::<PyResult<Vec<_>>>()?)?;
    dict.set_item("voxel_bytes", plan.voxel_bytes)?;
    dict.set_item("volume_bytes", plan.volume_bytes)?;
    dict.set_item("device_bytes", plan.device_bytes)?;
    dict.set_item("available_bytes", plan.memory)?;
    Ok(dict)
}

fn chosen(settings: Option<Bound<Settings>>) -> OurSettings {
    settings.map_or_else(OurSettings::default, |settings| *settings.get().ours())
}

/// A time limit of so many seconds.
fn longest(seconds: Option<f64>) -> Result<Option<Duration>> {
    let refused = |_| out_of_range("time_limit", seconds.unwrap_or_default(), "seconds, at least 0, or None");
    seconds.map(Duration::try_from_secs_f64).transpose().map_err(refused)
}

#[pymethods]
impl Renderer {
    #[new]
    #[pyo3(signature = (volume, transfer = None, *, device = None, context = None, queue = None, time_limit = None))]
    fn new(
        volume: &Bound<PyAny>,
        transfer: Option<Given<Bound<TransferFunction>>>,
        device: Option<&Bound<PyAny>>,
        context: Option<&Bound<PyAny>>,
        queue: Option<&Bound<PyAny>>,
        time_limit: Option<Given<f64>>,
    ) -> Result<Self> {
        given!(transfer, time_limit);
        let time_limit = longest(time_limit)?;
        let transfer = transfer.as_ref().map(Bound::get);
        let py = volume.py();
        if let Ok(there) = volume.cast::<DeviceVolume>() {
            return Self::of(py, there.get(), transfer, device, context, queue, time_limit);
        }
        // An array of pyopencl's.
        if volume.hasattr("base_data")? {
            // On its own queue, unless another is given.
            let own = volume.getattr("queue")?;
            let none = device.is_none() && context.is_none() && queue.is_none() && !own.is_none();
            let device = of_arguments(device, context, if none { Some(&own) } else { queue })?;
            let device = Bound::new(py, Device::new_of(device))?;
            let there = py.import("layersplat._arrays")?.call_method1("on_device", (device, volume))?;
            let there = there.cast::<DeviceVolume>().map_err(PyErr::from)?;
            return Self::of(py, there.get(), transfer, None, None, None, time_limit);
        }
        let made;
        let volume = match volume.cast::<Volume>() {
            Ok(volume) => volume.get(),
            Err(_) => {
                made = Volume::of(volume)?;
                &made
            }
        };
        let device = of_arguments(device, context, queue)?;
        let transfer = transfer.map(|transfer| transfer.ours().clone());
        let volume = volume.ours().clone();
        let renderer = abandonable(py, move || {
            let transfer = transfer.unwrap_or_else(|| Transfer::automatic(&volume));
            Ok(volume_renderer(&device, &volume, &transfer)?)
        })?;
        Ok(Self::with_limit(renderer, None, time_limit))
    }

    /// A picture: (height, width, 4), uint8, over a background; straight alpha over transparent; row 0 on top.
    #[pyo3(
        signature = (camera, size, settings = None, *, background = Given::Default(Over::default())),
        text_signature = "($self, camera, size, settings=None, *, background='black')"
    )]
    fn render<'py>(
        &self,
        py: Python<'py>,
        camera: Given<Bound<Camera>>,
        size: Given<Size>,
        settings: Option<Given<Bound<Settings>>>,
        background: Given<Over>,
    ) -> Result<Bound<'py, PyArray3<u8>>> {
        given!(camera, size, settings, background);
        let camera = *camera.get().ours();
        let (viewport, settings, background) = (size.viewport()?, chosen(settings), background.background()?);
        let (values, _) =
            self.shared.interruptible(py, move |ours| ours.render_rgba8(&camera, viewport, &settings, background))?;
        Ok(picture(py, values.expect(ONE_PROCESS), viewport)?)
    }

    /// A picture: (height, width, 4), float32, premultiplied, 0 … 1, without a background; row 0 on top.
    #[pyo3(signature = (camera, size, settings = None))]
    fn render_float<'py>(
        &self,
        py: Python<'py>,
        camera: Given<Bound<Camera>>,
        size: Given<Size>,
        settings: Option<Given<Bound<Settings>>>,
    ) -> Result<Bound<'py, PyArray3<f32>>> {
        given!(camera, size, settings);
        let camera = *camera.get().ours();
        let (viewport, settings) = (size.viewport()?, chosen(settings));
        let (frame, _) = self.shared.interruptible(py, move |ours| ours.render(&camera, viewport, &settings))?;
        Ok(picture(py, frame.expect(ONE_PROCESS).into_pixels().into_flattened(), viewport)?)
    }

    /// How far away is what a picture shows: two arrays (height, width), float32, distances from the eye along the view's direction, in world
    /// units, infinite where nothing is seen; where something is seen first, and on the average, weighted by opacity.
    ///
    /// Found by ray casting, whatever draws pictures. Raises InvalidValue for blend modes other than composite and iso.
    #[pyo3(signature = (camera, size, settings = None))]
    fn depths<'py>(
        &self,
        py: Python<'py>,
        camera: Given<Bound<Camera>>,
        size: Given<Size>,
        settings: Option<Given<Bound<Settings>>>,
    ) -> Result<(Depths<'py>, Depths<'py>)> {
        given!(camera, size, settings);
        let camera = *camera.get().ours();
        let (viewport, settings) = (size.viewport()?, chosen(settings));
        let depths = self.shared.interruptible(py, move |ours| ours.depths(&camera, viewport, &settings))?;
        let shape = [viewport.height as usize, viewport.width as usize];
        let array = |numbers: &[f32]| numbers.to_pyarray(py).reshape(shape);
        Ok((array(depths.first())?, array(depths.mean())?))
    }

    /// Enqueues a picture into a buffer or a 2D image of the context, after wait_for, and returns at once, with an Event.
    ///
    /// onto: an object with int_ptr (pyopencl's) or a number. format: rgba8, over the background, or float, premultiplied, without one.
    /// first: byte of the first pixel in a buffer; row_pitch: bytes from row to row. wait_for: Events, objects with int_ptr or numbers.
    ///
    /// Raises InvalidValue of sheets, which have to wait, and where the picture does not fit. What was enqueued leaves the queue usable.
    #[pyo3(
        signature = (
            camera, size, onto, settings = None, *, format = Given::Default("rgba8".into()), background = Given::Default(Over::default()), first = Given::Default(0), row_pitch = None,
            wait_for = None,
        ),
        text_signature = "($self, camera, size, onto, settings=None, *, format='rgba8', background='black', first=0, row_pitch=None, \
            wait_for=None)"
    )]
    #[allow(clippy::too_many_arguments)] // Each is named where it is given.
    fn enqueue(
        &self,
        py: Python,
        camera: Given<Bound<Camera>>,
        size: Given<Size>,
        onto: &Bound<PyAny>,
        settings: Option<Given<Bound<Settings>>>,
        format: Given<String>,
        background: Given<Over>,
        first: Given<usize>,
        row_pitch: Option<Given<usize>>,
        wait_for: Option<Given<Vec<Bound<PyAny>>>>,
    ) -> Result<Event> {
        given!(camera, size, settings, format, background, first, row_pitch, wait_for);
        let camera = *camera.get().ours();
        let (viewport, settings) = (size.viewport()?, chosen(settings));
        let mut onto = PictureMemory::new(&memory("onto", onto)?, picture_format(&format, &background)?).with_first(first);
        if let Some(row_pitch) = row_pitch {
            onto = onto.with_row_pitch(row_pitch);
        }
        let wait = events(wait_for)?;
        let event = self.shared.with(py, |ours| {
            let wait: Vec<_> = wait.iter().collect();
            ours.require_whole("Renderer.enqueue")?.enqueue(&camera, viewport, &settings, &onto, &wait)
        })?;
        Ok(Event::new(event))
    }

    /// Makes what pictures like this one need, from any side, and waits until it is there: kernels, tables, layouts.
    #[pyo3(signature = (camera, size, settings = None))]
    fn prepare(
        &self,
        py: Python,
        camera: Given<Bound<Camera>>,
        size: Given<Size>,
        settings: Option<Given<Bound<Settings>>>,
    ) -> Result<()> {
        given!(camera, size, settings);
        let camera = *camera.get().ours();
        let (viewport, settings) = (size.viewport()?, chosen(settings));
        self.shared.interruptible(py, move |ours| ours.prepare(&camera, viewport, &settings))
    }

    /// The voxels, in memory of the caller's own, are other ones after wait_for. Returns an Event; frames wait for it by themselves.
    #[pyo3(signature = (wait_for = None))]
    fn volume_changed(&self, py: Python, wait_for: Option<Given<Vec<Bound<PyAny>>>>) -> Result<Event> {
        given!(wait_for);
        let wait = events(wait_for)?;
        let event = self
            .shared
            .with(py, |ours| ours.require_whole("Renderer.volume_changed")?.volume_changed(&wait.iter().collect::<Vec<_>>()))?;
        Ok(Event::new(event))
    }

    /// Cancels the calls of render, render_float, depths and prepare that are in progress on other threads, or wait for the renderer: they
    /// raise Cancelled before their next kernel. Later calls are drawn in full. Returns at once, and does nothing where there are none.
    fn cancel(&self) {
        self.shared.cancel();
    }

    /// How a view would be streamed, a dict; None where the renderer holds all voxels, as without a memory budget.
    ///
    /// lattices: a list of dicts, each with the layer axis, the number of parts that are uploaded one after the other, and held_layers, the most
    /// layers on the device at a time. voxel_bytes: bytes of voxels that a frame uploads. volume_bytes: bytes of all voxels. device_bytes: most
    /// bytes of buffers at a time. available_bytes: bytes that these may take.
    ///
    /// Raises OutOfMemory where the budget is too small for the view.
    #[pyo3(signature = (camera, size, settings = None))]
    fn stream_plan<'py>(
        &self,
        py: Python<'py>,
        camera: Given<Bound<Camera>>,
        size: Given<Size>,
        settings: Option<Given<Bound<Settings>>>,
    ) -> Result<Option<Bound<'py, PyDict>>> {
        given!(camera, size, settings);
        let camera = *camera.get().ours();
        let (viewport, settings) = (size.viewport()?, chosen(settings));
        let plan = self.shared.with(py, |ours| ours.stream_plan(&camera, viewport, &settings))?;
        Ok(plan.map(|plan| stream_plan(py, &plan)).transpose()?)
    }

    /// Longest time of a frame in seconds; None: no limit. A longer frame raises TimedOut before its next kernel. It may be set, for the next
    /// frame on. Enqueued frames are not limited.
    #[getter]
    fn time_limit(&self) -> Option<f64> {
        self.time_limit.lock().unwrap_or_else(PoisonError::into_inner).map(|limit| limit.as_secs_f64())
    }

    #[setter]
    fn set_time_limit(&self, py: Python, time_limit: Option<Given<f64>>) -> Result<()> {
        given!(time_limit);
        let longest = longest(time_limit)?;
        self.shared.with(py, |ours| {
            ours.limit(longest);
            Ok(())
        })?;
        *self.time_limit.lock().unwrap_or_else(PoisonError::into_inner) = longest;
        Ok(())
    }

    /// A camera in which the whole grid fits from all sides; zoom: how many times larger it is seen then.
    ///
    /// size: (width, height) in pixels, or one number of both. azimuth, elevation, roll: degrees, see Camera.orbit. field_of_view: vertical,
    /// degrees, of a perspective.
    #[pyo3(
        signature = (
            size, *, azimuth = Given::Default(0.0), elevation = Given::Default(0.0), roll = Given::Default(0.0),
            zoom = Given::Default(1.0), field_of_view = None,
        ),
        text_signature = "($self, size, *, azimuth=0.0, elevation=0.0, roll=0.0, zoom=1.0, field_of_view=None)"
    )]
    #[allow(clippy::too_many_arguments)] // Each is named where it is given.
    fn camera(
        &self,
        py: Python,
        size: Given<Size>,
        azimuth: Given<f64>,
        elevation: Given<f64>,
        roll: Given<f64>,
        zoom: Given<f64>,
        field_of_view: Option<Given<f64>>,
    ) -> Result<Camera> {
        given!(size, azimuth, elevation, roll, zoom, field_of_view);
        let grid = self.shared.with(py, |ours| Ok(ours.grid().clone()))?;
        around(&grid, size.viewport()?, orbit(azimuth, elevation, roll)?, zoom, field_of_view)
    }

    /// The transfer function; another one may be set.
    #[getter]
    fn transfer(&self, py: Python) -> Result<TransferFunction> {
        Ok(TransferFunction::new_of(self.shared.with(py, |ours| Ok(ours.transfer_function().clone()))?))
    }

    #[setter]
    fn set_transfer(&self, py: Python, transfer: Given<Bound<TransferFunction>>) -> Result<()> {
        given!(transfer);
        let transfer = transfer.get().ours();
        self.shared.with(py, |ours| {
            ours.set_transfer_function(transfer);
            Ok(())
        })
    }

    /// Panics in the middle of a call: for the test of what follows.
    fn _panic(&self, py: Python) -> Result<()> {
        self.shared.with(py, |_| panic!("in the middle"))
    }
}

impl Renderer {
    fn with_limit(mut renderer: Box<AnyRenderer>, owner: Option<Py<PyAny>>, time_limit: Option<Duration>) -> Self {
        renderer.limit(time_limit);
        Self { shared: Arc::new(Exclusive::new(renderer, owner)), time_limit: Mutex::new(time_limit) }
    }

    /// Of voxels that are on a device already: on that device, unless another of its queues is given.
    fn of(
        py: Python,
        there: &DeviceVolume,
        transfer: Option<&TransferFunction>,
        device: Option<&Bound<PyAny>>,
        context: Option<&Bound<PyAny>>,
        queue: Option<&Bound<PyAny>>,
        time_limit: Option<Duration>,
    ) -> Result<Self> {
        if device.is_some() || context.is_some() || queue.is_some() {
            let problem = "the volume is on a device already: that is the one that it was made with";
            return Err(crate::errors::conflict("device", problem));
        }
        let transfer = match transfer {
            Some(transfer) => transfer.ours().clone(),
            None => {
                return Err(crate::errors::conflict(
                    "transfer",
                    "voxels on a device have no histogram at hand: give a transfer function",
                ));
            }
        };
        let renderer = Ours::from_uploaded(there.ours(), &transfer)?;
        Ok(Self::with_limit(Box::new(renderer), Some(there.owner().clone_ref(py)), time_limit))
    }
}
