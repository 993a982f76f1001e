//! Frames by ray casting, with and without pre-integrated stretches, and by slicing.

use super::Renderer;
use super::kept::SLAB_VALUES;
use super::sample::stretches;
use super::settings::{Classification, Settings};
use super::tables::{PointRays, PointReach};
use crate::device::launch::params::{MarchParams, SampleParams, ScreenParams};
use crate::device::launch::{MarchArguments, MarchKernel, MarchTable, Stretches};
use crate::error::Error;
use crate::layers::{Axis, Interpolation, Rays, Viewport};

/// Rays are marched in the upload's own layout.
const AXIS: Axis = Axis::Z;
/// Most steps across a volume.
const MOST_STEPS: f64 = (1 << 22) as f64;

impl Renderer {
    /// Casts rays into `scratch.frame`.
    pub(super) fn run_raycast(
        &mut self,
        interpolation: Interpolation,
        step: f64,
        rays: &Rays,
        viewport: Viewport,
        settings: &Settings,
    ) -> Result<(), Error> {
        self.check_steps(step)?;
        let gaussian = interpolation == Interpolation::Gaussian;
        let reach = if gaussian { PointReach::Gaussian } else { PointReach::Near };
        self.prepare_march(PointRays { reach, thinnest: None, samples: 1 }, settings)?;
        let axes = self.sample_axes(rays, settings);
        let length = step * axes.step.min_element();
        let params = MarchParams { length: length as f32, ..self.march_params(reach, settings) };
        let screen = self.begin_screen(rays, viewport, &axes, AXIS.frame())?;
        let kernel = self.kernels.raycast(&self.device, interpolation)?;
        let sample = self.sample_params(&axes, AXIS.frame(), settings);
        self.march("raycast", kernel, reach, MarchTable::Entries(&self.kept.table().entries), screen, params, sample)
    }

    /// Slices into `scratch.frame`.
    pub(super) fn run_slicing(&mut self, step: f64, rays: &Rays, viewport: Viewport, settings: &Settings) -> Result<(), Error> {
        self.check_steps(step)?;
        let axes = self.sample_axes(rays, settings);
        let length = step * axes.step.min_element();
        self.prepare_march(PointRays { reach: PointReach::Near, thinnest: Some(length), samples: 1 }, settings)?;
        let Self { device, kernels, kept, .. } = self;
        kept.prepare_slab_table(device, kernels, length as f32)?;
        let ray_parameter = self.ray_parameter(step, rays);
        let integrals = self.kept.integrals();
        let (table_first, per_value, last) = integrals.scale;
        let params = MarchParams {
            slice_step: ray_parameter as f32,
            thin: i32::from(longest_slab(rays, viewport, ray_parameter) <= 1.0),
            table_first,
            table_per_value: per_value * (SLAB_VALUES - 1) as f32 / last as f32,
            table_size: SLAB_VALUES as i32,
            visible: integrals.visible_values,
            ..self.march_params(PointReach::Near, settings)
        };
        let screen = self.begin_screen(rays, viewport, &axes, AXIS.frame())?;
        let kernel = self.kernels.slicing(&self.device, self.kept.integrals().cut)?;
        let table = MarchTable::Entries(&self.kept.table().slabs.as_ref().expect("made above").1);
        let sample = self.sample_params(&axes, AXIS.frame(), settings);
        self.march("slicing", kernel, PointReach::Near, table, screen, params, sample)
    }

