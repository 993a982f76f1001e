//! Streaming of volumes that do not fit on the device: their layers are uploaded in parts.

mod light;
mod needs;
mod plan;
mod whole;

pub use plan::{StreamPlan, StreamedLattice};

use super::accumulation::Jitter;
use super::classification::TableSizes;
use super::field::FieldShape;
use super::frame::{DeclaredLight, Declaring, Engine, Frame as Declared, Mode, PartOfLight, Stage, Step};
use super::light::{HostField, HostVolumes, LightOfParts};
use super::picture::{Finished, Share};
use super::plan::Plan;
use super::range::LayerRange;
use super::report::FrameReport;
use super::surfaces::{SurfaceSizes, UploadedSurfaces};
use super::tiles::read_samples;
use super::world::World;
use super::{PartRenderer, Renderer, UploadedVolume};
use crate::camera::Camera;
use crate::device::{Bands, Cancel, Device, DeviceKind, Limits};
use crate::error::Error;
use crate::image::Frame;
use crate::layers::{Lattice, Rays};
use crate::memory;
use crate::settings::{Layered, Settings};
use crate::surface::Surface;
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Grid, Volume, VoxelBox};
use light::PlannedLight;
use needs::{MemoryLimits, Needs};
use plan::Parts;
use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

/// Renders a volume of any size within the memory of a device handle ([`Device::with_memory`], [`Device::with_largest_buffer`]).
/// The result is bit-identical to that of a [`Renderer`] that holds the whole volume.
///
/// Layers on a lattice are uploaded in parts along the layer axis, each with as many layers as fit. Along x and y, layers are
/// gathered where the voxels are stored, for instance in a mapped file. Built-in volumes of more than 2^28 voxels are generated
/// on demand. The other resources of a frame (lattice, tables, picture) count against the memory, too, and are released after
/// each frame. If all voxels fit, they stay on the device, together with cached data as far as the memory allows.
///
/// Shadows and ambient occlusion are swept before, slab by slab, into a temporary file, and kept as long as they are those of the view. In the
/// studio, light scatters through the whole volume at a quarter of its resolution; finer light grids need the whole volume on the device.
///
/// Surfaces stay on the device. The volume between two fragments is drawn part by part, and parts that no ray needs there are not read. The light
/// of the whole volume is held, since fragments may be anywhere.
///
/// All other render paths (views in which each ray may have its own layer axis, sheets, slices, rays) need the whole volume and
/// are rejected if it does not fit.
///
/// ```
/// use layersplat::Settings;
/// use layersplat::renderer::StreamedRenderer;
/// # let volume = layersplat::Volume::open("builtin:hydrogen@16", &layersplat::OpenOptions::default())?;
/// # let transfer = layersplat::TransferFunction::automatic(&volume);
/// # let device = layersplat::Device::open(&layersplat::DeviceChoice::Default)?;
/// # let viewport = layersplat::Viewport::new(32, 24)?;
/// # let orbit = layersplat::Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
/// # let camera = layersplat::Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, orbit);
///
/// let mut renderer = StreamedRenderer::new(&device, &volume, &transfer);
/// let (frame, _) = renderer.render(&camera, viewport, &Settings::default())?;
/// assert_eq!(frame.width(), 32);
/// # Ok::<(), layersplat::Error>(())
/// ```
pub struct StreamedRenderer<'v> {
    device: Device,
    volume: Volume<'v>,
    transfer: TransferFunction,
    surfaces: Option<Arc<UploadedSurfaces>>,
    world: World,
    /// In normalised world units.
    grid: Grid,
    /// All voxels, if they fit, and their renderer.
    whole: Option<UploadedVolume>,
    kept: Option<Renderer>,
    /// Bytes on the device held by `whole` and `kept`.
    own: u64,
    /// Light volumes of earlier frames in parts, of this volume and transfer function.
    light: Vec<HostVolumes>,
    light_field: Option<HostField>,
    measuring: bool,
    limits: Limits,
}

/// A view with planned lattices.
struct Streamed {
    plan: Plan,
    rays: Rays,
    settings: Settings,
    layered: Layered,
    lattices: Vec<(Lattice, f64, Parts)>,
    light: Option<PlannedLight>,
    summary: StreamPlan,
}

impl Streamed {
    /// Whether all voxels are on the device at once, and nothing else is needed of the volume.
    fn holds_all(&self) -> bool {
        self.light.is_none() && self.lattices.iter().all(|(.., parts)| parts.ranges.len() == 1)
    }
}

