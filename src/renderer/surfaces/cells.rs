//! The cells of surfaces, by the tiles of the screen that they can cover.

use super::super::frame::{Arena, Resources, Slot};
use super::uploaded::{SurfaceSizes, UploadedSurfaces};
use crate::device::launch::Launcher;
use crate::device::launch::structs::{Float4, SurfaceSet, SurfaceView};
use crate::device::launch::surfaces::{
    Bins, BinsArguments, CountFragments, CountFragmentsArguments, Pass, PlacePoints, PlacePointsArguments, SURFACE_TILE, Scan,
    ScanArguments, SortCells, SortCellsArguments, surface_blocks,
};
use crate::device::{Buffer, Device, Tuning};
use crate::error::Error;
use crate::viewport::Viewport;
use std::sync::{Arc, Weak};

pub(super) const POINTS: Slot<Float4> = Slot::new("the placed points of surfaces");
pub(super) const ROUNDED: Slot<[i32; 2]> = Slot::new("the points of surfaces on the screen");
pub(super) const BOUNDS: Slot<[u16; 4]> = Slot::new("the pixels of cells");
pub(super) const COUNTS: Slot<u32> = Slot::new("the cells per tile");
const TOTAL: Slot<u64> = Slot::new("the number of cells in tiles");
/// Its size is known after the device has counted.
pub(super) const LISTS: Slot<u32> = Slot::new("the cells of tiles");
const MOST: Slot<u32> = Slot::new("the numbers of fragments of tiles");

/// Entries of lists that are declared, for each cell and for each tile. Cells are in as many tiles as they cover: usually one or two.
const ENTRIES_PER_CELL: usize = 3;
const ENTRIES_PER_TILE: usize = 16;

/// Declares the buffers of [`FoundCells`].
pub(super) fn declare_cells(sizes: SurfaceSizes, viewport: Viewport, tuning: &Tuning, resources: &mut Resources) {
    let tiles: usize = [viewport.width, viewport.height].map(|n| n.div_ceil(SURFACE_TILE) as usize).iter().product();
    resources.host(&POINTS, sizes.points);
    resources.host(&ROUNDED, sizes.points);
    resources.host(&BOUNDS, sizes.cells);
    resources.host(&COUNTS, tuning.splat_chunks * tiles);
    resources.host(&TOTAL, 1);
    resources.host(&LISTS, (sizes.cells * tiles).min(ENTRIES_PER_CELL * sizes.cells + ENTRIES_PER_TILE * tiles));
}

/// Lists the cells of each tile. Frames of the same view share the lists.
#[derive(Default)]
pub(super) struct CellLists {
    place: Launcher<PlacePoints>,
    bins: Launcher<Bins>,
    scan: Launcher<Scan>,
    count: Launcher<CountFragments>,
    sort: Launcher<SortCells>,
    /// For enqueued frames: their own commands may wait for the caller's events.
    own_queue: Option<Device>,
    found: Option<Arc<FoundCells>>,
    sorted: Option<SortedCells>,
}

/// Depths of the cells of tiles, which are in their order.
struct SortedCells {
    cells: Weak<FoundCells>,
    nearest: Buffer<f32>,
    farthest: Buffer<f32>,
}

/// The cells of tiles in a view.
pub(super) struct FoundCells {
    surfaces: Weak<UploadedSurfaces>,
    pub view: SurfaceView,
    placed: Vec<SurfaceSet>,
    pub sets: Buffer<SurfaceSet>,
    /// Not in the arena of frames, so that those of a later view can be listed while a frame that has been enqueued waits.
    pub buffers: Arena,
    /// A bound on the translucent fragments of a ray, if they have been counted.
    pub most_translucent: Option<usize>,
}

impl FoundCells {
    /// Whether they are those of surfaces in a view.
    fn are_of(&self, surfaces: &Arc<UploadedSurfaces>, view: &SurfaceView, placed: &[SurfaceSet]) -> bool {
        std::ptr::eq(self.surfaces.as_ptr(), Arc::as_ptr(surfaces)) && self.view == *view && self.placed == placed
    }
}

impl CellLists {
    /// The cells of surfaces in a view, for a frame that may read their numbers back.
    pub fn found(
        &mut self,
        device: &Device,
        surfaces: &Arc<UploadedSurfaces>,
        view: SurfaceView,
        placed: Vec<SurfaceSet>,
    ) -> Result<Arc<FoundCells>, Error> {
        if let Some(found) = self.found.as_ref().filter(|found| found.are_of(surfaces, &view, &placed)) {
            return Ok(found.clone());
        }
        self.sorted = None;
        // Frames that read the buffers come before this one.
        let buffers = self.found.take().and_then(Arc::into_inner).map(|found| found.buffers).unwrap_or_default();
        let found = Arc::new(self.find(device, surfaces, (view, placed), buffers)?);
        self.found = Some(found.clone());
        Ok(found)
    }

    /// The same for an enqueued frame, with a bound on the fragments of rays. New ones are found at once, while earlier frames may still wait for
    /// events of the caller.
    pub fn counted(
        &mut self,
        device: &Device,
        surfaces: &Arc<UploadedSurfaces>,
        view: SurfaceView,
        placed: Vec<SurfaceSet>,
    ) -> Result<Arc<FoundCells>, Error> {
        let is_counted = |found: &&Arc<FoundCells>| found.are_of(surfaces, &view, &placed) && found.most_translucent.is_some();
        if let Some(found) = self.found.as_ref().filter(is_counted) {
            return Ok(found.clone());
        }
        self.clear();
        let queue = match &self.own_queue {
            Some(queue) => queue.clone(),
            None => self.own_queue.insert(device.with_own_queue()?).clone(),
        };
        queue.begin(&[])?;
        let mut found = self.find(&queue, surfaces, (view, placed), Arena::default())?;
        found.most_translucent = Some(self.count_fragments(&queue, surfaces, &mut found)?);
        let found = Arc::new(found);
        self.found = Some(found.clone());
        Ok(found)
    }

