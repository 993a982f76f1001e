//! What frames find prepared on the device: the volume's layouts and min-max blocks, and what depends on the transfer function.
//! Everything is made when a frame first asks for it, and kept as long as memory allows.

mod blocks;
mod layouts;
mod splat_list;
mod tables;

pub(super) use layouts::{Layout, Placement};
pub(super) use splat_list::{SplatList, Splatted, read_total};
pub(super) use tables::{Integrals, SLAB_VALUES, SegmentNeeds, Table, integrals_bytes, table_bytes, table_entries};

use super::UploadedVolume;
use super::cache::{Cache, Kept, Key};
use crate::device::launch::layered::{FootprintSet, FootprintSetArguments};
use crate::device::launch::rays::PreintegratedTable;
use crate::device::launch::sheets::{Scan, Splats};
use crate::device::launch::volume::{
    FillMinMaxBlocks, PrefilterColumns, PrefilterRows, ShownChunks, ShownSlabs, SlabVisibility, Transpose,
};
use crate::device::launch::{Launcher, VoxelBuffer};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::layers::{Axis, FOOTPRINT_SET_LEN, FOOTPRINT_SET_SIZE, set_direction};
use crate::transfer::TransferFunction;
use crate::volume::{Grid, Held, Rescale, Stored};
use std::ops::Range;
use std::sync::Arc;

/// Bytes that may be kept besides those of the volume, twice (a second layout, and a list of splats), and the B-spline's coefficients, in
/// two layouts.
const BUDGET: usize = 256 << 20;

/// A volume on the device, or some layers of one, a transfer function, and what is made from both.
pub(super) struct Prepared {
    /// Of the whole volume, as all else but the voxels.
    grid: Grid,
    /// The lowest voxel that is held, and how many are.
    held_first: [usize; 3],
    held_dims: [usize; 3],
    stored: Stored,
    /// Whether some voxels are invalid, and count as background.
    holed: bool,
    rescale: Rescale,
    voxels: Arc<VoxelBuffer>,
    placed: Placement,
    /// The range is what somebody said, not what the voxels have.
    promised: bool,
    /// As it was given.
    given_transfer: TransferFunction,
    /// Of stored numbers, as all that follows takes it.
    transfer: TransferFunction,
    /// Changes with the transfer function.
    revision: u64,
    cache: Cache,
    launchers: Launchers,
    /// In a rehearsal, in place of what the transfer function needs.
    segment_needs: Option<SegmentNeeds>,
}

#[derive(Default)]
struct Launchers {
    transpose: Launcher<Transpose>,
    prefilter_rows: Launcher<PrefilterRows>,
    prefilter_columns: Launcher<PrefilterColumns>,
    min_max_blocks: Launcher<FillMinMaxBlocks>,
    slab_visibility: Launcher<SlabVisibility>,
    shown_chunks: Launcher<ShownChunks>,
    shown_slabs: Launcher<ShownSlabs>,
    footprint_set: Launcher<FootprintSet>,
    slicing_table: Launcher<PreintegratedTable>,
    splats: Launcher<Splats>,
    scan: Launcher<Scan>,
}

/// The paper's footprint images.
pub(super) struct FootprintImages {
    pub images: Buffer<u8>,
    pub shears: Buffer<[f32; 2]>,
}

impl Kept for VoxelBuffer {
    fn bytes(&self) -> usize {
        VoxelBuffer::bytes(self)
    }
}

impl<T: Send + Sync + Copy + 'static> Kept for Buffer<T> {
    fn bytes(&self) -> usize {
        Buffer::bytes(self)
    }
}

#[derive(PartialEq)]
struct FootprintImagesKey;

impl Key for FootprintImagesKey {
    type Value = FootprintImages;
    const OF_VOXELS: bool = false;
}

impl Kept for FootprintImages {
    fn bytes(&self) -> usize {
        self.images.bytes() + self.shears.bytes()
    }
}

impl Prepared {
    /// `grid` is that of the whole volume, in the world of frames.
    pub fn new(volume: &UploadedVolume, grid: Grid, transfer: &TransferFunction) -> Self {
        let UploadedVolume { description, voxels, first, dims, placed, promised, .. } = volume;
        let rescale = description.rescale();
        Self {
            grid,
            held_first: *first,
            held_dims: *dims,
            stored: description.stored(),
            holed: description.has_invalid_voxels(),
            rescale,
            cache: Cache::new(BUDGET + 2 * voxels.bytes() + 2 * size_of::<f32>() * dims.iter().product::<usize>()),
            voxels: voxels.clone(),
            placed: *placed,
            promised: *promised,
            given_transfer: transfer.clone(),
            transfer: transfer.of_stored(rescale),
            revision: 0,
            launchers: Launchers::default(),
            segment_needs: None,
        }
    }

    /// The same with nothing prepared yet, for frames that are not drawn; with what segments are said to need.
    pub fn for_rehearsal(&self, needs: Option<SegmentNeeds>) -> Self {
        Self {
            segment_needs: needs,
            grid: self.grid.clone(),
            voxels: self.voxels.clone(),
            given_transfer: self.given_transfer.clone(),
            transfer: self.transfer.clone(),
            cache: Cache::new(self.cache.budget()),
            launchers: Launchers::default(),
            ..*self
        }
    }

