//! Sheared lattice of a parallel view: the samples of each layer are shifted along the rays.

use super::phases::{MAX_SAMPLES_PER_VOXEL, Phases};
use super::pixel_rays::on_pixels;
use super::{ANCHOR_LIMIT, AffineRays, Density, Lattice, Sampling, Source, Stagger, aligned, support_corners};
use crate::layers::{Axis, Rays};
use crate::viewport::Viewport;
use crate::volume::Grid;

/// Largest |s|. Phases have stencils for up to 1. Other lattices continue where two axes are blended (`Axis::shares`).
const MAX_SHEAR_IN_PHASES: f64 = 1.0 + 1e-6;
const MAX_SHEAR: f64 = 1.06;
/// Margin around the viewport in samples: two for the warp's filter, one for rounding.
const MARGIN: f64 = 3.0;
/// Denser samples are indistinguishable in f32.
const MOST_POINTS_PER_VOXEL: f64 = (1 << 20) as f64;
/// Tolerance above an integer within which samples per voxel round down.
const CEIL_SLACK: f64 = 1e-6;

/// See [`Lattice::new`]. With phases, samples per voxel are integers up to [`MAX_SAMPLES_PER_VOXEL`], and cells are whole voxels.
pub(super) fn lattice(
    rays: &Rays,
    viewport: Viewport,
    grid: &Grid,
    axis: Axis,
    density: Density,
    sampling: Sampling,
) -> Option<Lattice> {
    let frame = axis.frame();
    let direction = rays.central_direction();
    let shear = frame.shear(direction);
    let in_phases = sampling == Sampling::Splats;
    let max_shear = if in_phases { MAX_SHEAR_IN_PHASES } else { MAX_SHEAR };
    if !shear.iter().all(|s| s.abs() <= max_shear) {
        return None;
    }
    let centre = frame.local(grid.centre_in_voxels());
    let spreads = aligned::spreads(rays, viewport, frame, density, sampling, |x, y| {
        let origin = frame.local(rays.at(x, y).origin);
        [0, 1].map(|i| origin[i] + (centre.z - origin.z) * shear[i])
    });
    let mut samples_per_voxel = spreads.along.map(|spread| spread.samples_per_voxel);
    let most = if in_phases {
        samples_per_voxel = samples_per_voxel.map(|m| (m - CEIL_SLACK).ceil());
        f64::from(MAX_SAMPLES_PER_VOXEL)
    } else {
        MOST_POINTS_PER_VOXEL
    };
    if samples_per_voxel.iter().any(|&m| m > most) {
        return None;
    }
    let mut lattice = Lattice {
        frame,
        dims: [frame.u, frame.v, frame.a].map(|i| grid.dims()[i]),
        size: [0; 2],
        samples_per_voxel,
        layer_step: if direction[frame.a] > 0.0 { 1 } else { -1 },
        centre_layer: centre.z,
        rays: shear.map(|s| AffineRays { crossing: [0.0; 2], shear: [s, 0.0] }),
        phases: None,
        aligned: match spreads.crossed_along {
            Some(_) => [false; 2],
            None => spreads.along.map(|spread| spread.on_pixel.is_some()),
        },
        crossed_along: spreads.crossed_along,
        stagger: Stagger::default(),
        pixel_rays: None,
        source: Source::Direction(direction),
    };
    for i in 0..2 {
        let (first, size) = extent(&lattice, rays, viewport, centre.to_array(), i, sampling);
        let m = samples_per_voxel[i];
        lattice.size[i] = size;
        let anchor = match spreads.along[i].on_pixel {
            Some(place) => ((place - centre[i]) * m).rem_euclid(1.0),
            None => anchor(lattice.dims[i], m),
        };
        let middle = centre[i] + first + ((f64::from(size) - 1.0) / 2.0 + anchor) / m;
        lattice.rays[i].crossing = [middle, 1.0 / m];
    }
    if lattice.is_staggered() {
        lattice.stagger = Stagger::onto_pixels(&lattice.from_screen(rays));
    }
    if !in_phases && !lattice.has_pixels_samples() {
        let on_pixels = on_pixels(&lattice, rays, viewport, density, &support_corners(lattice.dims, sampling));
        if on_pixels.is_some() {
            return on_pixels;
        }
    }
    if in_phases {
        let per_voxel = samples_per_voxel.map(|m| m as u32);
        let columns = [0, 1].map(|i| lattice.size[i] / per_voxel[i]);
        lattice.phases = Some(Phases { samples_per_voxel: per_voxel, columns });
    }
    Some(lattice)
}

/// First cell, in voxels from the centre, and number of samples along u (`i` = 0) or v (1).
///
/// The range is the intersection of the volume's shadow along the rays and the viewport, in whole cells placed symmetrically around the
/// centre. A cell is a sample, or with phases a voxel.
fn extent(lattice: &Lattice, rays: &Rays, viewport: Viewport, centre: [f64; 3], i: usize, sampling: Sampling) -> (f64, u32) {
    let m = lattice.samples_per_voxel[i];
    let s = lattice.rays[i].shear[0].abs();
    let per_cell = if sampling == Sampling::Splats { m } else { 1.0 };
    let cell = per_cell / m;
    let half_support = |voxels: usize| (voxels as f64 - 1.0) / 2.0 + sampling.radius();
    // Staggered samples start up to a row later.
    let stagger = if i == 1 && lattice.is_staggered() { 1.0 / m } else { 0.0 };
    let reach = half_support(lattice.dims[i]) + 2.0 * s + s * half_support(lattice.dims[2]) + stagger;
    let half = (reach / cell).ceil();
    let seen = rays.corners(viewport).map(|ray| lattice.crossing_of(ray)[i] - centre[i]);
    let lo = seen.iter().fold(f64::INFINITY, |a, &b| a.min(b)) - MARGIN / m;
    let hi = seen.iter().fold(f64::NEG_INFINITY, |a, &b| a.max(b)) + MARGIN / m;
    let first = (lo / cell + half).floor().clamp(0.0, 2.0 * half);
    let last = (hi / cell + half).ceil().clamp(first, 2.0 * half);
    ((first - half) * cell, ((last - first) * per_cell) as u32)
}

/// Position of the samples in their cells: symmetric to the centre. At about one sample per voxel, samples coincide with voxels, for odd
/// and for even numbers of voxels.
fn anchor(voxels: usize, samples_per_voxel: f64) -> f64 {
    let between = voxels % 2 == 1 && samples_per_voxel < ANCHOR_LIMIT;
    if between { 0.0 } else { 0.5 }
}
