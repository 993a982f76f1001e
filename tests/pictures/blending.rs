//! Blend modes: every algorithm and mode against the f64 reference, in both projections, and closed forms.

use crate::common::blends::*;
use crate::common::reference::Pair;
use crate::common::*;
use glam::DVec3;
use layersplat::layers::{Density, Kernel};
use layersplat::renderer::Plan;
use layersplat::settings::{Algorithm, Blend, Clipping, CropBox, Evaluation, Layered};
use layersplat::volume::{Rescale, Voxels};
use layersplat::{Camera, Settings, TransferFunction, Volume};

#[test]
fn every_algorithm_and_blend_mode_is_the_reference() {
    let volume = bump();
    let size = viewport(23, 19);
    let views = [parallel(&volume, size, 33.0, 21.0), perspective(&volume, -70.0, 15.0, 35.0)];
    assert_every_blend(&volume, views, size, Clipping::default());
}

/// Comparisons must detect another blend mode, another surface, and values over half a ray.
#[test]
fn errors_are_noticed() {
    let volume = bump();
    let size = viewport(23, 19);
    let camera = parallel(&volume, size, 33.0, 21.0);
    let differing = |algorithm, blend, wrong: Settings| {
        let settings = settings(algorithm, blend);
        let pair = Pair::against(&volume, &smooth_transfer(), &camera, size, &settings, &wrong);
        pair.differing(tolerance(&settings, true))
    };
    for algorithm in algorithms().into_iter().filter(|&a| !is_splatted(a)) {
        for (blend, wrong) in [
            (Blend::Maximum, Blend::Average),
            (Blend::Minimum, Blend::Maximum),
            (Blend::Average, Blend::Minimum),
            (Blend::Iso(ISO), Blend::Iso(ISO + 5.0)),
            (Blend::Iso(ISO), Blend::Composite),
        ] {
            let share = differing(algorithm, blend, settings(algorithm, wrong));
            assert!(share > 0.1, "{algorithm:?}: {blend:?} for {wrong:?} changes only {share}");
        }
    }
}

/// Rays in the faces of the box of voxels may miss it in floats; none inside may be off.
#[test]
fn only_rays_at_a_rim_may_be_off() {
    let volume = volume([12; 3], DVec3::ONE, Voxels::Uint8(vec![200; 1728])).with_background(0.0).unwrap();
    let size = viewport(12, 12);
    // Pixel centres at whole voxels.
    let camera = scaled(parallel(&volume, size, 0.0, 0.0), 6.0);
    for algorithm in [
        Algorithm::Raycast { kernel: Kernel::Linear, step: 0.6 },
        Layered { classification: POINTS, evaluation: Evaluation::Lattice(Density::Fixed(1)), ..Layered::default() }.into(),
    ] {
        let settings = settings(algorithm, Blend::Average);
        let mut pair = Pair::of(&volume, &smooth_transfer(), &camera, size, &settings);
        let opaque: Vec<usize> = (0..pair.expected.len()).filter(|&n| pair.expected[n][3] == 1.0).collect();
        let (first, inside) = (opaque[0], opaque[opaque.len() / 2 + 6]);
        assert_eq!(opaque.len(), 144, "all rays, and those in the faces too");
        assert_eq!(pair.unexplained(DEVICE_TOLERANCE), [0; 0]);
        (pair.found[first], pair.found[inside]) = ([0.0; 4], [0.0; 4]);
        assert_eq!(pair.unexplained(DEVICE_TOLERANCE), [inside], "{algorithm:?}");
    }
}

#[test]
fn from_inside_rays_begin_at_the_eye() {
    let volume = bump();
    let size = viewport(24, 18);
    let camera = perspective(&volume, 30.0, 20.0, 60.0);
    let eye = camera.focal_point + (camera.position - camera.focal_point).normalize() * 1.6;
    let inside = Camera { position: eye, ..camera };
    for algorithm in algorithms() {
        for blend in BLENDS.into_iter().filter(|&blend| has(algorithm, blend)) {
            let settings = settings(algorithm, blend);
            let pair = Pair::of(&volume, &smooth_transfer(), &inside, size, &settings);
            pair.assert_allowed(&format!("{algorithm:?} {blend:?}"), tolerance(&settings, false));
        }
    }
}

