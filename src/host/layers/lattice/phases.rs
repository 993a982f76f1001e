//! Phases: within a layer, all samples of a phase have the same offset from their voxels.

use super::Lattice;

/// Largest number of samples per voxel and axis with phases. Closer views are rendered per pixel.
pub const MAX_SAMPLES_PER_VOXEL: u32 = 16;

/// Integer samples per voxel of a parallel view. Sample I = i·m + p has phase p.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Phases {
    /// m along u and v.
    pub samples_per_voxel: [u32; 2],
    /// Number of columns and rows per phase.
    pub columns: [u32; 2],
}

/// Offset of the samples of a phase in a layer: sample column i lies at `base + i + fraction` voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerOffset {
    /// Voxel at or below the sample of column 0.
    pub base: i32,
    /// Distance from that voxel, 0 … 1.
    pub fraction: f32,
}

impl Lattice {
    /// Offsets along u (`i` = 0) or v (1) for layers −1 … n and all `phases`, layer by layer.
    pub fn offsets(&self, phases: Phases, i: usize) -> Vec<LayerOffset> {
        let m = phases.samples_per_voxel[i];
        (-1..=self.dims[2] as i64)
            .flat_map(|k| (0..m).map(move |p| (k, p)))
            .map(|(k, p)| {
                let [crossing, shear] = self.crossing(i, f64::from(p));
                let position = crossing + (k as f64 - self.centre_layer) * shear;
                let base = position.floor();
                LayerOffset { base: base as i32, fraction: (position - base) as f32 }
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Density, Sampling};
    use super::*;
    use crate::camera::{Camera, Orbit, Projection};
    use crate::layers::{Axis, Rays};
    use crate::viewport::Viewport;
    use crate::volume::Grid;
    use approx::assert_abs_diff_eq;
    use glam::DVec3;

    fn lattice(dims: [usize; 3], orbit: Orbit, scale: f64) -> (Option<Lattice>, Rays) {
        let grid = Grid::new(dims, DVec3::ONE).unwrap();
        let viewport = Viewport::new(64, 64).unwrap();
        let camera = Camera::orbit(grid.centre(), 10.0, orbit, Projection::Parallel { scale });
        let rays = Rays::new(&camera, viewport, &grid).unwrap();
        let axis = Axis::most_parallel(rays.central_direction());
        (Lattice::new(&rays, viewport, &grid, axis, Density::AtLeast(1), Sampling::Splats), rays)
    }

    #[test]
    fn offsets_follow_the_shear_and_are_never_coarser_than_the_screen() {
        let orbit = Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
        let (lattice, rays) = lattice([16; 3], orbit, 16.0);
        let lattice = lattice.unwrap();
        let phases = lattice.phases.unwrap();
        assert_eq!(phases.samples_per_voxel, [2, 2]);
        assert!(1.0 / 2.0 <= rays.pixel_size);
        let offsets = lattice.offsets(phases, 0);
        let at = |k: usize, p: usize| f64::from(offsets[k * 2 + p].base) + f64::from(offsets[k * 2 + p].fraction);
        for k in 0..17 {
            assert_abs_diff_eq!(at(k + 1, 0) - at(k, 0), lattice.shear()[0], epsilon = 1e-6);
            assert_abs_diff_eq!(at(k, 1) - at(k, 0), 0.5, epsilon = 1e-6);
        }
    }

    #[test]
    fn zooming_in_crops_and_then_leaves_the_lattice() {
        let (near, _) = lattice([64; 3], Orbit::default(), 4.0);
        let columns = near.unwrap().phases.unwrap().columns;
        assert!(columns[0] < 12, "{columns:?}");
        assert!(lattice([64; 3], Orbit::default(), 0.5).0.is_none());
    }
}
