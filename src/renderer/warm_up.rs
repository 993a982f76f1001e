//! Building the programs of future frames in the background.

use super::frame::Output;
use super::{Plan, Renderer};
use crate::camera::{Camera, Orbit, Projection};
use crate::device::launch::KernelRequest;
use crate::device::{ProgramBuilds, Rehearsal};
use crate::error::Error;
use crate::image::Background;
use crate::settings::Settings;
use crate::viewport::Viewport;
use crate::volume::Grid;
use std::collections::HashSet;
use std::sync::Arc;

/// Azimuths of representative views in degrees about the y axis: near each layer axis, between two axes, and exactly along them.
const AZIMUTHS: [f64; 6] = [0.0, 20.0, 45.0, 70.0, 90.0, 200.0];
/// Elevations above the xz plane in degrees.
const ELEVATIONS: [f64; 4] = [0.0, 20.0, 45.0, 80.0];
/// Rolls in degrees: upright, to which lattices can align, and rolled.
const ROLLS: [f64; 2] = [0.0, 10.0];
/// Magnifications relative to a view that fits the whole volume.
const ZOOMS: [f64; 12] = [0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 9.0, 13.0, 20.0];
/// Eye distances of perspective projections, relative to the distance that fits the whole volume: from far away to inside.
const DISTANCES: [f64; 6] = [4.0, 1.0, 0.6, 0.4, 0.25, 0.1];

/// Frames expected by the caller, for [`Renderer::warm_up`]: sets of settings, each combined with all views and all transfer
/// functions.
///
/// ```
/// use layersplat::renderer::ExpectedFrames;
/// use layersplat::{Quality, Settings, Viewport};
///
/// // A viewer that drags in `draft`, rests in `standard`, uses a 30° perspective and lets the user edit the transfer function.
/// let settings = [Settings::default(), Quality::Draft.settings()];
/// let expected = ExpectedFrames::new(&settings, Viewport::new(640, 480)?);
/// let expected = expected.with_parallel_views().with_perspective_views(30.0).with_any_transfer_function();
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct ExpectedFrames {
    settings: Vec<Settings>,
    viewport: Viewport,
    cameras: Vec<Camera>,
    parallel: bool,
    fields_of_view: Vec<f64>,
    any_transfer_function: bool,
}

impl ExpectedFrames {
    /// Frames of this size with these settings, initially without views.
    pub fn new(settings: &[Settings], viewport: Viewport) -> Self {
        Self {
            settings: settings.to_vec(),
            viewport,
            cameras: Vec::new(),
            parallel: false,
            fields_of_view: Vec::new(),
            any_transfer_function: false,
        }
    }

    /// Adds these views.
    pub fn with_cameras(mut self, cameras: &[Camera]) -> Self {
        self.cameras.extend_from_slice(cameras);
        self
    }

    /// Adds parallel projections from all directions, at many magnifications.
    pub fn with_parallel_views(mut self) -> Self {
        self.parallel = true;
        self
    }

    /// Adds perspective projections from all directions, from outside and inside the volume. `field_of_view` is vertical, in
    /// degrees, between 0 and 180 exclusive.
    pub fn with_perspective_views(mut self, field_of_view: f64) -> Self {
        self.fields_of_view.push(field_of_view);
        self
    }

    /// Covers every transfer function, not only the current one: up to four times as many programs.
    pub fn with_any_transfer_function(mut self) -> Self {
        self.any_transfer_function = true;
        self
    }

    /// All cameras, beginning with the caller's.
    fn all_cameras(&self, grid: &Grid) -> Vec<Camera> {
        let (centre, diagonal, viewport) = (grid.centre(), grid.diagonal(), self.viewport);
        let mut cameras = self.cameras.clone();
        for orbit in orbits() {
            if self.parallel {
                let fitted = Camera::fit_parallel(centre, diagonal, viewport, orbit);
                cameras.extend(ZOOMS.map(|zoom| zoomed(fitted, zoom)));
            }
            for &field_of_view in &self.fields_of_view {
                let fitted = Camera::fit_perspective(centre, diagonal, field_of_view, viewport, orbit);
                let distance = fitted.position.distance(centre);
                cameras.extend(DISTANCES.map(|times| Camera::orbit(centre, times * distance, orbit, fitted.projection)));
            }
        }
        cameras
    }
}

fn orbits() -> impl Iterator<Item = Orbit> {
    let rolled = |azimuth, elevation| ROLLS.map(|roll| Orbit { azimuth, elevation, roll });
    let raised = move |azimuth| ELEVATIONS.into_iter().flat_map(move |elevation| rolled(azimuth, elevation));
    AZIMUTHS.into_iter().flat_map(raised)
}

