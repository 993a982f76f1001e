//! The order of splats in a frame.

use super::super::prepared::{SplatList, Splatted, Table, read_total};
use super::super::scratch::Growing;
use super::super::tiles::Tiles;
use crate::device::launch::Launcher;
use crate::device::launch::sheets::{
    Pass, Scan, ScanArguments, SortedSplats, SortedSplatsArguments, TiledSplats, TiledSplatsArguments,
};
use crate::device::launch::structs::{SampleParams, Splat, SplatParams};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::viewport::Viewport;

/// Projects, sorts and lists splats per tile.
#[derive(Default)]
pub(super) struct SplatOrder {
    sorting: Launcher<SortedSplats>,
    tiling: Launcher<TiledSplats>,
    scan: Launcher<Scan>,
    total: Growing<u64>,
    sheet_counts: Growing<u32>,
    sorted: Growing<Splat>,
    tile_ends: Growing<u32>,
    lists: Growing<u32>,
}

/// Splats to be sorted.
pub(super) struct Unsorted<'a> {
    pub splats: &'a SplatList,
    pub splatted: Splatted,
    pub table: &'a Table,
    pub params: SplatParams,
    pub sample: SampleParams,
    pub viewport: Viewport,
}

/// Splats in their order, and the lists of each tile of the screen.
pub(super) struct Sorted<'a> {
    pub sorted: &'a Buffer<Splat>,
    /// Where the lists of tiles end, per chunk.
    pub ends: &'a Buffer<u32>,
    pub lists: &'a Buffer<u32>,
}

impl SplatOrder {
    /// Reads back how many splats and entries of lists there are, to make room for them.
    pub fn sort(&mut self, device: &Device, from: &Unsorted) -> Result<Sorted<'_>, Error> {
        let Unsorted { splats, params, .. } = *from;
        let chunks = device.tuning().splat_chunks;
        let [width, height] = [from.viewport.width, from.viewport.height].map(|n| n as i32);
        let buckets = match from.splatted {
            Splatted::Visible => 1,
            Splatted::InReach | Splatted::All => (params.sheets[1] - params.sheets[0] + 1) as usize,
        };
        let total = self.total.at_least(device, 1, "the number of splats")?;
        let counts = self.sheet_counts.at_least(device, chunks * buckets, "the splats per sheet")?;
        let sorted = self.sorted.at_least(device, splats.count, "the sorted splats")?;
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
                sorted,
            };
            self.sorting.launch(device, from.splatted == Splatted::Visible, &arguments)?;
            if pass == Pass::Count {
                let scan = ScanArguments { counts, chunks: chunks as i32, buckets: buckets as i32, total };
                self.scan.launch(device, (), &scan)?;
            }
        }
        let count = read_total(device, total, "the list of splats")?;

        let tiles = Tiles::of_lists(from.viewport, device.tuning());
        let [tiles_u, tiles_v] = tiles.for_kernels();
        let tiles = tiles.all_counts();
        let ends = self.tile_ends.at_least(device, chunks * tiles, "the splats per tile")?;
        for pass in [Pass::Count, Pass::Fill] {
            let lists = self.lists.at_least(device, 1, "the lists of tiles")?;
            let arguments = TiledSplatsArguments {
                sorted,
                count: count as i32,
                p: params,
                width,
                height,
                tiles_u,
                tiles_v,
                chunks: chunks as i32,
                fill: pass.fill(),
                counts: ends,
                lists,
            };
            self.tiling.launch(device, (), &arguments)?;
            if pass == Pass::Count {
                let scan = ScanArguments { counts: ends, chunks: chunks as i32, buckets: tiles as i32, total };
                self.scan.launch(device, (), &scan)?;
                let entries = read_total(device, total, "the lists of splats per tile")?;
                self.lists.at_least(device, entries, "the lists of tiles")?;
            }
        }
        Ok(Sorted { sorted, ends, lists: self.lists.at_least(device, 1, "the lists of tiles")? })
    }
}
