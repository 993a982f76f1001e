//! Renderers.

use crate::argument::{Argument, extract};
use crate::calls::abandonable;
use crate::camera::{Camera, around};
use crate::device::{Device, device_from_arguments};
use crate::device_volume::{DeviceVolume, is_pyopencl_array, refuse_voxels_on_device};
use crate::drawn_fields::DrawnFields;
use crate::errors::{Result, out_of_range};
use crate::event::Event;
use crate::exclusive::{AnyRenderer, Exclusive};
use crate::handles::{events, memory};
use crate::labels::Labels;
use crate::names::{Over, Size, orbit, picture_format};
use crate::settings::Settings;
use crate::slice::{Slice, colors};
use crate::stream_plan::stream_plan;
use crate::surface::Surface;
use crate::transfer::TransferFunction;
use crate::volume::Volume;
use layersplat::renderer::{PictureMemory, volume_renderer};
use layersplat::volume::Grid;
use layersplat::{Choice, Kernel, Renderer as Ours, Settings as OurSettings, TransferFunction as Transfer, Viewport};
use numpy::{Element, IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// A renderer of one volume on one device. Threads may share it.
///
/// volume: a Volume, or anything that Volume() takes, is uploaded. A DeviceVolume or a pyopencl.array.Array (z, y, x) is rendered in
/// place. transfer: a TransferFunction; by default one from the histogram, for voxels on the host. device: a Device, its name or index;
/// or the caller's context, device and queue, see Device. time_limit: time limit per frame in seconds; None: no limit. Instead of a volume,
/// a list of Channel, Colors and Labels is drawn together, and a Colors or a Labels by itself; they have their own colours, so transfer is
/// left out.
///
/// If the Device has a memory budget, or the volume exceeds its largest buffer, the voxels are uploaded during frames, in parts if they
/// do not fit. The renderer then keeps the Volume. See stream_plan.
///
/// On Python's main thread, Ctrl-C interrupts the constructor, render, render_float, depths, slice, slice_values and prepare: KeyboardInterrupt is raised
/// immediately. The kernel that is running completes first; the next call waits for it.
#[pyclass(frozen, module = "layersplat")]
pub struct Renderer {
    shared: Arc<Exclusive>,
    time_limit: Mutex<Option<Duration>>,
}

/// Only distributed renderers return no picture, and this package has none.
const ONE_PROCESS: &str = "a single-process renderer returns the picture";

/// A picture as an array (height, width, 4), without a copy.
fn picture<T: Element>(py: Python<'_>, values: Vec<T>, viewport: Viewport) -> PyResult<Bound<'_, PyArray3<T>>> {
    let values: Bound<PyArray1<T>> = values.into_pyarray(py);
    values.reshape([viewport.height as usize, viewport.width as usize, 4])
}

/// A depth map (height, width).
type Depths<'py> = Bound<'py, PyArray2<f32>>;

fn chosen(settings: Option<Bound<Settings>>) -> OurSettings {
    settings.map_or_else(OurSettings::default, |settings| *settings.get().ours())
}

/// A time limit in seconds.
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
        transfer: Option<Argument<Bound<TransferFunction>>>,
        device: Option<&Bound<PyAny>>,
        context: Option<&Bound<PyAny>>,
        queue: Option<&Bound<PyAny>>,
        time_limit: Option<Argument<f64>>,
    ) -> Result<Self> {
        extract!(transfer, time_limit);
        let time_limit = longest(time_limit)?;
        let transfer = transfer.as_ref().map(Bound::get);
        let py = volume.py();
        if let Some(shown) = DrawnFields::from_object(volume)? {
            let renderer = shown.renderer(py, transfer.is_some(), device_from_arguments(device, context, queue)?)?;
            return Ok(Self::with_limit(renderer, None, time_limit));
        }
        if let Ok(uploaded) = volume.cast::<DeviceVolume>() {
            return Self::from_device_volume(py, uploaded.get(), transfer, device, context, queue, time_limit);
        }
        if is_pyopencl_array(volume)? {
            // Default to the array's own queue.
            let own = volume.getattr("queue")?;
            let unspecified = device.is_none() && context.is_none() && queue.is_none() && !own.is_none();
            let device = device_from_arguments(device, context, if unspecified { Some(&own) } else { queue })?;
            let device = Bound::new(py, Device::from_library(device))?;
            let uploaded = py.import("layersplat._arrays")?.call_method1("on_device", (device, volume))?;
            let uploaded = uploaded.cast::<DeviceVolume>().map_err(PyErr::from)?;
            return Self::from_device_volume(py, uploaded.get(), transfer, None, None, None, time_limit);
        }
        let made;
        let volume = match volume.cast::<Volume>() {
            Ok(volume) => volume.get(),
            Err(_) => {
                made = Volume::from_data(volume)?;
                &made
            }
        };
        let device = device_from_arguments(device, context, queue)?;
        let transfer = transfer.map(|transfer| transfer.ours().clone());
        let volume = volume.ours().clone();
        let renderer = abandonable(py, move || {
            let transfer = transfer.unwrap_or_else(|| Transfer::automatic(&volume));
            Ok(volume_renderer(&device, &volume, &transfer)?)
        })?;
        Ok(Self::with_limit(renderer, None, time_limit))
    }

    /// Renders a picture: (height, width, 4), uint8, over a background; row 0 on top. With a transparent background, alpha is straight.
    #[pyo3(
        signature = (camera, size, settings = None, *, background = Argument::Default(Over::default())),
        text_signature = "($self, camera, size, settings=None, *, background='black')"
    )]
    fn render<'py>(
        &self,
        py: Python<'py>,
        camera: Argument<Bound<Camera>>,
        size: Argument<Size>,
        settings: Option<Argument<Bound<Settings>>>,
        background: Argument<Over>,
    ) -> Result<Bound<'py, PyArray3<u8>>> {
        extract!(camera, size, settings, background);
        let camera = *camera.get().ours();
        let (viewport, settings, background) = (size.viewport()?, chosen(settings), background.background()?);
        let (values, _) =
            self.shared.interruptible(py, move |ours| ours.render_rgba8(&camera, viewport, &settings, background))?;
        Ok(picture(py, values.expect(ONE_PROCESS), viewport)?)
    }

    /// Renders a picture: (height, width, 4), float32, premultiplied, 0 … 1, without a background; row 0 on top.
    #[pyo3(signature = (camera, size, settings = None))]
    fn render_float<'py>(
        &self,
        py: Python<'py>,
        camera: Argument<Bound<Camera>>,
        size: Argument<Size>,
        settings: Option<Argument<Bound<Settings>>>,
    ) -> Result<Bound<'py, PyArray3<f32>>> {
        extract!(camera, size, settings);
        let camera = *camera.get().ours();
        let (viewport, settings) = (size.viewport()?, chosen(settings));
        let (frame, _) = self.shared.interruptible(py, move |ours| ours.render(&camera, viewport, &settings))?;
        Ok(picture(py, frame.expect(ONE_PROCESS).into_pixels().into_flattened(), viewport)?)
    }

    /// Renders two depth maps (height, width), float32: the first visible depth, and the mean depth weighted by opacity. Depths are
    /// distances from the eye along the view direction, in world units; infinite where nothing is visible.
    ///
    /// Depths are always computed by ray casting. Raises InvalidValue for blend modes other than composite and iso.
    #[pyo3(signature = (camera, size, settings = None))]
    fn depths<'py>(
        &self,
        py: Python<'py>,
        camera: Argument<Bound<Camera>>,
        size: Argument<Size>,
        settings: Option<Argument<Bound<Settings>>>,
    ) -> Result<(Depths<'py>, Depths<'py>)> {
        extract!(camera, size, settings);
        let camera = *camera.get().ours();
        let (viewport, settings) = (size.viewport()?, chosen(settings));
        let depths = self.shared.interruptible(py, move |ours| ours.depths(&camera, viewport, &settings))?;
        let shape = [viewport.height as usize, viewport.width as usize];
        let array = |numbers: &[f32]| numbers.to_pyarray(py).reshape(shape);
        Ok((array(depths.first())?, array(depths.mean())?))
    }

    /// Draws a slice: (height, width, 4), uint8, over a background; row 0 on top. Where the slice lies outside the volume, the background
    /// shows.
    ///
    /// kernel: linear, cubic, catmull-rom, bspline or gaussian. window: (level, width) of a window of grey; otherwise the colours of the
    /// transfer function, opaque wherever it has any opacity. thickness: gives colours the opacity of a layer this many unit distances thick.
    #[pyo3(
        signature = (
            slice, size, *, kernel = Argument::Default("linear".into()), window = None, thickness = None,
            background = Argument::Default(Over::default()),
        ),
        text_signature = "($self, slice, size, *, kernel='linear', window=None, thickness=None, background='black')"
    )]
    #[allow(clippy::too_many_arguments)] // Python passes them by keyword.
    fn slice<'py>(
        &self,
        py: Python<'py>,
        slice: Argument<Bound<Slice>>,
        size: Argument<Size>,
        kernel: Argument<String>,
        window: Option<Argument<(f64, f64)>>,
        thickness: Option<Argument<f64>>,
        background: Argument<Over>,
    ) -> Result<Bound<'py, PyArray3<u8>>> {
        extract!(slice, size, kernel, window, thickness, background);
        let (slice, viewport, kernel) = (*slice.get().ours(), size.viewport()?, Kernel::from_name(&kernel)?);
        let (colors, background) = (colors(window, thickness)?, background.background()?);
        let draw = move |ours: &mut AnyRenderer| ours.require_whole("Renderer.slice")?.slice(&slice, viewport, kernel, colors);
        let frame = self.shared.interruptible(py, draw)?;
        Ok(picture(py, frame.to_rgba8(background), viewport)?)
    }

    /// The data values of a slice: (height, width), float32, NaN outside the volume. kernel: see slice.
    #[pyo3(
        signature = (slice, size, *, kernel = Argument::Default("linear".into())),
        text_signature = "($self, slice, size, *, kernel='linear')"
    )]
    fn slice_values<'py>(
        &self,
        py: Python<'py>,
        slice: Argument<Bound<Slice>>,
        size: Argument<Size>,
        kernel: Argument<String>,
    ) -> Result<Bound<'py, PyArray2<f32>>> {
        extract!(slice, size, kernel);
        let (slice, viewport, kernel) = (*slice.get().ours(), size.viewport()?, Kernel::from_name(&kernel)?);
        let find =
            move |ours: &mut AnyRenderer| ours.require_whole("Renderer.slice_values")?.slice_values(&slice, viewport, kernel);
        let values = self.shared.interruptible(py, find)?;
        Ok(values.values().to_pyarray(py).reshape([viewport.height as usize, viewport.width as usize])?)
    }

    /// Enqueues a picture into a buffer or a 2D image of the context, after wait_for. Returns an Event without waiting.
    ///
    /// onto: an object with int_ptr (pyopencl) or an integer handle. format: rgba8, over the background, or float, premultiplied, without
    /// a background. first: byte offset of the first pixel in a buffer. row_pitch: bytes from row to row. wait_for: Events, objects with
    /// int_ptr or integer handles.
    ///
    /// Raises InvalidValue for sheet algorithms, which need host readback, for hundreds of translucent surfaces behind each other, and if the
    /// picture does not fit. The queue stays usable.
    #[pyo3(
        signature = (
            camera, size, onto, settings = None, *, format = Argument::Default("rgba8".into()), background = Argument::Default(Over::default()), first = Argument::Default(0), row_pitch = None,
            wait_for = None,
        ),
        text_signature = "($self, camera, size, onto, settings=None, *, format='rgba8', background='black', first=0, row_pitch=None, \
            wait_for=None)"
    )]
    #[allow(clippy::too_many_arguments)] // Python passes them by keyword.
    fn enqueue(
        &self,
        py: Python,
        camera: Argument<Bound<Camera>>,
        size: Argument<Size>,
        onto: &Bound<PyAny>,
        settings: Option<Argument<Bound<Settings>>>,
        format: Argument<String>,
        background: Argument<Over>,
        first: Argument<usize>,
        row_pitch: Option<Argument<usize>>,
        wait_for: Option<Argument<Vec<Bound<PyAny>>>>,
    ) -> Result<Event> {
        extract!(camera, size, settings, format, background, first, row_pitch, wait_for);
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

    /// Replaces the volume, from the next frame on: a Volume, or anything that Volume() takes. Shape, type and range may differ. A list of
    /// Channel, Colors and Labels, a Colors or a Labels replaces all that is drawn; voxels that are on the device stay there.
    ///
    /// Raises InvalidType for voxels on a device (a DeviceVolume or a pyopencl.array.Array): they need a new Renderer. Raises
    /// OutOfMemory if device memory is insufficient; the renderer may then have no volume until one is set.
    fn set_volume(&self, volume: &Bound<PyAny>) -> Result<()> {
        if let Some(shown) = DrawnFields::from_object(volume)? {
            return self.shared.interruptible(volume.py(), move |renderer| shown.replace(renderer));
        }
        refuse_voxels_on_device(volume)?;
        let made;
        let ours = match volume.cast::<Volume>() {
            Ok(volume) => volume.get().ours().clone(),
            Err(_) => {
                made = Volume::from_data(volume)?;
                made.ours().clone()
            }
        };
        self.shared.interruptible(volume.py(), move |renderer| renderer.set_volume(&ours))
    }

    /// Draws the volume in the colours of labels from the next frame on, or in its own again: labels is None. Its opacities stay. The colour C of
    /// the volume becomes (1 - w) C + w L where a label has the colour L and the opacity w, before lighting; hidden labels leave it. Labels
    /// without a placement, as arrays, lie where a volume of their shape does.
    ///
    /// Point-sampled layers and ray casting have them, with the blend modes composite and iso; other frames, slices, and frames of channels,
    /// Colors or Labels raise InvalidValue. So do labels that lie outside the volume, and renderers that stream.
    fn set_label_colors(&self, py: Python, labels: Option<Argument<Bound<Labels>>>) -> Result<()> {
        extract!(labels);
        let labels = labels.map(|labels| labels.get().drawn().clone());
        self.shared.interruptible(py, move |renderer| {
            let renderer = renderer.require_whole("Renderer.set_label_colors")?;
            let colors = labels.map(|labels| labels.over_scan(renderer.device())).transpose()?;
            renderer.set_label_colors(colors.as_ref())
        })
    }

    /// Draws surfaces in and around the volume, from the next frame on, in place of those before: a list of Mesh, Spheres and Tubes.
    ///
    /// Slices show none. Splatted layers, sheets and slicing raise InvalidValue while there are visible ones.
    fn set_surfaces(&self, py: Python, surfaces: Argument<Vec<Bound<Surface>>>) -> Result<()> {
        extract!(surfaces);
        let surfaces: Vec<_> = surfaces.iter().map(|surface| surface.get().ours().clone()).collect();
        self.shared.interruptible(py, move |renderer| renderer.set_surfaces(&surfaces))
    }

    /// Builds the kernels, tables and layouts that pictures with these settings need, for every view direction, and waits for them.
    #[pyo3(signature = (camera, size, settings = None))]
    fn prepare(
        &self,
        py: Python,
        camera: Argument<Bound<Camera>>,
        size: Argument<Size>,
        settings: Option<Argument<Bound<Settings>>>,
    ) -> Result<()> {
        extract!(camera, size, settings);
        let camera = *camera.get().ours();
        let (viewport, settings) = (size.viewport()?, chosen(settings));
        self.shared.interruptible(py, move |ours| ours.prepare(&camera, viewport, &settings))
    }

    /// Notifies the renderer that voxels in the caller's memory change, and are valid after wait_for. Returns an Event; frames wait for
    /// it automatically.
    #[pyo3(signature = (wait_for = None))]
    fn volume_changed(&self, py: Python, wait_for: Option<Argument<Vec<Bound<PyAny>>>>) -> Result<Event> {
        extract!(wait_for);
        let wait = events(wait_for)?;
        let event = self
            .shared
            .with(py, |ours| ours.require_whole("Renderer.volume_changed")?.volume_changed(&wait.iter().collect::<Vec<_>>()))?;
        Ok(Event::new(event))
    }

    /// Cancels calls of render, render_float, depths, slice, slice_values and prepare on other threads, including those that wait for the renderer. They raise
    /// Cancelled before their next kernel. Later calls are not affected. Does not block.
    fn cancel(&self) {
        self.shared.cancel();
    }

    /// The streaming plan of a view, a dict; None if the renderer holds all voxels.
    ///
    /// lattices: a list of dicts with the layer axis, the number of parts that are uploaded in sequence, and held_layers, the maximum
    /// number of layers on the device. voxel_bytes: bytes of voxels that a frame uploads. light_bytes: bytes of those that it uploads before,
    /// for shadows and ambient occlusion; 0 if these are kept from an earlier frame. volume_bytes: bytes of all voxels. device_bytes: peak
    /// bytes of buffers. available_bytes: bytes available for these buffers.
    ///
    /// Raises OutOfMemory if the budget is too small for the view.
    #[pyo3(signature = (camera, size, settings = None))]
    fn stream_plan<'py>(
        &self,
        py: Python<'py>,
        camera: Argument<Bound<Camera>>,
        size: Argument<Size>,
        settings: Option<Argument<Bound<Settings>>>,
    ) -> Result<Option<Bound<'py, PyDict>>> {
        extract!(camera, size, settings);
        let camera = *camera.get().ours();
        let (viewport, settings) = (size.viewport()?, chosen(settings));
        let plan = self.shared.with(py, |ours| ours.stream_plan(&camera, viewport, &settings))?;
        Ok(plan.map(|plan| stream_plan(py, &plan)).transpose()?)
    }

    /// Time limit per frame in seconds; None: no limit. A frame that exceeds it raises TimedOut before its next kernel. It can be set,
    /// effective from the next frame. Enqueued frames are not limited.
    #[getter]
    fn time_limit(&self) -> Option<f64> {
        self.time_limit.lock().unwrap_or_else(PoisonError::into_inner).map(|limit| limit.as_secs_f64())
    }

    #[setter]
    fn set_time_limit(&self, py: Python, time_limit: Option<Argument<f64>>) -> Result<()> {
        extract!(time_limit);
        let longest = longest(time_limit)?;
        self.shared.with(py, |ours| {
            ours.limit(longest);
            Ok(())
        })?;
        *self.time_limit.lock().unwrap_or_else(PoisonError::into_inner) = longest;
        Ok(())
    }

    /// A camera that shows the whole grid from all sides. zoom: magnification relative to the fit.
    ///
    /// size: (width, height) in pixels, or one number for both. azimuth, elevation, roll: degrees, see Camera.orbit. field_of_view: the
    /// vertical angle of a perspective in degrees.
    #[pyo3(
        signature = (
            size, *, azimuth = Argument::Default(0.0), elevation = Argument::Default(0.0), roll = Argument::Default(0.0),
            zoom = Argument::Default(1.0), field_of_view = None,
        ),
        text_signature = "($self, size, *, azimuth=0.0, elevation=0.0, roll=0.0, zoom=1.0, field_of_view=None)"
    )]
    #[allow(clippy::too_many_arguments)] // Python passes them by keyword.
    fn camera(
        &self,
        py: Python,
        size: Argument<Size>,
        azimuth: Argument<f64>,
        elevation: Argument<f64>,
        roll: Argument<f64>,
        zoom: Argument<f64>,
        field_of_view: Option<Argument<f64>>,
    ) -> Result<Camera> {
        extract!(size, azimuth, elevation, roll, zoom, field_of_view);
        around(&self.grid(py)?, size.viewport()?, orbit(azimuth, elevation, roll)?, zoom, field_of_view)
    }

    /// The transfer function. It can be set, effective from the next frame.
    #[getter]
    fn transfer(&self, py: Python) -> Result<TransferFunction> {
        Ok(TransferFunction::from_library(self.shared.with(py, |ours| Ok(ours.transfer_function().clone()))?))
    }

    #[setter]
    fn set_transfer(&self, py: Python, transfer: Argument<Bound<TransferFunction>>) -> Result<()> {
        extract!(transfer);
        let transfer = transfer.get().ours();
        self.shared.with(py, |ours| {
            ours.set_transfer_function(transfer);
            Ok(())
        })
    }

    /// Panics during a call, for tests of the behaviour afterwards.
    fn _panic(&self, py: Python) -> Result<()> {
        self.shared.with(py, |_| panic!("in the middle"))
    }
}