/// Magnifies a parallel projection.
fn zoomed(camera: Camera, zoom: f64) -> Camera {
    let Projection::Parallel { scale } = camera.projection else { return camera };
    Camera { projection: Projection::Parallel { scale: scale / zoom }, ..camera }
}

/// A renderer whose frames only record the kernels that they would launch.
struct RehearsalRenderer {
    renderer: Renderer,
    rehearsal: Arc<Rehearsal>,
}

impl Renderer {
    /// Builds the programs of the expected frames in the background and calls `on_ready` when all are ready. On failure
    /// `on_ready` receives the error: invalid settings or cameras, or the first program that failed to build. Frames can be
    /// rendered meanwhile; missing programs are then built on demand.
    ///
    /// Programs belong to the [`Device`](crate::Device) and are shared by all its renderers. When the last clone of the device
    /// and its last renderer are dropped, builds that have not started are cancelled. `on_ready` is called on another thread.
    /// Views that a forced layer axis cannot render are ignored.
    pub fn warm_up(&self, expected: &ExpectedFrames, on_ready: impl FnOnce(Result<(), Error>) + Send + 'static) -> ProgramBuilds {
        // All that segments of any transfer function can need.
        let any = [Some(false), Some(true)];
        let more = if expected.any_transfer_function { any.as_slice() } else { &[] };
        let renderers: Vec<_> = [None].iter().chain(more).map(|&dimmed| self.rehearsal_renderer(dimmed)).collect();
        let expected = expected.clone();
        self.engine.device.build_ahead(move || kernels(renderers, &expected), on_ready)
    }

    /// Builds the programs that a frame launches and that are not built yet, before all programs that wait in the background. `None` if
    /// there are none. `frame` [rehearses](Self::rehearse) it, or draws it, with the renderer that it is given, which launches nothing.
    #[cfg(feature = "page")]
    pub(crate) fn build_first(&self, frame: impl FnOnce(&mut Self) -> Result<(), Error>) -> Result<Option<ProgramBuilds>, Error> {
        let RehearsalRenderer { mut renderer, rehearsal } = self.rehearsal_renderer(None);
        frame(&mut renderer)?;
        let device = &self.engine.device;
        let mut missing: Vec<KernelRequest> = Vec::new();
        for launched in rehearsal.take() {
            let is_ready = device.is_ready(&launched.best) || launched.general.is_some_and(|general| device.is_ready(&general));
            if !is_ready && !missing.contains(&launched.best) {
                missing.push(launched.best);
            }
        }
        Ok((!missing.is_empty()).then(|| device.build_first(missing)))
    }

    /// A renderer of the same volume that only records launches.
    fn rehearsal_renderer(&self, dimmed: Option<bool>) -> RehearsalRenderer {
        let (engine, rehearsal) = self.engine.for_rehearsal(dimmed);
        RehearsalRenderer { renderer: Self { engine }, rehearsal }
    }
}

/// The kernels of all frames: general programs first, then those of the current transfer function, in the order of the settings.
fn kernels(mut renderers: Vec<RehearsalRenderer>, expected: &ExpectedFrames) -> Result<Vec<KernelRequest>, Error> {
    let (mut best, mut general) = (Vec::new(), Vec::new());
    let mut known = HashSet::new();
    for rehearsing in &mut renderers {
        let cameras = expected.all_cameras(rehearsing.renderer.grid());
        for settings in &expected.settings {
            for camera in &cameras {
                rehearsing.renderer.rehearse(camera, expected.viewport, settings)?;
                for launched in rehearsing.rehearsal.take() {
                    general.extend(launched.general.filter(|kernel| known.insert(kernel.clone())));
                    best.extend(known.insert(launched.best.clone()).then_some(launched.best));
                }
            }
        }
    }
    tracing::debug!("{} kernels are needed ahead, {} of them general", general.len() + best.len(), general.len());
    general.extend(best);
    Ok(general)
}

