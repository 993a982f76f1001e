//! Runs the steps of frames.

use super::super::picture::{Finished, WarpInputs};
use super::super::plan::Plan;
use super::super::range::LayerRange;
use super::super::rays::RayOutput;
use super::super::scene::{Scene, View};
use super::super::surfaces::{Pending, SurfacePass, UploadedSurfaces};
use super::super::tiles::Target;
use super::engine::{Done, Engine, Frame};
use super::steps::{Step, between, drawn_by};
use crate::device::launch::structs::Float4;
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::layers::Lattice;
use crate::settings::{self, Layered};
use std::sync::Arc;

impl Engine {
    /// Runs a step.
    pub(super) fn step(&mut self, view: View, frame: &Frame, step: &Step, done: &mut Done) -> Result<(), Error> {
        let View { device, rays, viewport, settings, .. } = view;
        match *step {
            Step::Sweep { light, group, slab } => self.with_scene(view, |scene| scene.sweep_slab(light, group, slab))?,
            Step::FinishLight(light) => self.with_scene(view, |scene| scene.finish_light(light))?,
            Step::SumBlocks { light, slabs, slab } => {
                self.with_scene(view, |scene| scene.sum_blocks(light, &slabs.slabs[slab]))?
            }
            Step::Scatter(light) => self.with_scene(view, |scene| scene.scatter_light(light))?,
            Step::HoldLight { light, axis, ref voxels } => {
                self.with_scene(view, |scene| scene.hold_light(light, axis, voxels))?
            }
            Step::Hold { voxels, .. } if self.field().holds(voxels) => {}
            Step::Hold { voxels, capacity } => {
                tracing::debug!("reading {voxels:?}");
                let volume = frame.volume.expect("only streamed frames replace voxels");
                let part = volume.part(voxels.first, voxels.dims)?;
                self.field_mut().replace(device, &part.held(), capacity)?;
            }
            Step::Continue(samples) => self.target.fill(device, samples)?,
            Step::Layers { lattice, layered, ref range } => {
                self.draw_layers(view, lattice, layered, range)?;
                self.count(device, done)?;
                done.finished = Finished::Floats(self.target.drawn().samples);
            }
            Step::Screen(plan, gathers) => {
                self.draw_screen(view, plan, gathers)?;
                self.count(device, done)?;
                done.finished = Finished::Floats(self.target.drawn().samples);
            }
            Step::Surfaces(ref volume, _) => {
                done.finished = Finished::Floats(self.draw_surfaces(view, frame, volume, done)?);
            }
            Step::Slice(plan) => {
                let Self { fields, kernels, light, passes, target, .. } = self;
                fields.with_scene(view, kernels, light, |scene| passes.slices.draw(scene, plan, target))?;
                done.finished = Finished::Floats(target.drawn().samples);
            }
            Step::Warp { lattice, share } => {
                let onto = WarpInputs { lattice, rays, viewport, is_linear: settings.studio.is_some() };
                done.finished = self.passes.picture.warp(device, &self.target, onto, share)?;
            }
            Step::WarpDisplayed { lattice, background } => {
                let onto = WarpInputs { lattice, rays, viewport, is_linear: settings.studio.is_some() };
                done.finished = self.passes.picture.warp_displayed(device, &self.target, onto, (background, settings.curve()))?;
            }
            Step::Present(background) => {
                let Finished::Floats(floats) = &done.finished else { unreachable!("floats are displayed") };
                done.finished =
                    self.passes.picture.present(device, &self.target, floats, viewport, (background, settings.curve()))?;
            }
        }
        Ok(())
    }

    fn with_scene<T>(&mut self, view: View, work: impl FnOnce(&mut Scene) -> Result<T, Error>) -> Result<T, Error> {
        let Self { fields, kernels, light, .. } = self;
        fields.with_scene(view, kernels, light, work)
    }

    /// Adds the number of samples with opacity of the last pass, if the frame is measured.
    fn count(&self, device: &Device, done: &mut Done) -> Result<(), Error> {
        if let Some(active_samples) = &mut done.active_samples {
            *active_samples += self.target.count_active(device)?;
        }
        Ok(())
    }