#[test]
fn thin_volumes_among_their_voxels() {
    let size = viewport(20, 20);
    for dims in [[9, 1, 7], [1, 6, 8], [7, 5, 1], [1, 1, 1]] {
        let volume = random_volume(dims, DVec3::new(1.0, 0.9, 1.2), 5);
        let camera = parallel(&volume, size, 35.0, 25.0);
        for algorithm in [
            Algorithm::Raycast { kernel: Kernel::Linear, step: 0.6 },
            Layered { classification: POINTS, evaluation: Evaluation::Direct, ..Layered::default() }.into(),
            Layered { classification: SPLATTED, evaluation: Evaluation::Lattice(Density::Fixed(2)), ..Layered::default() }.into(),
        ] {
            for blend in VALUES {
                let settings = settings(algorithm, blend);
                let pair = Pair::of(&volume, &smooth_transfer(), &camera, size, &settings);
                pair.assert_allowed(&format!("{dims:?} {algorithm:?} {blend:?}"), tolerance(&settings, true));
                assert!(pair.expected.iter().any(|p| p[3] == 1.0), "{dims:?}: nothing to see");
            }
        }
    }
}

/// Maps values 0 … `largest` to brightness; `largest` has an opacity of 0.5.
fn brightness(largest: f64) -> TransferFunction {
    let colors = vec![(0.0, [0.0; 3]), (largest, [1.0; 3])];
    TransferFunction::new("brightness", colors, vec![(0.0, 0.0), (largest, 0.5)]).unwrap()
}

/// Values 10·x.
fn ramp(dims: [usize; 3], spacing: DVec3) -> Volume<'static> {
    let voxels = (0..dims.iter().product()).map(|i| (10 * (i % dims[0])) as u8).collect();
    volume(dims, spacing, Voxels::Uint8(voxels))
}

/// Linear interpolation reproduces a ramp: values along a ray lie between those at its ends in the voxel region.
#[test]
fn a_ramp_in_closed_form() {
    /// Half an entry of 4096, and rounding.
    const ENTRY: f64 = 3e-4;
    let dims = [13, 9, 11];
    let volume = ramp(dims, DVec3::new(1.0, 0.8, 1.5));
    let size = viewport(25, 21);
    let transfer = brightness(120.0);
    for camera in [parallel(&volume, size, 40.0, 25.0), perspective(&volume, -130.0, -20.0, 40.0)] {
        let rays = layersplat::layers::Rays::new(&camera, size, volume.grid()).unwrap();
        for algorithm in [Algorithm::Slicing { step: 0.7 }, Algorithm::Raycast { kernel: Kernel::Linear, step: 1.3 }] {
            for blend in VALUES {
                let frame = render(&volume, &transfer, &camera, size, &settings(algorithm, blend));
                let mut met = 0;
                for (n, pixel) in frame.pixels().iter().enumerate() {
                    let ray = rays.at((n % 25) as f64 + 0.5, (n / 25) as f64 + 0.5);
                    let (enter, leave) = span_in(&ray, [0.0; 3], dims.map(|n| n as f64 - 1.0));
                    let [a, b] = [enter, leave].map(|t| (ray.origin.x + t * ray.direction.x) / 12.0);
                    let expected = match blend {
                        Blend::Maximum => a.max(b),
                        Blend::Minimum => a.min(b),
                        _ => (a + b) / 2.0,
                    };
                    if leave - enter > 1e-3 {
                        met += 1;
                        let off = (f64::from(pixel[0]) - expected).abs();
                        assert!(off < ENTRY && pixel[3] == 1.0, "{algorithm:?} {blend:?}: {pixel:?} for {expected}");
                    } else if leave < enter - 1e-3 {
                        assert_eq!(*pixel, [0.0; 4], "{algorithm:?} {blend:?}: outside the volume");
                    }
                }
                assert!(met > 80, "{met} rays meet the volume");
            }
        }
    }
}

