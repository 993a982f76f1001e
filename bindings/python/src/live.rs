//! Views that are live in a notebook: the library's sessions of pages, whose messages Python carries.

use crate::argument::{Argument, extract};
use crate::calls::detached;
use crate::camera::Camera;
use crate::device::Device;
use crate::errors::{Failure, Result};
use crate::labels::Labels;
use crate::names::Over;
use crate::renderer::Renderer;
use crate::settings::Settings;
use crate::transfer::TransferFunction;
use crate::volume::Volume;
use layersplat::camera::Up;
use layersplat::framing::Orientation;
use layersplat::viewer::{Change, Drawn, First, Host, Look, Message, Opening, Overlay, PageCamera, Session, SharedScene, Wanted};
use layersplat::{Background, Camera as OurCamera, Error, Orbit, Projection, Quality, Settings as OurSettings, Viewport};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyList, PyString};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Locks what no panic leaves half changed.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What a view looks like.
struct ViewLook {
    overlay: Overlay,
    /// The newest look, by Python or by a hand.
    look: Look,
}

/// The program around the pages.
struct View {
    shown: Mutex<ViewLook>,
    dims: [usize; 3],
    /// The value that an iso-surface begins with.
    iso: f64,
    frame: layersplat::camera::OrbitFrame,
    has_labels: bool,
}

impl View {
    fn overlay(&self, settings: OurSettings, background: Background) -> Overlay {
        Overlay::new(settings, background, self.iso, self.dims)
    }

    /// The newest look. The own lights of the studio stay in the world where this camera sees them first: turning computes no light anew.
    /// Returns the look before, too, which Python knows until the page tells it the other.
    fn look_from(&self, camera: &OurCamera) -> Result<(Look, Look)> {
        let mut shown = locked(&self.shown);
        let before = shown.look.clone();
        if shown.look.has_light_of_studio() {
            shown.look = shown.look.clone().with_light_in_world(camera)?;
        }
        Ok((before, shown.look.clone()))
    }
}

/// The host of the scene is the view, which Python reaches too.
struct ViewHost(Arc<View>);

impl Host for ViewHost {
    fn settings(&self, look: &Look, quality: Option<Quality>) -> std::result::Result<OurSettings, Error> {
        locked(&self.0.shown).overlay.settings(look, quality)
    }

    fn require_checked(&self, _: &OurCamera, _: Viewport, _: &OurSettings) -> std::result::Result<(), Error> {
        Ok(())
    }

    /// Compilers that run when Python exits would end it by a crash.
    fn builds_ahead(&self) -> bool {
        false
    }

    /// A notebook has no command: the code, too.
    fn command_line(&self, wanted: &Wanted) -> String {
        self.python(wanted)
    }

    /// The code that writes a picture. `data` stands for the volume.
    fn python(&self, wanted: &Wanted) -> String {
        let &Wanted { look, view, size: Viewport { width, height }, transfer, .. } = wanted;
        let settings = self.settings(look, None).unwrap_or_default();
        let settings = Python::try_attach(|py| Settings::from_library(settings).code(py).unwrap_or_default()).unwrap_or_default();
        let (camera, background) = (code_of(&view), &look.background);
        let labels = if self.0.has_labels { labels_code(&look.labels.words()) } else { String::new() };
        format!(
            "layersplat.volshow(data, cmap=\"{transfer}\", settings={settings}, camera={camera}, size=({width}, {height}), \
             background=\"{background}\"{labels}).save(\"layersplat.png\")"
        )
    }
}

/// The argument for labels after changes. `labels` stands for those that were given.
fn labels_code(changes: &[String]) -> String {
    let changes: Vec<String> = changes.iter().map(|change| format!("{change:?}")).collect();
    let changed = if changes.is_empty() { String::new() } else { format!(".changed([{}])", changes.join(", ")) };
    format!(", label_colors=labels{changed}")
}

/// The code that makes a camera, with all bits.
fn code_of(camera: &OurCamera) -> String {
    let vector = |v: layersplat::glam::DVec3| format!("({:?}, {:?}, {:?})", v.x, v.y, v.z);
    let projection = match camera.projection {
        Projection::Parallel { scale } => format!("scale={scale:?}"),
        Projection::Perspective { field_of_view } => format!("field_of_view={field_of_view:?}"),
    };
    let [position, focal_point, view_up] = [camera.position, camera.focal_point, camera.view_up].map(vector);
    format!("layersplat.Camera({position}, {focal_point}, {view_up}, {projection})")
}

