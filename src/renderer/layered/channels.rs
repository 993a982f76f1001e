//! Point-sampled layers of several fields.

use super::super::channels::{CHANNELS, MergedInputs};
use super::super::classification::{DIMMING, Table};
use super::super::scene::Scene;
use super::point_inputs::{LatticeView, PointInputs};
use crate::device::launch::layered::{ChannelLattice, ChannelLatticeArguments, Segments};
use crate::device::launch::{BlendMode, Launcher, Output, PerChannel};
use crate::error::Error;
use crate::transfer::Extinction;
use std::sync::Arc;

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

impl ChannelLayers {
    pub fn draw(&mut self, scene: &mut Scene, view: &LatticeView, output: Output) -> Result<(), Error> {
        let device = scene.device;
        let inputs = scene.for_each_channel(|scene| PointInputs::new(scene, view))?;
        let merged = MergedInputs::new(inputs.iter().map(|inputs| &inputs.field).collect())?;
        let segments = self.merged(&inputs, merged.rendering.blend, scene.settings.extinction);
        let integrals: Vec<_> = inputs.iter().map(|inputs| &inputs.integrals.nodes).collect();
        let tables: Vec<_> = inputs.iter().map(|inputs| &inputs.table.entries).collect();
        let (illumination, fields) = (scene.illumination()?, merged.params(device, CHANNELS.name)?);
        let light = illumination.arguments(merged.unused());
        let arguments = ChannelLatticeArguments {
            channels: merged.shaded(&fields, &tables, light, merged.region.for_layers(view.frame()), output),
            integrals: PerChannel::new(&integrals),
            shown_slabs: merged.shown_slabs(),
            p: view.params(merged.blocks(), scene.settings.culling),
            colors: merged.colors(),
        };
        let variant = (merged.kind, view.kernel, segments, view.rendering(merged.rendering), merged.channels());
        self.lattice.launch(device, variant, &arguments)
    }

    /// Segment permutation for all fields together.
    fn merged(&mut self, channels: &[PointInputs], blend: BlendMode, extinction: Extinction) -> Segments {
        let base = channels[0].segments;
        if blend != BlendMode::Composite || extinction == Extinction::Linear {
            return base;
        }
        let tables: Vec<_> = channels.iter().map(|channel| channel.table.clone()).collect();
        let layers: Vec<_> = channels.iter().map(|channel| channel.field.length).collect();
        let known = self.dimming.take().filter(|known| known.is_of(&tables, &layers));
        let dimming = self.dimming.insert(known.unwrap_or_else(|| MutualDimming::new(tables, layers)));
        Segments { dimmed: dimming.is_noticeable || channels.iter().any(|channel| channel.segments.dimmed), ..base }
    }
}
