//! Pictures beside those of the f64 reference, ray by ray, whatever draws them.

use super::*;
use layersplat::layers::Rays;
use layersplat::reference::{Layered as LayeredReference, Marched, Sheets};

/// A pixel whose ray just meets or just misses something can fall to either side in floats.
pub const RIM_SHARE: f64 = 6e-3;

/// The same rays, drawn by the device and by the reference.
pub struct Pair {
    pub found: Vec<[f64; 4]>,
    pub expected: Vec<[f64; 4]>,
    pub total: usize,
}

impl Pair {
    /// Draws a view with both. Where there is a lattice, its rays, before they are warped to the screen.
    pub fn of(volume: &Volume, transfer: &TransferFunction, camera: &Camera, size: Viewport, settings: &Settings) -> Self {
        Self::against(volume, transfer, camera, size, settings, settings)
    }

    /// The same, drawn by a device of other tuning values.
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

    /// The same with other settings for the reference: to show that a comparison can fail.
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
                // Neighbours, so that a shift by one is one of the picture too, but not all of many.
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
            // What layers and slices become where none can be drawn.
            Plan::Raycast(kernel, step) | Plan::CastValues(kernel, step) => {
                let cast = Settings { algorithm: Algorithm::Raycast { kernel, step }, ..*expected };
                Marched::new(volume, transfer, &cast).render(camera, size)
            }
            other => panic!("no reference for {other}"),
        };
        let (found, _) = renderer.render(camera, size, settings).unwrap();
        Self { found: wide(found.pixels()), expected: wide(expected.unwrap().pixels()), total: 0 }
    }

    /// The share of rays of which a channel, alpha included, differs by more than a tolerance.
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

    /// Asserts that the pictures are the same but for [`RIM_SHARE`] of their rays, that there is something to see, that not all rays are
    /// the same, and that a shift by one ray is noticed.
    #[track_caller]
    pub fn assert_same(&self, what: &str, tolerance: f64) {
        let seen = self.expected.iter().filter(|p| p[3] > 0.02).count();
        assert!(20 * seen > self.expected.len(), "{what}: {seen} of {} rays show anything", self.expected.len());
        let share = self.differing(tolerance);
        assert!(share <= RIM_SHARE, "{what}: {share} of the rays off by more than {tolerance}, up to {}", self.largest());
        let shifted = differing(&self.found[1..], &self.expected[..self.expected.len() - 1], tolerance);
        assert!(shifted > 5.0 * RIM_SHARE, "{what}: a shift by one ray must be noticed, but changes only {shifted} of them");
    }

    /// The largest difference of any channel.
    pub fn largest(&self) -> f64 {
        self.found.iter().zip(&self.expected).map(|(a, b)| difference(a, b)).fold(0.0, f64::max)
    }
}

/// Rays of a lattice that are looked at.
const MOST_SAMPLES: usize = 1500;

fn wide(pixels: &[[f32; 4]]) -> Vec<[f64; 4]> {
    pixels.iter().map(|p| p.map(f64::from)).collect()
}

fn difference(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    // A NaN must not pass for the smaller one.
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, |most, d| if d <= most { most } else { d })
}

fn differing(a: &[[f64; 4]], b: &[[f64; 4]], tolerance: f64) -> f64 {
    let same = a.iter().zip(b).filter(|(a, b)| difference(a, b) <= tolerance).count();
    1.0 - same as f64 / a.len() as f64
}
