//! Structures of kernels that scatter light.

use super::super::cl_type::ClType;
use super::super::kernel_struct::{Field, kernel_struct};

kernel_struct! {
    /// A grid of cubic cells for scattered light (kernels/light/scatter_grid.cl).
    ScatterGrid {
        x: i32,
        y: i32,
        z: i32,
    }
}

kernel_struct! {
    /// What blocks of voxels absorb and scatter.
    ScatterMediumParams {
        /// Blocks along each axis, of which layers along z are summed from this one on.
        dims as [dims_x, dims_y, dims_z]: i32,
        first_layer: i32,
        /// Number of lights, and the radiance of each that arrives from all sides: its irradiance over 4 pi.
        lights: i32,
        irradiance: [[f32; 3]; 4],
        /// Bytes of the volume of a light, of its rows and of its layers, and the first layer. Values cover 2^shift voxels along each axis.
        light_bytes: i32,
        light_row: i32,
        light_layer: i32,
        light_first: i32,
        light_shift: i32,
        /// Of each light: the way of its rays from layer to layer of values, in edges of a cell; the bytes to the next value towards it along
        /// the axis of these layers, and along the other axes; and the shears along these.
        crossings: [f32; 4],
        towards: [[i32; 3]; 4],
        shears: [[f32; 2]; 4],
    }
}

kernel_struct! {
    /// Cubic cells from blocks of voxels.
    ScatterCellsParams {
        grid: ScatterGrid,
        /// Blocks along each axis, and how many a cell covers.
        blocks as [blocks_x, blocks_y, blocks_z]: i32,
        per_cell as [per_cell_x, per_cell_y, per_cell_z]: f32,
        /// Edge of a cell, in lengths that the depths of blocks are for.
        edges: f32,
        /// The grid from which the radiance is interpolated, and cells of it per cell.
        coarser: ScatterGrid,
        per_coarse: f32,
        /// Factor of the albedo.
        scattering: f32,
        /// 1: that grid has a radiance.
        refined: i32,
    }
}

kernel_struct! {
    /// The light that cells scatter.
    ScatterSourceParams {
        grid: ScatterGrid,
        /// Factor of the albedo.
        scattering: f32,
        /// Mean radiance of the sky.
        sky: [f32; 3],
        /// 1: the mean radiance is a start value.
        starts: i32,
        /// Chebyshev's iteration: relaxation (gain (swept - last) + last - before) + before.
        relaxation: f32,
        gain: f32,
    }
}

kernel_struct! {
    /// A sweep along an axis and back.
    ScatterSweepParams {
        grid: ScatterGrid,
        /// Work-items.
        items: i32,
        /// The first layer, and the number of layers.
        first: i32,
        layers: i32,
        /// Weight of each of both directions.
        weight: f32,
        /// 1: the axis is x; the flux is found, too.
        along_x: i32,
        flux: i32,
        /// Radiance that enters along the axis, and against it.
        entering: [[f32; 3]; 2],
    }
}

kernel_struct! {
    /// A sweep across layers.
    ScatterLayersParams {
        grid: ScatterGrid,
        /// Work-items.
        items: i32,
        /// Of layers in the order of the sweep: the first one, and their number.
        first: i32,
        layers: i32,
        /// Rows of a block, and of rays.
        rows: i32,
        ring: i32,
        /// 1: rows between blocks.
        between: i32,
        /// 1: from the first layer to the last.
        upwards: i32,
        /// 1: the last sweep, which finds the flux.
        is_last: i32,
        /// The first layer of which the mean radiance is held, and their number.
        held_from: i32,
        held: i32,
        /// Weight of the axis, and of each diagonal.
        axis: f32,
        diagonal: f32,
        /// Radiance that enters along each ordinate.
        entering: [[f32; 3]; 5],
    }
}