impl Renderer {
    pub fn grid(&self, py: Python) -> Result<Grid> {
        self.shared.with(py, |ours| Ok(ours.grid().clone()))
    }

    /// A renderer of the library, and what owns its voxels.
    pub fn with_limit(mut renderer: Box<AnyRenderer>, owner: Option<Py<PyAny>>, time_limit: Option<Duration>) -> Self {
        renderer.limit(time_limit);
        Self { shared: Arc::new(Exclusive::new(renderer, owner)), time_limit: Mutex::new(time_limit) }
    }

    /// A renderer of voxels on a device. It uses the device of the volume.
    fn from_device_volume(
        py: Python,
        uploaded: &DeviceVolume,
        transfer: Option<&TransferFunction>,
        device: Option<&Bound<PyAny>>,
        context: Option<&Bound<PyAny>>,
        queue: Option<&Bound<PyAny>>,
        time_limit: Option<Duration>,
    ) -> Result<Self> {
        if device.is_some() || context.is_some() || queue.is_some() {
            let problem = "leave it out: the volume is already on the device that it was made with";
            return Err(crate::errors::conflict("device", problem));
        }
        let transfer = match transfer {
            Some(transfer) => transfer.ours().clone(),
            None => {
                return Err(crate::errors::conflict(
                    "transfer",
                    "voxels on a device have no histogram: give a transfer function",
                ));
            }
        };
        let renderer = Ours::from_uploaded(uploaded.ours(), &transfer)?;
        Ok(Self::with_limit(Box::new(renderer), Some(uploaded.owner().clone_ref(py)), time_limit))
    }
}
