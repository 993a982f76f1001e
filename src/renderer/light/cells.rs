//! Grids of cubic cells in which light is scattered.

use crate::device::launch::structs::ScatterGrid;
use crate::layers::AxisFrame;
use crate::settings::LightGrid;
use crate::volume::Grid;
use glam::DVec3;

/// Edges of the cells of both grids, in smallest spacings.
const EDGES: [f64; 2] = [2.0, 4.0];
/// Cells of the finer grid of a volume of few voxels may be that many. Otherwise they are at most a quarter of the voxels: cubes in flat voxels
/// multiply.
const ALWAYS_ALLOWED: f64 = 65_536.0;

/// The blocks of voxels from which cells are made, and the finer and the coarser grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::renderer) struct ScatterGrids {
    /// Voxels per block along x, y, z.
    pub per_block: [usize; 3],
    /// Blocks along x, y, z.
    pub blocks: [usize; 3],
    pub fine: CellGrid,
    pub coarse: CellGrid,
}

/// A grid of cubic cells from the lower corner of a volume on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::renderer) struct CellGrid {
    /// Cells along x, y, z.
    pub dims: [usize; 3],
    /// In world units.
    pub edge: f64,
    /// Blocks of voxels that a cell covers along x, y, z.
    pub per_cell: DVec3,
    /// Cells per voxel along x, y, z.
    scale: DVec3,
}

impl ScatterGrids {
    /// The cells of a volume, and blocks of voxels for those of the finest grid that light of this resolution has.
    pub fn new(grid: &Grid, resolution: LightGrid) -> Self {
        let (dims, spacing) = (grid.dims(), grid.spacing());
        let smallest = spacing.min_element();
        let extent = DVec3::from_array(dims.map(|n| n as f64)) * spacing;
        let most = ALWAYS_ALLOWED.max(grid.voxel_count() as f64 / 4.0);
        let cells = (extent / (EDGES[0] * smallest)).max(DVec3::ONE).element_product();
        let larger = (cells / most).cbrt().max(1.0) * smallest;
        let [fine, coarse] = EDGES.map(|edge| edge * larger);
        let finest = if resolution == LightGrid::Quarter { coarse } else { fine };
        let per_block = [0, 1, 2].map(|i| ((finest / spacing[i]).round() as usize).clamp(1, dims[i]));
        let blocks = [0, 1, 2].map(|i| dims[i].div_ceil(per_block[i]));
        let block = DVec3::from_array(per_block.map(|n| n as f64)) * spacing;
        let grid = |edge: f64| CellGrid {
            dims: [0, 1, 2].map(|i| ((extent[i] / edge - 1e-6).ceil() as usize).max(1)),
            edge,
            per_cell: edge / block,
            scale: spacing / edge,
        };
        Self { per_block, blocks, fine: grid(fine), coarse: grid(coarse) }
    }
}

impl CellGrid {
    pub fn cells(&self) -> usize {
        self.dims.iter().product()
    }

    /// Kernel argument.
    pub fn params(&self) -> ScatterGrid {
        let [x, y, z] = self.dims.map(|n| n as i32);
        ScatterGrid { x, y, z }
    }

    /// Cells per voxel.
    pub fn scale(&self) -> DVec3 {
        self.scale
    }

    /// Position of voxel 0 in cells; the middle of the first one is at 0.
    pub fn origin(&self) -> DVec3 {
        0.5 * self.scale - 0.5
    }

    /// Largest position of a look-up.
    pub fn last(&self) -> DVec3 {
        DVec3::from_array(self.dims.map(|n| (n as f64 - 1.001).max(0.0)))
    }

    /// Distance of neighbouring cells along u, v and a.
    pub fn strides(&self, frame: AxisFrame) -> [i32; 3] {
        let [x, y, _] = self.dims;
        let strides = [1, x, x * y].map(|stride| stride as i32);
        [frame.u, frame.v, frame.a].map(|i| strides[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn cells_are_cubes_that_cover_the_volume() {
        let even = ScatterGrids::new(&Grid::new([65, 64, 3], DVec3::ONE).unwrap(), LightGrid::Full);
        assert_eq!(
            (even.per_block, even.blocks, even.fine.dims, even.coarse.dims),
            ([2, 2, 2], [33, 32, 2], [33, 32, 2], [17, 16, 1])
        );
        assert_eq!((even.fine.per_cell, even.coarse.per_cell), (DVec3::ONE, DVec3::splat(2.0)));
        assert_eq!(even.fine.origin(), DVec3::splat(-0.25));
        let coarse = ScatterGrids::new(&Grid::new([65, 64, 3], DVec3::ONE).unwrap(), LightGrid::Quarter);
        assert_eq!((coarse.per_block, coarse.blocks), ([4, 4, 3], [17, 16, 1]));
        assert_eq!((coarse.coarse.dims, coarse.coarse.per_cell.truncate()), (even.coarse.dims, DVec2::ONE));
        let thick = ScatterGrids::new(&Grid::new([40, 40, 10], DVec3::new(1.0, 1.0, 5.0)).unwrap(), LightGrid::Half);
        assert_eq!((thick.per_block, thick.fine.dims), ([2, 2, 1], [20, 20, 25]));
        assert!((thick.fine.per_cell - DVec3::new(1.0, 1.0, 0.4)).length() < 1e-12);
        for dims in [[300, 300, 200], [1, 1, 1], [2000, 1, 1]] {
            let grid = Grid::new(dims, DVec3::new(1.0, 1.3, 20.0)).unwrap();
            let grids = ScatterGrids::new(&grid, LightGrid::Full);
            assert!(grids.fine.cells() as f64 <= 1.2 * ALWAYS_ALLOWED.max(grid.voxel_count() as f64 / 4.0), "{grids:?}");
            for cells in [grids.fine, grids.coarse] {
                let covered = DVec3::from_array(cells.dims.map(|n| n as f64)) * cells.edge;
                let extent = DVec3::from_array(dims.map(|n| n as f64)) * grid.spacing();
                assert!(covered.cmpge(extent - 1e-3).all() && covered.cmple(extent + cells.edge).all(), "{cells:?}");
            }
        }
    }
}