    /// Drops the lists.
    pub fn clear(&mut self) {
        (self.found, self.sorted) = (None, None);
    }

    /// Sorts the cells of tiles by depth; the nearest crossings of cells, and the farthest ones up to them. `None` if there is no memory for
    /// these.
    pub fn sorted(
        &mut self,
        device: &Device,
        surfaces: &UploadedSurfaces,
        found: &Arc<FoundCells>,
    ) -> Result<Option<[&Buffer<f32>; 2]>, Error> {
        let cells = Arc::downgrade(found);
        if self.sorted.as_ref().is_none_or(|sorted| !sorted.cells.ptr_eq(&cells)) {
            self.sorted = None;
            let lists = found.buffers.get(&LISTS);
            let depths = || Buffer::new(device, lists.len(), "the depths of cells");
            let (nearest, farthest) = match depths().and_then(|nearest| Ok((nearest, depths()?))) {
                Err(error) if error.is_lack_of_device_memory() => return Ok(None),
                both => both?,
            };
            let arguments = SortCellsArguments {
                points: &found.buffers.get(&POINTS),
                cells: &surfaces.cells,
                sets: &found.sets,
                rounded: &found.buffers.get(&ROUNDED),
                bounds: &found.buffers.get(&BOUNDS),
                ends: &found.buffers.get(&COUNTS),
                lists: &lists,
                chunks: device.tuning().splat_chunks as i32,
                view: found.view,
                nearest: &nearest,
                farthest: &farthest,
            };
            self.sort.launch(device, (), &arguments)?;
            self.sorted = Some(SortedCells { cells, nearest, farthest });
        }
        Ok(self.sorted.as_ref().map(|sorted| [&sorted.nearest, &sorted.farthest]))
    }

    /// Lists the cells of each tile. Reads their number back, to allocate the lists.
    fn find(
        &mut self,
        device: &Device,
        surfaces: &Arc<UploadedSurfaces>,
        (view, placed): (SurfaceView, Vec<SurfaceSet>),
        mut buffers: Arena,
    ) -> Result<FoundCells, Error> {
        let sets = Buffer::from_slice(device, &placed, "the sets of surfaces")?;
        let chunks = device.tuning().splat_chunks;
        let tiles = view.tiles[0] * view.tiles[1];
        let sizes = surfaces.sizes();
        let points = buffers.counted(device, &POINTS, sizes.points)?;
        let rounded = buffers.counted(device, &ROUNDED, sizes.points)?;
        let bounds = buffers.counted(device, &BOUNDS, sizes.cells)?;
        let counts = buffers.counted(device, &COUNTS, chunks * tiles as usize)?;
        let total = buffers.counted(device, &TOTAL, 1)?;
        for (n, range) in surfaces.ranges().enumerate() {
            let arguments = PlacePointsArguments {
                own: &surfaces.own,
                sets: &sets,
                set: n as i32,
                first: range.start as i32,
                count: range.len() as i32,
                view,
                points: &points,
                rounded: &rounded,
            };
            self.place.launch(device, (), &arguments)?;
        }
        let chunks = chunks as i32;
        let mut entries = 1;
        for pass in [Pass::Count, Pass::Fill] {
            let arguments = BinsArguments {
                points: &points,
                rounded: &rounded,
                cells: &surfaces.cells,
                count: sizes.cells as i32,
                view,
                chunks,
                fill: pass.fill(),
                bounds: &bounds,
                counts: &counts,
                lists: &*buffers.counted(device, &LISTS, entries)?,
            };
            self.bins.launch(device, (), &arguments)?;
            if pass == Pass::Count {
                self.scan.launch(device, (), &ScanArguments { counts: &counts, chunks, buckets: tiles, total: &total })?;
                entries = total.read_count(device, "the cells of tiles")?;
            }
        }
        Ok(FoundCells { surfaces: Arc::downgrade(surfaces), view, placed, sets, buffers, most_translucent: None })
    }

    /// A bound on the translucent fragments of a ray.
    fn count_fragments(&mut self, device: &Device, surfaces: &UploadedSurfaces, found: &mut FoundCells) -> Result<usize, Error> {
        let blocks = surface_blocks(&found.view, device.tuning());
        let most = found.buffers.counted(device, &MOST, blocks)?;
        let buffers = &found.buffers;
        let arguments = CountFragmentsArguments {
            points: &buffers.get(&POINTS),
            cells: &surfaces.cells,
            sets: &found.sets,
            rounded: &buffers.get(&ROUNDED),
            bounds: &buffers.get(&BOUNDS),
            ends: &buffers.get(&COUNTS),
            lists: &buffers.get(&LISTS),
            chunks: device.tuning().splat_chunks as i32,
            view: found.view,
            most: &most,
        };
        self.count.launch(device, (), &arguments)?;
        let mut numbers = vec![0; blocks];
        most.read(device, &mut numbers)?;
        Ok(numbers.into_iter().max().unwrap_or(0) as usize)
    }
}
