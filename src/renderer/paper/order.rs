//! Sorting and tiling of splats.

use super::super::classification::{SplatList, Splatted, Table};
use super::super::frame::{Arena, Slot};
use super::super::tiles::Tiles;
use crate::device::launch::Launcher;
use crate::device::launch::paper::{SortedSplats, SortedSplatsArguments, TiledSplats, TiledSplatsArguments};
use crate::device::launch::structs::{SampleParams, Splat, SplatParams};
use crate::device::launch::surfaces::{Pass, Scan, ScanArguments};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::viewport::Viewport;
use std::sync::Arc;

/// Projects and sorts splats, and lists them per tile.
#[derive(Default)]
pub(super) struct SplatOrder {
    sorting: Launcher<SortedSplats>,
    tiling: Launcher<TiledSplats>,
    scan: Launcher<Scan>,
}

// The device counts splats first, so frames can declare only the size of `TOTAL`.
const TOTAL: Slot<u64> = Slot::new("the number of splats");
const SHEET_COUNTS: Slot<u32> = Slot::new("the splats per sheet");
const SORTED: Slot<Splat> = Slot::new("the sorted splats");
const TILE_ENDS: Slot<u32> = Slot::new("the splats per tile");
const LISTS: Slot<u32> = Slot::new("the lists of tiles");

/// Splats to sort.
pub(super) struct Unsorted<'a> {
    pub splats: &'a SplatList,
    pub splatted: Splatted,
    pub table: &'a Table,
    pub params: SplatParams,
    pub sample: SampleParams,
    pub viewport: Viewport,
}

/// Sorted splats, and the lists of splats per screen tile.
pub(super) struct Sorted {
    pub sorted: Arc<Buffer<Splat>>,
    /// Ends of the tile lists, per chunk.
    pub ends: Arc<Buffer<u32>>,
    pub lists: Arc<Buffer<u32>>,
}

impl SplatOrder {
    /// Sorts splats. Reads back the numbers of splats and of list entries to allocate their buffers.
    pub fn sort(&mut self, device: &Device, arena: &mut Arena, from: &Unsorted) -> Result<Sorted, Error> {
        let Unsorted { splats, params, .. } = *from;
        let chunks = device.tuning().splat_chunks;
        let [width, height] = [from.viewport.width, from.viewport.height].map(|n| n as i32);
        let buckets = match from.splatted {
            Splatted::Visible => 1,
            Splatted::InReach | Splatted::All => (params.sheets[1] - params.sheets[0] + 1) as usize,
        };
        let total = &arena.counted(device, &TOTAL, 1)?;
        let counts = &arena.counted(device, &SHEET_COUNTS, chunks * buckets)?;
        let sorted = arena.counted(device, &SORTED, splats.count)?;
        for pass in [Pass::Count, Pass::Fill] {
            let arguments = SortedSplatsArguments {
                places: &splats.places,
                contents: &splats.contents,
                count: splats.count as i32,
                p: params,
                table: &from.table.entries,
                sample: from.sample,
                width,
                height,
                chunks: chunks as i32,
                buckets: buckets as i32,
                fill: pass.fill(),
                counts,
                sorted: &sorted,
            };
            self.sorting.launch(device, from.splatted == Splatted::Visible, &arguments)?;
            if pass == Pass::Count {
                let scan = ScanArguments { counts, chunks: chunks as i32, buckets: buckets as i32, total };
                self.scan.launch(device, (), &scan)?;
            }
        }
        let count = total.read_count(device, "the list of splats")?;

        let tiles = Tiles::for_lists(from.viewport, device.tuning());
        let [tiles_u, tiles_v] = tiles.for_kernels();
        let tiles = tiles.count();
        let ends = arena.counted(device, &TILE_ENDS, chunks * tiles)?;
        let mut entries = 1;
        for pass in [Pass::Count, Pass::Fill] {
            let lists = &arena.counted(device, &LISTS, entries)?;
            let arguments = TiledSplatsArguments {
                sorted: &sorted,
                count: count as i32,
                p: params,
                width,
                height,
                tiles_u,
                tiles_v,
                chunks: chunks as i32,
                fill: pass.fill(),
                counts: &ends,
                lists,
            };
            self.tiling.launch(device, (), &arguments)?;
            if pass == Pass::Count {
                let scan = ScanArguments { counts: &ends, chunks: chunks as i32, buckets: tiles as i32, total };
                self.scan.launch(device, (), &scan)?;
                entries = total.read_count(device, "the lists of splats per tile")?;
            }
        }
        Ok(Sorted { sorted, ends, lists: arena.counted(device, &LISTS, entries)? })
    }
}
