//! Rendering of volume parts: each part composites its own layers behind those composited before.

#[cfg(feature = "mpi")]
mod ranks;
#[cfg(feature = "mpi")]
mod shares;
mod view;

#[cfg(feature = "mpi")]
pub(crate) use shares::Shares;
pub(crate) use view::{LatticeView, SeenVolume, combined};

use super::UploadedVolume;
use super::frame::{DeclaredLight, Declaring, Engine, Frame as Declared, Mode, PartOfLight, Stage, Step};
use super::light::LightOfParts;
use super::picture::{Finished, Share};
use super::range::LayerRange;
use super::report::Measured;
use super::tiles::read_samples;
use crate::camera::Camera;
use crate::device::{Cancel, Device};
use crate::error::Error;
use crate::image::Frame;
use crate::layers::{Axis, GradientEstimator, Kernel, PREFILTER_RADIUS};
use crate::settings::{Classification, Settings};
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{VolumePart, VoxelBox};
use std::ops::Range;
use std::time::Duration;
use view::view_error;

/// Renders a range of layers of a volume, those of a [`VolumePart`].
///
/// Layers are composited on a lattice (both classifications) and passed on in their raw state, so that a volume rendered in parts
/// is bit-identical to one rendered as a whole. All properties of the whole volume come from the part's description. Views
/// without a lattice, where each ray may have its own layer axis, and pictures shared by several layer axes need the whole
/// volume. They are rejected with an error that says so.
///
/// ```
/// use layersplat::renderer::{CompositedLayers, PartRenderer};
/// use layersplat::{Settings, renderer::Renderer};
/// # let volume = layersplat::Volume::open("builtin:hydrogen@16", &layersplat::OpenOptions::default())?;
/// # let transfer = layersplat::TransferFunction::automatic(&volume);
/// # let device = layersplat::Device::open(&layersplat::DeviceChoice::Default)?;
/// # let viewport = layersplat::Viewport::new(32, 24)?;
/// # let orbit = layersplat::Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
/// # let camera = layersplat::Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, orbit);
///
/// let settings = Settings::default();
/// let (axis, rising) = PartRenderer::new(&device, &volume.part([0; 3], [16; 3])?, &transfer)?.order(&camera, viewport, &settings)?;
/// let composite = |layers: std::ops::Range<usize>| {
///     let needed = PartRenderer::needed(&layers, 16, &settings);
///     let (mut first, mut dims) = ([0; 3], [16; 3]);
///     (first[axis.index()], dims[axis.index()]) = (needed.start, needed.len());
///     PartRenderer::new(&device, &volume.part(first, dims)?, &transfer)?.composite(&camera, viewport, &settings, layers, None)
/// };
/// let [lower, upper] = [composite(0..8)?, composite(8..16)?];
/// let whole = if rising { CompositedLayers::combine(&lower, &upper)? } else { CompositedLayers::combine(&upper, &lower)? };
/// assert_eq!(whole.layers(), 0..16);
/// # Ok::<(), layersplat::Error>(())
/// ```
pub struct PartRenderer {
    engine: Engine,
}

/// Composited layers in their raw state, front to back. Later layers can continue from them; they are not yet a picture.
///
/// ```
/// use layersplat::Settings;
/// use layersplat::renderer::PartRenderer;
/// # let volume = layersplat::Volume::open("builtin:hydrogen@16", &layersplat::OpenOptions::default())?;
/// # let transfer = layersplat::TransferFunction::automatic(&volume);
/// # let device = layersplat::Device::open(&layersplat::DeviceChoice::Default)?;
/// # let viewport = layersplat::Viewport::new(32, 24)?;
/// # let orbit = layersplat::Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
/// # let camera = layersplat::Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, orbit);
///
/// let mut renderer = PartRenderer::new(&device, &volume.part([0; 3], [16; 3])?, &transfer)?;
/// let composited = renderer.composite(&camera, viewport, &Settings::default(), 0..16, None)?;
/// assert_eq!(renderer.finish(&composited)?.width(), 32);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct CompositedLayers {
    view: LatticeView,
    layers: Range<usize>,
    /// Depending on the blend mode: premultiplied colour and transmittance, or a value.
    samples: Vec<[f32; 4]>,
}

/// Raw samples of layers, and the frame statistics if measured.
type RawSamples = (Vec<[f32; 4]>, Option<Measured>);

impl CompositedLayers {
    /// The range of layers, numbered as in the whole volume.
    pub fn layers(&self) -> Range<usize> {
        self.layers.clone()
    }

