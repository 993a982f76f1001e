//! What stays on the device from frame to frame.

use super::kernels::Kernels;
use super::splat_list::{SplatList, SplatSource, Splatted};
use super::tables::{Integrals, PointRays, PointReach, SlabsVisible, Table};
use crate::device::launch::params::VolumeView;
use crate::device::launch::{Occupancy, PreintegratedTableArguments, Reach, Visibility, VoxelBuffer};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::layers::{Axis, FOOTPRINT_SET_LEN, FOOTPRINT_SET_SIZE, set_direction};
use crate::transfer::{Extinction, TransferFunction};
use crate::volume::{Grid, Volume};

/// The volume, what is known of it per layer axis, and the tables of the transfer function.
pub(super) struct Kept {
    dims: [usize; 3],
    /// Taken from every voxel by the kernels, so that float sums are as fine as the data's own range.
    offset: f64,
    background: f64,
    field_range: (f64, f64),
    voxels: VoxelBuffer,
    transposed: Option<VoxelBuffer>,
    occupancies: [Option<Occupancy>; 3],
    /// Of points with kernels of radius 1, and of 2.
    point_occupancies: [[Option<Occupancy>; 3]; 2],
    table: Option<Table>,
    footprint_set: Option<FootprintSet>,
}

/// The paper's footprint images.
pub(super) struct FootprintSet {
    pub images: Buffer<u8>,
    pub shears: Buffer<[f32; 2]>,
}

impl Kept {
    pub fn upload(device: &Device, volume: &Volume) -> Result<Self, Error> {
        Ok(Self {
            dims: volume.grid().dims(),
            offset: volume.range().0,
            background: volume.background(),
            field_range: volume.field_range(),
            voxels: VoxelBuffer::upload(device, volume.voxels(), volume.name())?,
            transposed: None,
            occupancies: [None, None, None],
            point_occupancies: Default::default(),
            table: None,
            footprint_set: None,
        })
    }

    pub fn forget_transfer(&mut self) {
        self.table = None;
    }

    /// The voxels as they were uploaded, x fastest.
    pub fn uploaded(&self) -> &VoxelBuffer {
        &self.voxels
    }

    /// The background as kernels see it, and what they take from every voxel.
    pub fn background(&self) -> (f32, f32) {
        ((self.background - self.offset) as f32, self.offset as f32)
    }

    /// The same for the Gaussian.
    pub fn gaussian_background(&self) -> f32 {
        self.table().gaussian_background
    }

    /// [`Self::layout`] as samples of a reach see it.
    pub fn layout_for(&self, axis: Axis, reach: PointReach) -> (&VoxelBuffer, VolumeView) {
        let (voxels, view) = self.layout(axis);
        match reach {
            PointReach::Near | PointReach::Leaning => (voxels, view),
            PointReach::Gaussian => (voxels, VolumeView { background: self.gaussian_background(), ..view }),
        }
    }

    /// Voxels in which u has unit stride, and where they lie. Layer axes y and z read the upload; x has its own layout.
    pub fn layout(&self, axis: Axis) -> (&VoxelBuffer, VolumeView) {
        let [x, y, z] = self.dims.map(|n| n as i64);
        let (stride, voxels) = match axis {
            Axis::X => ([1, y, y * z], self.transposed.as_ref().expect("prepare() made it")),
            Axis::Y => ([1, x * y, x], &self.voxels),
            Axis::Z => ([1, x, x * y], &self.voxels),
        };
        let (background, offset) = self.background();
        (voxels, VolumeView { stride, dims: self.local_dims(axis).map(|n| n as i32), background, offset, padding: 0 })
    }

    /// The occupancy of a layer axis.
    pub fn occupancy(&self, axis: Axis) -> &Occupancy {
        self.occupancies[axis.index()].as_ref().expect("prepare() made it")
    }

    /// The occupancy of a layer axis for samples at points.
    pub fn point_occupancy(&self, axis: Axis, reach: PointReach) -> &Occupancy {
        self.point_occupancies[occupancy_index(reach)][axis.index()].as_ref().expect("prepare_points() made it")
    }

    /// The visible blocks of a layer axis for samples at points.
    pub fn slabs_visible(&self, axis: Axis, reach: PointReach) -> &SlabsVisible {
        self.table().slabs_visible[reach as usize][axis.index()].as_ref().expect("prepare_points() made it")
    }

    /// The integrals of the transfer function.
    pub fn integrals(&self) -> &Integrals {
        self.table().integrals.as_ref().expect("prepare_points() made it")
    }

    /// The table of the transfer function.
    pub fn table(&self) -> &Table {
        self.table.as_ref().expect("prepare() made it")
    }