    /// Holds other voxels of the same volume, as many as there is room for, and forgets what was made from those before.
    pub fn hold(&mut self, device: &Device, held: &Held) -> Result<(), Error> {
        self.cache.forget_voxels();
        let voxels = Arc::get_mut(&mut self.voxels).expect("voxels that are replaced are nobody else's");
        voxels.refill(device, held)?;
        (self.held_first, self.held_dims) = (held.first, held.dims());
        self.placed = Placement::dense(self.held_dims);
        Ok(())
    }

    pub fn set_transfer_function(&mut self, transfer: &TransferFunction) {
        if self.given_transfer != *transfer {
            self.transfer = transfer.of_stored(self.rescale);
            self.given_transfer = transfer.clone();
            self.revision += 1;
            // No later one has this revision again.
            self.cache.forget_transfer();
        }
    }

    /// All is made again when it is next needed.
    pub fn forget(&mut self) {
        self.cache.forget();
    }

    /// The voxels have changed: what is made of them is made again when it is next needed, in the same buffers.
    pub fn voxels_changed(&mut self) {
        self.cache.voxels_changed();
    }

    /// As it was given.
    pub fn transfer_function(&self) -> &TransferFunction {
        &self.given_transfer
    }

    /// A value as the number that kernels see, less the offset.
    pub fn stored_value(&self, value: f64) -> f64 {
        self.rescale.stored(value) - self.offset()
    }

    /// Whether larger values are smaller numbers.
    pub fn reverses_values(&self) -> bool {
        self.rescale.slope() < 0.0
    }

    /// Taken from every voxel by the kernels, so that float sums are as fine as the data's own range.
    fn offset(&self) -> f64 {
        self.stored.range.0
    }

    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Smallest and largest number of a voxel.
    pub fn stored_range(&self) -> (f64, f64) {
        self.stored.range
    }

    /// Whether the background itself has opacity.
    pub fn background_visible(&self) -> bool {
        self.transfer.opacity(self.stored.background) > 0.0
    }

    /// The background as kernels see it, and what they take from every voxel.
    pub fn background(&self) -> (f32, f32) {
        ((self.stored.background - self.offset()) as f32, self.offset() as f32)
    }

    /// The paper's footprint set.
    pub fn footprint_images(&mut self, device: &Device) -> Result<Arc<FootprintImages>, Error> {
        if let Some(kept) = self.cache.get(&FootprintImagesKey) {
            return Ok(kept);
        }
        let shears: Vec<[f32; 2]> = (0..FOOTPRINT_SET_LEN).map(|i| set_direction(i).map(|s| s as f32)).collect();
        let shears = Buffer::from_slice(device, &shears, "the footprint set")?;
        let count = FOOTPRINT_SET_LEN * FOOTPRINT_SET_SIZE * FOOTPRINT_SET_SIZE;
        let images = Buffer::new(device, count, "the footprint set")?;
        let arguments = FootprintSetArguments { shears: &shears, count: count as i32, images: &images };
        self.launchers.footprint_set.launch(device, (), &arguments)?;
        Ok(self.cache.keep(FootprintImagesKey, FootprintImages { images, shears }))
    }

    /// The layers of an axis that are held.
    pub fn held_layers(&self, axis: Axis) -> Range<usize> {
        let a = axis.frame().a;
        self.held_first[a]..self.held_first[a] + self.held_dims[a]
    }

    /// Whether layers of an axis are held as a whole.
    pub fn holds_whole_layers(&self, axis: Axis) -> bool {
        let frame = axis.frame();
        [frame.u, frame.v].iter().all(|&i| self.held_dims[i] == self.grid.dims()[i])
    }

    /// Voxels along u, v, a that are held.
    fn held_local(&self, axis: Axis) -> [usize; 3] {
        local(axis, self.held_dims)
    }
}

/// Numbers along u, v, a.
fn local(axis: Axis, dims: [usize; 3]) -> [usize; 3] {
    let frame = axis.frame();
    [frame.u, frame.v, frame.a].map(|i| dims[i])
}

#[cfg(test)]
mod tests {
    use super::super::{Renderer, View};
    use super::*;
    use crate::camera::{Camera, Orbit};
    use crate::device::DeviceChoice;
    use crate::layers::Kernel;
    use crate::settings::{Algorithm, Quality, Settings};
    use crate::viewport::Viewport;
    use crate::volume::{OpenOptions, Volume};
    use glam::DVec3;

