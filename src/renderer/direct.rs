//! Frames per screen pixel.

use super::Renderer;
use super::kept::upload_strides;
use super::sample::SampleAxes;
use super::sample::{slab_table, stretches};
use super::scratch::{at_least, filled};
use super::settings::{Footprints, Settings};
use super::tables::{PointRays, PointReach};
use crate::device::launch::params::DirectParams;
use crate::device::launch::{DirectArguments, PointDirectArguments};
use crate::error::Error;
use crate::layers::{Axis, Correction, Rays, Viewport};
use glam::DVec3;

impl Renderer {
    /// Renders into `scratch.frame`, with one layer axis for all rays or each ray's own.
    pub(super) fn run_direct(
        &mut self,
        axis: Option<Axis>,
        correction: Correction,
        rays: &Rays,
        viewport: Viewport,
        settings: &Settings,
    ) -> Result<(), Error> {
        let Self { device, kernels, kept, scratch, .. } = self;
        let axes = axes_of(axis);
        kept.prepare(device, kernels, &axes, &self.transfer, settings.extinction)?;
        filled(&mut scratch.slabs, device, &slab_table(correction), "the sub-slabs")?;
        // A kernel with exact footprints reads neither: any buffers do.
        let set = settings.footprints == Footprints::Set;
        at_least(&mut scratch.crossings[0], device, 1, "a placeholder")?;
        if set {
            kept.make_footprint_set(device, kernels)?;
        }
        self.make_frame(viewport)?;

        // Blocks and flags of axes that no ray takes are not read.
        let known = Axis::ALL.map(|a| if axes.contains(&a) { a } else { axes[0] });
        let sample_axes = self.sample_axes(rays, settings);
        let sample = self.sample_params(&sample_axes, Axis::Z.frame(), settings);
        let blocks = known.map(|a| self.kept.occupancy(a).blocks);
        let params = self.direct_params(axis, rays, &sample_axes, blocks, settings);
        let Self { device, kernels, kept, scratch, .. } = self;
        let written = "written above";
        let visible = known.map(|a| kept.visible(a));
        let (images, shears) = match kept.footprint_set() {
            Some(set) => (&set.images, &set.shears),
            None => (visible[0], scratch.crossings[0].as_ref().expect(written)),
        };
        kernels.direct(device, set)?.launch(
            device,
            &DirectArguments {
                voxels: kept.uploaded(),
                visible,
                table: &kept.table().entries,
                slabs: scratch.slabs.as_ref().expect(written),
                images,
                shears,
                params,
                sample,
                size: [viewport.width as i32, viewport.height as i32],
                frame: scratch.frame.as_ref().expect(written),
                active_samples: scratch.active_samples.as_ref().expect(written),
            },
        )
    }

    /// The same with point-sampled layers.
    pub(super) fn run_point_direct(
        &mut self,
        axis: Option<Axis>,
        rays: &Rays,
        viewport: Viewport,
        settings: &Settings,
    ) -> Result<(), Error> {
        let sample_axes = self.sample_axes(rays, settings);
        let Self { device, kernels, kept, .. } = self;
        let axes = axes_of(axis);
        let point_rays = PointRays {
            reach: PointReach::Leaning,
            thinnest: Some(sample_axes.step.min_element()),
            samples: settings.samples_per_layer(),
        };
        kept.prepare_points(device, kernels, &axes, &self.transfer, settings.extinction, point_rays)?;
        self.make_frame(viewport)?;

        let known = Axis::ALL.map(|a| if axes.contains(&a) { a } else { axes[0] });
        let sample = self.sample_params(&sample_axes, Axis::Z.frame(), settings);
        let blocks = known.map(|a| self.kept.point_occupancy(a, PointReach::Leaning).blocks);
        let params = self.direct_params(axis, rays, &sample_axes, blocks, settings);
        let Self { device, kernels, kept, scratch, .. } = self;
        let made = "made above";
        let stretches = stretches(kept.integrals(), settings);
        kernels.point_direct(device, stretches)?.launch(
            device,
            &PointDirectArguments {
                voxels: kept.uploaded(),
                visible: known.map(|a| &kept.slabs_visible(a, PointReach::Leaning).bits),
                integrals: &kept.integrals().nodes,
                params,
                sample,
                size: [viewport.width as i32, viewport.height as i32],
                frame: scratch.frame.as_ref().expect(made),
                active_samples: scratch.active_samples.as_ref().expect(made),
            },
        )
    }

    fn make_frame(&mut self, viewport: Viewport) -> Result<(), Error> {
        let Self { device, scratch, .. } = self;
        at_least(&mut scratch.frame, device, viewport.pixels(), "the frame")?;
        at_least(&mut scratch.active_samples, device, viewport.pixels(), "the sample counts")?;
        scratch.active_count = viewport.pixels();
        Ok(())
    }

    fn direct_params(
        &self,
        axis: Option<Axis>,
        rays: &Rays,
        axes: &SampleAxes,
        blocks: [[i32; 2]; 3],
        settings: &Settings,
    ) -> DirectParams {
        let narrow = |v: DVec3| v.as_vec3().to_array();
        let affine = |p: &[DVec3; 3]| p.map(|v| v.as_vec3().extend(0.0).to_array());
        let (background, offset) = self.kept.background();
        DirectParams {
            stride: upload_strides(&self.grid),
            origin: affine(&rays.origin),
            direction: affine(&rays.direction),
            start: rays.start as f32,
            spacing: narrow(axes.step),
            gradient: narrow(axes.gradient),
            light: narrow(axes.light),
            half_way: narrow(axes.half_way),
            dims: self.grid.dims().map(|n| n as i32),
            blocks,
            axis: axis.map_or(-1, |a| a.index() as i32),
            culling: i32::from(settings.culling),
            background,
            offset,
        }
    }
}

/// The layer axes that rays can have: one, or each ray's own.
fn axes_of(axis: Option<Axis>) -> Vec<Axis> {
    axis.map_or(Axis::ALL.to_vec(), |a| vec![a])
}