impl<'v> StreamedRenderer<'v> {
    /// Creates a renderer. Nothing is read or uploaded yet.
    pub fn new(device: &Device, volume: &Volume<'v>, transfer: &TransferFunction) -> Self {
        let world = World::new(volume.grid());
        Self {
            device: device.clone(),
            volume: volume.clone(),
            transfer: transfer.clone(),
            surfaces: None,
            world,
            grid: world.grid(volume.grid()),
            whole: None,
            kept: None,
            own: 0,
            light: Vec::new(),
            light_field: None,
            measuring: false,
            limits: Limits::default(),
        }
    }

    /// Replaces the transfer function, from the next frame on.
    pub fn set_transfer_function(&mut self, transfer: &TransferFunction) {
        if self.transfer != *transfer {
            self.forget_light();
        }
        self.transfer = transfer.clone();
        if let Some(kept) = &mut self.kept {
            kept.set_transfer_function(transfer);
        }
    }

    /// Replaces the surfaces, from the next frame on. They stay on the device, and count against its memory.
    ///
    /// # Errors
    /// If they do not fit into the memory of the device; there are none then.
    pub fn set_surfaces(&mut self, surfaces: &[Surface]) -> Result<(), Error> {
        self.kept = None;
        UploadedSurfaces::replace(&mut self.surfaces, &self.device, surfaces)
    }

    /// The transfer function in use.
    pub fn transfer_function(&self) -> &TransferFunction {
        &self.transfer
    }

    /// Replaces the volume, from the next frame on. Nothing is read yet.
    pub fn set_volume(&mut self, volume: &Volume<'v>) {
        self.world = World::new(volume.grid());
        (self.grid, self.volume) = (self.world.grid(volume.grid()), volume.clone());
        (self.whole, self.kept, self.own) = (None, None, 0);
        self.forget_light();
    }

    fn forget_light(&mut self) {
        self.light.clear();
        self.light_field = None;
    }

    /// The grid that places the voxels in the world.
    pub fn grid(&self) -> &Grid {
        self.volume.grid()
    }

    /// Enables frame statistics in reports, from the next frame on.
    pub fn measure(&mut self, measuring: bool) {
        self.measuring = measuring;
    }

    /// Limits the time of a frame, as [`Renderer::limit`](super::Renderer::limit). Reading and uploading parts counts, but not
    /// the upload of a volume that is held as a whole.
    pub fn limit(&mut self, longest: Option<Duration>) {
        self.limits.longest = longest;
    }

    /// Sets the handle with which another thread can cancel frames, as [`Renderer::set_cancel`](super::Renderer::set_cancel).
    pub fn set_cancel(&mut self, cancel: Option<Cancel>) {
        self.limits.cancel = cancel;
    }

    /// Renders frames in bands, as [`Renderer::set_bands`](super::Renderer::set_bands).
    pub fn set_bands(&mut self, bands: Option<Bands>) {
        self.limits.bands = bands;
    }

