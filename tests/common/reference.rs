//! Comparison of device pictures with the f64 reference, ray by ray, for all algorithms.

use super::*;
use layersplat::layers::Rays;
use layersplat::reference::{Layered as LayeredReference, Marched, Sheets};

/// Fraction of pixels whose rays just hit or just miss something, and may fall to either side in f32.
pub const RIM_SHARE: f64 = 6e-3;

/// The same rays, rendered by the device and by the reference.
pub struct Pair {
    pub found: Vec<[f64; 4]>,
    pub expected: Vec<[f64; 4]>,
    pub total: usize,
}

impl Pair {
    /// Renders a view with both. On a lattice, compares its samples before the warp.
    pub fn of(volume: &Volume, transfer: &TransferFunction, camera: &Camera, size: Viewport, settings: &Settings) -> Self {
        Self::against(volume, transfer, camera, size, settings, settings)
    }

    /// As [`Pair::of`], on a device with other tuning values.
    pub fn on(
        device: &Device,
        volume: &Volume,
        transfer: &TransferFunction,
        camera: &Camera,
        size: Viewport,
        settings: &Settings,
    ) -> Self {
        Self::drawn(Renderer::new(device, volume, transfer).unwrap(), volume, camera, size, settings, settings)
    }

    /// As [`Pair::of`], with other settings for the reference, to show that a comparison can fail.
    pub fn against(
        volume: &Volume,
        transfer: &TransferFunction,
        camera: &Camera,
        size: Viewport,
        settings: &Settings,
        expected: &Settings,
    ) -> Self {
        Self::drawn(Renderer::new(&device(), volume, transfer).unwrap(), volume, camera, size, settings, expected)
    }

    fn drawn(
        mut renderer: Renderer,
        volume: &Volume,
        camera: &Camera,
        size: Viewport,
        settings: &Settings,
        expected: &Settings,
    ) -> Self {
        let rays = Rays::new(camera, size, volume.grid()).unwrap();
        let transfer = &renderer.transfer_function().clone();
        let reference = LayeredReference::new(volume, transfer, expected);
        let plan = Plan::new(&rays, size, volume.grid(), settings).unwrap();
        let expected = match plan {
            Plan::Lattice(lattice, _) => {
                let picture = renderer.lattice_picture(camera, size, settings).unwrap().expect("a lattice, as planned");
                let axis = lattice.frame.layer_axis();
                // Consecutive samples, so that a shift by one is meaningful, but not all of a large lattice.
                let count = picture.samples.len().min(MOST_SAMPLES);
                let first = (picture.samples.len() - count) / 2;
                let of_sample = |n: usize| {
                    let (column, row) = (n as u32 % picture.size[0], n as u32 / picture.size[0]);
                    reference.composite(&picture.ray(column, row), Some(axis), rays.to_eye)
                };
                let expected = (first..first + count).map(of_sample).collect();
                return Self { found: wide(&picture.samples[first..first + count]), expected, total: picture.samples.len() };
            }
            Plan::Direct(axis, _) => reference.render(camera, size, axis),
            Plan::AxisSheets(_) | Plan::ViewSheets(_) => Sheets::new(volume, transfer, expected).render(camera, size),
            Plan::Slicing(_) => Marched::new(volume, transfer, expected).render(camera, size),
            // Ray casting replaces layers and slices where these cannot be rendered.
            Plan::Raycast(kernel, step) | Plan::CastValues(kernel, step) => {
                let cast = Settings { algorithm: Algorithm::Raycast { kernel, step }, ..*expected };
                Marched::new(volume, transfer, &cast).render(camera, size)
            }
            other => panic!("no reference for {other}"),
        };
        let (found, _) = renderer.render(camera, size, settings).unwrap();
        Self { found: wide(found.pixels()), expected: wide(expected.unwrap().pixels()), total: 0 }
    }

    /// Fraction of rays that differ by more than a tolerance in a channel, alpha included.
    pub fn differing(&self, tolerance: f64) -> f64 {
        use std::io::Write;
        if let Ok(p) = std::env::var("PAIR_LOG") {
            let mut f = std::fs::OpenOptions::new().append(true).create(true).open(p).unwrap();
            let mut ds: Vec<f64> =
                self.found.iter().zip(&self.expected).map(|(a, b)| difference(a, b)).filter(|&d| d > tolerance).collect();
            ds.sort_by(f64::total_cmp);
            ds.reverse();
            let al = self.found.iter().zip(&self.expected).map(|(a, b)| (a[3] - b[3]).abs()).fold(0.0, f64::max);
            let line = format!(
                "{} {} n={} off={} of_all={} tol={tolerance} alpha={al:.4} {:.4?}\n",
                std::thread::current().name().unwrap_or("?"),
                std::env::args().next().unwrap().rsplit('/').next().unwrap(),
                self.found.len(),
                ds.len(),
                self.total,
                &ds[..ds.len().min(6)]
            );
            f.write_all(line.as_bytes()).unwrap();
        }
        differing(&self.found, &self.expected, tolerance)
    }

    /// Asserts that the pictures agree except for [`RIM_SHARE`] of their rays, that they are neither empty nor uniform, and that a shift by one
    /// ray would be detected.
    #[track_caller]
    pub fn assert_same(&self, what: &str, tolerance: f64) {
        let seen = self.expected.iter().filter(|p| p[3] > 0.02).count();
        assert!(20 * seen > self.expected.len(), "{what}: {seen} of {} rays show anything", self.expected.len());
        let share = self.differing(tolerance);
        assert!(share <= RIM_SHARE, "{what}: {share} of the rays off by more than {tolerance}, up to {}", self.largest());
        let shifted = differing(&self.found[1..], &self.expected[..self.expected.len() - 1], tolerance);
        assert!(shifted > 5.0 * RIM_SHARE, "{what}: a shift by one ray must be noticed, but changes only {shifted} of them");
    }

    /// Largest difference of any channel.
    pub fn largest(&self) -> f64 {
        self.found.iter().zip(&self.expected).map(|(a, b)| difference(a, b)).fold(0.0, f64::max)
    }
}

/// Number of lattice samples compared.
const MOST_SAMPLES: usize = 1500;

fn wide(pixels: &[[f32; 4]]) -> Vec<[f64; 4]> {
    pixels.iter().map(|p| p.map(f64::from)).collect()
}

fn difference(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    // NaN must not be replaced by a smaller number.
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, |most, d| if d <= most { most } else { d })
}

fn differing(a: &[[f64; 4]], b: &[[f64; 4]], tolerance: f64) -> f64 {
    let same = a.iter().zip(b).filter(|(a, b)| difference(a, b) <= tolerance).count();
    1.0 - same as f64 / a.len() as f64
}