/// Along the layer axis, every algorithm samples the voxels themselves: maximum, minimum, and their mean with integration weights.
#[test]
fn a_ramp_along_the_layers() {
    /// Half an entry of 4096; splat sums of layers combine values from three layers.
    const ENTRY: f64 = 3e-4;
    let volume = ramp([13, 9, 11], DVec3::ONE);
    let size = viewport(9, 9);
    for azimuth in [90.0, -90.0] {
        let camera = scaled(parallel(&volume, size, azimuth, 0.0), 3.0);
        for algorithm in algorithms().into_iter().filter(|&a| !is_splatted(a)) {
            if matches!(algorithm, Algorithm::Raycast { kernel: Kernel::Gaussian, .. }) {
                continue;
            }
            for (blend, expected) in [(Blend::Maximum, 1.0), (Blend::Minimum, 0.0), (Blend::Average, 0.5)] {
                let frame = render(&volume, &brightness(120.0), &camera, size, &settings(algorithm, blend));
                for pixel in frame.pixels() {
                    let off = (f64::from(pixel[1]) - expected).abs();
                    assert!(off < ENTRY && (pixel[3] - 1.0).abs() < 1e-5, "{algorithm:?} {blend:?}: {pixel:?}, not {expected}");
                }
            }
        }
    }
}

/// Blinn–Phong colour of a plane by manual calculation, and its position: visible when clipped just in front, invisible just behind.
#[test]
fn an_iso_plane_in_closed_form() {
    /// Error of the highlight's logarithm.
    const LIGHT: f64 = 1e-3;
    /// Distance of the clip planes in voxels; refinement ends within it.
    const NEAR: f64 = 0.02;
    let volume = ramp([13, 9, 11], DVec3::ONE);
    let size = viewport(9, 9);
    let (azimuth, value) = (70.0f64, 42.0);
    let camera = scaled(parallel(&volume, size, azimuth, 0.0), 1.0);
    let colors = vec![(0.0, [0.1, 0.3, 0.6]), (84.0, [0.5, 0.3, 0.2])];
    // Iso-surfaces ignore opacity.
    let transfer = TransferFunction::new("clear", colors, vec![(0.0, 0.0), (120.0, 0.0)]).unwrap();
    // Azimuth 90 looks along x.
    let cosine = azimuth.to_radians().sin();
    let expected = [0.3, 0.3, 0.4].map(|c: f64| (c * (0.2 + 0.7 * cosine) + 0.3 * cosine.powf(20.0)).min(1.0));
    // The cubic reaches a fifth of the difference between two voxels at 3t² − 2t³ = 1/5.
    let mut bent: f64 = 0.3;
    for _ in 0..20 {
        bent -= (3.0 * bent * bent - 2.0 * bent * bent * bent - 0.2) / (6.0 * bent - 6.0 * bent * bent);
    }
    for algorithm in algorithms().into_iter().filter(|&a| !is_splatted(a)) {
        let place = match algorithm {
            Algorithm::Raycast { kernel: Kernel::Gaussian, .. } => continue,
            // Steps that do not coincide with layers lie anywhere between voxels.
            Algorithm::Raycast { kernel: Kernel::Cubic, .. } => continue,
            Algorithm::Layered(layered) if layered.classification == REFINED => 4.0 + bent,
            _ => 4.2,
        };
        let settings = settings(algorithm, Blend::Iso(value));
        let seen = |cut: f64| {
            let crop = Some(CropBox { lowest: DVec3::new(cut, 0.0, 0.0), highest: DVec3::new(12.0, 8.0, 10.0) });
            let clipping = Clipping { crop, ..Clipping::default() };
            render(&volume, &transfer, &camera, size, &Settings { clipping, ..settings }).pixel(4, 4)
        };
        let (shown, gone) = (seen(place - NEAR), seen(place + NEAR));
        assert_eq!(gone[3], 0.0, "{algorithm:?}: the surface must lie in front of {}", place + NEAR);
        assert!((shown[3] - 1.0).abs() < 1e-5, "{algorithm:?}: the surface must lie behind {}: {shown:?}", place - NEAR);
        for (c, e) in shown.iter().zip(expected) {
            assert!((f64::from(*c) - e).abs() < LIGHT, "{algorithm:?}: {shown:?}, not {expected:?}");
        }
    }
}

