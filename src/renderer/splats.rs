//! The order of splats in a frame.

use super::Renderer;
use super::kept::Kept;
use super::scratch::at_least;
use super::splat_list::{SplatList, Splatted, read_total};
use crate::device::launch::params::{SampleParams, ScreenParams, SplatParams};
use crate::device::launch::{Pass, SortedSplatsArguments, TiledSplatsArguments};
use crate::error::Error;
use crate::layers::{AxisFrame, SplatProjection};
use glam::DVec3;

/// The projection as kernels see it, in the axes of `frame`; without sheets.
pub(super) fn splat_params(projection: &SplatProjection, frame: AxisFrame, background: f32) -> SplatParams {
    let row = |coefficients: DVec3, constant: f64| frame.local(coefficients).extend(constant).as_vec4().to_array();
    let half_size = projection.half_size().as_vec2();
    SplatParams {
        to_screen: [0, 1, 2].map(|r| row(projection.to_screen.row(r), projection.offset[r])),
        along: row(projection.along, -projection.along.dot(projection.centre)),
        footprint: projection.footprint.map(|f| f as f32),
        half_size: half_size.to_array(),
        nearest: projection.nearest as f32,
        least_w: projection.least_w as f32,
        nearest_sheet: projection.nearest_sheet() as f32,
        sheet_distance: 1.0,
        sheets: [0; 2],
        backwards: 0,
        background,
    }
}

impl Renderer {
    /// Projects, sorts and lists splats per tile: in `scratch.sorted`, `scratch.tile_ends` and `scratch.lists`.
    pub(super) fn sort_splats(
        &mut self,
        list: impl Fn(&Kept) -> &SplatList,
        splatted: Splatted,
        params: SplatParams,
        sample: SampleParams,
        screen: &ScreenParams,
    ) -> Result<(), Error> {
        let Self { device, kernels, kept, scratch, .. } = self;
        let list = list(kept);
        let chunks = device.tuning().splat_chunks;
        let buckets = match splatted {
            Splatted::Visible => 1,
            Splatted::InReach | Splatted::All => (params.sheets[1] - params.sheets[0] + 1) as usize,
        };
        at_least(&mut scratch.total, device, 1, "the number of splats")?;
        at_least(&mut scratch.sheet_counts, device, chunks * buckets, "the splats per sheet")?;
        at_least(&mut scratch.sorted, device, list.count, "the sorted splats")?;
        let made = "made above";
        let total = scratch.total.as_ref().expect(made);
        let arguments = SortedSplatsArguments {
            places: &list.places,
            contents: &list.contents,
            count: list.count,
            params,
            table: &kept.table().entries,
            sample,
            size: screen.size,
            buckets,
            counts: scratch.sheet_counts.as_ref().expect(made),
            sorted: scratch.sorted.as_ref().expect(made),
        };
        let kernel = kernels.sorted_splats(device, splatted == Splatted::Visible)?;
        kernel.launch(device, Pass::Count, &arguments)?;
        kernels.scan(device)?.launch(device, arguments.counts, chunks, buckets, total)?;
        kernel.launch(device, Pass::Fill, &arguments)?;
        let count = read_total(device, total, "the list of splats")?;

        let tiles = screen.tiles[0] as usize * screen.tiles[1] as usize;
        at_least(&mut scratch.tile_ends, device, chunks * tiles, "the splats per tile")?;
        at_least(&mut scratch.lists, device, 1, "the lists of tiles")?;
        let kernel = kernels.tiled_splats(device)?;
        for pass in [Pass::Count, Pass::Fill] {
            let total = scratch.total.as_ref().expect(made);
            let arguments = TiledSplatsArguments {
                sorted: scratch.sorted.as_ref().expect(made),
                count,
                params,
                size: screen.size,
                tiles: screen.tiles,
                counts: scratch.tile_ends.as_ref().expect(made),
                lists: scratch.lists.as_ref().expect(made),
            };
            kernel.launch(device, pass, &arguments)?;
            if pass == Pass::Count {
                kernels.scan(device)?.launch(device, arguments.counts, chunks, tiles, total)?;
                let entries = read_total(device, total, "the lists of splats per tile")?;
                at_least(&mut scratch.lists, device, entries, "the lists of tiles")?;
            }
        }
        Ok(())
    }
}
