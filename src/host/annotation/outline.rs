//! Bounding box of the voxels.

use super::canvas::Canvas;
use super::screen::Screen;
use crate::volume::Grid;
use glam::DVec3;

/// Opacities of the nearest and the farthest edges; opacity decreases linearly with depth.
const OPACITY: (f64, f64) = (0.95, 0.4);

/// Draws the twelve edges: those of front faces over the volume, the others under it. The box is convex and encloses the volume, so this
/// order is correct for whole edges.
pub(super) fn draw(screen: &Screen, grid: &Grid, under: &mut Canvas, over: &mut Canvas) {
    let last = DVec3::from_array(grid.dims().map(|n| n as f64 - 1.0));
    let to_world = grid.index_to_world();
    let corner = |bits: usize| {
        let share = DVec3::new((bits & 1) as f64, (bits >> 1 & 1) as f64, (bits >> 2 & 1) as f64);
        to_world.transform_point3(share * last)
    };
    let depths: Vec<f64> = (0..8).map(|bits| screen.depth(corner(bits))).collect();
    let (nearest, farthest) = depths.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), &d| (lo.min(d), hi.max(d)));
    for axis in 0..3 {
        for others in 0..4 {
            let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
            let first = (others & 1) << b | (others >> 1) << c;
            let (from, to) = (corner(first), corner(first | 1 << axis));
            let faces = [b, c].map(|side| {
                let outwards = if first >> side & 1 == 1 { 1.0 } else { -1.0 };
                screen.faces(from, to_world.matrix3.col(side) * outwards)
            });
            let Some(ends) = screen.line(from, to) else { continue };
            let depth = (depths[first] + depths[first | 1 << axis]) / 2.0;
            let far = if farthest > nearest { ((depth - nearest) / (farthest - nearest)).clamp(0.0, 1.0) } else { 0.0 };
            let opacity = OPACITY.0 + (OPACITY.1 - OPACITY.0) * far;
            let canvas = if faces.contains(&true) { &mut *over } else { &mut *under };
            let (width, ink) = (1.2 * canvas.extent().scale, canvas.ink());
            canvas.line(ends[0], ends[1], width, ink, opacity);
        }
    }
}