    /// Combines `front` and the layers directly `behind` it with the operator of the blend mode. Each was composited from an
    /// empty state. `over` is not associative in floats, and the layers behind were composited without early termination by those
    /// in front. The picture therefore equals that of the whole volume up to rounding (and [`Settings::OPAQUE`], with early
    /// termination), not bit for bit.
    ///
    /// # Errors
    /// If the layers belong to different views, or are not adjacent in view order.
    pub fn combine(front: &Self, behind: &Self) -> Result<Self, Error> {
        if front.view != behind.view {
            return Err(view_error(
                "these layers belong to different views: composite them with the same camera and settings".into(),
            ));
        }
        front.view.check_joined(&front.layers, &behind.layers)?;
        let blend = front.view.blend;
        let samples = front.samples.iter().zip(&behind.samples).map(|(&f, &b)| combined(blend, f, b)).collect();
        Ok(Self { view: front.view.clone(), layers: union(&front.layers, &behind.layers), samples })
    }
}

impl PartRenderer {
    /// Number of ghost layers that must be held on each side of the composited layers: two for kernels and gradients, plus the
    /// prefilter radius for the B-spline or the radius of the Gaussian of gradients, whichever is larger.
    pub fn around(settings: &Settings) -> usize {
        let classification = settings.layered().map(|layered| layered.classification);
        let filtered = match classification {
            Some(Classification::Preintegrated { kernel: Kernel::BSpline, .. }) => PREFILTER_RADIUS,
            _ => 0,
        };
        2 + filtered.max(settings.needed_gradient().map_or(0, GradientEstimator::smoothing_radius))
    }

    /// The layers that a part must hold to composite `layers` of a volume with `total` layers.
    pub fn needed(layers: &Range<usize>, total: usize, settings: &Settings) -> Range<usize> {
        let around = Self::around(settings);
        layers.start.saturating_sub(around)..(layers.end + around).min(total)
    }

    /// Uploads a part and creates a renderer for it with this transfer function.
    pub fn new(device: &Device, part: &VolumePart, transfer: &TransferFunction) -> Result<Self, Error> {
        Ok(Self::from_uploaded(&UploadedVolume::part(device, part)?, transfer))
    }

    /// Creates a renderer for a volume, or a part of one, that is already on a device.
    pub fn from_uploaded(volume: &UploadedVolume, transfer: &TransferFunction) -> Self {
        Self { engine: Engine::new(volume, transfer) }
    }

    /// Replaces the transfer function, from the next call on.
    pub fn set_transfer_function(&mut self, transfer: &TransferFunction) {
        self.engine.set_transfer_function(transfer);
    }

    /// Replaces the part, from the next call on, also by one of another volume. If the voxel type is unchanged, no device program is
    /// rebuilt.
    ///
    /// # Errors
    /// As [`Renderer::set_volume`](crate::Renderer::set_volume).
    pub fn set_part(&mut self, part: &VolumePart) -> Result<(), Error> {
        self.engine.replace_field(&part.held())
    }

    /// Limits the time of compositing and finishing, as [`Renderer::limit`](crate::Renderer::limit).
    pub fn limit(&mut self, longest: Option<Duration>) {
        self.engine.limits.longest = longest;
    }

    /// Sets the handle with which another thread can cancel compositing and finishing, as
    /// [`Renderer::set_cancel`](crate::Renderer::set_cancel).
    pub fn set_cancel(&mut self, cancel: Option<Cancel>) {
        self.engine.limits.cancel = cancel;
    }