/// The voxels of a View on a device, shared by its renderer and its pages. Not for users.
///
/// volume: a Volume, which is uploaded, or streamed if the device has a memory budget. transfer: the transfer function that the pages call
/// the first one. device: a Device. labels: Labels in whose colours the volume is drawn, or None.
#[pyclass(frozen, module = "layersplat")]
pub struct LiveScene {
    scene: Arc<SharedScene>,
    view: Arc<View>,
}

#[pymethods]
impl LiveScene {
    #[new]
    #[pyo3(signature = (volume, transfer, device, labels = None))]
    fn new(
        py: Python,
        volume: Argument<Bound<Volume>>,
        transfer: Argument<Bound<TransferFunction>>,
        device: Argument<Bound<Device>>,
        labels: Option<Argument<Bound<Labels>>>,
    ) -> Result<Self> {
        extract!(volume, transfer, device, labels);
        let (volume, transfer) = (volume.get().ours().clone(), transfer.get().ours().clone());
        let device = device.get().ours().clone();
        let (grid, (lo, hi)) = (volume.grid().clone(), volume.range());
        // The angles of this package are about y, whatever the volume shows.
        let orientation = Orientation::with_up(Up::Y, &grid);
        let (dims, iso, frame) = (grid.dims(), (lo + hi) / 2.0, orientation.frame());
        let overlay = Overlay::new(OurSettings::default(), Background::BLACK, iso, dims);
        let look = overlay.look().clone();
        let whole = OurCamera::fit_parallel(grid.centre(), grid.diagonal(), Viewport::new(1, 1)?, Orbit::default());
        let camera = PageCamera::of(&whole, frame)?;
        let drawn = match labels {
            Some(labels) => Drawn::LabelColors(labels.get().drawn().indexed().clone().over(volume.description())?),
            None => Drawn::One,
        };
        let has_labels = matches!(drawn, Drawn::LabelColors(_));
        let view = View { shown: Mutex::new(ViewLook { overlay, look: look.clone() }), dims, iso, frame, has_labels };
        let view = Arc::new(view);
        let time = None;
        let (camera_is_given, time_limit, notes) = (true, None, Vec::new());
        let opening =
            Opening { volume, time, transfer, drawn, device, orientation, camera, camera_is_given, look, time_limit, notes };
        let host = Box::new(ViewHost(view.clone()));
        let scene = detached(py, move || Ok(SharedScene::new(opening, host)?))?;
        Ok(Self { scene: Arc::new(scene), view })
    }

    /// A renderer of these voxels.
    fn renderer(&self, transfer: Argument<Bound<TransferFunction>>) -> Result<Renderer> {
        extract!(transfer);
        Ok(Renderer::with_limit(self.scene.renderer(transfer.get().ours())?, None, None))
    }

    /// Shows these settings from the next picture of each page on.
    fn show(&self, settings: Argument<Bound<Settings>>, background: Argument<Over>) -> Result<()> {
        extract!(settings, background);
        let overlay = self.view.overlay(*settings.get().ours(), background.background()?);
        let mut shown = locked(&self.view.shown);
        // What a hand has changed of labels is no part of settings.
        let look = Look { labels: shown.look.labels.clone(), ..overlay.look().clone() };
        *shown = ViewLook { overlay, look };
        Ok(())
    }

    /// A page, to which `send(text, picture)` carries messages, one of both each. It is called at once and by the thread that draws.
    fn page(
        &self,
        py: Python,
        camera: Argument<Bound<Camera>>,
        transfer: Argument<Bound<TransferFunction>>,
        send: Py<PyAny>,
    ) -> Result<LivePage> {
        extract!(camera, transfer);
        let (before, look) = self.view.look_from(camera.get().ours())?;
        let camera = PageCamera::of(camera.get().ours(), self.view.frame)?;
        let transfer = transfer.get().ours().clone();
        let first = First { camera, camera_is_given: true, look, transfer, others: Vec::new() };
        let hello = detached(py, || Ok(self.scene.hello(&first)))?;
        send.call1(py, (hello, py.None()))?;
        let (scene, sender) = (self.scene.clone(), send.clone_ref(py));
        let carry = move |message| {
            // Not while Python ends.
            Python::try_attach(|py| carried(py, &sender, message));
        };
        let begin = first.clone();
        let session = detached(py, move || Ok(Session::new(scene, &begin, carry)?))?;
        let state = Mutex::new(State { session: Some(session), last: First { look: before, ..first } });
        Ok(LivePage { scene: self.scene.clone(), view: self.view.clone(), send, state })
    }
}

