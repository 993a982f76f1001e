//! Data of the systems that the paper compares with: lists of the voxels that sheets splat, and the table of slicing.

use super::super::field::{Field, Layout};
use super::super::store::{Key, Stored};
use super::tables::{CELL_ENTRIES, EntryKind, Integrals, IntegralsKey, TableKey};
use super::{Classification, PreparationKernels};
use crate::device::launch::Launcher;
use crate::device::launch::paper::{Place, PreintegratedTable, PreintegratedTableArguments, Splats, SplatsArguments};
use crate::device::launch::structs::Float4;
use crate::device::launch::surfaces::{Pass, Scan, ScanArguments};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::layers::{Axis, GAUSSIAN_OVERSHOOT, Kernel};
use crate::transfer::Extinction;
use std::sync::Arc;

/// Name of the table of slicing.
const SLICING_TABLE: &str = "the pre-integration table";

/// Number of front and of back values in the table of slicing.
pub(in crate::renderer) const SLAB_VALUES: usize = 256;

/// Kernels that derive these data.
#[derive(Default)]
pub(super) struct PaperKernels {
    splats: Launcher<Splats>,
    scan: Launcher<Scan>,
    slicing_table: Launcher<PreintegratedTable>,
}

/// Splatted voxels in the order of a layout.
pub(in crate::renderer) struct SplatList {
    pub places: Buffer<Place>,
    pub contents: Buffer<Float4>,
    pub count: usize,
}

/// Selection of the voxels in a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::renderer) enum Splatted {
    /// Visible voxels, for pre-classification.
    Visible,
    /// Voxels within reach of any visible sample, for post-classification.
    InReach,
    /// All voxels that differ from the background, for post-classification without culling.
    All,
}

#[derive(PartialEq)]
struct SplatListKey(TableKey, Axis, Splatted);

impl Key for SplatListKey {
    type Value = SplatList;
}

impl Stored for SplatList {
    fn bytes(&self) -> usize {
        self.places.bytes() + self.contents.bytes()
    }
}

/// Key: integrals, slab thickness in unit distances.
#[derive(PartialEq)]
struct SlicingKey(IntegralsKey, f32);

impl Key for SlicingKey {
    type Value = Buffer<Float4>;
}

impl Classification {
    /// The splats of axis-aligned sheets.
    pub fn axis_splats(
        &mut self,
        kernels: &mut PreparationKernels,
        device: &Device,
        field: &Field,
        axis: Axis,
        kind: EntryKind,
    ) -> Result<Arc<SplatList>, Error> {
        let layout = field.layout(&mut kernels.field, device, axis)?;
        self.splat_list(kernels, device, field, (axis, layout), kind, Splatted::Visible)
    }

    /// The splats of image-aligned sheets, and the layout that they refer to.
    pub fn view_splats(
        &mut self,
        kernels: &mut PreparationKernels,
        device: &Device,
        field: &Field,
        kind: EntryKind,
        splatted: Splatted,
    ) -> Result<(Arc<SplatList>, Layout), Error> {
        let layout = self.gaussian_layout(kernels, device, field, kind)?;
        let again = Layout { voxels: layout.voxels.clone(), view: layout.view };
        Ok((self.splat_list(kernels, device, field, (Axis::Z, layout), kind, splatted)?, again))
    }

