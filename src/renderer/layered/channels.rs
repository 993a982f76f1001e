//! Point-sampled layers of several fields.

use super::super::frame::{Declaring, Resources, Slot};
use super::super::region::Region;
use super::super::scene::Scene;
use super::points::{LatticeView, PointInputs, segments};
use crate::device::Buffer;
use crate::device::launch::layered::{ChannelLattice, ChannelLatticeArguments, Channels, Segments};
use crate::device::launch::structs::{ChannelParams, Float4};
use crate::device::launch::{BlendMode, Launcher, PerChannel, Rendering};
use crate::error::Error;
use crate::transfer::Extinction;

const CHANNELS: Slot<ChannelParams> = Slot::new("the parameters of channels");

/// Sum of the optical depths of a layer above which the fields dim each other: SUBDIVISION_DEPTH in kernels/shared/dimmed_segment.cl.
const DIMMING_DEPTH: f64 = 0.3;

/// Renders point-sampled layers of several fields.
#[derive(Default)]
pub(super) struct ChannelLayers {
    lattice: Launcher<ChannelLattice>,
}

/// The layers of a field, and the programs that they need.
struct ClassifiedLayers {
    inputs: PointInputs,
    region: Region,
    rendering: Rendering,
    segments: Segments,
}

/// Declares what several fields need besides the resources of each.
pub(super) fn declare_channels(declaring: &Declaring, resources: &mut Resources) {
    if !declaring.others.is_empty() {
        resources.host(&CHANNELS, 1 + declaring.others.len());
    }
}

impl ChannelLayers {
    pub fn draw(
        &mut self,
        scene: &mut Scene,
        view: &LatticeView,
        samples: &Buffer<Float4>,
        active_samples: &Buffer<u32>,
    ) -> Result<(), Error> {
        let device = scene.device;
        let (kernel, per_layer) = (view.kernel, view.per_layer);
        let channels = scene.for_each_channel(|scene| {
            let inputs = PointInputs::new(scene, view)?;
            let region = Region::new(scene, kernel, per_layer);
            let rendering = region.rendering_from(&inputs.gradients);
            let segments = segments(scene, &inputs.integrals, per_layer);
            Ok(ClassifiedLayers { inputs, region, rendering, segments })
        })?;
        let (base, others) = channels.split_first().expect("the scene's own field");
        let kind = base.inputs.layout.voxels.kind();
        let mut rendering = base.rendering;
        for other in others {
            require_alike(base, other)?;
            rendering = Rendering {
                clipped: rendering.clipped || other.rendering.clipped,
                gradient_opacity: rendering.gradient_opacity || other.rendering.gradient_opacity,
                ..rendering
            };
        }
        let region = Region::intersection(channels.iter().map(|channel| &channel.region));
        let params: Vec<ChannelParams> = channels.iter().map(|channel| channel.params(base.inputs.layer)).collect();
        let arguments = ChannelLatticeArguments {
            voxels: each(&channels, |inputs| &*inputs.layout.voxels),
            gradient_voxels: each(&channels, |inputs| &*inputs.gradients.layout.voxels),
            visible: each(&channels, |inputs| &inputs.visible.flags),
            shown_slabs: each(&channels, |inputs| &inputs.visible.shown),
            integrals: each(&channels, |inputs| &inputs.integrals.nodes),
            tables: each(&channels, |inputs| &inputs.table.entries),
            channel_params: &Buffer::from_slice(device, &params, CHANNELS.name)?,
            count: params.len() as i32,
            light: &base.inputs.visible.flags,
            sky: &base.inputs.visible.flags,
            p: view.params(base.inputs.visible.blocks, scene.settings.culling),
            clip: region.for_layers(view.frame()),
            lattice: samples,
            active_samples,
        };
        let variant = (kind, kernel, merged(&channels, scene.settings.extinction), rendering, Channels::new(params.len()));
        self.lattice.launch(device, variant, &arguments)
    }
}

impl ClassifiedLayers {
    /// Kernel argument, with lengths in unit distances of the field whose layers have the length `layer`.
    fn params(&self, layer: f64) -> ChannelParams {
        let PointInputs { layout, gradients, sample, layer: own, .. } = &self.inputs;
        let mut sample = *sample;
        sample.classification.table_unit *= (own / layer) as f32;
        ChannelParams { view: layout.view, gradient_view: gradients.layout.view, sample }
    }
}

fn each<'a, T: Copy>(channels: &'a [ClassifiedLayers], argument: impl Fn(&'a PointInputs) -> T) -> PerChannel<T> {
    PerChannel::new(&channels.iter().map(|channel| argument(&channel.inputs)).collect::<Vec<_>>())
}

/// Segment permutation for all fields together.
fn merged(channels: &[ClassifiedLayers], extinction: Extinction) -> Segments {
    let depth: f64 = channels.iter().map(|channel| channel.inputs.integrals.deepest * channel.inputs.layer).sum();
    let composites = channels.iter().all(|channel| channel.rendering.blend == BlendMode::Composite);
    let together = composites && extinction == Extinction::Exponential && depth > DIMMING_DEPTH;
    let base = channels[0].segments;
    Segments { dimmed: together || channels.iter().any(|channel| channel.segments.dimmed), ..base }
}

/// Rejects fields that one program cannot draw together.
fn require_alike(base: &ClassifiedLayers, other: &ClassifiedLayers) -> Result<(), Error> {
    if other.rendering.blend != base.rendering.blend {
        let problem = "the values of one channel fall where its stored numbers rise, and those of another do not: convert one of them";
        return Err(Error::Settings { field: "channels", problem: problem.into() });
    }
    Ok(())
}