    /// The streaming plan of a view; `None` if the view needs the whole volume and that fits.
    ///
    /// # Errors
    /// As [`render`](Self::render).
    pub fn plan(&self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Option<StreamPlan>, Error> {
        let (rays, seen) = self.world.normalised_view(&self.grid, camera, viewport, settings)?;
        let plan = self.render_path(&rays, viewport, &seen)?;
        match self.streamed(plan, rays, viewport, seen)? {
            Ok(streamed) => Ok(Some(streamed.summary)),
            Err(whole) => self.require_whole("this view", &whole, viewport, settings).map(|()| None),
        }
    }

    /// Renders a picture as premultiplied floats, without a background. The streaming plan is logged first.
    ///
    /// # Errors
    /// [`Error::MemoryBudget`] and [`Error::DeviceMemory`], with the least memory required: if not even one layer and its
    /// neighbours fit beside the other resources of a frame, or if the view cannot be streamed and the whole volume does not fit.
    pub fn render(&mut self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<(Frame, FrameReport), Error> {
        self.render_jittered(camera, viewport, settings, None)
    }

    /// Renders a picture whose rays are moved within their pixels.
    pub(super) fn render_jittered(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
        jitter: Option<Jitter>,
    ) -> Result<(Frame, FrameReport), Error> {
        let (rays, seen) = self.world.normalised_view(&self.grid, camera, viewport, settings)?;
        let rays = jitter.map_or(rays, |jitter| jitter.apply(rays));
        let plan = self.render_path(&rays, viewport, &seen)?;
        let streamed = self.streamed(plan, rays, viewport, seen)?;
        let others = self.others();
        let in_parts = match &streamed {
            Ok(streamed) => !streamed.holds_all(),
            Err(whole) => self.require_whole("this view", whole, viewport, settings).map(|()| false)?,
        };
        // Cached data of earlier frames may leave too little memory: retry without them.
        let rendered = match if in_parts { None } else { Some(self.render_whole(camera, viewport, settings, jitter)) } {
            Some(Ok(rendered)) => Ok(rendered),
            Some(Err(error)) if !error.is_lack_of_device_memory() => Err(error),
            _ => {
                self.kept = None;
                match &streamed {
                    Ok(streamed) => self.draw(streamed, viewport),
                    Err(_) => self.render_whole(camera, viewport, settings, jitter),
                }
            }
        };
        self.own = self.device.taken_bytes().saturating_sub(others);
        rendered
    }

    /// The render path of a view, for all voxels. Settings are in normalised world units.
    fn render_path(&self, rays: &Rays, viewport: Viewport, settings: &Settings) -> Result<Plan, Error> {
        let steepness = self.transfer.steepness(self.volume.description().field_range());
        let plan = Plan::with_steepness(rays, viewport, &self.grid, settings, steepness)?;
        if self.surfaces.is_some() { plan.with_surfaces(rays, viewport, &self.grid, settings) } else { Ok(plan) }
    }

    fn surface_sizes(&self) -> Option<SurfaceSizes> {
        self.surfaces.as_deref().map(UploadedSurfaces::sizes)
    }

    /// Divides the lattices of a plan into parts. Returns the plan itself if it has no lattices, or if the volume fits with its light.
    fn streamed(&self, plan: Plan, rays: Rays, viewport: Viewport, settings: Settings) -> Result<Result<Streamed, Plan>, Error> {
        let limits = self.memory_limits();
        let (lattices, layered) = match &plan {
            _ if settings.sweeps_light() && limits.fits(self.needs_as_whole(&plan, viewport, &settings)) => return Ok(Err(plan)),
            Plan::Lattice(lattice, layered) => (vec![(lattice.clone(), Share::WHOLE.share)], *layered),
            Plan::Shared(lattices, layered) => (lattices.clone(), *layered),
            _ => return Ok(Err(plan)),
        };
        let light = self.plan_light(&rays, viewport, &settings, limits)?;
        let declared = light.as_ref().map(|light| light.declared(&settings));
        let tables = TableSizes::new(&self.transfer, self.volume.description());
        let with_parts = lattices.into_iter().map(|(lattice, share)| {
            let needs = Needs::new(
                &lattice,
                (layered, &settings, declared),
                (viewport, self.surface_sizes()),
                self.device.tuning(),
                self.volume.description(),
                &tables,
            );
            let parts = Parts::new(&self.device, &lattice, &settings, &needs, limits)?;
            Ok((lattice, share, parts))
        });
        let lattices = with_parts.collect::<Result<Vec<_>, Error>>()?;
        let summary = StreamPlan {
            lattices: lattices
                .iter()
                .map(|(lattice, _, parts)| StreamedLattice {
                    axis: lattice.frame.layer_axis(),
                    parts: parts.ranges.len(),
                    held_layers: parts.held,
                })
                .collect(),
            voxel_bytes: lattices.iter().map(|(.., parts)| parts.read).sum(),
            light_bytes: light.as_ref().map_or(0, |light| light.read),
            volume_bytes: self.volume_bytes(),
            device_bytes: (lattices.iter().map(|(.., parts)| parts.bytes.sum))
                .chain(light.as_ref().map(|light| light.bytes.sum))
                .max()
                .unwrap_or(0),
            memory: limits.free(),
        };
        Ok(Ok(Streamed { plan, rays, settings, layered, lattices, light, summary }))
    }

    fn draw(&mut self, streamed: &Streamed, viewport: Viewport) -> Result<(Frame, FrameReport), Error> {
        tracing::info!("{}: {}", self.volume.name(), streamed.summary);
        let mut engine = self.first_engine(streamed)?;
        engine.surfaces = self.surfaces.clone();
        (engine.measuring, engine.limits) = (self.measuring, self.limits.clone());
        let light = match &streamed.light {
            Some(planned) => Some(self.take_light(planned)?),
            None => None,
        };
        let drawn = self.run(&mut engine, streamed, light.as_ref(), viewport);
        if let Some(light) = light {
            self.light_field = light.take_field().filter(HostField::is_complete).or(self.light_field.take());
            self.light.extend(light.into_volumes().into_iter().filter(|volumes| volumes.is_complete));
        }
        drawn
    }

    fn run(
        &self,
        engine: &mut Engine,
        streamed: &Streamed,
        light: Option<&LightOfParts>,
        viewport: Viewport,
    ) -> Result<(Frame, FrameReport), Error> {
        let Streamed { plan, rays, settings, lattices, .. } = streamed;
        let mut stages = Vec::new();
        if let Some((planned, light)) = streamed.light.as_ref().zip(light) {
            stages = self.light_stages(engine, planned, light, (viewport, settings));
        }
        stages.extend((0..lattices.len()).map(|n| self.stage(engine, streamed, n, light, viewport)));
        let frame = Declared { rays, viewport, settings, stages, volume: Some(&self.volume), into: None, host_bytes: 0 };
        let read = |device: &Device, finished: &Finished| read_samples(finished.floats(), device, viewport.pixels());
        let (pixels, statistics) = engine.run(&frame, Mode::Waited, read)?;
        Ok((Frame::new(viewport, pixels).with_curve(settings.curve()), FrameReport::new(plan, statistics)))
    }

    /// The steps of the `n`-th lattice of a view: each part in turn.
    fn stage<'a>(
        &self,
        engine: &Engine,
        streamed: &'a Streamed,
        n: usize,
        light: Option<&'a LightOfParts>,
        viewport: Viewport,
    ) -> Stage<'a> {
        let Streamed { layered, settings, .. } = streamed;
        let (lattice, share, parts) = &streamed.lattices[n];
        let ([u, v, _], axis) = (lattice.dims, lattice.frame.layer_axis());
        let mut steps = Vec::new();
        let last = parts.ranges.len() - 1;
        let surfaces = self.surface_sizes();
        for (m, layers) in parts.ranges.iter().enumerate() {
            let voxels = self.part_box(lattice, settings, layers);
            if let Some(light) = light.filter(|_| surfaces.is_none()) {
                let voxels = voxels.first[lattice.frame.a]..voxels.end(lattice.frame.a);
                steps.push(Step::HoldLight { light, axis, voxels });
            }
            steps.push(Step::Hold { voxels, capacity: u * v * parts.held });
            let range = LayerRange { voxels: layers.clone(), continues: m > 0, raw: m < last };
            steps.push(Step::Layers { lattice, layered: *layered, range });
        }
        steps.push(Step::Warp { lattice, share: Share { share: *share, added: n > 0 } });
        let whole = self.grid.dims();
        if let Some(surfaces) = surfaces {
            // Fragments may be anywhere.
            let light = light.map(|light| Step::HoldLight { light, axis, voxels: 0..whole[lattice.frame.a] });
            steps = light.into_iter().chain([Step::Surfaces(steps, surfaces)]).collect();
        }
        // The voxels on the device are those of the first part, which need not be the largest.
        let mut dims = whole;
        dims[lattice.frame.a] = parts.held;
        let shape = FieldShape::new(self.volume.description(), dims);
        let part = Some(PartOfLight { whole, axis, layers: surfaces.map_or(parts.held, |_| whole[lattice.frame.a]) });
        let light = streamed.light.as_ref().map(|light| DeclaredLight { part, ..light.declared(settings) });
        engine.declaring(viewport, settings, |declaring| Stage::new(steps, false, &Declaring { shape, light, ..*declaring }))
    }