/// Passes a message on. A page that is gone needs none.
fn carried(py: Python, send: &Py<PyAny>, message: Message) {
    let sent = match message {
        Message::Text(text) => send.call1(py, (text, py.None())),
        Message::Binary(bytes) => send.call1(py, (py.None(), PyBytes::new(py, &bytes))),
    };
    if let Err(error) = sent {
        tracing::info!("a page was not reached: {error}");
    }
}

struct State {
    /// `None` once it is closed.
    session: Option<Session>,
    /// What the page shows, as far as it is known.
    last: First,
}

/// A page of a LiveScene. Not for users.
#[pyclass(frozen, module = "layersplat")]
pub struct LivePage {
    scene: Arc<SharedScene>,
    view: Arc<View>,
    send: Py<PyAny>,
    state: Mutex<State>,
}

/// What a hand changed: attributes of a View by name.
type Changes<'py> = Vec<(&'static str, Bound<'py, PyAny>)>;

#[pymethods]
impl LivePage {
    /// Takes a message of the page. It does not wait for pictures. Returns what a hand changed, (name, value) each; nothing unless
    /// `follow`, for messages of a page that does not know the newest state yet.
    fn receive<'py>(&self, py: Python<'py>, message: String, follow: bool) -> Result<Changes<'py>> {
        let received = detached(py, || {
            let state = locked(&self.state);
            let Some(session) = &state.session else { return Ok(None) };
            if !session.is_drawing() {
                return Err(Failure::Panicked("layersplat panicked while it drew for this page: run the cell again".into()));
            }
            Ok(session.receive(&message))
        })?;
        let Some(received) = received else { return Ok(Vec::new()) };
        if let Some(answer) = received.answer {
            carried(py, &self.send, answer);
        }
        match received.change {
            Some(change) if follow => self.changed(py, change),
            _ => Ok(Vec::new()),
        }
    }

    /// Shows another camera and transfer function, and what the scene shows now.
    fn give(&self, py: Python, camera: Argument<Bound<Camera>>, transfer: Argument<Bound<TransferFunction>>) -> Result<()> {
        extract!(camera, transfer);
        let (before, look) = self.view.look_from(camera.get().ours())?;
        let camera = PageCamera::of(camera.get().ours(), self.view.frame)?;
        let transfer = transfer.get().ours().clone();
        let now = First { camera, camera_is_given: true, look, transfer, others: Vec::new() };
        let text = self.scene.given(&now);
        locked(&self.state).last = First { look: before, ..now };
        carried(py, &self.send, Message::Text(text));
        Ok(())
    }

    /// Ends the page, and waits until its running kernel has ended.
    fn close(&self, py: Python) -> Result<()> {
        let session = locked(&self.state).session.take();
        // The thread that draws may wait for the interpreter lock.
        detached(py, || {
            if let Some(session) = session {
                session.end();
            }
            Ok(())
        })
    }
}

impl LivePage {
    /// The attributes that a change changes.
    fn changed<'py>(&self, py: Python<'py>, change: Change) -> Result<Changes<'py>> {
        let mut state = locked(&self.state);
        match change {
            Change::Camera(camera) if camera != state.last.camera => {
                state.last.camera = camera;
                let camera = Camera::from_library(self.scene.camera(&camera)?);
                Ok(vec![("camera", Bound::new(py, camera)?.into_any())])
            }
            Change::Look(look) if *look != state.last.look => {
                let mut shown = locked(&self.view.shown);
                let settings = Settings::from_library(shown.overlay.settings(&look, None)?);
                let mut changes = vec![("settings", Bound::new(py, settings)?.into_any())];
                if look.background != state.last.look.background {
                    changes.push(("background", PyString::new(py, &look.background).into_any()));
                }
                if look.labels != state.last.look.labels {
                    changes.push(("label_changes", PyList::new(py, look.labels.words())?.into_any()));
                }
                state.last.look.clone_from(&look);
                shown.look = *look;
                Ok(changes)
            }
            Change::Transfer(transfer) if !has_points_of(&transfer, &state.last.transfer) => {
                state.last.transfer = transfer.clone();
                Ok(vec![("transfer", Bound::new(py, TransferFunction::from_library(transfer))?.into_any())])
            }
            _ => Ok(Vec::new()),
        }
    }
}

/// Whether two transfer functions are the same, whatever their names are.
fn has_points_of(a: &layersplat::TransferFunction, b: &layersplat::TransferFunction) -> bool {
    a.colors() == b.colors() && a.opacities() == b.opacities()
}