    fn draw_layers(&mut self, view: View, lattice: &Lattice, layered: Layered, range: &LayerRange) -> Result<(), Error> {
        let Self { fields, kernels, light, passes, target, .. } = self;
        fields.with_scene(view, kernels, light, |scene| match layered.classification {
            settings::Classification::Post(correction) => passes.splats.draw_lattice(scene, lattice, correction, range, target),
            settings::Classification::Preintegrated { kernel, samples_per_layer } => {
                passes.points.draw_lattice(scene, lattice, (kernel, samples_per_layer), layered.evaluation, range, target)
            }
        })
    }

    fn draw_screen(&mut self, view: View, plan: &Plan, gathers: RayOutput) -> Result<(), Error> {
        let Self { fields, kernels, light, passes, target, .. } = self;
        fields.with_scene(view, kernels, light, |scene| match *plan {
            Plan::Raycast(kernel, step) => passes.rays.cast(scene, kernel, step, gathers, target),
            // Several fields, and colours, are classified at each sample of a ray, not between them.
            Plan::CastSegments(kernel, step) if scene.is_tiled() => passes.rays.cast(scene, kernel, step, gathers, target),
            Plan::CastSegments(kernel, step) => passes.rays.cast_segments(scene, kernel, step, target),
            Plan::CastValues(kernel, step) => passes.rays.cast_values(scene, kernel, step, gathers, target),
            Plan::Direct(axis, layered) => match layered.classification {
                settings::Classification::Post(correction) => {
                    passes.splats.draw_pixels(scene, axis, correction, layered.footprints, target)
                }
                settings::Classification::Preintegrated { kernel, samples_per_layer } => {
                    passes.points.draw_pixels(scene, axis, (kernel, samples_per_layer), target)
                }
            },
            #[cfg(feature = "paper")]
            Plan::Paper(plan) => passes.paper.draw(scene, plan, target),
            Plan::Lattice(..) | Plan::Shared(..) => unreachable!("drawn as layers"),
        })
    }

    /// Draws surfaces, and between them the volume by these steps.
    fn draw_surfaces(
        &mut self,
        view: View,
        frame: &Frame,
        volume: &[Step],
        done: &mut Done,
    ) -> Result<Arc<Buffer<Float4>>, Error> {
        let view = View { is_cut: true, ..view };
        let (lattice, gathers) = drawn_by(volume);
        let mut drawn = self.target.drawn().samples;
        let mut first = true;
        let mut pending = Pending::FIRST;
        let is_enqueued = done.is_enqueued;
        let mut enqueued =
            self.with_surfaces(view, |pass, surfaces, scene, target| pass.begin(scene, surfaces, lattice, is_enqueued, target))?;
        while !pending.is_nothing() {
            if pending.find {
                self.with_surfaces(view, |pass, surfaces, scene, target| pass.find(scene, surfaces, target, first))?;
            }
            if let Some(layers) = pending.draw {
                self.target.cuts = Some(SurfacePass::cuts(&self.target, lattice.is_some()));
                let result = between(volume, layers).iter().try_for_each(|step| self.step(view, frame, step, done));
                self.target.cuts = None;
                result?;
                drawn = done.finished.floats().clone();
            }
            pending = self.with_surfaces(view, |pass, _, scene, target| {
                pass.composite(scene, (&drawn, lattice), target, gathers, first)?;
                enqueued.as_mut().map_or_else(|| SurfacePass::pending(scene, target), |passes| Ok(passes.next()))
            })?;
            first = false;
        }
        if enqueued.is_none() {
            self.passes.surfaces.end();
        }
        Ok(SurfacePass::picture(&self.target))
    }

    fn with_surfaces<T>(
        &mut self,
        view: View,
        work: impl FnOnce(&mut SurfacePass, &Arc<UploadedSurfaces>, &mut Scene, &mut Target) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let Self { fields, kernels, light, passes, target, surfaces, .. } = self;
        let surfaces = surfaces.as_ref().expect("frames with surfaces have them");
        fields.with_scene(view, kernels, light, |scene| work(&mut passes.surfaces, surfaces, scene, target))
    }
}
