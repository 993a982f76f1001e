//! Weights of a reconstruction kernel along one axis.

use crate::layers::Kernel;

/// Weights of the voxels around a position along one axis.
pub(super) struct Taps {
    /// Index of the first voxel.
    pub first: i64,
    pub count: usize,
    pub taps: [f64; Taps::MOST],
}

impl Taps {
    /// Largest number of taps, that of the Gaussian's slopes.
    const MOST: usize = 6;

    /// Weights of the value at x.
    pub fn weights(kernel: Kernel, x: f64) -> Self {
        Self::new(x, kernel.radius(), |x| kernel.weight(x))
    }

    /// Weights of the slope at x.
    pub fn slopes(kernel: Kernel, x: f64) -> Self {
        let radius = match kernel {
            // Central differences of the weights reach one voxel further.
            Kernel::Linear | Kernel::Cubic | Kernel::Gaussian => kernel.radius() + 1,
            Kernel::CatmullRom | Kernel::BSpline => kernel.radius(),
        };
        Self::new(x, radius, |x| kernel.slope(x))
    }

    fn new(x: f64, radius: i32, tap: impl Fn(f64) -> f64) -> Self {
        let first = x.floor() as i64 - i64::from(radius) + 1;
        let (count, mut taps) = (2 * radius as usize, [0.0; Self::MOST]);
        for (n, own) in taps[..count].iter_mut().enumerate() {
            *own = tap(x - (first + n as i64) as f64);
        }
        Self { first, count, taps }
    }

    /// Pairs of voxel index and tap.
    pub fn each(&self) -> impl Iterator<Item = (i64, f64)> + '_ {
        (self.first..).zip(self.taps[..self.count].iter().copied())
    }
}