    /// One byte per block and layer of a layer axis.
    pub fn visible(&self, axis: Axis) -> &Buffer<u8> {
        self.table().visible[axis.index()].as_ref().expect("prepare() made it")
    }

    /// Makes what splatted layers need and do not have yet: layout, occupancy, table, visibility.
    pub fn prepare(
        &mut self,
        device: &Device,
        kernels: &Kernels,
        axes: &[Axis],
        transfer: &TransferFunction,
        extinction: Extinction,
    ) -> Result<(), Error> {
        self.prepare_table(device, transfer, extinction)?;
        for &axis in axes {
            self.prepare_layout(device, kernels, axis)?;
            let i = axis.index();
            if self.occupancies[i].is_none() {
                self.occupancies[i] = Some(self.find_occupancy(device, kernels, axis, Reach::SPLATS)?);
            }
            if self.table().visible[i].is_none() {
                let visibility = self.visibility(self.occupancy(axis));
                let visible = Buffer::new(device, visibility.occupancy.flags(), "the visibility of blocks")?;
                kernels.visibility(device)?.launch(device, &visibility, &visible)?;
                self.table.as_mut().expect("made above").visible[i] = Some(visible);
            }
        }
        Ok(())
    }

    /// The same for samples at points.
    pub fn prepare_points(
        &mut self,
        device: &Device,
        kernels: &Kernels,
        axes: &[Axis],
        transfer: &TransferFunction,
        extinction: Extinction,
        rays: PointRays,
    ) -> Result<(), Error> {
        self.prepare_table(device, transfer, extinction)?;
        for &axis in axes {
            self.prepare_layout(device, kernels, axis)?;
            let i = axis.index();
            let reach = rays.reach;
            if self.point_occupancies[occupancy_index(reach)][i].is_none() {
                let occupancy = self.find_occupancy(device, kernels, axis, reach.occupancy())?;
                self.point_occupancies[occupancy_index(reach)][i] = Some(occupancy);
            }
            if self.table().slabs_visible[reach as usize][i].is_none() {
                let visibility = self.visibility(self.point_occupancy(axis, reach));
                let bits = Buffer::new(device, visibility.occupancy.slab_bytes(), "the visibility of blocks")?;
                kernels.slab_visibility(device)?.launch(device, &visibility, reach.around(), reach.slack(), &bits)?;
                let visible = SlabsVisible::new(device, bits, visibility.occupancy)?;
                self.table.as_mut().expect("made above").slabs_visible[reach as usize][i] = Some(visible);
            }
        }
        let (field_range, offset) = (self.field_range, self.offset);
        let table = self.table.as_mut().expect("made above");
        if let Some(thinnest) = rays.thinnest
            && table.integrals.as_ref().is_none_or(|i| (i.thinnest, i.samples) != (thinnest, rays.samples))
        {
            table.integrals = Some(Integrals::upload(device, &table.on_host, field_range, offset, thinnest, rays.samples)?);
            table.slabs = None;
        }
        Ok(())
    }

    /// Makes the table of slicing for slabs of a thickness in unit distances. The integrals are there.
    pub fn prepare_slab_table(&mut self, device: &Device, kernels: &Kernels, thickness: f32) -> Result<(), Error> {
        let table = self.table.as_mut().expect("prepare_points() made it");
        if table.slabs.as_ref().is_none_or(|(made_for, _)| *made_for != thickness) {
            let integrals = table.integrals.as_ref().expect("prepare_points() made it");
            let slabs = Buffer::new(device, SLAB_VALUES * SLAB_VALUES, "the pre-integration table")?;
            let arguments = PreintegratedTableArguments {
                integrals: &integrals.nodes,
                unit: integrals.unit,
                thickness,
                linear: table.extinction == Extinction::Linear,
                size: SLAB_VALUES,
                table: &slabs,
            };
            kernels.preintegrated_table(device)?.launch(device, &arguments)?;
            table.slabs = Some((thickness, slabs));
        }
        Ok(())
    }

    /// Makes the list of splats for sheets along an axis.
    pub fn prepare_axis_splats(
        &mut self,
        device: &Device,
        kernels: &Kernels,
        axis: Axis,
        transfer: &TransferFunction,
        extinction: Extinction,
    ) -> Result<(), Error> {
        self.prepare_table(device, transfer, extinction)?;
        self.prepare_layout(device, kernels, axis)?;
        if self.table().axis_splats[axis.index()].is_none() {
            let list = SplatList::new(device, kernels, &self.splat_source(self.layout(axis)), Splatted::Visible)?;
            self.table.as_mut().expect("made above").axis_splats[axis.index()] = Some(list);
        }
        Ok(())
    }

