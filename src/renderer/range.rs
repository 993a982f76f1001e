//! Ranges of layers to composite, and their initial state.

use crate::layers::Lattice;
use std::ops::Range;

/// Layers beside a part in which rays are counted as in it: more than the rounding of kernels.
const BESIDE_PART: f64 = 0.01;

/// Layers of a lattice, numbered as in the whole volume.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LayerRange {
    /// Layers of voxels. The outer layers without voxels belong to the first and the last range.
    pub voxels: Range<usize>,
    /// Whether compositing continues from the raw samples in the lattice.
    pub continues: bool,
    /// Whether the result stays raw, so that later layers can continue.
    pub raw: bool,
}

impl LayerRange {
    /// All layers of a lattice, composited from an empty state and resolved.
    pub fn whole(lattice: &Lattice) -> Self {
        Self { voxels: 0..lattice.dims[2], continues: false, raw: false }
    }

    /// Resolve only: no layers, the raw samples of the lattice become colours.
    pub fn end() -> Self {
        Self { voxels: 0..0, continues: true, raw: false }
    }

    /// Whether rays are in these layers between two positions, in layers from that of the centre along rays.
    pub fn meets(&self, lattice: &Lattice, [from, to]: [f32; 2]) -> bool {
        let Range { start, end } = self.voxels;
        let first = if start == 0 { f64::NEG_INFINITY } else { start as f64 - 1.0 - BESIDE_PART };
        let last = if end == lattice.dims[2] { f64::INFINITY } else { end as f64 - 1.0 + BESIDE_PART };
        let along = |layer: f64| f64::from(lattice.layer_step) * (layer - lattice.centre_layer);
        let (one, other) = (along(first), along(last));
        one.min(other) <= f64::from(to) && f64::from(from) <= one.max(other)
    }

    /// First and last layer, −1 … n, in which splats are composited.
    pub fn layers(&self, lattice: &Lattice) -> [i32; 2] {
        let Range { start, end } = self.voxels;
        if start == end {
            return [0, -1];
        }
        let (first, last) = (start as i32, end as i32 - 1);
        [if first == 0 { -1 } else { first }, if end == lattice.dims[2] { last + 1 } else { last }]
    }

    /// First and last slab of a kernel's field. Slab q lies between layers q − radius and q − radius + 1. A slab belongs to the
    /// later of its two layers; slabs outside the voxels belong to the first and the last layer.
    pub fn slabs(&self, lattice: &Lattice, radius: i32) -> [i32; 2] {
        let Range { start, end } = self.voxels;
        if start == end {
            return [0, -1];
        }
        let all = lattice.dims[2];
        let slab_of_layer = |k: usize| k as i32 + radius - 1;
        let first = if start == 0 { 0 } else { slab_of_layer(start) };
        [first, slab_of_layer(end - 1) + if end == all { radius } else { 0 }]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, Orbit};
    use crate::layers::{Axis, Density, Kernel, Rays, Sampling};
    use crate::viewport::Viewport;
    use crate::volume::Grid;
    use glam::DVec3;

    #[test]
    fn parts_have_each_layer_and_slab_once() {
        let grid = Grid::new([5, 6, 7], DVec3::ONE).unwrap();
        let viewport = Viewport::new(8, 8).unwrap();
        let camera = Camera::fit_parallel(grid.centre(), grid.diagonal(), viewport, Orbit::default());
        let rays = Rays::new(&camera, viewport, &grid).unwrap();
        let lattice = Lattice::new(&rays, viewport, &grid, Axis::Z, Density::Fixed(1), Sampling::Points(Kernel::Cubic)).unwrap();
        let part = |voxels| LayerRange { voxels, ..LayerRange::whole(&lattice) };
        let of = |find: &dyn Fn(LayerRange) -> [i32; 2]| -> Vec<i32> {
            [0..3, 3..4, 4..7].into_iter().map(|voxels| find(part(voxels))).flat_map(|[first, last]| first..=last).collect()
        };
        assert_eq!(of(&|part| part.layers(&lattice)), (-1..=7).collect::<Vec<_>>());
        for radius in [1, 2] {
            let slabs = 7 + 2 * radius - 1;
            assert_eq!(of(&|part| part.slabs(&lattice, radius)), (0..slabs).collect::<Vec<_>>());
            let [first, last] = LayerRange::end().slabs(&lattice, radius);
            assert!(first > last);
        }
        // Slab 3 lies between layers 2 and 3, or with a radius of two between layers 1 and 2.
        assert_eq!((part(3..4).slabs(&lattice, 1), part(2..3).slabs(&lattice, 2)), ([3, 3], [3, 3]));
    }
}