    /// Casts rays with pre-integrated stretches into `scratch.frame`.
    pub(super) fn run_stretches(&mut self, step: f64, rays: &Rays, viewport: Viewport, settings: &Settings) -> Result<(), Error> {
        self.check_steps(step)?;
        // Here steps are what divides a layer, not samples.
        let settings = &Settings { classification: Classification::Preintegrated { samples_per_layer: 1 }, ..*settings };
        let axes = self.sample_axes(rays, settings);
        let layer = axes.step.min_element();
        let samples = (1.0 / step).round() as u32;
        self.prepare_march(PointRays { reach: PointReach::Near, thinnest: Some(step * layer), samples }, settings)?;
        let ray_parameter = self.ray_parameter(step, rays);
        let params = MarchParams {
            slice_step: ray_parameter as f32,
            thin: i32::from(longest_slab(rays, viewport, ray_parameter) <= 1.0),
            visible: self.kept.integrals().visible_values,
            ..self.march_params(PointReach::Near, settings)
        };
        let screen = self.begin_screen(rays, viewport, &axes, AXIS.frame())?;
        let stretches = Stretches { curved: false, ..stretches(self.kept.integrals(), settings) };
        let kernel = self.kernels.cast_stretches(&self.device, stretches)?;
        let table = MarchTable::Integrals(&self.kept.integrals().nodes);
        let sample = SampleParams { curve: 0.0, ..self.sample_params(&axes, AXIS.frame(), settings) };
        self.march("raycast", kernel, PointReach::Near, table, screen, params, sample)
    }

    /// The rays' parameter from one plane to the next, `step` smallest spacings apart along the central ray; other rays of a perspective
    /// cross them at an angle.
    fn ray_parameter(&self, step: f64, rays: &Rays) -> f64 {
        step * self.grid.spacing().min_element() / self.depth_per_parameter(rays)
    }

    /// Refuses what would take practically forever, or more steps than floats can count.
    fn check_steps(&self, step: f64) -> Result<(), Error> {
        let steps = self.grid.diagonal() / (step * self.grid.spacing().min_element());
        if steps <= MOST_STEPS {
            return Ok(());
        }
        let problem = format!(
            "a step of {step} smallest spacings cuts the volume's diagonal into {steps:.0} steps, more than {MOST_STEPS:.0}: make \
             --step longer"
        );
        Err(Error::Settings { problem })
    }

    fn prepare_march(&mut self, rays: PointRays, settings: &Settings) -> Result<(), Error> {
        let Self { device, kernels, kept, .. } = self;
        kept.prepare_points(device, kernels, &[AXIS], &self.transfer, settings.extinction, rays)
    }

    /// World distance along the central ray per unit of the rays' parameter: the same for all rays.
    fn depth_per_parameter(&self, rays: &Rays) -> f64 {
        -(rays.direction[0] * self.grid.spacing()).dot(rays.to_eye)
    }

    /// What both ways of marching need.
    fn march_params(&self, reach: PointReach, settings: &Settings) -> MarchParams {
        MarchParams {
            blocks: self.kept.point_occupancy(AXIS, reach).blocks,
            culling: i32::from(settings.culling),
            length: 0.0,
            slice_step: 0.0,
            thin: 0,
            table_first: 0.0,
            table_per_value: 0.0,
            table_size: 0,
            visible: [0.0; 2],
        }
    }

    #[expect(clippy::too_many_arguments, reason = "one launch")]
    fn march(
        &self,
        stage: &'static str,
        kernel: &MarchKernel,
        reach: PointReach,
        table: MarchTable,
        screen: ScreenParams,
        params: MarchParams,
        sample: SampleParams,
    ) -> Result<(), Error> {
        let (voxels, view) = self.kept.layout_for(AXIS, reach);
        let made = "begin_screen() made it";
        kernel.launch(
            &self.device,
            stage,
            &MarchArguments {
                voxels,
                view,
                visible: &self.kept.slabs_visible(AXIS, reach).bits,
                table,
                screen,
                params,
                sample,
                frame: self.scratch.frame.as_ref().expect(made),
                active_samples: self.scratch.active_samples.as_ref().expect(made),
            },
        )
    }
}

/// The longest way of any ray through a slab along any axis, in voxels: a corner's, since directions are affine in pixels.
fn longest_slab(rays: &Rays, viewport: Viewport, ray_parameter: f64) -> f64 {
    rays.corners(viewport).iter().map(|ray| ray.direction.abs().max_element() * ray_parameter).fold(0.0, f64::max)
}
