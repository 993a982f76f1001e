//! Voxels in floats, with the background around them.

use crate::layers::{Kernel, Ray};
use crate::settings::Blend;
use crate::transfer::TransferFunction;
use crate::volume::Volume;
use glam::DVec3;

/// A volume's voxels and what surrounds them.
pub(super) struct Field {
    dims: [i64; 3],
    background: f64,
    gaussian_background: f64,
    range: (f64, f64),
    /// Where a voxel is missing the nearest one stands for it, and no background enters.
    edge_goes_on: bool,
    voxels: Vec<f64>,
}

impl Field {
    /// As a blend mode sees it.
    pub fn new(volume: &Volume, transfer: &TransferFunction, blend: Blend) -> Self {
        let gaussian_background = match blend {
            Blend::Composite => transfer.gaussian_background(volume.range().0, volume.background()),
            Blend::Iso(_) => volume.background(),
            // What a Gaussian's sums, which are only near 1, miss of the value: of its distance from the smallest one.
            _ => volume.range().0,
        };
        let voxels = (0..volume.grid().voxel_count()).map(|i| volume.value(i)).collect();
        Self {
            dims: volume.grid().dims().map(|n| n as i64),
            background: volume.background(),
            gaussian_background,
            range: volume.field_range(),
            edge_goes_on: blend.gathers_values(),
            voxels,
        }
    }

    /// Voxels along x, y, z.
    pub fn dims(&self) -> [i64; 3] {
        self.dims
    }

    /// Value of the voxels missing around the volume.
    pub fn background(&self) -> f64 {
        self.background
    }

    /// The same as a kernel takes it.
    pub fn background_of(&self, kernel: Kernel) -> f64 {
        if kernel == Kernel::Gaussian { self.gaussian_background } else { self.background }
    }

    /// Any voxel, inside or around the volume.
    pub fn voxel(&self, p: [i64; 3]) -> f64 {
        self.voxel_or(p, self.background)
    }

    /// Any voxel, or what it counts as where it is missing.
    pub fn voxel_or(&self, p: [i64; 3], missing: f64) -> f64 {
        let [x, y, z] = self.dims;
        let nearest = |i: usize| p[i].clamp(0, self.dims[i] - 1);
        let p = if self.edge_goes_on { [nearest(0), nearest(1), nearest(2)] } else { p };
        if (0..x).contains(&p[0]) && (0..y).contains(&p[1]) && (0..z).contains(&p[2]) {
            self.voxels[(p[0] + x * (p[1] + y * p[2])) as usize]
        } else {
            missing
        }
    }

    /// The field that a kernel reconstructs, at a point in voxels: background + Σ (ρ − background) × weights. (Weights sum to 1
    /// but for the Gaussian's.)
    pub fn reconstructed(&self, kernel: Kernel, p: DVec3) -> f64 {
        if kernel == Kernel::Cubic {
            return self.value(p);
        }
        let r = i64::from(kernel.radius());
        let below = p.floor().to_array().map(|c| c as i64);
        let weights: [Vec<(i64, f64)>; 3] = std::array::from_fn(|a| {
            let taps = below[a] - r + 1..=below[a] + r;
            taps.map(|i| (i, kernel.weight(p[a] - i as f64))).collect()
        });
        let missing = self.background_of(kernel);
        let mut sum = 0.0;
        for &(k, wz) in &weights[2] {
            for &(j, wy) in &weights[1] {
                for &(i, wx) in &weights[0] {
                    sum += wx * wy * wz * (self.voxel_or([i, j, k], missing) - missing);
                }
            }
        }
        missing + sum
    }

    /// A reconstructed value without what lattice sums overshoot the data's range by.
    pub fn within_range(&self, value: f64) -> f64 {
        value.clamp(self.range.0, self.range.1)
    }

    /// Central differences of the same over two voxels.
    pub fn differences(&self, kernel: Kernel, p: DVec3) -> DVec3 {
        let along = |d: DVec3| (self.reconstructed(kernel, p + d) - self.reconstructed(kernel, p - d)) / 2.0;
        DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
    }

    /// Where a ray before its eye is in the support of a kernel's field, [−r, n−1+r] per axis, as parameters of the ray: beyond, there
    /// is nothing to be marched through.
    pub fn support(&self, kernel: Kernel, ray: &Ray) -> Option<(f64, f64)> {
        let radius = f64::from(kernel.radius());
        let (mut enter, mut leave) = (ray.start, f64::INFINITY);
        for i in 0..3 {
            let (lo, hi) = (-radius, self.dims[i] as f64 - 1.0 + radius);
            let (o, d) = (ray.origin[i], ray.direction[i]);
            if d == 0.0 {
                if o <= lo || o >= hi {
                    return None;
                }
                continue;
            }
            let (a, b) = ((lo - o) / d, (hi - o) / d);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        (leave > enter).then_some((enter, leave))
    }

    /// The reconstructed field Σ ρ f(x−i) f(y−j) f(z−k) (paper, Eq. 1 and 2) at a point in voxels.
    pub fn value(&self, p: DVec3) -> f64 {
        let below = p.floor();
        let [i, j, k] = below.to_array().map(|c| c as i64);
        // f(1−t) = 3t² − 2t³ is the weight of the farther voxel.
        let w = (p - below).map(|t| t * t * (3.0 - 2.0 * t));
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let [x, y, z] = self.dims;
        let inside = i >= 0 && j >= 0 && k >= 0 && i + 1 < x && j + 1 < y && k + 1 < z;
        let corner = |n: i64| {
            let (di, dj, dk) = (n & 1, n >> 1 & 1, n >> 2);
            match inside {
                true => self.voxels[(i + di + x * (j + dj + y * (k + dk))) as usize],
                false => self.voxel([i + di, j + dj, k + dk]),
            }
        };
        let plane = |n: i64| mix(mix(corner(n), corner(n + 1), w.x), mix(corner(n + 2), corner(n + 3), w.x), w.y);
        mix(plane(0), plane(4), w.z)
    }
}