impl Renderer {
    /// Records the launches of a frame, as a float picture and as an 8-bit picture. For renderers that launch nothing.
    pub(crate) fn rehearse(&mut self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<(), Error> {
        let planned = match self.planned(camera, viewport, settings) {
            Err(Error::Settings { field: "layer_axis", .. }) => return Ok(()),
            planned => planned?,
        };
        let outputs = [Output::Rgba8(Background::BLACK), Output::Floats];
        // Without a lattice, the kernels of an 8-bit picture include those of a float picture.
        let count = if matches!(planned.plan, Plan::Lattice(..)) { 2 } else { 1 };
        outputs.into_iter().take(count).try_for_each(|output| self.run(&planned, output, |_, _| Ok(())).map(drop))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::{Device, DeviceChoice};
    use crate::layers::{Correction, Kernel};
    use crate::settings::{Algorithm, Blend, Classification, Clipping, CropBox, Evaluation, GradientOpacity, Layered};
    use crate::transfer::TransferFunction;
    use crate::volume::{OpenOptions, Volume};
    use glam::DVec3;
    use std::collections::BTreeSet;

    const VIEWPORT: Viewport = Viewport { width: 40, height: 32 };

    fn device() -> Device {
        Device::open(&DeviceChoice::Default).expect("the tests need an OpenCL device: scripts/test installs PoCL")
    }

    struct Scene {
        volume: Volume<'static>,
        transfer: TransferFunction,
    }

    impl Scene {
        fn new() -> Self {
            let volume = Volume::open("builtin:hydrogen@24", &OpenOptions::default()).unwrap();
            Self { transfer: TransferFunction::builtin("fire", &volume).unwrap(), volume }
        }

        fn camera(&self, azimuth: f64, roll: f64) -> Camera {
            let grid = self.volume.grid();
            Camera::fit_parallel(grid.centre(), grid.diagonal(), VIEWPORT, Orbit { azimuth, elevation: 20.0, roll })
        }

        /// The frames of benches/stalls, and others with programs of their own.
        fn frames(&self) -> Vec<(Camera, Settings)> {
            let (view, standard) = (self.camera(30.0, 0.0), Settings::default());
            let layered = |classification| Settings::from(Layered { classification, ..Layered::default() });
            let sampled = |kernel, samples_per_layer| layered(Classification::Preintegrated { kernel, samples_per_layer });
            let blended = |blend| Settings { blend, ..standard };
            let (lowest, largest) = self.transfer.range();
            let steep = GradientOpacity::new(&[(0.0, 0.0), (1.0, 1.0)]).unwrap();
            let crop = Some(CropBox { lowest: DVec3::splat(5.0), highest: DVec3::splat(15.0) });
            let direct = Layered { evaluation: Evaluation::Direct, ..Layered::default() };
            let inside = Camera::orbit(
                self.volume.grid().centre(),
                4.0,
                Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 },
                Projection::Perspective { field_of_view: 90.0 },
            );
            let cameras = [self.camera(80.0, 0.0), self.camera(45.0, 0.0), self.camera(30.0, 20.0), zoomed(view, 4.0), inside];
            let changed = [
                crate::Quality::High.settings(),
                sampled(Kernel::Linear, 1),
                sampled(Kernel::CatmullRom, 1),
                sampled(Kernel::Cubic, 2),
                layered(Classification::Post(Correction::SubLayers(2))),
                Settings { gradient_opacity: Some(steep), ..standard },
                Settings { clipping: Clipping { crop, ..Clipping::default() }, ..standard },
                blended(Blend::Maximum),
                blended(Blend::Iso((lowest + largest) / 2.0)),
                direct.into(),
                Algorithm::Slicing { step: 0.5 }.into(),
                Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.5 }.into(),
                Algorithm::ViewSheets { sheet_distance: 1.0 }.into(),
            ];
            let seen = cameras.into_iter().map(|camera| (camera, standard));
            [(view, standard)].into_iter().chain(seen).chain(changed.map(|settings| (view, settings))).collect()
        }
    }

    /// Kernel name, build options and work-group size.
    type Programs = BTreeSet<(String, String, usize)>;

    #[test]
    fn a_rehearsal_records_the_kernels_of_the_frame() {
        let scene = Scene::new();
        for (camera, settings) in scene.frames() {
            let device = device();
            let mut renderer = Renderer::new(&device, &scene.volume, &scene.transfer).unwrap();
            let expected = ExpectedFrames::new(&[settings], VIEWPORT).with_cameras(&[camera]);
            let rehearsed = kernels(vec![renderer.rehearsal_renderer(None)], &expected).unwrap();
            let in_rehearsal: Programs =
                rehearsed.iter().map(|kernel| (kernel.kernel.to_string(), kernel.options(), kernel.group)).collect();
            assert!(device.started().is_empty() && device.programs() == 0, "a rehearsal launches nothing");
            renderer.render(&camera, VIEWPORT, &settings).unwrap();
            renderer.render_rgba8(&camera, VIEWPORT, &settings, Background::BLACK).unwrap();
            let in_frame: Programs =
                device.started().into_iter().map(|started| (started.kernel.into(), started.options, started.group)).collect();
            assert_eq!(in_rehearsal, in_frame, "{settings:?} from {camera:?}");
        }
    }

