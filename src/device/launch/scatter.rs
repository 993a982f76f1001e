//! Kernels that compute scattered light.

use super::layered::Channels;
use super::light::{block_lanes, blocks};
use super::structs::{
    Float4, RayEnds, ScatterCellsParams, ScatterGrid, ScatterLayersParams, ScatterMediumParams, ScatterSourceParams,
    ScatterSweepParams,
};
use super::{ChannelColors, ChannelFields, Defines, Items, PerChannel, Rendering, VoxelKind, kernel};
use crate::device::{Buffer, LatticeSchedule, Tuning};
use crate::layers::Kernel;

/// Planes of the medium: optical depth, albedo and direct light.
pub(crate) const MEDIUM_PLANES: usize = 7;

impl ScatterGrid {
    /// Cells of a plane, with those that fill rows up.
    pub fn plane(self, tuning: &Tuning) -> usize {
        self.pitch(tuning) * self.rows()
    }

    fn pitch(self, tuning: &Tuning) -> usize {
        (self.x as usize).next_multiple_of(lanes(tuning) as usize)
    }

    fn rows(self) -> usize {
        self.y as usize * self.z as usize
    }
}

/// Rays that are swept side by side.
fn lanes(tuning: &Tuning) -> u32 {
    match tuning.lattice_schedule {
        LatticeSchedule::Tiles => tuning.vector_width.max(4),
        LatticeSchedule::Samples => 1,
    }
}

kernel! {
    /// Sums what blocks of voxels absorb and scatter.
    ScatterMedium = "light/scatter_medium.cl", scatter_medium, "light", Items::Tiles;
    // With the numbers of voxels per block along x, y, z.
    defines |tuning, (voxels, rendering, per_block, channels): (VoxelKind, Rendering, [usize; 3], Channels)| {
        let defines = Defines::new(block_lanes(tuning)).with_voxels(voxels).with_kernel(Kernel::Cubic).with_channels(channels);
        blocks(defines.with_rendering(rendering), per_block)
    };
    items |a, tuning| {
        let [x, y, z] = a.p.dims.map(|n| n as usize);
        if block_lanes(tuning) == 1 { x * y * z } else { y * z }
    };
    arguments ScatterMediumArguments<'a> {
        /// In the layout of layer axis z.
        fields: ChannelFields<'a>,
        /// Per table entry: optical depth times albedo, and optical depth.
        entries: PerChannel<&'a Buffer<Float4>>,
        ray_ends: RayEnds,
        light: &'a Buffer<u8>,
        p: ScatterMediumParams,
        blocks: &'a Buffer<f32>,
        colors: Option<ChannelColors<'a>>,
    }
}

kernel! {
    /// Makes cubic cells of blocks of voxels.
    ScatterCells = "light/scatter.cl", scatter_cells, "light", Items::Tiles;
    defines |tuning, (): ()| Defines::new(lanes(tuning));
    items |a, _| a.p.grid.rows();
    arguments ScatterCellsArguments<'a> {
        blocks: &'a Buffer<f32>,
        medium: &'a Buffer<f32>,
        /// The radiance of the coarser grid, and the light that cells scatter with it; neither is used without.
        coarser: &'a Buffer<f32>,
        source: &'a Buffer<f32>,
        p: ScatterCellsParams,
    }
}

kernel! {
    /// Computes the light that cells scatter.
    ScatterSource = "light/scatter.cl", scatter_source, "light", Items::Tiles;
    defines |tuning, (): ()| Defines::new(lanes(tuning));
    items |a, _| a.p.grid.rows();
    arguments ScatterSourceArguments<'a> {
        medium: &'a Buffer<f32>,
        /// The last mean radiance.
        radiance: &'a Buffer<f32>,
        /// The one before, which becomes the next.
        older: &'a Buffer<f32>,
        /// What sweeps found of the last one.
        mean: &'a Buffer<f32>,
        source: &'a Buffer<f32>,
        p: ScatterSourceParams,
    }
}

kernel! {
    /// Sweeps radiance along an axis x or y and back.
    ScatterSweep = "light/scatter.cl", scatter_sweep, "light", Items::Tiles;
    defines |tuning, (): ()| Defines::new(lanes(tuning));
    items |a, _| a.p.items as usize;
    arguments ScatterSweepArguments<'a> {
        medium: &'a Buffer<f32>,
        source: &'a Buffer<f32>,
        mean: &'a Buffer<f32>,
        p: ScatterSweepParams,
    }
}

impl ScatterSweep {
    /// Work-items.
    pub fn work(grid: ScatterGrid, layers: i32, along_x: bool, tuning: &Tuning) -> i32 {
        layers * if along_x { grid.y } else { (grid.x as u32).div_ceil(lanes(tuning)) as i32 }
    }
}

kernel! {
    /// Sweeps radiance upwards or downwards through layers.
    ScatterLayers = "light/scatter.cl", scatter_layers, "light", Items::Tiles;
    defines |tuning, (): ()| Defines::new(lanes(tuning));
    items |a, _| a.p.items as usize;
    arguments ScatterLayersArguments<'a> {
        medium: &'a Buffer<f32>,
        source: &'a Buffer<f32>,
        mean: &'a Buffer<f32>,
        rays: &'a Buffer<f32>,
        packed: &'a Buffer<u8>,
        p: ScatterLayersParams,
    }
}

/// Layers of a launch where a work-item takes a block of rows, and those whose light is held at the same time in the last sweep.
pub(crate) const LAYERS: i32 = 8;

impl ScatterLayers {
    /// The launches of a sweep, without its direction and light: some layers each, first blocks of rows, then the rows between them.
    pub fn launches(grid: ScatterGrid, tuning: &Tuning) -> impl Iterator<Item = ScatterLayersParams> {
        // Half of the rows of a block are left after as many layers.
        let (most, rows, columns) = if lanes(tuning) == 1 { (1, 1, grid.x) } else { (LAYERS, 2 * LAYERS, 1) };
        let blocks = (grid.y + rows - 1) / rows;
        let launches = (0..grid.z).step_by(most as usize).flat_map(move |first| [false, true].map(|between| (first, between)));
        let launch = move |(first, between)| ScatterLayersParams {
            grid,
            items: (blocks - i32::from(between)) * columns,
            first,
            layers: most.min(grid.z - first),
            rows,
            ring: grid.y + LAYERS,
            between: i32::from(between),
            upwards: 0,
            is_last: 0,
            held_from: 0,
            held: grid.z,
            axis: 0.0,
            diagonal: 0.0,
            entering: [[0.0; 3]; 5],
        };
        launches.map(launch).filter(|p| p.items > 0 && (p.between == 0 || p.layers > 1))
    }

    /// Floats of the rays on their way.
    pub fn rays(grid: ScatterGrid, tuning: &Tuning) -> usize {
        15 * (grid.y + LAYERS) as usize * (grid.pitch(tuning) + grid.z as usize)
    }
}
