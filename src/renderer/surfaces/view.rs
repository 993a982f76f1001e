//! Rays, clip planes and volumes in the coordinates of surfaces: along the axes of the grid, in world units, from the volume's centre.

use super::super::region::Region;
use super::super::scene::Scene;
use crate::device::launch::structs::{RayEnds, SurfaceView};
use crate::device::launch::surfaces::SURFACE_TILE;
use crate::layers::{Axis, Lattice, Rays};
use crate::viewport::Viewport;
use crate::volume::Grid;
use glam::{DMat3, DVec3, DVec4};

/// Places nearer to the eye than this, in smallest spacings, have no pixel coordinates.
const NEAREST: f64 = 1e-3;

/// The view of surfaces.
pub(super) fn surface_view(grid: &Grid, rays: &Rays, viewport: Viewport, lattice: Option<&Lattice>) -> SurfaceView {
    let (spacing, centre) = (grid.spacing(), grid.centre_in_voxels());
    let origin = [(rays.origin[0] - centre) * spacing, rays.origin[1] * spacing, rays.origin[2] * spacing];
    let direction = rays.direction.map(|d| d * spacing);
    // The axes that pixel coordinates count along, the third one away from the eye, and where these begin.
    let (axes, begin) = if rays.is_parallel() {
        ([origin[1], origin[2], direction[0]], origin[0])
    } else {
        ([direction[1], direction[2], direction[0]], origin[0] + direction[0] * rays.start)
    };
    let inverse = DMat3::from_cols(axes[0], axes[1], axes[2]).inverse();
    let row = |i: usize| inverse.row(i).extend(-inverse.row(i).dot(begin));
    let last = if rays.is_parallel() { DVec4::W } else { row(2) };
    let narrow = |v: DVec3| v.as_vec3().extend(0.0).to_array();
    SurfaceView {
        origin: origin.map(narrow),
        direction: direction.map(narrow),
        to_screen: [row(0), row(1), last].map(|row| row.as_vec4().to_array()),
        start: rays.start as f32,
        nearest: if rays.is_parallel() { 0.0 } else { NEAREST as f32 },
        depth_of_unit: last.truncate().length() as f32,
        handedness: axes[0].cross(axes[1]).dot(axes[2]).signum() as f32,
        to_layers: lattice.map_or([[0.0; 3]; 2], |lattice| {
            let along = |p: DVec3| p[lattice.frame.a] * f64::from(lattice.layer_step);
            let centre = lattice.centre_layer * f64::from(lattice.layer_step);
            let [offset, right, down] = rays.origin.map(along);
            [[offset - centre, right, down], rays.direction.map(along)].map(|row| row.map(|n| n as f32))
        }),
        to_voxels: (1.0 / spacing).as_vec3().to_array(),
        centre: centre.as_vec3().to_array(),
        size: [viewport.width as i32, viewport.height as i32],
        tiles: [viewport.width, viewport.height].map(|pixels| pixels.div_ceil(SURFACE_TILE) as i32),
    }
}

/// Voxels by which fragments may lie outside the crop box and clip planes: without, those of a surface on a face would be drawn or not by
/// rounding.
const ON_FACE: f32 = 1e-3;

/// Where rays meet fragments.
pub(super) fn fragment_ends(region: &Region, scene: &Scene) -> RayEnds {
    let ends = ray_ends(region, scene);
    RayEnds {
        lowest: ends.lowest.map(|n| n - ON_FACE),
        highest: ends.highest.map(|n| n + ON_FACE),
        planes: ends.planes.map(|[a, b, c, d]| [a, b, c, d + ON_FACE * glam::Vec3::new(a, b, c).length()]),
        ..ends
    }
}

/// Ray ends of a region in voxels.
pub(super) fn ray_ends(region: &Region, scene: &Scene) -> RayEnds {
    let grid = scene.field.grid();
    let (spacing, centre) = (grid.spacing().as_vec3(), grid.centre_in_voxels().as_vec3());
    let voxels = region.for_screen(Axis::Z.frame(), scene.rays);
    let place = |p: [f32; 3]| ((glam::Vec3::from_array(p) - centre) * spacing).to_array();
    let plane = |[a, b, c, d]: [f32; 4]| {
        let normal = glam::Vec3::new(a, b, c);
        (normal / spacing).extend(d + normal.dot(centre)).to_array()
    };
    // Planes that are not used are 0.
    RayEnds { lowest: place(voxels.lowest), highest: place(voxels.highest), planes: voxels.planes.map(plane), ..voxels }
}
