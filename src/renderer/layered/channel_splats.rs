//! Splatted layers of several fields, post-classified.

use super::super::channels::{CHANNELS, Together};
use super::super::scene::Scene;
use super::splats::{PhaseWeights, SplatInputs, SplattedLayers};
use crate::device::Buffer;
use crate::device::launch::layered::{
    ChannelSplatLattice, ChannelSplatLatticeArguments, ChannelSplatPerspective, ChannelSplatPerspectiveArguments,
};
use crate::device::launch::{Launcher, PerChannel};
use crate::error::Error;

/// Renders splatted layers of several fields.
#[derive(Default)]
pub(super) struct ChannelSplats {
    lattice: Launcher<ChannelSplatLattice>,
    perspective: Launcher<ChannelSplatPerspective>,
}

impl ChannelSplats {
    /// Renders a lattice in phases.
    pub fn draw_phases(&mut self, scene: &mut Scene, layers: &SplattedLayers, phases: &PhaseWeights) -> Result<(), Error> {
        let device = scene.device;
        let inputs = inputs(scene, layers)?;
        let together = Together::new(inputs.iter().map(|inputs| &inputs.field).collect())?;
        let tables: Vec<_> = inputs.iter().map(|inputs| &inputs.table.entries).collect();
        let illumination = scene.illumination()?;
        let [light, sky] = illumination.arguments(together.unused());
        let arguments = ChannelSplatLatticeArguments {
            voxels: together.voxels(),
            gradient_voxels: together.gradient_voxels(),
            visible: together.visible(),
            tables: PerChannel::new(&tables),
            channel_params: &together.params(device, CHANNELS.name)?,
            count: together.count() as i32,
            light,
            sky,
            offsets_u: &phases.offsets[0],
            offsets_v: &phases.offsets[1],
            weights: &phases.weights,
            slabs: &layers.slabs,
            p: layers.phase_params(phases.phases, together.blocks(), scene.settings.culling),
            clip: together.region.for_kernels(layers.lattice.frame),
            lattice: &layers.drawn.samples,
            active_samples: &layers.drawn.active_samples,
        };
        self.lattice.launch(device, (together.kind, together.rendering, together.channels()), &arguments)
    }

    /// Renders a lattice of rays. `nodes`: those of the quadrature of footprints.
    pub fn draw_rays(&mut self, scene: &mut Scene, layers: &SplattedLayers, nodes: &Buffer<[f32; 2]>) -> Result<(), Error> {
        let device = scene.device;
        let inputs = inputs(scene, layers)?;
        let together = Together::new(inputs.iter().map(|inputs| &inputs.field).collect())?;
        let tables: Vec<_> = inputs.iter().map(|inputs| &inputs.table.entries).collect();
        let illumination = scene.illumination()?;
        let [light, sky] = illumination.arguments(together.unused());
        let arguments = ChannelSplatPerspectiveArguments {
            voxels: together.voxels(),
            gradient_voxels: together.gradient_voxels(),
            visible: together.visible(),
            tables: PerChannel::new(&tables),
            channel_params: &together.params(device, CHANNELS.name)?,
            count: together.count() as i32,
            light,
            sky,
            nodes,
            slabs: &layers.slabs,
            p: layers.ray_params(together.blocks(), scene.settings.culling),
            clip: together.region.for_kernels(layers.lattice.frame),
            lattice: &layers.drawn.samples,
            active_samples: &layers.drawn.active_samples,
        };
        self.perspective.launch(device, (together.kind, together.rendering, together.channels()), &arguments)
    }
}

/// What layers of each field are splatted from.
fn inputs(scene: &mut Scene, layers: &SplattedLayers) -> Result<Vec<SplatInputs>, Error> {
    scene.for_each_channel(|scene| SplatInputs::new(scene, layers))
}
