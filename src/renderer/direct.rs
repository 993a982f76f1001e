//! Frames per screen pixel.

use super::Renderer;
use super::kept::{at_least, filled, upload_strides};
use super::sample::slab_table;
use super::settings::{Footprints, Settings};
use crate::device::launch::DirectArguments;
use crate::device::launch::params::DirectParams;
use crate::error::Error;
use crate::layers::{Axis, Rays, Viewport};
use glam::DVec3;

impl Renderer {
    /// Renders into `scratch.frame`, with one layer axis for all rays or each ray's own.
    pub(super) fn run_direct(
        &mut self,
        axis: Option<Axis>,
        rays: &Rays,
        viewport: Viewport,
        settings: &Settings,
    ) -> Result<(), Error> {
        let Self { device, kernels, kept, scratch, .. } = self;
        let axes = axis.map_or(Axis::ALL.to_vec(), |a| vec![a]);
        kept.prepare(device, kernels, &axes, &self.transfer, settings.extinction)?;
        filled(&mut scratch.slabs, device, &slab_table(settings.correction), "the sub-slabs")?;
        at_least(&mut scratch.frame, device, viewport.pixels(), "the frame")?;
        at_least(&mut scratch.active_samples, device, viewport.pixels(), "the sample counts")?;
        // A kernel with exact footprints reads neither: any buffers do.
        let set = settings.footprints == Footprints::Set;
        at_least(&mut scratch.crossings[0], device, 1, "a placeholder")?;
        if set {
            kept.make_footprint_set(device, kernels)?;
        }

        let sample_axes = self.sample_axes(rays, settings);
        let sample = self.sample_params(&sample_axes, Axis::Z.frame(), settings);
        let narrow = |v: DVec3| v.as_vec3().to_array();
        let affine = |p: &[DVec3; 3]| p.map(|v| v.as_vec3().extend(0.0).to_array());
        // Blocks and flags of axes that no ray takes are not read.
        let known = Axis::ALL.map(|a| if axes.contains(&a) { a } else { axes[0] });
        let (background, offset) = self.kept.background();
        let params = DirectParams {
            stride: upload_strides(&self.grid),
            origin: affine(&rays.origin),
            direction: affine(&rays.direction),
            start: rays.start as f32,
            spacing: narrow(sample_axes.step),
            gradient: narrow(sample_axes.gradient),
            light: narrow(sample_axes.light),
            half_way: narrow(sample_axes.half_way),
            dims: self.grid.dims().map(|n| n as i32),
            blocks: known.map(|a| self.kept.occupancy(a).blocks),
            axis: axis.map_or(-1, |a| a.index() as i32),
            culling: i32::from(settings.culling),
            background,
            offset,
        };
        let Self { device, kernels, kept, scratch, .. } = self;
        let written = "written above";
        scratch.active_count = viewport.pixels();
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
}