#[test]
fn culling_and_early_ends_change_no_bit() {
    let size = viewport(48, 40);
    for (volume, blends) in [(mostly_empty(), &BLENDS[..]), (mostly_full(), &VALUES[..])] {
        let views =
            [parallel(&volume, size, 20.0, 15.0), parallel(&volume, size, 0.0, 0.0), perspective(&volume, 200.0, -30.0, 40.0)];
        let cases = algorithms().into_iter().flat_map(|a| blends.iter().map(move |&blend| (a, blend)));
        for (algorithm, blend) in cases.filter(|&(a, blend)| has(a, blend)) {
            for camera in &views {
                let culled = render(&volume, &smooth_transfer(), camera, size, &settings(algorithm, blend));
                let whole = Settings { culling: false, early_termination: false, ..settings(algorithm, blend) };
                let all = render(&volume, &smooth_transfer(), camera, size, &whole);
                let off = culled.pixels().iter().zip(all.pixels()).filter(|(a, b)| a != b).count();
                assert_eq!(off, 0, "{algorithm:?} {blend:?}: pixels with different bits");
                // Rays through nothing but the smallest value display it.
                let opaque = culled.pixels().iter().filter(|p| p[3] > 0.99).count();
                let least = if blend.gathers_values() { 450 } else { 80 };
                assert!(opaque > least, "{algorithm:?} {blend:?}: {opaque} opaque pixels");
            }
        }
    }
}

/// The minimum of negated values is the negated maximum. The average does not depend on the direction.
#[test]
fn mirrored_values_and_views() {
    /// Entries of two tables.
    const ENTRIES: f64 = 5e-4;
    let dims = [9, 10, 8];
    let bytes = random_bytes(dims, 12);
    let positive = volume(dims, DVec3::ONE, Voxels::Uint8(bytes.clone()));
    let negative = volume(dims, DVec3::ONE, Voxels::Uint8(bytes.iter().map(|b| 255 - b).collect()));
    let falling = TransferFunction::new("falling", vec![(0.0, [1.0; 3]), (255.0, [0.0; 3])], vec![(0.0, 0.5), (255.0, 0.0)]);
    let (falling, rising) = (falling.unwrap(), brightness(255.0));
    let size = viewport(21, 21);
    let (front, behind) = (parallel(&positive, size, 25.0, 0.0), parallel(&positive, size, 205.0, 0.0));
    for algorithm in algorithms() {
        let picture = |volume, transfer, camera, blend| render(volume, transfer, camera, size, &settings(algorithm, blend));
        let largest = picture(&positive, &rising, &front, Blend::Maximum);
        let smallest = picture(&negative, &falling, &front, Blend::Minimum);
        if !matches!(algorithm, Algorithm::Raycast { kernel: Kernel::Gaussian, .. }) {
            // Sums of a Gaussian have an error of 4 % of the distance from the smallest value.
            assert_close(&format!("{algorithm:?}"), &largest, &smallest, ENTRIES);
        }
        for blend in VALUES {
            let (one, other) = (picture(&positive, &rising, &front, blend), picture(&positive, &rising, &behind, blend));
            let mirrored = other.pixels().chunks(21).flat_map(|row| row.iter().rev().copied()).collect();
            assert_close(&format!("{algorithm:?} {blend:?}"), &one, &layersplat::Frame::new(size, mirrored), ENTRIES);
        }
    }
}

