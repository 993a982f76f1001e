//! Launchers of splats.cl, scan.cl, sorted_splats.cl and tiled_splats.cl: which voxels are splatted, and in which order.

use super::params::{Float4, SampleParams, SplatParams, VolumeView};
use super::{VoxelBuffer, launch, screen_defines, voxel_defines};
use crate::device::{Buffer, Device, program::source};
use crate::error::Error;
use crate::volume::VoxelType;
use opencl3::kernel::Kernel;

/// A splat on the screen: `Splat` in kernels/splat.cl.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Splat([f32; 8]);

/// A voxel that is splatted: its place along u, v, a, and one number more.
pub(crate) type Place = [u16; 4];

/// Whether a kernel of this room only counts, or fills the places that the counts have become.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pass {
    Count,
    Fill,
}

impl Pass {
    fn fill(self) -> i32 {
        i32::from(self == Pass::Fill)
    }
}

/// Lists the voxels that are splatted.
pub(crate) struct SplatsKernel(Kernel);

/// What [`SplatsKernel`] reads and writes.
pub(crate) struct SplatsArguments<'a> {
    pub voxels: &'a VoxelBuffer,
    pub view: VolumeView,
    /// Voxels around a voxel that can make it count; 0: only itself.
    pub reach: i32,
    /// By how much sums of kernels overshoot.
    pub slack: f32,
    /// See [`super::Visibility::table`].
    pub table: (f32, f32, i32),
    pub visible_before: &'a Buffer<u32>,
    /// One per row of voxels.
    pub counts: &'a Buffer<u32>,
    pub places: &'a Buffer<Place>,
    pub contents: &'a Buffer<Float4>,
}

impl SplatsKernel {
    /// Farthest reach.
    pub const REACH: i32 = 3;

    pub fn new(device: &Device, voxel_type: VoxelType) -> Result<Self, Error> {
        let defines = voxel_defines(voxel_type, device.tuning().vector_width);
        Ok(Self(device.kernel(&source!("splats", "volume", "elementary", "opacity_range"), &defines)?))
    }

    pub fn launch(&self, device: &Device, pass: Pass, a: &SplatsArguments) -> Result<(), Error> {
        let rows = a.view.dims[1] as usize * a.view.dims[2] as usize;
        let (first, per_value, last) = a.table;
        launch(
            device,
            "splats",
            &self.0,
            rows,
            device.tuning().tile_group,
            &[
                a.voxels,
                &a.view,
                &a.reach,
                &a.slack,
                &first,
                &per_value,
                &last,
                a.visible_before,
                &pass.fill(),
                a.counts,
                a.places,
                a.contents,
            ],
        )
    }
}

/// Turns counts into places.
pub(crate) struct ScanKernel(Kernel);

impl ScanKernel {
    pub fn new(device: &Device) -> Result<Self, Error> {
        Ok(Self(device.kernel(&source!("scan"), "")?))
    }

    /// `counts` holds `buckets` numbers for each of `chunks`; the sum of all comes into `total`.
    pub fn launch(
        &self,
        device: &Device,
        counts: &Buffer<u32>,
        chunks: usize,
        buckets: usize,
        total: &Buffer<u64>,
    ) -> Result<(), Error> {
        launch(device, "sort", &self.0, 1, 1, &[counts, &(chunks as i32), &(buckets as i32), total])
    }
}

/// Projects splats and sorts them into the sheets where they begin.
pub(crate) struct SortedSplatsKernel(Kernel);

/// What [`SortedSplatsKernel`] reads and writes.
pub(crate) struct SortedSplatsArguments<'a> {
    pub places: &'a Buffer<Place>,
    pub contents: &'a Buffer<Float4>,
    pub count: usize,
    pub params: SplatParams,
    /// (r, g, b, τ) per value; read only by a kernel that classifies.
    pub table: &'a Buffer<Float4>,
    pub sample: SampleParams,
    /// Of the screen, in pixels.
    pub size: [i32; 2],
    pub buckets: usize,
    /// `buckets` per chunk.
    pub counts: &'a Buffer<u32>,
    pub sorted: &'a Buffer<Splat>,
}

impl SortedSplatsKernel {
    /// `preclassified`: for axis-aligned sheets, with colours and in one bucket.
    pub fn new(device: &Device, preclassified: bool) -> Result<Self, Error> {
        let defines = if preclassified { "-DVW=1 -DPRECLASSIFIED" } else { "-DVW=1" };
        Ok(Self(device.kernel(&source!("sorted_splats", "elementary", "shading", "splat"), defines)?))
    }

    pub fn launch(&self, device: &Device, pass: Pass, a: &SortedSplatsArguments) -> Result<(), Error> {
        let chunks = device.tuning().splat_chunks;
        launch(
            device,
            "sort",
            &self.0,
            chunks,
            device.tuning().tile_group,
            &[
                a.places,
                a.contents,
                &(a.count as i32),
                &a.params,
                a.table,
                &a.sample,
                &a.size[0],
                &a.size[1],
                &(chunks as i32),
                &(a.buckets as i32),
                &pass.fill(),
                a.counts,
                a.sorted,
            ],
        )
    }
}

/// Lists the splats of each tile of the screen.
pub(crate) struct TiledSplatsKernel(Kernel);

/// What [`TiledSplatsKernel`] reads and writes.
pub(crate) struct TiledSplatsArguments<'a> {
    pub sorted: &'a Buffer<Splat>,
    pub count: usize,
    pub params: SplatParams,
    /// Of the screen, in pixels.
    pub size: [i32; 2],
    pub tiles: [i32; 2],
    /// One per chunk and tile.
    pub counts: &'a Buffer<u32>,
    pub lists: &'a Buffer<u32>,
}

impl TiledSplatsKernel {
    pub fn new(device: &Device) -> Result<Self, Error> {
        let defines = format!("-DVW=1 -DTILE_COLUMNS={} {}", device.tuning().vector_width, screen_defines(device));
        Ok(Self(device.kernel(&source!("tiled_splats", "elementary", "splat"), &defines)?))
    }

    pub fn launch(&self, device: &Device, pass: Pass, a: &TiledSplatsArguments) -> Result<(), Error> {
        let chunks = device.tuning().splat_chunks;
        launch(
            device,
            "sort",
            &self.0,
            chunks,
            device.tuning().tile_group,
            &[
                a.sorted,
                &(a.count as i32),
                &a.params,
                &a.size[0],
                &a.size[1],
                &a.tiles[0],
                &a.tiles[1],
                &(chunks as i32),
                &pass.fill(),
                a.counts,
                a.lists,
            ],
        )
    }
}
