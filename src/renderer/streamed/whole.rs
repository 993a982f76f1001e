//! Pictures and depths for which all voxels are on the device.

use super::super::accumulation::Jitter;
use super::super::classification::TableSizes;
use super::super::depths::depth_settings;
use super::super::field::FieldShape;
use super::super::frame::{Bytes, DeclaredLight, Declaring, Output, Stage};
use super::super::plan::Plan;
use super::super::report::FrameReport;
use super::super::{Renderer, UploadedVolume};
use super::{StreamedRenderer, plan};
use crate::camera::Camera;
use crate::error::Error;
use crate::image::{Depths, Frame};
use crate::settings::{FieldKind, Method, Settings};
use crate::viewport::Viewport;

impl StreamedRenderer<'_> {
    /// Renders with all voxels on the device, and keeps the renderer for the next frame.
    pub(super) fn render_whole(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
        jitter: Option<Jitter>,
    ) -> Result<(Frame, FrameReport), Error> {
        self.with_whole(|renderer| match jitter {
            None => renderer.render(camera, viewport, settings),
            Some(jitter) => renderer.render_jittered(camera, viewport, settings, jitter),
        })
    }

    /// Depths of the visible surfaces of a picture, as [`Renderer::depths`].
    ///
    /// # Errors
    /// Those of `Renderer::depths`. [`Error::MemoryBudget`] and [`Error::DeviceMemory`], with the memory required, if not all voxels
    /// fit on the device, because rays need all of them.
    pub fn depths(&mut self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Depths, Error> {
        FieldKind::One.check_method(Method::Depths, settings.blend)?;
        let (rays, seen) = self.world.normalised_view(&self.grid, camera, viewport, &depth_settings(settings))?;
        let plan = self.render_path(&rays, viewport, &seen)?;
        self.require_whole("a depth picture", &plan, viewport, &seen)?;
        let others = self.others();
        // Cached data of earlier frames may leave too little memory: retry without them.
        let found = match self.with_whole(|renderer| renderer.depths(camera, viewport, settings)) {
            Err(error) if error.is_lack_of_device_memory() => {
                self.kept = None;
                self.with_whole(|renderer| renderer.depths(camera, viewport, settings))
            }
            found => found,
        };
        self.own = self.device.taken_bytes().saturating_sub(others);
        found
    }

    /// Runs a frame with all voxels on the device, and keeps the renderer for the next frame.
    fn with_whole<T>(&mut self, run: impl FnOnce(&mut Renderer) -> Result<T, Error>) -> Result<T, Error> {
        let mut renderer = self.whole_renderer()?;
        let finished = run(&mut renderer);
        self.kept = Some(renderer);
        finished
    }

    /// A renderer of all voxels: the kept one, or a new one.
    fn whole_renderer(&mut self) -> Result<Renderer, Error> {
        let mut renderer = match self.kept.take() {
            Some(kept) => kept,
            None => Renderer::from_uploaded(&self.whole()?, &self.transfer)?,
        };
        renderer.measure(self.measuring);
        renderer.engine.limits = self.limits.clone();
        renderer.engine.surfaces = self.surfaces.clone();
        Ok(renderer)
    }

    /// Uploads all voxels on first use.
    pub(super) fn whole(&mut self) -> Result<UploadedVolume, Error> {
        match &self.whole {
            Some(uploaded) => Ok(uploaded.clone()),
            None => Ok(self.whole.insert(UploadedVolume::new(&self.device, &self.volume)?).clone()),
        }
    }

    /// Memory on the device of a plan with all voxels.
    pub(super) fn needs_as_whole(&self, plan: &Plan, viewport: Viewport, settings: &Settings) -> Bytes {
        let tables = TableSizes::new(&self.transfer, self.volume.description());
        let shape = FieldShape::new(self.volume.description(), self.grid.dims());
        let gradient = settings.needed_gradient();
        let light = DeclaredLight::new(settings, self.volume.description().grid());
        let surfaces = self.surface_sizes();
        let declaring = Declaring { gradient, light, surfaces, ..Declaring::new(shape, &tables, self.device.tuning(), viewport) };
        Stage::from_plan(plan, Output::Floats, false, &declaring).resources.bytes()
    }

    /// Rejects the plan of `what`, which needs the whole volume, if that does not fit together with the other resources of the frame.
    pub(super) fn require_whole(&self, what: &str, plan: &Plan, viewport: Viewport, settings: &Settings) -> Result<(), Error> {
        let (needed, limits) = (self.needs_as_whole(plan, viewport, settings), self.memory_limits());
        if limits.fits(needed) {
            return Ok(());
        }
        let unknown = if plan.counts_splats() { ", and more for its splats" } else { "" };
        let what = format!(
            "{what} ({plan}), which needs the whole volume at once because only layers on a lattice can be streamed{unknown},"
        );
        Err(plan::out_of_memory(&self.device, settings, &what, needed, limits))
    }
}
