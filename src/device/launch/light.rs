//! Kernels that fill light volumes.

use super::layered::Channels;
use super::structs::{Float4, LayerOffset, LightSweepParams, RayEnds};
use super::{ChannelFields, Defines, Floats, Items, Launch, PerChannel, Rendering, VoxelKind, kernel, large_grid, tiles};
use crate::device::{Buffer, LatticeSchedule, Tuning};
use crate::layers::Kernel;

/// Value of a sum for a light of 1: below 65535, so that the rounded parts of all sweeps fit.
pub(crate) const WHOLE_SUM: f32 = 65000.0;

kernel! {
    /// Computes the transmittance of a thickness for each table entry.
    LightTable = "light/light_table.cl", light_table, "light", Items::Pixels;
    defines |_, (): ()| Defines::none();
    items |a, _| a.count as usize;
    arguments LightTableArguments<'a> {
        /// (r, g, b, τ) per value, or α with linear extinction.
        table: &'a Buffer<Float4>,
        count: i32,
        /// In unit distances.
        thickness: f32,
        linear: i32,
        transmittance: &'a Buffer<f32>,
    }
}

kernel! {
    /// Sweeps the transmittance of parallel rays from a light through the layers of an axis. The extinctions of all fields add.
    LightSweep = "light/light_sweep.cl", light_sweep, "light", Items::Tiles;
    // The flag: voxels are coarse transmittances, of all fields. They know no gradients and are not clipped.
    defines |tuning, variant: (VoxelKind, bool, Rendering, Channels)| {
        let defines = Self::shared_defines(Self::lanes(tuning), variant);
        defines.with("SWEEP_VECTORS", Self::VECTORS).with("SWEEP_ROWS", Self::ROWS)
    };
    items |a, _| tiles(a.p.tiles);
    arguments LightSweepArguments<'a> {
        fields: ChannelFields<'a>,
        /// One bit per block and slab.
        visible: PerChannel<&'a Buffer<u8>>,
        /// Tables of integrals, for compositing at full resolution.
        integrals: PerChannel<&'a Buffer<[i32; 4]>>,
        /// Of layers -1 … n along u, then along v.
        offsets: &'a Buffer<LayerOffset>,
        p: LightSweepParams,
        ray_ends: RayEnds,
        light: &'a Buffer<u8>,
        /// One per voxel, for light that is averaged over several sweeps; otherwise not read.
        sums: &'a Buffer<u16>,
        /// Transmittances of rays, tile by tile, for sweeps of some layers; otherwise neither read nor written.
        state: &'a Buffer<f32>,
    }
}

impl LightSweep {
    /// Rows of rays in a tile.
    const ROWS: usize = 19;
    /// Columns of rays: three vectors. Wider tiles would lie over more than eight blocks, which are loaded at once.
    const VECTORS: usize = 3;

    /// Columns and rows of rays in a tile.
    fn tile(tuning: &Tuning) -> [usize; 2] {
        [Self::VECTORS * Self::lanes(tuning) as usize, Self::ROWS]
    }

    /// Number of tiles for this many rays along u and v.
    pub fn tiles(size: [usize; 2], tuning: &Tuning) -> [i32; 2] {
        overlapping_tiles(size, Self::tile(tuning))
    }

    fn lanes(tuning: &Tuning) -> u32 {
        tuning.vector_width.max(4)
    }

    fn shared_defines(vector_width: u32, (voxels, coarse, rendering, channels): <Self as Launch>::Variant) -> Defines {
        let kernel = if coarse { Kernel::Linear } else { Kernel::Cubic };
        let whole = Rendering { clipped: false, gradient_opacity: false, ..rendering };
        let defines = Defines::new(vector_width).with_voxels(voxels).with_kernel(kernel).with_channels(channels);
        defines.with_rendering(if coarse { whole } else { rendering }).with_if(coarse, "COARSE")
    }

    /// Number of rays of all tiles, which overlap, for this many rays along u and v.
    pub fn states(size: [usize; 2], tuning: &Tuning) -> usize {
        tiles(Self::tiles(size, tuning)) * Self::tile(tuning).into_iter().product::<usize>()
    }
}

