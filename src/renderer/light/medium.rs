//! The medium in which light scatters, from the fields of a scene.

use super::super::channels::{FieldInputs, MergedInputs};
use super::super::classification::VisibleBlocks;
use super::super::region::Region;
use super::super::scene::Scene;
use super::super::store::Key;
use super::cells::ScatterGrids;
use super::scatter::{CELLS, LIGHT_FIELD, Scattering, levels, packed_bytes};
use super::sources::{LightSources, StudioLight};
use super::{ABSORBERS, KERNEL, Medium, check_addressable};
use crate::color::albedo;
use crate::device::Buffer;
use crate::device::launch::PerChannel;
use crate::device::launch::scatter::{MEDIUM_PLANES, ScatterMediumArguments};
use crate::device::launch::structs::{ClassificationParams, Float4, ScatterMediumParams};
use crate::error::Error;
use crate::layers::{Axis, OrdinatePair, entering};
use std::ops::Range;
use std::sync::Arc;

/// Optical depth of the edge of a cell above which matter is as good as opaque. Floats are precise below.
const DEEPEST: f64 = 1e3;

#[derive(PartialEq)]
struct ScatterKey(StudioLight, Vec<Medium>);

impl Key for ScatterKey {
    type Value = Buffer<u8>;
}

/// A field that scatters light: the optical depth of each table entry, and that times the albedo.
struct Scatterer {
    field: FieldInputs,
    entries: Buffer<Float4>,
}

