//! Point-sampled layers of several fields.

use super::super::classification::{DIMMING, Table};
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
use std::sync::Arc;

const CHANNELS: Slot<ChannelParams> = Slot::new("the parameters of channels");

/// Renders point-sampled layers of several fields.
#[derive(Default)]
pub(super) struct ChannelLayers {
    lattice: Launcher<ChannelLattice>,
    dimming: Option<MutualDimming>,
}

/// Whether some fields dim each other.
struct MutualDimming {
    tables: Vec<Arc<Table>>,
    /// Length of a layer in unit distances of each.
    layers: Vec<f64>,
    is_noticeable: bool,
}

impl MutualDimming {
    fn new(tables: Vec<Arc<Table>>, layers: Vec<f64>) -> Self {
        let length = layers.iter().fold(0.0, |longest: f64, &layer| longest.max(layer));
        let pairs = tables.iter().enumerate().flat_map(|(n, one)| {
            let others = tables.iter().enumerate().filter(move |(m, _)| *m != n);
            others.map(move |(_, other)| one.on_host.dimming_with(&other.on_host, length))
        });
        let is_noticeable = pairs.fold(0.0, f64::max) > DIMMING;
        Self { tables, layers, is_noticeable }
    }

    fn is_of(&self, tables: &[Arc<Table>], layers: &[f64]) -> bool {
        let same = self.tables.iter().zip(tables).all(|(one, other)| Arc::ptr_eq(one, other));
        same && self.tables.len() == tables.len() && self.layers == layers
    }
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
        let variant = (kind, kernel, self.merged(&channels, scene.settings.extinction), rendering, Channels::new(params.len()));
        self.lattice.launch(device, variant, &arguments)
    }

    /// Segment permutation for all fields together.
    fn merged(&mut self, channels: &[ClassifiedLayers], extinction: Extinction) -> Segments {
        let base = channels[0].segments;
        if channels[0].rendering.blend != BlendMode::Composite || extinction == Extinction::Linear {
            return base;
        }
        let tables: Vec<_> = channels.iter().map(|channel| channel.inputs.table.clone()).collect();
        let layers: Vec<_> = channels.iter().map(|channel| channel.inputs.layer).collect();
        let known = self.dimming.take().filter(|known| known.is_of(&tables, &layers));
        let dimming = self.dimming.insert(known.unwrap_or_else(|| MutualDimming::new(tables, layers)));
        Segments { dimmed: dimming.is_noticeable || channels.iter().any(|channel| channel.segments.dimmed), ..base }
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

/// Rejects fields that one program cannot draw together.
fn require_alike(base: &ClassifiedLayers, other: &ClassifiedLayers) -> Result<(), Error> {
    if other.rendering.blend != base.rendering.blend {
        let problem = "the values of one channel fall where its stored numbers rise, and those of another do not: convert one of them";
        return Err(Error::Settings { field: "channels", problem: problem.into() });
    }
    Ok(())
}
