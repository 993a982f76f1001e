//! Kernels, each built when first needed.

use crate::device::Device;
use crate::device::launch::params::Float4;
use crate::device::launch::{
    AxisSheetsKernel, DirectKernel, FootprintSetKernel, FootprintsKernel, LatticeKernel, MarchKernel, OccupancyKernel,
    PerspectiveKernel, PointDirectKernel, PointLatticeKernel, PreintegratedTableKernel, PresentKernel, ScanKernel,
    SlabVisibilityKernel, SortedSplatsKernel, SplatsKernel, Stretches, TableKernel, TiledSplatsKernel, TransposeKernel,
    ViewSheetsKernel, VisibilityKernel, WarpKernel,
};
use crate::error::Error;
use crate::layers::Interpolation;
use crate::volume::VoxelType;
use std::cell::{OnceCell, RefCell};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::rc::Rc;

/// All kernels for one voxel type.
pub(super) struct Kernels {
    voxel_type: VoxelType,
    transpose: OnceCell<TransposeKernel>,
    occupancy: OnceCell<OccupancyKernel>,
    visibility: OnceCell<VisibilityKernel>,
    slab_visibility: OnceCell<SlabVisibilityKernel>,
    table: OnceCell<TableKernel>,
    footprints: OnceCell<FootprintsKernel>,
    footprint_set: OnceCell<FootprintSetKernel>,
    lattice: OnceCell<LatticeKernel>,
    perspective: OnceCell<PerspectiveKernel>,
    /// By kind of stretches.
    point_lattice: [OnceCell<PointLatticeKernel>; 8],
    point_direct: [OnceCell<PointDirectKernel>; 8],
    cast_stretches: [OnceCell<MarchKernel>; 8],
    direct: OnceCell<DirectKernel>,
    direct_set: OnceCell<DirectKernel>,
    warp: OnceCell<WarpKernel<Float4>>,
    warp_displayed: OnceCell<WarpKernel<[u8; 4]>>,
    present: OnceCell<PresentKernel>,
    /// Per interpolation.
    raycast: [OnceCell<MarchKernel>; 3],
    /// For tables of integrals that span all values, and for others.
    slicing: [OnceCell<MarchKernel>; 2],
    preintegrated_table: OnceCell<PreintegratedTableKernel>,
    splats: OnceCell<SplatsKernel>,
    scan: OnceCell<ScanKernel>,
    /// As they are, and classified.
    sorted_splats: [OnceCell<SortedSplatsKernel>; 2],
    tiled_splats: OnceCell<TiledSplatsKernel>,
    axis_sheets: OnceCell<AxisSheetsKernel>,
    /// By how many sheets a splat reaches, and whether they are shaded.
    view_sheets: RefCell<HashMap<(usize, bool), Rc<ViewSheetsKernel>>>,
}

fn built<T>(cell: &OnceCell<T>, build: impl FnOnce() -> Result<T, Error>) -> Result<&T, Error> {
    match cell.get() {
        Some(kernel) => Ok(kernel),
        None => {
            let kernel = build()?;
            Ok(cell.get_or_init(|| kernel))
        }
    }
}

fn kind_of(stretches: Stretches) -> usize {
    4 * usize::from(stretches.dimmed) + 2 * usize::from(stretches.cut) + usize::from(stretches.curved)
}

/// A getter that builds its kernel from the device alone, or from the device and the voxel type.
macro_rules! getter {
    ($name:ident, $kernel:ty) => {
        pub fn $name(&self, device: &Device) -> Result<&$kernel, Error> {
            built(&self.$name, || <$kernel>::new(device))
        }
    };
    ($name:ident, $kernel:ident, voxels) => {
        pub fn $name(&self, device: &Device) -> Result<&$kernel, Error> {
            built(&self.$name, || $kernel::new(device, self.voxel_type))
        }
    };
}

