//! What processes that share a volume need of a renderer of their layers.

use super::PartRenderer;
use super::view::LatticeView;
use crate::error::Error;
use crate::renderer::LatticeReport;
use crate::settings::Blend;
use opencl3::event::Event;
use std::ops::Range;

impl LatticeView {
    /// Samples along u and v.
    pub fn size(&self) -> [usize; 2] {
        self.lattice.size.map(|n| n as usize)
    }

    /// The blend mode of stored numbers.
    pub fn blend(&self) -> Blend {
        self.blend
    }

    pub fn report(&self) -> LatticeReport {
        LatticeReport::of(&self.lattice)
    }
}

impl PartRenderer {
    /// The raw samples of some layers of a view, composited behind those `before`, or from nothing; no layers are nothing.
    pub(crate) fn raw(
        &mut self,
        view: &LatticeView,
        layers: &Range<usize>,
        before: Option<&[[f32; 4]]>,
    ) -> Result<Vec<[f32; 4]>, Error> {
        if !layers.is_empty() {
            self.check_held(view, layers)?;
        }
        self.samples(view, if layers.is_empty() { 0..0 } else { layers.clone() }, before)
    }

    /// The voxels have changed, where they are in memory of the caller's own.
    pub(crate) fn volume_changed(&mut self, wait: &[&Event]) -> Result<(), Error> {
        self.engine.device.begin(wait)?;
        self.engine.field.voxels_changed();
        self.engine.device.end().map(drop)
    }
}
