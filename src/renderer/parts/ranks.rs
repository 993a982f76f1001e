//! Interface of part renderers for distributed rendering.

use super::view::LatticeView;
use super::{PartRenderer, RawSamples};
use crate::device::Tuning;
use crate::error::Error;
use crate::layers::Axis;
use crate::renderer::LatticeReport;
use crate::renderer::frame::Step;
use crate::renderer::light::{BlockSlabs, LightOfParts, SweepGroup, Wanted, WantedField};
use crate::renderer::lighting::Lighting;
use crate::renderer::world::World;
use crate::settings::{Blend, Settings};
use crate::volume::{Description, Grid};
use opencl3::event::Event;
use std::ops::Range;

/// The grid of a volume in normalised world units.
fn normalised(description: &Description) -> Grid {
    World::new(description.grid()).grid(description.grid())
}

impl LatticeView {
    /// Number of samples along u and v.
    pub fn size(&self) -> [usize; 2] {
        self.lattice.size.map(|n| n as usize)
    }

    /// Blend mode of stored numbers.
    pub fn blend(&self) -> Blend {
        self.blend
    }

    /// Settings in normalised world units.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The light volumes of the whole view, and the light field of the studio.
    pub fn wanted_light(&self, description: &Description) -> Result<(Vec<Wanted>, Option<WantedField>), Error> {
        let Some(sources) = Lighting::sources_in(&self.settings, &normalised(description), &self.rays) else {
            return Ok((Vec::new(), None));
        };
        Ok((Wanted::all(&sources, &self.settings), WantedField::new(&sources, &self.settings)?))
    }

    /// All blocks of a light field.
    pub fn blocks(&self, description: &Description, field: &WantedField) -> BlockSlabs {
        BlockSlabs::new(field, &normalised(description), &self.settings)
    }

    /// The wanted volumes: those of `kept` that are among them, and others without light yet. With what must be swept for them.
    pub fn light(
        &self,
        description: &Description,
        kept: Option<LightOfParts>,
        wanted: &[Wanted],
    ) -> Result<(LightOfParts, Vec<SweepGroup>), Error> {
        let grid = normalised(description);
        let light = LightOfParts::continued(kept, wanted, &grid)?;
        let missing = light.missing(&grid, &self.settings);
        Ok((light, missing))
    }

    pub fn report(&self) -> LatticeReport {
        LatticeReport::new(&self.lattice)
    }
}

impl PartRenderer {
    /// Enables frame statistics, from the next call on.
    pub(crate) fn measure(&mut self, measuring: bool) {
        self.engine.measuring = measuring;
    }

    /// Composites a range of layers of a view behind the raw samples `before`, or from an empty state, and returns raw samples.
    /// The range may be empty.
    pub(crate) fn raw(
        &mut self,
        view: &LatticeView,
        layers: &Range<usize>,
        before: Option<&[[f32; 4]]>,
        light: Option<&LightOfParts>,
    ) -> Result<RawSamples, Error> {
        if !layers.is_empty() {
            self.check_held(view, layers)?;
        }
        self.samples(view, if layers.is_empty() { 0..0 } else { layers.clone() }, before, light)
    }

    /// Sweeps light through the first slab of a group, whose voxels the part holds.
    pub(crate) fn sweep(&mut self, view: &LatticeView, light: &LightOfParts, group: &SweepGroup) -> Result<(), Error> {
        self.run(view, vec![Step::Sweep { light, group, slab: 0 }], None, |_, _| Ok(())).map(drop)
    }

    /// Completes light volumes: all sweeps are in.
    pub(crate) fn finish_light(&mut self, view: &LatticeView, light: &LightOfParts) -> Result<(), Error> {
        self.run(view, vec![Step::FinishLight(light)], None, |_, _| Ok(())).map(drop)
    }

    /// Sums the blocks of the first slab, whose voxels the part holds.
    pub(crate) fn sum_blocks(&mut self, view: &LatticeView, light: &LightOfParts, slabs: &BlockSlabs) -> Result<(), Error> {
        let hold = Step::HoldLight { light, axis: Axis::Z, voxels: slabs.own_layers(&slabs.slabs[0]) };
        self.run(view, vec![hold, Step::SumBlocks { light, slabs, slab: 0 }], None, |_, _| Ok(())).map(drop)
    }

    /// Scatters light between all blocks, whose sums are in.
    pub(crate) fn scatter(&mut self, view: &LatticeView, light: &LightOfParts) -> Result<(), Error> {
        self.run(view, vec![Step::Scatter(light)], None, |_, _| Ok(())).map(drop)
    }

    /// Tuning values of the device.
    pub(crate) fn tuning(&self) -> &Tuning {
        self.engine.device.tuning()
    }

    /// Declares that the voxels in the caller's memory have changed.
    pub(crate) fn volume_changed(&mut self, wait: &[&Event]) -> Result<(), Error> {
        self.engine.device.begin(wait)?;
        self.engine.field_mut().voxels_changed();
        self.engine.device.end().map(drop)
    }
}
