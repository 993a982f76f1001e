//! Interface of part renderers for distributed rendering.

use super::view::LatticeView;
use super::{PartRenderer, RawSamples};
use crate::error::Error;
use crate::renderer::LatticeReport;
use crate::settings::Blend;
use opencl3::event::Event;
use std::ops::Range;

impl LatticeView {
    /// Number of samples along u and v.
    pub fn size(&self) -> [usize; 2] {
        self.lattice.size.map(|n| n as usize)
    }

    /// Blend mode of stored numbers.
    pub fn blend(&self) -> Blend {
        self.blend
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
    ) -> Result<RawSamples, Error> {
        if !layers.is_empty() {
            self.check_held(view, layers)?;
        }
        self.samples(view, if layers.is_empty() { 0..0 } else { layers.clone() }, before)
    }

    /// Declares that the voxels in the caller's memory have changed.
    pub(crate) fn volume_changed(&mut self, wait: &[&Event]) -> Result<(), Error> {
        self.engine.device.begin(wait)?;
        self.engine.field.voxels_changed();
        self.engine.device.end().map(drop)
    }
}
