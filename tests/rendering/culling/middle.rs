//! Interpolated values half-way between two lit samples.

use super::assert_culled_right;
use crate::common::*;
use glam::DVec3;
use layersplat::layers::{Axis, Kernel};
use layersplat::settings::{Classification, Evaluation, LayerAxis, Layered};
use layersplat::volume::Voxels;
use layersplat::{Camera, Orbit, Projection, TransferFunction, Volume};

/// A volume of which only the values half-way between two samples of an oblique ray are visible. These are computed from the samples and
/// their slopes. The pattern has two values, placed to maximise the middle value, far from a low visible value.
fn leaning_pattern(kernel: Kernel, start: [f64; 2], lean: f64) -> Volume<'static> {
    const DIMS: [usize; 3] = [96, 24, 24];
    let step = DVec3::new(lean, lean, 1.0);
    let from = DVec3::new(60.0 + start[0], 12.0 + start[1], 12.0);
    let weight = |p: DVec3| kernel.weight(p.x) * kernel.weight(p.y) * kernel.weight(p.z);
    let slope = |p: DVec3| {
        let [w, s] = [Kernel::weight, Kernel::slope].map(|of| [of(kernel, p.x), of(kernel, p.y), of(kernel, p.z)]);
        step.dot(DVec3::new(s[0] * w[1] * w[2], w[0] * s[1] * w[2], w[0] * w[1] * s[2]))
    };
    let of_the_middle = |voxel: DVec3| {
        let [front, back] = [from - voxel, from + step - voxel];
        (weight(front) + weight(back)) / 2.0 + (slope(front) - slope(back)) / 8.0
    };
    let place = |n: usize| [n % DIMS[0], n / DIMS[0] % DIMS[1], n / (DIMS[0] * DIMS[1])];
    let coefficient = |[i, j, k]: [usize; 3]| {
        let w = of_the_middle(DVec3::new(i as f64, j as f64, k as f64));
        if i < 8 { 0.0 } else { LEANING[0] + if w == 0.0 { 0.0 } else { LEANING[1] * w.signum() } }
    };
    let count = DIMS.iter().product();
    let voxel = |n: usize| {
        let p = place(n);
        if kernel != Kernel::BSpline {
            return coefficient(p) as f32;
        }
        // Value at a voxel of the spline with these coefficients.
        let mut sum = 0.0;
        for m in 0..27 {
            let offset = [m % 3, m / 3 % 3, m / 9];
            let near: [usize; 3] = std::array::from_fn(|a| (p[a] + offset[a]).saturating_sub(1).min(DIMS[a] - 1));
            sum += coefficient(near) * offset.map(|o| if o == 1 { 2.0 / 3.0 } else { 1.0 / 6.0 }).iter().product::<f64>();
        }
        sum as f32
    };
    volume(DIMS, DVec3::ONE, Voxels::Float32((0..count).map(voxel).collect()))
}

/// Centre of the two values of the pattern, and their distance from it.
const LEANING: [f64; 2] = [0.5, 0.1];

/// Interpolation by values and slopes may exceed the bounds that the kernel's weights imply.
#[test]
fn culling_sees_the_middle_between_lit_samples() {
    // The last number is the overshoot of the pattern's largest sum, less than that of the middle value: 0.04, 0.18 and 1.02 of the difference.
    for (kernel, start, lean, beyond) in [
        (Kernel::BSpline, [0.5, 0.5], 1.0, 0.02),
        (Kernel::BSpline, [0.0, 0.0], 2.0, 0.08),
        (Kernel::CatmullRom, [0.5, 0.5], 2.0, 0.6),
    ] {
        let volume = leaning_pattern(kernel, start, lean);
        let edge = LEANING[0] + LEANING[1] * (1.0 + 2.0 * beyond);
        let opacities = vec![(0.0, 0.9), (0.02, 0.9), (0.03, 0.0), (edge, 0.0), (edge + 1e-3, 0.9)];
        let transfer = TransferFunction::new("two bands", vec![(0.0, [1.0, 0.8, 0.6])], opacities).unwrap();
        let classification = Classification::Preintegrated { kernel, samples_per_layer: 1 };
        let evaluation = Evaluation::Direct;
        let layered = Layered { layer_axis: LayerAxis::Forced(Axis::Z), classification, evaluation, ..Layered::default() };
        let mut seen = 0;
        let (azimuth, elevation) = (lean.atan().to_degrees(), (lean / lean.hypot(1.0)).atan().to_degrees());
        for (azimuth, elevation) in [(azimuth, elevation), (azimuth, -elevation), (-azimuth, elevation), (-azimuth, -elevation)] {
            let orbit = Orbit { azimuth, elevation, roll: 0.0 };
            let middle = volume
                .grid()
                .index_to_world()
                .transform_point3(DVec3::new(60.0 + start[0], 12.0 + start[1], 12.0) + 0.5 * DVec3::new(lean, lean, 1.0));
            let camera = Camera::orbit(middle, 100.0, orbit, Projection::Parallel { scale: 1.0 });
            seen += assert_culled_right("middle", &volume, &transfer, &camera, layered.into());
        }
        assert!(seen > 10, "{kernel:?}, {lean}: {seen} pixels show the middle value");
    }
}
