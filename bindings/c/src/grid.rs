//! Grids of voxels in the world.

use layersplat::glam::{DMat3, DVec3};
use layersplat::volume;

/// The grid of a volume. Voxel (i, j, k) lies at origin + i · hx · x + j · hy · y + k · hz · z, in world units, with the spacing
/// (hx, hy, hz) and the directions x, y, z.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Number of voxels along x, y, z; x is the fastest in memory.
    pub dims: [usize; 3],
    /// World distance between neighbouring voxels along x, y, z.
    pub spacing: [f64; 3],
    /// World position of voxel (0, 0, 0).
    pub origin: [f64; 3],
    /// World directions of x, y, z in this order: orthonormal.
    pub direction: [[f64; 3]; 3],
}

impl Grid {
    pub(crate) fn from_library(grid: &volume::Grid) -> Self {
        Self {
            dims: grid.dims(),
            spacing: grid.spacing().to_array(),
            origin: grid.origin().to_array(),
            direction: grid.direction().to_cols_array_2d(),
        }
    }

    pub(crate) fn checked(&self) -> Result<volume::Grid, layersplat::Error> {
        let [spacing, origin] = [self.spacing, self.origin].map(DVec3::from_array);
        volume::Grid::oriented(self.dims, spacing, origin, DMat3::from_cols_array_2d(&self.direction))
    }
}

/// An axis-aligned grid at the origin: the number of voxels and their spacing along x, y, z.
#[unsafe(no_mangle)]
pub extern "C" fn layersplat_grid_at_origin(nx: usize, ny: usize, nz: usize, hx: f64, hy: f64, hz: f64) -> Grid {
    let direction = DMat3::IDENTITY.to_cols_array_2d();
    Grid { dims: [nx, ny, nz], spacing: [hx, hy, hz], origin: [0.0; 3], direction }
}
