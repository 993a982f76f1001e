//! Frames on a lattice, parallel and perspective.

use super::Renderer;
use super::sample::slab_table;
use super::scratch::{at_least, filled};
use super::settings::Settings;
use crate::device::launch::params::{LatticeParams, LayerOffset, RayLatticeParams};
use crate::device::launch::{FootprintsKernel, LatticeArguments, LatticeKernel, PerspectiveArguments};
use crate::error::Error;
use crate::layers::{Axis, Correction, Lattice, PerspectiveLattice, Rays, quadrature_nodes};

impl Renderer {
    /// Makes what every lattice needs; `false` if the lattice has no samples, the volume being out of sight.
    fn begin_lattice(&mut self, axis: Axis, size: [u32; 2], correction: Correction, settings: &Settings) -> Result<bool, Error> {
        let Self { device, kernels, kept, scratch, .. } = self;
        kept.prepare(device, kernels, &[axis], &self.transfer, settings.extinction)?;
        filled(&mut scratch.slabs, device, &slab_table(correction), "the sub-slabs")?;
        let samples = size[0] as usize * size[1] as usize;
        at_least(&mut scratch.lattice, device, samples, "the lattice")?;
        at_least(&mut scratch.active_samples, device, 1, "the sample counts")?;
        scratch.active_count = 0;
        Ok(samples > 0)
    }

    /// Renders the lattice of a parallel view into `scratch.lattice`.
    pub(super) fn run_lattice(
        &mut self,
        lattice: &Lattice,
        correction: Correction,
        rays: &Rays,
        settings: &Settings,
    ) -> Result<(), Error> {
        let (frame, axis) = (lattice.frame, lattice.frame.layer_axis());
        if !self.begin_lattice(axis, lattice.size, correction, settings)? {
            return Ok(());
        }
        let Self { device, kept, scratch, .. } = self;
        let m = lattice.phases().map(|m| m as i32);
        let shear = lattice.shear.map(|s| s as f32);
        let layers = lattice.dims[2] + 2;
        let offsets = [0, 1].map(|i| -> Vec<LayerOffset> {
            lattice.offsets(i).iter().map(|o| LayerOffset { base: o.base, fraction: o.fraction }).collect()
        });
        for (slot, offsets) in scratch.offsets.iter_mut().zip(&offsets) {
            filled(slot, device, offsets, "the lattice offsets")?;
        }
        let weights = layers * m[0] as usize * m[1] as usize * FootprintsKernel::WEIGHTS;
        at_least(&mut scratch.weights, device, weights, "the footprint weights")?;
        at_least(&mut scratch.table, device, kept.table().entries.len(), "the opacity table")?;
        let tuning = *device.tuning();
        let columns = lattice.columns();
        let tiles = [columns[0].div_ceil(tuning.tile_columns()), columns[1].div_ceil(tuning.tile_rows)];
        let params = LatticeParams {
            samples_per_voxel: m,
            columns: columns.map(|c| c as i32),
            tiles: tiles.map(|t| t as i32),
            blocks: kept.occupancy(axis).blocks,
            layer_step: lattice.layer_step,
            culling: i32::from(settings.culling),
            shear,
        };
        scratch.active_count = LatticeKernel::tiles(&params);
        at_least(&mut scratch.active_samples, device, scratch.active_count, "the sample counts")?;

        let axes = self.sample_axes(rays, settings);
        let sample = self.sample_params(&axes, frame, settings);
        let Self { device, kernels, kept, scratch, .. } = self;
        let written = "written above";
        let offsets = [0, 1].map(|i| scratch.offsets[i].as_ref().expect(written));
        let weights = scratch.weights.as_ref().expect(written);
        let table = scratch.table.as_ref().expect(written);
        let dt = axes.sample_length(frame, lattice.shear) as f32;
        kernels.table(device)?.launch(device, &kept.table().entries, dt, sample.linear != 0, table)?;
        kernels.footprints(device)?.launch(device, offsets, shear, m, layers as i32, weights)?;
        let (voxels, view) = kept.layout(axis);
        kernels.lattice(device)?.launch(
            device,
            &LatticeArguments {
                voxels,
                view,
                offsets,
                weights,
                visible: kept.visible(axis),
                table,
                slabs: scratch.slabs.as_ref().expect(written),
                params,
                sample,
                lattice: scratch.lattice.as_ref().expect(written),
                active_samples: scratch.active_samples.as_ref().expect(written),
            },
        )
    }

    /// Renders the lattice of a perspective into `scratch.lattice`.
    pub(super) fn run_perspective(
        &mut self,
        lattice: &PerspectiveLattice,
        correction: Correction,
        rays: &Rays,
        settings: &Settings,
    ) -> Result<(), Error> {
        let (frame, axis) = (lattice.frame, lattice.frame.layer_axis());
        if !self.begin_lattice(axis, lattice.size, correction, settings)? {
            return Ok(());
        }
        let Self { device, kept, scratch, .. } = self;
        for (i, slot) in scratch.crossings.iter_mut().enumerate() {
            filled(slot, device, &lattice.crossings(i, 0), "the lattice rays")?;
        }
        filled(&mut scratch.nodes, device, &quadrature_nodes().map(|n| [n.z as f32, n.weight as f32]), "the quadrature")?;
        let tuning = *device.tuning();
        let tiles = [lattice.size[0].div_ceil(tuning.vector_width), lattice.size[1].div_ceil(tuning.tile_rows)];
        let params = RayLatticeParams {
            size: lattice.size.map(|n| n as i32),
            tiles: tiles.map(|t| t as i32),
            blocks: kept.occupancy(axis).blocks,
            layer_step: lattice.layer_step,
            culling: i32::from(settings.culling),
            centre_layer: lattice.centre_layer() as f32,
            visible: [0.0; 2],
            slabs: [0; 2],
        };
        scratch.active_count = tiles[0] as usize * tiles[1] as usize;
        at_least(&mut scratch.active_samples, device, scratch.active_count, "the sample counts")?;

        let sample = self.sample_params(&self.sample_axes(rays, settings), frame, settings);
        let Self { device, kernels, kept, scratch, .. } = self;
        let written = "written above";
        let (voxels, view) = kept.layout(axis);
        kernels.perspective(device)?.launch(
            device,
            &PerspectiveArguments {
                voxels,
                view,
                crossings: [0, 1].map(|i| scratch.crossings[i].as_ref().expect(written)),
                nodes: scratch.nodes.as_ref().expect(written),
                visible: kept.visible(axis),
                table: &kept.table().entries,
                slabs: scratch.slabs.as_ref().expect(written),
                params,
                sample,
                lattice: scratch.lattice.as_ref().expect(written),
                active_samples: scratch.active_samples.as_ref().expect(written),
            },
        )
    }
}