/// Modes that reduce values ignore the background. Stored numbers may decrease with increasing value.
#[test]
fn backgrounds_and_rescaled_values() {
    let dims = [9, 10, 8];
    let bytes = random_bytes(dims, 13);
    let size = viewport(21, 17);
    let plain = volume(dims, DVec3::ONE, Voxels::Uint8(bytes.clone()));
    let camera = parallel(&plain, size, 50.0, -20.0);
    let mirrored = bytes.iter().map(|&b| 255 - b).collect();
    let rescaled = volume(dims, DVec3::ONE, Voxels::Uint8(mirrored)).with_rescale(Rescale::new(-1.0, 255.0).unwrap());
    for background in [-300.0, 200.0, 900.0] {
        let volume = volume(dims, DVec3::ONE, Voxels::Uint8(bytes.clone())).with_background(background).unwrap();
        for algorithm in algorithms() {
            for blend in VALUES {
                let one = render(&plain, &smooth_transfer(), &camera, size, &settings(algorithm, blend));
                let other = render(&volume, &smooth_transfer(), &camera, size, &settings(algorithm, blend));
                assert_close(&format!("{algorithm:?} {blend:?}, {background} around"), &other, &one, DEVICE_TOLERANCE);
            }
        }
    }
    for algorithm in algorithms() {
        if matches!(algorithm, Algorithm::Raycast { kernel: Kernel::Gaussian, .. }) {
            // The Gaussian's sums have an error of 4 % of the distance from the smallest stored number.
            continue;
        }
        for blend in BLENDS.into_iter().filter(|&blend| has(algorithm, blend)) {
            let one = render(&plain, &smooth_transfer(), &camera, size, &settings(algorithm, blend));
            let other = render(&rescaled, &smooth_transfer(), &camera, size, &settings(algorithm, blend));
            assert_close(&format!("{algorithm:?} {blend:?}, rescaled"), &other, &one, DEVICE_TOLERANCE);
        }
    }
}

/// Where two layer axes are blended, pixels that are opaque in both stay opaque.
#[test]
fn opaque_between_two_axes() {
    let volume = volume([12; 3], DVec3::ONE, Voxels::Uint8(vec![100; 1728])).with_background(0.0).unwrap();
    let size = viewport(30, 30);
    let camera = parallel(&volume, size, 45.0, 0.0);
    let rays = layersplat::layers::Rays::new(&camera, size, volume.grid()).unwrap();
    for blend in [Blend::Maximum, Blend::Minimum, Blend::Average, Blend::Iso(50.0)] {
        let settings = Settings { shading: None, ..settings(Layered::default().into(), blend) };
        let plan = Plan::new(&rays, size, volume.grid(), &settings).unwrap();
        assert!(matches!(plan, Plan::Shared(..)), "{plan}");
        let pixel = render(&volume, &brightness(200.0), &camera, size, &settings).pixel(15, 15);
        let expected = if blend == Blend::Iso(50.0) { 0.25 } else { 0.5 };
        assert!((pixel[0] - expected).abs() < 1e-3 && (pixel[3] - 1.0).abs() < 1e-5, "{blend:?}: {pixel:?}");
    }
}

/// Invalid voxels have the background value, also in the voxel region, and also if it lies outside the range of the others.
#[test]
fn invalid_voxels_are_background() {
    let dims = [9, 10, 8];
    let bytes = random_bytes(dims, 14);
    let value = |n: usize| if n % 7 == 3 { f32::NAN } else { f32::from(bytes[n]) };
    let size = viewport(21, 17);
    for background in [-60.0, 300.0] {
        let volume = volume(dims, DVec3::ONE, Voxels::Float32((0..bytes.len()).map(value).collect()));
        let volume = volume.with_background(background).unwrap();
        let camera = parallel(&volume, size, 50.0, -20.0);
        let colors = vec![(-60.0, [0.0, 0.3, 1.0]), (300.0, [1.0, 0.8, 0.0])];
        let transfer = TransferFunction::new("wide", colors, vec![(0.0, 0.5), (255.0, 0.5)]).unwrap();
        for algorithm in [Layered::default().into(), Algorithm::Raycast { kernel: Kernel::Linear, step: 0.6 }] {
            for blend in VALUES {
                let pair = Pair::of(&volume, &transfer, &camera, size, &settings(algorithm, blend));
                pair.assert_same(&format!("{algorithm:?} {blend:?}, {background}"), DEVICE_TOLERANCE);
            }
        }
    }
}