    /// The same for sheets across the view.
    pub fn prepare_view_splats(
        &mut self,
        device: &Device,
        kernels: &Kernels,
        transfer: &TransferFunction,
        extinction: Extinction,
        splatted: Splatted,
    ) -> Result<(), Error> {
        self.prepare_table(device, transfer, extinction)?;
        if self.table().view_splats.as_ref().is_none_or(|(held, _)| *held != splatted) {
            let source = self.splat_source(self.layout_for(Axis::Z, PointReach::Gaussian));
            let list = SplatList::new(device, kernels, &source, splatted)?;
            self.table.as_mut().expect("made above").view_splats = Some((splatted, list));
        }
        Ok(())
    }

    fn splat_source<'a>(&'a self, (voxels, view): (&'a VoxelBuffer, VolumeView)) -> SplatSource<'a> {
        let table = self.table();
        SplatSource { voxels, view, table: table.scale, visible_before: &table.visible_before }
    }

    /// The splats of sheets along an axis.
    pub fn axis_splats(&self, axis: Axis) -> &SplatList {
        self.table().axis_splats[axis.index()].as_ref().expect("prepare_axis_splats() made it")
    }

    /// The splats of sheets across the view.
    pub fn view_splats(&self) -> &SplatList {
        &self.table().view_splats.as_ref().expect("prepare_view_splats() made it").1
    }

    fn prepare_table(&mut self, device: &Device, transfer: &TransferFunction, extinction: Extinction) -> Result<(), Error> {
        if self.table.as_ref().is_none_or(|t| t.extinction != extinction) {
            self.table = Some(Table::upload(device, transfer, self.field_range, self.offset, extinction)?);
        }
        Ok(())
    }

    fn prepare_layout(&mut self, device: &Device, kernels: &Kernels, axis: Axis) -> Result<(), Error> {
        if axis == Axis::X && self.transposed.is_none() {
            let layout =
                VoxelBuffer::new(device, self.dims.iter().product(), self.voxels.voxel_type(), "the layout of layer axis x")?;
            kernels.transpose(device)?.launch(device, &self.voxels, self.dims.map(|n| n as i32), &layout)?;
            self.transposed = Some(layout);
        }
        Ok(())
    }

    fn find_occupancy(&self, device: &Device, kernels: &Kernels, axis: Axis, reach: Reach) -> Result<Occupancy, Error> {
        let occupancy = Occupancy::new(device, self.local_dims(axis), self.voxels.voxel_type(), reach)?;
        let (voxels, view) = self.layout(axis);
        kernels.occupancy(device)?.launch(device, voxels, &view, reach, &occupancy)?;
        Ok(occupancy)
    }

    fn visibility<'a>(&'a self, occupancy: &'a Occupancy) -> Visibility<'a> {
        let (background, offset) = self.background();
        let table = self.table();
        Visibility { occupancy, background, offset, table: table.scale, visible_before: &table.visible_before }
    }

    /// The paper's footprint set, if it was made.
    pub fn footprint_set(&self) -> Option<&FootprintSet> {
        self.footprint_set.as_ref()
    }

    /// Makes the paper's footprint set, once.
    pub fn make_footprint_set(&mut self, device: &Device, kernels: &Kernels) -> Result<(), Error> {
        if self.footprint_set.is_none() {
            let shears: Vec<[f32; 2]> = (0..FOOTPRINT_SET_LEN).map(|i| set_direction(i).map(|s| s as f32)).collect();
            let shears = Buffer::from_slice(device, &shears, "the footprint set")?;
            let images = Buffer::new(device, FOOTPRINT_SET_LEN * FOOTPRINT_SET_SIZE * FOOTPRINT_SET_SIZE, "the footprint set")?;
            kernels.footprint_set(device)?.launch(device, &shears, &images)?;
            self.footprint_set = Some(FootprintSet { images, shears });
        }
        Ok(())
    }

    fn local_dims(&self, axis: Axis) -> [usize; 3] {
        let frame = axis.frame();
        [frame.u, frame.v, frame.a].map(|i| self.dims[i])
    }
}

/// Values in front and behind that the table of slicing has entries for.
pub(super) const SLAB_VALUES: usize = 256;

fn occupancy_index(reach: PointReach) -> usize {
    usize::from(reach == PointReach::Gaussian)
}

/// A view over the volume in its own axes, for kernels that take strides per axis.
pub(super) fn upload_strides(grid: &Grid) -> [i64; 4] {
    let [x, y, _] = grid.dims().map(|n| n as i64);
    [1, x, x * y, 0]
}