    /// The layer axis of a view, and whether its rays cross layers in ascending order.
    pub fn order(&self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<(Axis, bool), Error> {
        let view = self.view(camera, viewport, settings)?;
        Ok((view.axis(), view.ascending()))
    }

    /// Composites layers, directly behind those composited `before`, or from an empty state.
    ///
    /// # Errors
    /// If the part does not hold the layers and the ghost layers [`around`](Self::around) them, if they do not follow those
    /// composited before in the [order](Self::order) of the view, and if the view does not have a single lattice.
    pub fn composite(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
        layers: Range<usize>,
        before: Option<&CompositedLayers>,
    ) -> Result<CompositedLayers, Error> {
        let view = self.view(camera, viewport, settings)?;
        self.check_held(&view, &layers)?;
        let mut done = layers.clone();
        if let Some(before) = before {
            if before.view != view {
                return Err(view_error(
                    "the layers before belong to another view: composite all with the same camera and settings".into(),
                ));
            }
            view.check_joined(&before.layers, &layers)?;
            done = union(&before.layers, &layers);
        }
        let (samples, _) = self.samples(&view, layers, before.map(|b| b.samples.as_slice()), None)?;
        Ok(CompositedLayers { view, layers: done, samples })
    }

    /// The picture of composited layers as premultiplied floats, without a background. The renderer of any part can make it.
    pub fn finish(&mut self, composited: &CompositedLayers) -> Result<Frame, Error> {
        let view = &composited.view;
        let read = |device: &Device, finished: &Finished| read_samples(finished.floats(), device, view.viewport.pixels());
        let (pixels, _) = self.run(view, self.warped(view, &composited.samples, Share::WHOLE, None), None, read)?;
        Ok(Frame::new(view.viewport, pixels).with_curve(view.settings.curve()))
    }

    fn view(&self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<LatticeView, Error> {
        if settings.sweeps_light() {
            let problem = "a part alone has no shadows and no ambient occlusion: disable them, or use a StreamedRenderer or several processes";
            return Err(view_error(problem.into()));
        }
        let (description, transfer) = (self.engine.field().description(), self.engine.classification().transfer_function());
        let seen = SeenVolume { description, transfer };
        let mut views = LatticeView::all(seen, camera, viewport, settings)?;
        match views.pop() {
            Some((view, _)) if views.is_empty() => Ok(view),
            last => {
                let axes: Vec<_> = views.iter().chain(&last).map(|(view, _)| view.axis()).collect();
                Err(view_error(format!("this view is shared by the layer axes {axes:?}: choose one of them")))
            }
        }
    }

    fn check_held(&self, view: &LatticeView, layers: &Range<usize>) -> Result<(), Error> {
        let (axis, all) = (view.axis(), view.lattice.dims[2]);
        if layers.is_empty() || layers.end > all {
            let expected = "a range of the volume's layers that is not empty";
            return Err(Error::OutOfRange { name: "layers", value: format!("{layers:?} of {all}"), expected });
        }
        let (held, needed) = (self.engine.field().held(), Self::needed(layers, all, &view.settings));
        if !held.holds(&VoxelBox::layers(self.engine.field().grid().dims(), axis.index(), &needed)) {
            let problem =
                format!("layers {layers:?} of axis {axis:?} need all of layers {needed:?}, which this part does not hold");
            return Err(view_error(problem));
        }
        Ok(())
    }

    /// Composites layers behind the raw samples `before`, or from an empty state, and returns raw samples. `light`: that of the view, if
    /// it has any.
    fn samples(
        &mut self,
        view: &LatticeView,
        voxels: Range<usize>,
        before: Option<&[[f32; 4]]>,
        light: Option<&LightOfParts>,
    ) -> Result<RawSamples, Error> {
        let range = LayerRange { voxels, continues: before.is_some(), raw: true };
        let layers = Step::Layers { lattice: &view.lattice, layered: view.layered, range };
        let light = self.light_step(view, light);
        let steps = before.map(Step::Continue).into_iter().chain(light).chain([layers]).collect();
        self.run(view, steps, None, |device, finished| read_samples(finished.floats(), device, view.lattice.samples()))
    }

    /// The steps that resolve and warp the raw samples of all layers of a view.
    fn warped<'a>(
        &self,
        view: &'a LatticeView,
        samples: &'a [[f32; 4]],
        share: Share,
        light: Option<&'a LightOfParts>,
    ) -> Vec<Step<'a>> {
        let LatticeView { lattice, layered, .. } = view;
        let end = Step::Layers { lattice, layered: *layered, range: LayerRange::end() };
        let light = self.light_step(view, light);
        [Step::Continue(samples)].into_iter().chain(light).chain([end, Step::Warp { lattice, share }]).collect()
    }

    /// Uploads the light of a view for the layers that this part holds.
    fn light_step<'a>(&self, view: &LatticeView, light: Option<&'a LightOfParts>) -> Option<Step<'a>> {
        let (axis, held) = (view.axis(), self.engine.field().held());
        let voxels = held.first[axis.index()]..held.end(axis.index());
        light.map(|light| Step::HoldLight { light, axis, voxels })
    }

    /// Runs steps of a view; the last one writes to `into` if it is given. Also returns the frame statistics, if measured.
    fn run<T>(
        &mut self,
        view: &LatticeView,
        steps: Vec<Step>,
        into: Option<Finished>,
        deliver: impl FnOnce(&Device, &Finished) -> Result<T, Error>,
    ) -> Result<(T, Option<Measured>), Error> {
        let LatticeView { rays, viewport, settings, .. } = view;
        let (whole, axis) = (self.engine.field().grid().dims(), view.axis());
        let part = Some(PartOfLight { whole, axis, layers: self.engine.field().held().dims[axis.index()] });
        let stage = self.engine.declaring(*viewport, settings, |declaring| {
            let light = declaring.light.map(|light| DeclaredLight { part, ..light });
            Stage::new(steps, into.is_some(), &Declaring { light, ..*declaring })
        });
        let frame = Declared { rays, viewport: *viewport, settings, stages: vec![stage], volume: None, into, host_bytes: 0 };
        let (delivered, statistics) = self.engine.run(&frame, Mode::Waited, deliver)?;
        Ok((delivered, statistics.measured))
    }
}

fn union(a: &Range<usize>, b: &Range<usize>) -> Range<usize> {
    a.start.min(b.start)..a.end.max(b.end)
}