    fn splat_list(
        &mut self,
        kernels: &mut PreparationKernels,
        device: &Device,
        field: &Field,
        (axis, Layout { voxels, view }): (Axis, Layout),
        kind: EntryKind,
        splatted: Splatted,
    ) -> Result<Arc<SplatList>, Error> {
        let key = SplatListKey(TableKey::new(kind, Kernel::Gaussian), axis, splatted);
        let inputs = self.inputs_with(field);
        if let Some(kept) = self.store.get(device, &key, inputs)? {
            return Ok(kept);
        }
        if let Some(n) = view.dims.iter().find(|&&n| n > i32::from(u16::MAX)) {
            let problem = format!("sheets support up to 65535 voxels along an axis, not {n}: use another algorithm");
            return Err(Error::Settings { field: "algorithm", problem });
        }
        let table = self.table(device, field, kind, Kernel::Gaussian)?;
        let rows = view.dims[1] as usize * view.dims[2] as usize;
        let counts = Buffer::new(device, rows, "the splats per row")?;
        let total = Buffer::new(device, 1, "the number of splats")?;
        let mut list = SplatList {
            places: Buffer::new(device, 1, "the splats")?,
            contents: Buffer::new(device, 1, "the splats")?,
            count: 0,
        };
        let (reach, slack) = match splatted {
            Splatted::Visible => (0, 0.0),
            Splatted::InReach => (Splats::REACH, GAUSSIAN_OVERSHOOT as f32),
            Splatted::All => (-1, 0.0),
        };
        for pass in [Pass::Count, Pass::Fill] {
            let arguments = SplatsArguments {
                voxels: &voxels,
                view,
                reach,
                slack,
                table_first: table.scale.first,
                table_per_value: table.scale.per_value,
                table_last: table.scale.last,
                visible_before: &table.visible_before,
                fill: pass.fill(),
                counts: &counts,
                places: &list.places,
                contents: &list.contents,
            };
            kernels.paper.splats.launch(device, voxels.kind(), &arguments)?;
            if pass == Pass::Count {
                let scan = ScanArguments { counts: &counts, chunks: rows as i32, buckets: 1, total: &total };
                kernels.paper.scan.launch(device, (), &scan)?;
                list.count = total.read_count(device, "the list of splats")?;
                list.places = Buffer::new(device, list.count, "the splats")?;
                list.contents = Buffer::new(device, list.count, "the splats")?;
            }
        }
        Ok(self.store.keep(key, inputs, device.produced()?, list))
    }

    /// The integrals and the slicing table for slabs of this thickness in unit distances.
    pub fn slicing_table(
        &mut self,
        kernels: &mut PreparationKernels,
        device: &Device,
        field: &Field,
        kind: EntryKind,
        thickness: f64,
    ) -> Result<(Arc<Integrals>, Arc<Buffer<Float4>>), Error> {
        let integrals = self.integrals(device, field, kind, Kernel::Linear, (thickness, 1))?;
        let integrals_key = IntegralsKey(TableKey::new(kind, Kernel::Linear), thickness, 1);
        let (key, inputs) = (SlicingKey(integrals_key, thickness as f32), self.inputs());
        if let Some(kept) = self.store.get(device, &key, inputs)? {
            return Ok((integrals, kept));
        }
        let bytes = SLAB_VALUES * SLAB_VALUES * size_of::<Float4>();
        let table = match self.store.reuse(device, &key, inputs, bytes) {
            Some(reused) => reused,
            None => Arc::new(Buffer::new(device, SLAB_VALUES * SLAB_VALUES, SLICING_TABLE)?),
        };
        let nodes = integrals.scale.last + 1;
        let arguments = PreintegratedTableArguments {
            integrals: &integrals.nodes,
            first: CELL_ENTRIES as i32,
            nodes,
            nodes_per_entry: (nodes - 1) as f32 / (SLAB_VALUES - 1) as f32,
            unit: integrals.unit,
            thickness: thickness as f32,
            linear: i32::from(kind.extinction == Extinction::Linear),
            size: SLAB_VALUES as i32,
            out: &table,
        };
        kernels.paper.slicing_table.launch(device, (), &arguments)?;
        Ok((integrals, self.store.keep(key, inputs, device.produced()?, table)))
    }
}

/// Name and bytes of the table of slicing, for resource declarations.
pub(in crate::renderer) fn slicing_table_size() -> (&'static str, usize) {
    (SLICING_TABLE, SLAB_VALUES * SLAB_VALUES * size_of::<Float4>())
}