    /// And two views, of different layer axes.
    fn renderer() -> (Renderer, [Camera; 2], Viewport) {
        let device = Device::open(&DeviceChoice::Default).expect("the tests need an OpenCL device: scripts/test installs PoCL");
        let volume = Volume::open("builtin:hydrogen@24", &OpenOptions::default()).unwrap();
        let transfer = TransferFunction::builtin("fire", &volume).unwrap();
        let viewport = Viewport::new(40, 32).unwrap();
        let camera = |azimuth| {
            let orbit = Orbit { azimuth, elevation: 10.0, roll: 0.0 };
            Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, orbit)
        };
        (Renderer::new(&device, &volume, &transfer).unwrap(), [20.0, 80.0].map(camera), viewport)
    }

    /// Dragging in `draft` and letting go in `high`, lit and unlit, from several sides, again and again.
    #[test]
    fn what_was_made_once_is_not_made_again() {
        let (mut renderer, cameras, viewport) = renderer();
        let unlit = |settings: Settings| Settings { shading: None, ..settings };
        let drag = |renderer: &mut Renderer| {
            for settings in [Quality::Draft.settings(), Quality::High.settings(), unlit(Quality::Draft.settings())] {
                for camera in cameras {
                    renderer.render(&camera, viewport, &settings).unwrap();
                }
            }
        };
        drag(&mut renderer);
        let made = renderer.prepared.cache.made;
        assert!(made > 4, "tables, integrals and blocks are made");
        (0..3).for_each(|_| drag(&mut renderer));
        assert_eq!(renderer.prepared.cache.made, made);
        renderer.set_transfer_function(&renderer.transfer_function().clone());
        drag(&mut renderer);
        assert_eq!(renderer.prepared.cache.made, made, "the same transfer function again is no other");
    }

    /// Layers so far apart that the distance from one to another in bytes is more than an int counts: rays gather the same voxels there.
    #[test]
    fn voxels_far_apart() {
        /// Rows that a layer would have; 6 layers of it are 2.3 GB, which are never touched but for the few rows that there are.
        const ROWS: usize = 42_000_000;
        const DIMS: [usize; 3] = [9, 8, 6];
        let device = Device::open(&DeviceChoice::Default).expect("the tests need an OpenCL device: scripts/test installs PoCL");
        let bytes: Vec<u8> = (0..DIMS.iter().product()).map(|n: usize| (n * 37 % 251) as u8).collect();
        let grid = Grid::new(DIMS, DVec3::ONE).unwrap();
        let volume = Volume::new("far", grid, bytes.as_slice()).unwrap();
        let transfer = TransferFunction::builtin("fire", &volume).unwrap();
        let viewport = Viewport::new(24, 20).unwrap();
        // Across the layers, so that the rays of a vector are in several.
        let orbit = Orbit { azimuth: 85.0, elevation: 8.0, roll: 70.0 };
        let camera = Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, orbit);
        let mut renderer = Renderer::new(&device, &volume, &transfer).unwrap();
        let raycast = |kernel| Algorithm::Raycast { kernel, step: 0.3 };
        let algorithms = [Algorithm::Slicing { step: 0.5 }, raycast(Kernel::Cubic)];
        let frames = |renderer: &mut Renderer| {
            algorithms.map(|algorithm| renderer.render(&camera, viewport, &algorithm.into()).unwrap().0)
        };
        let near = frames(&mut renderer);
        assert!(near.iter().all(|frame| frame.pixels().iter().any(|p| p[3] > 0.1)));
        let layer = DIMS[0] * DIMS[1];
        match VoxelBuffer::with_gaps(&device, bytes.chunks(layer), DIMS[0] * ROWS) {
            Ok(voxels) => renderer.prepared.voxels = Arc::new(voxels),
            Err(e) => return eprintln!("SKIPPED: this device has no room for voxels far apart: {e}"),
        }
        assert!(renderer.prepared.voxels.kind().far);
        // Layers of so many rows lie where those of the buffer do; min-max blocks are kept from before.
        renderer.prepared.placed = Placement::dense([DIMS[0], ROWS, DIMS[2]]);
        assert!(frames(&mut renderer) == near, "voxels far apart are other ones");
    }

    /// A frame that was started and never came to its report.
    #[test]
    fn a_failed_frame_leaves_nothing_to_the_next() {
        let (mut renderer, [camera, _], viewport) = renderer();
        renderer.measure(true);
        let settings = Settings::default();
        renderer.render(&camera, viewport, &settings).unwrap();
        let stages = |renderer: &mut Renderer| -> Vec<&str> {
            let measured = renderer.render(&camera, viewport, &settings).unwrap().1.measured.unwrap();
            measured.stages.into_iter().map(|(stage, _)| stage).collect()
        };
        let alone = stages(&mut renderer);
        let cast = Algorithm::Slicing { step: 0.5 }.into();
        let device = renderer.frame_device().unwrap();
        let (rays, cast) = renderer.seen(&camera, viewport, &cast).unwrap();
        let plan = super::super::Plan::new(&rays, viewport, renderer.prepared.grid(), &cast).unwrap();
        renderer.draw(View { device: &device, rays: &rays, viewport, settings: &cast }, &plan).unwrap();
        assert_eq!(stages(&mut renderer), alone);
        assert_ne!(device.stage_times().unwrap().first().map(|(stage, _)| *stage), None, "the failed one was timed itself");
    }
}
