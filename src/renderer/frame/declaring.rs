//! What passes need to know to declare what a frame needs: sizes, and nothing of a device's memory.

use super::super::classification::TableSizes;
use super::super::field::FieldShape;
use super::resources::Resources;
use crate::device::Tuning;
use crate::layers::{Axis, Kernel};
use crate::viewport::Viewport;

/// A frame to be declared.
pub(in crate::renderer) struct Declaring<'a> {
    /// The voxels on the device, or those that would be.
    pub shape: FieldShape,
    pub tables: &'a TableSizes<'a>,
    pub tuning: &'a Tuning,
    pub viewport: Viewport,
}

impl Declaring<'_> {
    /// What a kernel reads of the voxels of a layer axis, and which blocks of them show anything.
    pub fn visibility(&self, axis: Axis, kernel: Kernel, resources: &mut Resources) {
        self.layouts(axis, kernel, resources);
        resources.kept(("visibility", Some(axis), Some(kernel)), self.shape.visibility(axis, kernel));
        self.table(kernel, resources);
    }

    /// The layouts that a kernel needs for a layer axis.
    pub fn layouts(&self, axis: Axis, kernel: Kernel, resources: &mut Resources) {
        resources.kept(("layouts", Some(axis), Some(kernel)), self.shape.layouts(axis, kernel));
    }

    /// The transfer table of a kernel's field.
    pub fn table(&self, kernel: Kernel, resources: &mut Resources) {
        resources.kept(("table", None, Some(kernel)), TableSizes::table(self.tables.entries(kernel)));
    }

    /// Its integrals.
    pub fn integrals(&self, kernel: Kernel, resources: &mut Resources) {
        self.table(kernel, resources);
        resources.kept(("integrals", None, Some(kernel)), [TableSizes::integrals(self.tables.entries(kernel))]);
    }
}
