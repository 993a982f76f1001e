//! Structures of kernels that draw surfaces.

use super::super::cl_type::ClType;
use super::super::kernel_struct::{Field, kernel_struct};

kernel_struct! {
    /// The view of surfaces, in the coordinates of surfaces/cells.cl.
    SurfaceView {
        /// Rays of pixels: at (0, 0), and per column and row.
        origin: [[f32; 4]; 3],
        direction: [[f32; 4]; 3],
        /// Homogeneous pixel coordinates of a place: three rows.
        to_screen: [[f32; 4]; 3],
        /// Ray parameter at which rays begin.
        start: f32,
        /// Last homogeneous coordinate of the nearest places that have pixel coordinates.
        nearest: f32,
        /// By how much the last homogeneous coordinate changes, at most, over a unit of length.
        depth_of_unit: f32,
        /// Sign of the volume between two columns, two rows and the direction.
        handedness: f32,
        /// From ray parameters to layers of a lattice, from that of the centre along rays: offset and factor, each at pixel coordinates (0, 0)
        /// and per column and row.
        to_layers: [[f32; 3]; 2],
        /// From places to voxels, and the centre in voxels.
        to_voxels: [f32; 3],
        centre: [f32; 3],
        size as [width, height]: i32,
        tiles as [tiles_u, tiles_v]: i32,
    }
}

kernel_struct! {
    /// A set of surfaces.
    SurfaceSet {
        /// From its points to the coordinates of surfaces/cells.cl: three rows. The same of normals, but for their length.
        to_view: [[f32; 4]; 3],
        normal_to_view: [[f32; 3]; 3],
        /// Factor of radii.
        scale: f32,
        /// Straight colour and opacity.
        color: [f32; 4],
        /// Value of the first of the colours of values, and their number per value.
        table_from: f32,
        table_per_value: f32,
        /// What points or cells have: 0 nothing, colours of points 1, of cells 2, values of points 3, of cells 4.
        attribute: i32,
        /// Its first attribute, colour of values, point, cell and normal; no normals: -1.
        first_attribute: i32,
        first_color: i32,
        first_point: i32,
        first_cell: i32,
        first_normal: i32,
        /// 1: all its fragments are opaque; clip planes cut it. shaded: kinds of kernels/surfaces/surface_colors.cl.
        opaque: i32,
        shaded: i32,
        clipped: i32,
    }
}
