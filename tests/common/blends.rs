//! Algorithms with blend modes and clipping, and volumes for them.

use super::reference::Pair;
use super::*;
use layersplat::layers::{Density, Ray};
use layersplat::settings::{Blend, ClipPlane, Clipping, CropBox, Evaluation};

/// Eight quadrature nodes approximate the footprint integral of a splat sum in a perspective: up to 0.25 % of the value range, which
/// changes colours by 0.5 % per cent.
pub const QUADRATURE_TOLERANCE: f64 = 1.5e-2;
/// Refined surfaces are found in three steps of false position, within 0.01 of a segment, and lit there.
pub const REFINED_TOLERANCE: f64 = 1e-2;

/// Between most voxels of the outer shell and those of the centre.
pub const ISO: f64 = 120.0;
pub const BLENDS: [Blend; 4] = [Blend::Maximum, Blend::Minimum, Blend::Average, Blend::Iso(ISO)];
pub const VALUES: [Blend; 3] = [Blend::Maximum, Blend::Minimum, Blend::Average];
pub const REFINED: Classification = Classification::Preintegrated { kernel: Kernel::Cubic, samples_per_layer: 2 };

/// All algorithms with blend modes.
pub fn algorithms() -> Vec<Algorithm> {
    let mut all = Vec::new();
    for classification in [SPLATTED, POINTS, REFINED] {
        for evaluation in [Evaluation::Lattice(Density::Fixed(2)), Evaluation::Direct] {
            all.push(Layered { classification, evaluation, ..Layered::default() }.into());
        }
    }
    all.push(Algorithm::Slicing { step: 0.8 });
    for kernel in [Kernel::Linear, Kernel::Cubic, Kernel::Gaussian] {
        all.push(Algorithm::Raycast { kernel, step: 0.6 });
    }
    all
}

pub fn is_splatted(algorithm: Algorithm) -> bool {
    matches!(algorithm, Algorithm::Layered(Layered { classification: Classification::Post(_), .. }))
}

pub fn settings(algorithm: Algorithm, blend: Blend) -> Settings {
    Settings { algorithm, blend, ..Settings::default() }
}

pub fn tolerance(settings: &Settings, parallel: bool) -> f64 {
    match settings.algorithm {
        Algorithm::Layered(Layered { classification: Classification::Preintegrated { samples_per_layer: 2.., .. }, .. })
            if matches!(settings.blend, Blend::Iso(_)) =>
        {
            REFINED_TOLERANCE
        }
        Algorithm::Layered(Layered { evaluation: Evaluation::Lattice(_), .. })
            if is_splatted(settings.algorithm) && !parallel =>
        {
            QUADRATURE_TOLERANCE
        }
        _ => DEVICE_TOLERANCE,
    }
}

/// Whether an algorithm supports a blend mode.
pub fn has(algorithm: Algorithm, blend: Blend) -> bool {
    !(is_splatted(algorithm) && matches!(blend, Blend::Iso(_)))
}

/// A bump in noise: odd dimensions, flat voxels, a background far below.
pub fn bump() -> Volume<'static> {
    random_volume([11, 8, 13], DVec3::new(1.0, 0.7, 1.3), 21).with_background(-40.0).unwrap()
}

/// A block and a bump in a corner of a large empty volume: culling leaves some tiles empty.
pub fn mostly_empty() -> Volume<'static> {
    empty_but_for_a_corner(|value| value)
}

/// The volume of [`mostly_empty`] with negated values: culling of maxima here corresponds to that of minima there.
pub fn mostly_full() -> Volume<'static> {
    empty_but_for_a_corner(|value| 255 - value)
}

fn empty_but_for_a_corner(turned: fn(u8) -> u8) -> Volume<'static> {
    let dims = [40, 24, 30];
    let noise = random_bytes([14, 12, 13], 3);
    let value = |n: usize| {
        let (i, j, k) = (n % dims[0], n / dims[0] % dims[1], n / (dims[0] * dims[1]));
        if i < 14 && j < 12 && k < 13 {
            noise[i + 14 * (j + 12 * k)]
        } else if i > 30 && j > 15 {
            255
        } else {
            0
        }
    };
    volume(dims, DVec3::new(1.0, 1.1, 0.9), Voxels::Uint8((0..dims.iter().product()).map(|n| turned(value(n))).collect()))
}

/// Asserts that every algorithm and blend mode matches the reference under clipping, in a parallel view and in another one.
#[track_caller]
pub fn assert_every_blend(volume: &Volume, views: [Camera; 2], size: Viewport, clipping: Clipping) {
    for algorithm in algorithms() {
        for blend in BLENDS.into_iter().filter(|&blend| has(algorithm, blend)) {
            let settings = clipped(algorithm, blend, clipping);
            for (n, camera) in views.iter().enumerate() {
                let pair = Pair::of(volume, &smooth_transfer(), camera, size, &settings);
                pair.assert_same(&format!("{algorithm:?} {blend:?}, view {n}"), tolerance(&settings, n == 0));
            }
        }
    }
}

/// All algorithms that composite.
pub fn compositing() -> Vec<Algorithm> {
    algorithms().into_iter().filter(|a| matches!(a, Algorithm::Layered(_))).chain(OTHERS).collect()
}

pub fn crop(lowest: [f64; 3], highest: [f64; 3]) -> Clipping {
    let crop = Some(CropBox { lowest: lowest.into(), highest: highest.into() });
    Clipping { crop, ..Clipping::default() }
}

pub fn plane(point: [f64; 3], normal: [f64; 3]) -> ClipPlane {
    ClipPlane { point: point.into(), normal: normal.into() }
}

/// A crop box and two oblique planes through [`bump`], none of them at integer or half-integer coordinates.
pub fn cuts() -> Clipping {
    let planes = [plane([3.1, 2.2, 12.0], [1.0, 0.4, -0.6]), plane([6.3, 4.0, 9.0], [-0.3, -2.0, 0.7])];
    crop([1.3, 0.8, 2.37], [8.71, 20.0, 11.2]).with_planes(planes)
}

pub fn clipped(algorithm: Algorithm, blend: Blend, clipping: Clipping) -> Settings {
    Settings { clipping, ..settings(algorithm, blend) }
}

pub fn composited(algorithm: Algorithm, clipping: Clipping) -> Settings {
    Settings { early_termination: false, ..clipped(algorithm, Blend::Composite, clipping) }
}

/// Slicing looks up the nearest of 256 front and back values.
pub fn tolerance_of(settings: &Settings, parallel: bool) -> f64 {
    let slicing = matches!(settings.algorithm, Algorithm::Slicing { .. }) && settings.blend == Blend::Composite;
    if slicing { 6e-3 } else { tolerance(settings, parallel) }
}

/// Entry of a ray into a box, in front of its eye, and exit; entry exceeds exit if the ray misses the box.
pub fn span_in(ray: &Ray, lowest: [f64; 3], highest: [f64; 3]) -> (f64, f64) {
    let (mut enter, mut leave) = (ray.start, f64::INFINITY);
    for i in (0..3).filter(|&i| ray.direction[i].abs() > 1e-9) {
        let [a, b] = [lowest[i], highest[i]].map(|face| (face - ray.origin[i]) / ray.direction[i]);
        (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
    }
    (enter, leave)
}