    #[test]
    fn rehearsals_take_no_memory_of_the_device() {
        let (scene, device) = (Scene::new(), device());
        let renderer = Renderer::new(&device, &scene.volume, &scene.transfer).unwrap();
        let before = device.allocated_bytes();
        let mut rehearsing = renderer.rehearsal_renderer(None);
        for (camera, settings) in scene.frames() {
            rehearsing.renderer.rehearse(&camera, VIEWPORT, &settings).unwrap();
        }
        assert_eq!(device.allocated_bytes(), before);
    }

    #[test]
    fn after_a_warm_up_frames_build_nothing() {
        let (scene, device) = (Scene::new(), device());
        let mut renderer = Renderer::new(&device, &scene.volume, &scene.transfer).unwrap();
        let settings = Settings::default();
        let expected = ExpectedFrames::new(&[settings], VIEWPORT).with_parallel_views().with_any_transfer_function();
        let (sender, receiver) = std::sync::mpsc::channel();
        let builds = renderer.warm_up(&expected, move |built| sender.send(built).unwrap());
        builds.wait();
        receiver.recv().unwrap().unwrap();
        let built = device.programs();
        assert_eq!(builds.progress().1, Some(builds.progress().0));
        let opaque = scene.transfer.opacities().iter().map(|&(value, opacity)| (value, f64::from(opacity > 0.0))).collect();
        for transfer in [scene.transfer.clone(), scene.transfer.with_opacities(opaque).unwrap()] {
            renderer.set_transfer_function(&transfer);
            for azimuth in [10.0, 44.9, 63.0, 100.0, 135.0] {
                for zoom in [0.3, 1.1, 5.0] {
                    let camera = zoomed(scene.camera(azimuth, azimuth / 3.0), zoom);
                    renderer.render_rgba8(&camera, VIEWPORT, &settings, Background::BLACK).unwrap();
                }
            }
        }
        assert_eq!(device.programs(), built);
    }

    #[test]
    fn settings_that_frames_refuse_are_reported() {
        let (scene, device) = (Scene::new(), device());
        let renderer = Renderer::new(&device, &scene.volume, &scene.transfer).unwrap();
        let wrong = Algorithm::Slicing { step: -1.0 }.into();
        let (sender, receiver) = std::sync::mpsc::channel();
        let expected = ExpectedFrames::new(&[wrong], VIEWPORT).with_parallel_views();
        renderer.warm_up(&expected, move |built| sender.send(built).unwrap()).wait();
        assert!(matches!(receiver.recv().unwrap(), Err(Error::OutOfRange { .. } | Error::Settings { .. })));
    }

    /// Rounding of sums in a different order. Programs with different branches contract floating-point arithmetic differently.
    const GENERAL_TOLERANCE: f32 = 2e-3;

    #[test]
    fn general_programs_match_the_specialised_ones() {
        let scene = Scene::new();
        let opaque = scene.transfer.opacities().iter().map(|&(value, opacity)| (value, f64::from(opacity > 0.0))).collect();
        let opaque = scene.transfer.with_opacities(opaque).unwrap();
        let settings = Settings::default();
        for (transfer, azimuth) in [(&scene.transfer, 30.0), (&opaque, 45.0)] {
            let camera = scene.camera(azimuth, 0.0);
            let mut renderer = Renderer::new(&device(), &scene.volume, transfer).unwrap();
            let (best, report) = renderer.render(&camera, VIEWPORT, &settings).unwrap();
            assert!(!report.general_program);

            let mut renderer = Renderer::new(&device(), &scene.volume, transfer).unwrap();
            renderer.use_general_programs(true);
            let mut rehearsing = renderer.rehearsal_renderer(None);
            rehearsing.renderer.rehearse(&camera, VIEWPORT, &settings).unwrap();
            let general: Vec<_> = rehearsing.rehearsal.take().into_iter().filter_map(|launched| launched.general).collect();
            assert!(!general.is_empty());
            renderer.engine.device.build_ahead(move || Ok(general), |built| built.unwrap()).wait();
            let (meanwhile, report) = renderer.render(&camera, VIEWPORT, &settings).unwrap();
            assert!(report.general_program, "the specialised program is not built");
            let pairs = best.pixels().as_flattened().iter().zip(meanwhile.pixels().as_flattened());
            let difference = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(difference <= GENERAL_TOLERANCE, "{difference} apart");

            // The specialised program was requested above; frames use it once it is built.
            let expected = ExpectedFrames::new(&[settings], VIEWPORT).with_cameras(&[camera]);
            renderer.warm_up(&expected, |built| built.unwrap()).wait();
            let (after, report) = renderer.render(&camera, VIEWPORT, &settings).unwrap();
            assert!(!report.general_program && after == best);
        }
    }
}
