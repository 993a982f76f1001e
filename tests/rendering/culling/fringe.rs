//! Kernel tails of single voxels, at all positions in blocks and in chunks of layers.

use super::assert_culled_right;
use crate::common::*;
use glam::DVec3;
use layersplat::layers::{Axis, Density, Kernel};
use layersplat::settings::{Classification, Evaluation, LayerAxis, Layered};
use layersplat::volume::Voxels;
use layersplat::{Settings, TransferFunction, Volume};

const DIMS: [usize; 3] = [68, 60, 52];

/// Isolated voxels of 255 in 0.
fn drops() -> Volume<'static> {
    let mut bytes = vec![0u8; DIMS.iter().product()];
    for n in 0..72 {
        // 8 rows of 9, offset along all axes, so that all positions in blocks of 8 × 4 and in chunks of eight layers occur.
        let [row, column] = [n / 9, n % 9];
        let (x, y, z) = (3 + 7 * column + row % 3, 2 + 7 * row + column % 5, 2 + (5 * n + 3 * row) % 48);
        bytes[x + DIMS[0] * (y + DIMS[1] * z)] = 255;
    }
    volume(DIMS, DVec3::ONE, Voxels::Uint8(bytes))
}

/// Shows only values far below those of the voxels: the tails of their kernels.
fn fringe() -> TransferFunction {
    let opacities = vec![(0.0, 0.0), (0.2, 0.0), (0.4, 0.5), (25.0, 0.5), (30.0, 0.0), (255.0, 0.0)];
    TransferFunction::new("fringe", vec![(0.0, [1.0, 0.8, 0.6])], opacities).unwrap()
}

#[test]
fn culling_sees_the_fringe_of_every_voxel() {
    let (volume, transfer, size) = (drops(), fringe(), viewport(150, 140));
    let spline = Classification::Preintegrated { kernel: Kernel::BSpline, samples_per_layer: 1 };
    for (n, (azimuth, elevation)) in [(5.0, 3.0), (40.0, -30.0), (-60.0, 25.0), (170.0, 80.0)].into_iter().enumerate() {
        // Includes rays that move more than a voxel per layer.
        let leaning = if n == 2 { LayerAxis::Forced(Axis::Z) } else { LayerAxis::Auto };
        let views = [
            (parallel(&volume, size, azimuth, elevation), leaning),
            (perspective(&volume, azimuth, elevation, 40.0), LayerAxis::Auto),
        ];
        for (camera, layer_axis) in views {
            for classification in [SPLATTED, POINTS, spline] {
                // Every other view per pixel.
                let evaluation = if n % 2 == 0 { Layered::default().evaluation } else { Evaluation::Direct };
                let layered = Layered { classification, evaluation, layer_axis, ..Layered::default() };
                let settings = Settings { early_termination: false, ..layered.into() };
                let seen = assert_culled_right("fringe", &volume, &transfer, &camera, settings);
                assert!(seen > 30, "{azimuth}, {elevation}, {classification:?}: {seen} visible pixels");
            }
        }
    }
}

/// A field of floats around −0.7 … 1.9, mostly in a gap between two opaque bands. Without culling, rows that only appear visible are lit, so
/// gradients at edges must be bit-identical to those inside.
#[test]
fn culling_lights_no_row_in_another_way() {
    let dims = [66, 59, 61];
    let mut random = Random(11);
    let mut values: Vec<f32> = (0..dims.iter().product()).map(|_| 0.05 + 0.1 * (random.next() % 1000) as f32 / 1000.0).collect();
    for n in 0..60 {
        let at = random.next() as usize % values.len();
        values[at] = if n % 2 == 0 { -0.7 } else { 1.9 };
    }
    let volume = volume(dims, DVec3::ONE, Voxels::Float32(values));
    let opacities = vec![(-0.7, 0.6), (-0.1, 0.4), (-0.05, 0.0), (0.4, 0.0), (0.5, 0.5), (1.9, 0.7)];
    let transfer = TransferFunction::new("gap", vec![(0.0, [1.0, 0.8, 0.6])], opacities).unwrap();
    for n in 0..12 {
        let camera = parallel(&volume, viewport(120, 100), 29.0 * f64::from(n), 11.0 * f64::from(n) - 60.0);
        for (classification, samples) in [(SPLATTED, 1), (POINTS, 2)] {
            let evaluation = Evaluation::Lattice(Density::Fixed(samples));
            let layered = Layered { classification, evaluation, ..Layered::default() };
            let seen = assert_culled_right("gap", &volume, &transfer, &camera, layered.into());
            assert!(seen > 100, "view {n}, {classification:?}: {seen} visible pixels");
        }
    }
}
