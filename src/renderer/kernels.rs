//! Kernels, each built when first needed.

use crate::device::Device;
use crate::device::launch::params::Float4;
use crate::device::launch::{
    DirectKernel, FootprintSetKernel, FootprintsKernel, LatticeKernel, MarchKernel, OccupancyKernel, PerspectiveKernel, PointDirectKernel,
    PointLatticeKernel, PreintegratedTableKernel, PresentKernel, SlabVisibilityKernel, TableKernel, TransposeKernel, VisibilityKernel, WarpKernel,
};
use crate::error::Error;
use crate::layers::Interpolation;
use crate::volume::VoxelType;
use std::cell::OnceCell;

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
    /// For tables of integrals that span all values, and for others.
    point_lattice: [OnceCell<PointLatticeKernel>; 2],
    point_direct: [OnceCell<PointDirectKernel>; 2],
    direct: OnceCell<DirectKernel>,
    direct_set: OnceCell<DirectKernel>,
    warp: OnceCell<WarpKernel<Float4>>,
    warp_displayed: OnceCell<WarpKernel<[u8; 4]>>,
    present: OnceCell<PresentKernel>,
    /// Per interpolation.
    raycast: [OnceCell<MarchKernel>; 3],
    slicing: OnceCell<MarchKernel>,
    preintegrated_table: OnceCell<PreintegratedTableKernel>,
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
            direct: OnceCell::new(),
            direct_set: OnceCell::new(),
            warp: OnceCell::new(),
            warp_displayed: OnceCell::new(),
            present: OnceCell::new(),
            raycast: Default::default(),
            slicing: OnceCell::new(),
            preintegrated_table: OnceCell::new(),
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

    pub fn raycast(&self, device: &Device, interpolation: Interpolation) -> Result<&MarchKernel, Error> {
        let cell = &self.raycast[interpolation as usize];
        built(cell, || MarchKernel::raycast(device, self.voxel_type, interpolation))
    }

    pub fn slicing(&self, device: &Device) -> Result<&MarchKernel, Error> {
        built(&self.slicing, || MarchKernel::slicing(device, self.voxel_type))
    }

    /// `cut`: values can lie beyond the table of integrals.
    pub fn point_lattice(&self, device: &Device, cut: bool) -> Result<&PointLatticeKernel, Error> {
        built(&self.point_lattice[usize::from(cut)], || PointLatticeKernel::new(device, self.voxel_type, cut))
    }

    /// The same per pixel.
    pub fn point_direct(&self, device: &Device, cut: bool) -> Result<&PointDirectKernel, Error> {
        built(&self.point_direct[usize::from(cut)], || PointDirectKernel::new(device, self.voxel_type, cut))
    }

    pub fn direct(&self, device: &Device, footprint_set: bool) -> Result<&DirectKernel, Error> {
        let cell = if footprint_set { &self.direct_set } else { &self.direct };
        built(cell, || DirectKernel::new(device, self.voxel_type, footprint_set))
    }
}
