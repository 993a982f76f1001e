//! Frames on a lattice with point-sampled layers, parallel and perspective.

use super::Renderer;
use super::plan::Plan;
use super::sample::stretches;
use super::scratch::{at_least, filled};
use super::settings::{Classification, Evaluation, Settings};
use super::tables::{PointRays, PointReach};
use crate::device::launch::PointLatticeArguments;
use crate::device::launch::params::RayLatticeParams;
use crate::error::Error;
use crate::layers::{AxisFrame, Density, Lattice, PerspectiveLattice, Rays};

/// What the kernel needs to know of a lattice of either projection.
struct RayLattice {
    frame: AxisFrame,
    size: [u32; 2],
    layer_step: i32,
    centre_layer: f64,
    reach: PointReach,
    crossings: [Vec<[f32; 2]>; 2],
}

impl RayLattice {
    /// `padding` more columns than the lattice has.
    fn new(plan: &Plan, padding: impl Fn(u32) -> u32) -> Option<Self> {
        Some(match plan {
            Plan::Lattice(l) => {
                let crossings = [l.crossings(0, padding(l.size[0])), l.crossings(1, 0)];
                let Lattice { frame, size, layer_step, shear, .. } = *l;
                let reach = if shear.iter().all(|s| s.abs() <= 1.0) { PointReach::Near } else { PointReach::Leaning };
                Self { frame, size, layer_step, centre_layer: l.centre_layer(), reach, crossings }
            }
            Plan::Perspective(l) => {
                let crossings = [l.crossings(0, padding(l.size[0])), l.crossings(1, 0)];
                let PerspectiveLattice { frame, size, layer_step, .. } = *l;
                Self { frame, size, layer_step, centre_layer: l.centre_layer(), reach: PointReach::Leaning, crossings }
            }
            _ => return None,
        })
    }
}

/// Pixels that a layer is thick from which on it is sampled once more, and twice more.
const MAGNIFIED: [f64; 2] = [6.0, 12.0];

/// Settings for layers that are so many pixels thick: where lattices follow the screen, samples along rays do too. Few voxels
/// are in view then, and what happens between layers is large enough to be seen.
fn magnified(settings: &Settings, pixels: f64) -> Settings {
    match (settings.evaluation, settings.classification) {
        (Evaluation::Lattice(Density::Relaxed | Density::Fine), Classification::Preintegrated { samples_per_layer }) => {
            let more = MAGNIFIED.iter().filter(|&&limit| pixels >= limit).count() as u32;
            let samples_per_layer = (samples_per_layer + more).min(Classification::MAX_POINTS);
            Settings { classification: Classification::Preintegrated { samples_per_layer }, ..*settings }
        }
        _ => *settings,
    }
}

impl Renderer {
    /// Renders the lattice of a plan into `scratch.lattice`; nothing for one without a lattice.
    pub(super) fn run_points(&mut self, plan: &Plan, rays: &Rays, settings: &Settings) -> Result<(), Error> {
        let tuning = *self.device.tuning();
        let Some(lattice) = RayLattice::new(plan, |columns| columns.next_multiple_of(tuning.vector_width) - columns) else {
            return Ok(());
        };
        let axis = lattice.frame.layer_axis();
        let settings = &magnified(settings, rays.pixels_along(lattice.frame.a));
        let axes = self.sample_axes(rays, settings);
        let Self { device, kernels, kept, scratch, .. } = self;
        let point_rays =
            PointRays { reach: lattice.reach, thinnest: Some(axes.step.min_element()), samples: settings.samples_per_layer() };
        kept.prepare_points(device, kernels, &[axis], &self.transfer, settings.extinction, point_rays)?;
        let samples = lattice.size[0] as usize * lattice.size[1] as usize;
        at_least(&mut scratch.lattice, device, samples, "the lattice")?;
        at_least(&mut scratch.active_samples, device, 1, "the sample counts")?;
        scratch.active_count = 0;
        if samples == 0 {
            return Ok(());
        }
        for (slot, crossings) in scratch.crossings.iter_mut().zip(&lattice.crossings) {
            filled(slot, device, crossings, "the lattice rays")?;
        }
        let tiles = [lattice.size[0].div_ceil(tuning.vector_width), lattice.size[1].div_ceil(tuning.point_tile_rows)];
        let params = RayLatticeParams {
            size: lattice.size.map(|n| n as i32),
            tiles: tiles.map(|t| t as i32),
            blocks: kept.point_occupancy(axis, lattice.reach).blocks,
            layer_step: lattice.layer_step,
            culling: i32::from(settings.culling),
            centre_layer: lattice.centre_layer as f32,
            visible: kept.integrals().visible_values,
            slabs: kept.slabs_visible(axis, lattice.reach).slabs,
        };
        scratch.active_count = tiles[0] as usize * tiles[1] as usize;
        at_least(&mut scratch.active_samples, device, scratch.active_count, "the sample counts")?;

        let sample = self.sample_params(&axes, lattice.frame, settings);
        let Self { device, kernels, kept, scratch, .. } = self;
        let written = "written above";
        let (voxels, view) = kept.layout(axis);
        let stretches = stretches(kept.integrals(), settings);
        kernels.point_lattice(device, stretches)?.launch(
            device,
            &PointLatticeArguments {
                voxels,
                view,
                crossings: [0, 1].map(|i| scratch.crossings[i].as_ref().expect(written)),
                visible: &kept.slabs_visible(axis, lattice.reach).bits,
                integrals: &kept.integrals().nodes,
                params,
                sample,
                lattice: scratch.lattice.as_ref().expect(written),
                active_samples: scratch.active_samples.as_ref().expect(written),
            },
        )
    }
}