/// Columns and rows of rays that neighbouring tiles have in common: COMMON_RAYS in kernels/light/ray_sample.cl.
const COMMON: usize = 3;

/// Number of tiles of some columns and rows for this many rays.
fn overlapping_tiles(size: [usize; 2], tile: [usize; 2]) -> [i32; 2] {
    [0, 1].map(|i| (size[i] - COMMON).div_ceil(tile[i] - COMMON) as i32)
}

kernel! {
    /// [`LightSweep`] with a work-item per ray, through all layers of one field.
    LightRays = "light/light_rays.cl", light_rays, "light", Items::Rays(Self::TILE[0] * Self::TILE[1]);
    defines |_, variant: <LightSweep as Launch>::Variant| {
        let [columns, rows] = Self::TILE;
        LightSweep::shared_defines(1, variant).with("SAMPLE_COLUMNS", columns).with("SAMPLE_ROWS", rows)
    };
    items |a, _| tiles(a.p.tiles) * Self::TILE[0] * Self::TILE[1];
    arguments LightSweepArguments
}

impl LightRays {
    /// Columns and rows of rays of a work-group. Of 8 × 8, only 5 × 5 would have all the rays that their voxels need.
    const TILE: [usize; 2] = [16, 16];

    /// Number of tiles for this many rays along u and v.
    pub fn tiles(size: [usize; 2]) -> [i32; 2] {
        overlapping_tiles(size, Self::TILE)
    }
}

kernel! {
    /// Converts sums of several sweeps to bytes.
    FinishLight = "light/finish_light.cl", finish_light, "light", Items::Pixels;
    defines |_, (): ()| Defines::new(1);
    items |a, _| large_grid(a.values as usize);
    arguments FinishLightArguments<'a> {
        sums: &'a Buffer<u16>,
        /// Number of values of a volume.
        values: i32,
        /// Sum of a light of 1.
        whole: f32,
        gain: f32,
        /// Whether values are codes of light (kernels/shared/light_codes.cl), or the light itself.
        coded: i32,
        /// Number of the volume.
        volume: i32,
        light: &'a Buffer<u8>,
    }
}

kernel! {
    /// Computes the mean transmittance of blocks of voxels. The extinctions of all fields add.
    CoarseTransmittance = "light/coarse_transmittance.cl", coarse_transmittance, "light", Items::Tiles;
    // With the number of voxels per block and axis.
    defines |tuning, (voxels, rendering, coarse, channels): (VoxelKind, Rendering, usize, Channels)| {
        let defines = Defines::new(block_lanes(tuning)).with_voxels(voxels).with_kernel(Kernel::Cubic).with_channels(channels);
        blocks(defines.with_rendering(rendering), [coarse; 3])
    };
    items |a, tuning| {
        let rows = a.dims_y as usize * a.dims_z as usize;
        if block_lanes(tuning) == 1 { a.dims_x as usize * rows } else { rows }
    };
    arguments CoarseTransmittanceArguments<'a> {
        /// In the layout of layer axis z.
        fields: ChannelFields<'a>,
        /// Of each voxel along the edge of a block: results of [`LightTable`].
        entries: PerChannel<&'a Buffer<f32>>,
        ray_ends: RayEnds,
        /// First block and blocks along each axis.
        first_x: i32,
        first_y: i32,
        first_z: i32,
        dims_x: i32,
        dims_y: i32,
        dims_z: i32,
        coarse: Floats<'a>,
    }
}

/// For kernels that sum over blocks of this many voxels along each axis.
pub(super) fn blocks(defines: Defines, [u, v, a]: [usize; 3]) -> Defines {
    defines.with("PER_BLOCK_U", u).with("PER_BLOCK_V", v).with("PER_BLOCK_A", a)
}

/// Vector lanes in which rows of blocks are reduced; 1: block by block.
pub(super) fn block_lanes(tuning: &Tuning) -> u32 {
    match tuning.lattice_schedule {
        LatticeSchedule::Tiles => tuning.vector_width.max(4),
        LatticeSchedule::Samples => 1,
    }
}