    /// An engine that holds what a frame begins with, the first slab of its light or the first part of the first lattice, with capacity
    /// for the others; or all voxels, if each lattice has one part.
    fn first_engine(&mut self, streamed: &Streamed) -> Result<Engine, Error> {
        if streamed.holds_all() {
            return Ok(Engine::new(&self.whole()?, &self.transfer));
        }
        let Streamed { lattices, light, settings, .. } = streamed;
        let (lattice, _, parts) = &lattices[0];
        // Free their memory for the parts.
        (self.kept, self.whole) = (None, None);
        let (VoxelBox { first, dims }, capacity) = match light.as_ref().and_then(PlannedLight::first_voxels) {
            Some(first) => first,
            None => (self.part_box(lattice, settings, &parts.ranges[0]), lattice.dims[0] * lattice.dims[1] * parts.held),
        };
        let part = self.volume.part(first, dims)?;
        let uploaded = UploadedVolume::with_capacity(&self.device, &part.held(), capacity)?;
        Ok(Engine::new(&uploaded, &self.transfer))
    }

    /// The voxels that a range of layers of a lattice needs.
    fn part_box(&self, lattice: &Lattice, settings: &Settings, layers: &Range<usize>) -> VoxelBox {
        let (a, dims) = (lattice.frame.a, self.grid.dims());
        VoxelBox::layers(dims, a, &PartRenderer::needed(layers, dims[a], settings))
    }

    fn volume_bytes(&self) -> u64 {
        self.grid.voxel_count() as u64 * self.volume.voxel_type().bytes() as u64
    }

    /// Limits for the buffers of a frame, including voxels.
    fn memory_limits(&self) -> MemoryLimits {
        let info = self.device.info();
        // A CPU device shares the host's memory, which also holds the source voxels and the picture.
        let available = if info.kind == DeviceKind::Cpu { memory::available() / 2 } else { info.memory_bytes };
        let budget = self.device.memory_budget().unwrap_or(available).min(info.memory_bytes);
        MemoryLimits { budget, taken: self.others(), largest: self.device.largest_buffer_bytes() }
    }

    /// Bytes on the device that other objects hold.
    fn others(&self) -> u64 {
        self.device.taken_bytes().saturating_sub(self.own)
    }
}