impl Scene<'_> {
    /// The light field that samples look up. `lights`: the volumes of the lights that are swept.
    pub(super) fn scattered(
        &mut self,
        light: &StudioLight,
        grids: ScatterGrids,
        sources: &LightSources,
        lights: Option<&Buffer<u8>>,
    ) -> Result<Arc<Buffer<u8>>, Error> {
        let (key, inputs) = (ScatterKey(light.clone(), self.media()?), self.inputs());
        if let Some(kept) = self.light.store.get(self.device, &key, inputs)? {
            return Ok(kept);
        }
        let bytes = packed_bytes(light.cells(&grids));
        check_addressable(bytes)?;
        let packed = match self.light.store.reuse(self.device, &key, inputs, bytes) {
            Some(reused) => reused,
            None => Arc::new(Buffer::new(self.device, bytes, LIGHT_FIELD)?),
        };
        let blocks = self.scatter_blocks(light, &grids, sources, lights, 0..grids.blocks[2])?;
        self.solve(light, grids, &blocks, &packed)?;
        Ok(self.light.store.keep(key, inputs, self.device.produced()?, packed))
    }

    /// Scatters light between blocks of voxels.
    pub(super) fn solve(
        &mut self,
        light: &StudioLight,
        grids: ScatterGrids,
        blocks: &Buffer<f32>,
        packed: &Buffer<u8>,
    ) -> Result<(), Error> {
        let sky = light.studio.sky;
        let entering = entering(&OrdinatePair::all(), |direction| sky.radiance(direction.dot(light.up)));
        let (device, kernels) = (self.device, &mut self.light.scatter);
        let mut scattering = Scattering { device, kernels, grids, entering, scattering: light.studio.scattering };
        scattering.solve(blocks, &levels(&grids, light.grid), packed)
    }

    /// What blocks of voxels absorb and scatter of the lights of this scene.
    #[cfg(test)]
    pub(in crate::renderer) fn lit_blocks(&mut self) -> Result<(ScatterGrids, Buffer<f32>), Error> {
        let sources = self.light_sources().expect("the studio has lights");
        let lights = self.shadows(sources.swept.clone(), 1.0)?;
        let (light, grids) = sources.studio().expect("the look is the studio");
        Ok((*grids, self.scatter_blocks(light, grids, &sources, Some(&lights), 0..grids.blocks[2])?))
    }

    /// What blocks of voxels in some layers along z absorb and scatter.
    pub(super) fn scatter_blocks(
        &mut self,
        light: &StudioLight,
        grids: &ScatterGrids,
        sources: &LightSources,
        lights: Option<&Buffer<u8>>,
        layers: Range<usize>,
    ) -> Result<Buffer<f32>, Error> {
        let scatterers = self.for_each_absorber(|scene| scene.scatterer(grids.fine.edge))?;
        let merged = MergedInputs::new(scatterers.iter().map(|scatterer| &scatterer.field).collect())?;
        let entries: Vec<_> = scatterers.iter().map(|scatterer| &scatterer.entries).collect();
        let [x, y, _] = grids.blocks;
        let dims = [x, y, layers.len()];
        let blocks = Buffer::new(self.device, MEDIUM_PLANES * dims.iter().product::<usize>(), CELLS)?;
        let fields = merged.params(self.device, ABSORBERS.name)?;
        let (frame, values) = (Axis::Z.frame(), sources.grids()[0]);
        let strides = values.strides(frame);
        let (crossings, towards, shears) = sources.ways(grids.fine.edge, strides);
        let p = ScatterMediumParams {
            dims: dims.map(|n| n as i32),
            first_layer: layers.start as i32,
            lights: lights.map_or(0, |_| sources.swept.len() as i32),
            irradiance: light.arriving(),
            light_bytes: values.values() as i32,
            light_row: strides[1],
            light_layer: strides[2],
            light_first: values.held().first[2] as i32,
            light_shift: values.voxels().ilog2() as i32,
            crossings,
            towards,
            shears,
        };
        let arguments = ScatterMediumArguments {
            fields: merged.arguments(&fields),
            entries: PerChannel::new(&entries),
            ray_ends: merged.region.for_kernels(frame),
            light: lights.unwrap_or(merged.unused()),
            p,
            blocks: &blocks,
            colors: merged.colors(),
        };
        let variant = (merged.kind, merged.rendering, grids.per_block, merged.channels());
        self.light.medium.launch(self.device, variant, &arguments)?;
        Ok(blocks)
    }

    /// The field of this scene, with optical depths of an edge of this world length.
    fn scatterer(&mut self, edge: f64) -> Result<Scatterer, Error> {
        let mut field = self.absorbing_blocks(edge / self.settings.unit_distance.unwrap_or(self.field.unit_distance()))?;
        if let Some(colors) = self.absorbed_colors()? {
            field.place.to_own = colors.placement();
            field.colors = Some(colors.along(Axis::Z.frame()));
        }
        let table = self.table(KERNEL)?;
        let scattering = |&[r, g, b, extinction]: &[f32; 4]| {
            let depth = (f64::from(extinction) * field.length).min(DEEPEST);
            let [r, g, b] = [r, g, b].map(|reflectance| (albedo(f64::from(reflectance)) * depth) as f32);
            Float4([r, g, b, depth as f32])
        };
        let entries: Vec<_> = table.on_host.entries.iter().map(scattering).collect();
        Ok(Scatterer { entries: Buffer::from_slice(self.device, &entries, CELLS)?, field })
    }

    /// The field of this scene as input of kernels that sum over blocks of voxels. `length`: see [`FieldInputs::length`].
    pub(super) fn absorbing_blocks(&mut self, length: f64) -> Result<FieldInputs, Error> {
        let table = self.table(KERNEL)?;
        let layout = self.weighted(Axis::Z, KERNEL)?;
        let mut gradients = self.extinction_gradients(Axis::Z, &layout)?;
        let layout = self.field.in_whole(layout);
        gradients.layout = self.field.in_whole(gradients.layout);
        let sample = self.light_samples(Axis::Z.frame(), ClassificationParams::from_table(self, &table));
        let (visible, region) = (Arc::new(VisibleBlocks::unculled(self.device)?), Region::for_light(self));
        let place = self.placement(Axis::Z.frame(), KERNEL, &region, &visible);
        Ok(FieldInputs { layout, gradients, visible, sample, region, place, length, colors: None })
    }
}