impl Kernels {
    pub fn new(voxel_type: VoxelType) -> Self {
        Self {
            voxel_type,
            transpose: OnceCell::new(),
            occupancy: OnceCell::new(),
            visibility: OnceCell::new(),
            slab_visibility: OnceCell::new(),
            table: OnceCell::new(),
            footprints: OnceCell::new(),
            footprint_set: OnceCell::new(),
            lattice: OnceCell::new(),
            perspective: OnceCell::new(),
            point_lattice: Default::default(),
            point_direct: Default::default(),
            cast_stretches: Default::default(),
            direct: OnceCell::new(),
            direct_set: OnceCell::new(),
            warp: OnceCell::new(),
            warp_displayed: OnceCell::new(),
            present: OnceCell::new(),
            raycast: Default::default(),
            slicing: Default::default(),
            preintegrated_table: OnceCell::new(),
            splats: OnceCell::new(),
            scan: OnceCell::new(),
            sorted_splats: Default::default(),
            tiled_splats: OnceCell::new(),
            axis_sheets: OnceCell::new(),
            view_sheets: RefCell::default(),
        }
    }

    getter!(transpose, TransposeKernel, voxels);
    getter!(occupancy, OccupancyKernel, voxels);
    getter!(visibility, VisibilityKernel, voxels);
    getter!(slab_visibility, SlabVisibilityKernel, voxels);
    getter!(table, TableKernel);
    getter!(footprints, FootprintsKernel);
    getter!(footprint_set, FootprintSetKernel);
    getter!(lattice, LatticeKernel, voxels);
    getter!(perspective, PerspectiveKernel, voxels);
    getter!(warp, WarpKernel<Float4>);
    getter!(warp_displayed, WarpKernel<[u8; 4]>);
    getter!(present, PresentKernel);
    getter!(preintegrated_table, PreintegratedTableKernel);
    getter!(splats, SplatsKernel, voxels);
    getter!(scan, ScanKernel);
    getter!(tiled_splats, TiledSplatsKernel);
    getter!(axis_sheets, AxisSheetsKernel);

    pub fn sorted_splats(&self, device: &Device, preclassified: bool) -> Result<&SortedSplatsKernel, Error> {
        built(&self.sorted_splats[usize::from(preclassified)], || SortedSplatsKernel::new(device, preclassified))
    }

    pub fn view_sheets(&self, device: &Device, sheets: usize, shading: bool) -> Result<Rc<ViewSheetsKernel>, Error> {
        match self.view_sheets.borrow_mut().entry((sheets, shading)) {
            Entry::Occupied(kernel) => Ok(kernel.get().clone()),
            Entry::Vacant(place) => Ok(place.insert(Rc::new(ViewSheetsKernel::new(device, sheets, shading)?)).clone()),
        }
    }

    pub fn raycast(&self, device: &Device, interpolation: Interpolation) -> Result<&MarchKernel, Error> {
        let cell = &self.raycast[interpolation as usize];
        built(cell, || MarchKernel::raycast(device, self.voxel_type, interpolation))
    }

    /// `cut`: values can lie beyond the table of integrals.
    pub fn slicing(&self, device: &Device, cut: bool) -> Result<&MarchKernel, Error> {
        built(&self.slicing[usize::from(cut)], || MarchKernel::slicing(device, self.voxel_type, cut))
    }

    pub fn point_lattice(&self, device: &Device, stretches: Stretches) -> Result<&PointLatticeKernel, Error> {
        let cell = &self.point_lattice[kind_of(stretches)];
        built(cell, || PointLatticeKernel::new(device, self.voxel_type, stretches))
    }

    /// The same per pixel.
    pub fn point_direct(&self, device: &Device, stretches: Stretches) -> Result<&PointDirectKernel, Error> {
        let cell = &self.point_direct[kind_of(stretches)];
        built(cell, || PointDirectKernel::new(device, self.voxel_type, stretches))
    }

    /// The same by ray casting.
    pub fn cast_stretches(&self, device: &Device, stretches: Stretches) -> Result<&MarchKernel, Error> {
        let cell = &self.cast_stretches[kind_of(stretches)];
        built(cell, || MarchKernel::stretches(device, self.voxel_type, stretches))
    }

    pub fn direct(&self, device: &Device, footprint_set: bool) -> Result<&DirectKernel, Error> {
        let cell = if footprint_set { &self.direct_set } else { &self.direct };
        built(cell, || DirectKernel::new(device, self.voxel_type, footprint_set))
    }
}
