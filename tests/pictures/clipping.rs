//! Crop boxes and clip planes: every algorithm and blend mode against the f64 reference, closed forms and symmetries.

use crate::common::blends::*;
use crate::common::reference::Pair;
use crate::common::*;
use glam::{DMat3, DQuat, DVec3};
use layersplat::layers::{Density, Kernel, Rays};
use layersplat::reference::{Integral, Layered as LayeredReference};
use layersplat::renderer::Plan;
use layersplat::settings::{Algorithm, Blend, Classification, ClipPlane, Clipping, CropBox, Evaluation, Layered};
use layersplat::volume::{Grid, Voxels};
use layersplat::{Camera, Frame, Orbit, Settings, TransferFunction, Volume};

/// The same numbers in another order, or in another specialisation of a kernel.
const ROUNDING: f64 = 2e-5;

#[test]
fn every_algorithm_is_the_reference() {
    let volume = bump();
    let size = viewport(23, 19);
    let views =
        [parallel(&volume, size, 33.0, 21.0), perspective(&volume, -70.0, 15.0, 35.0), parallel(&volume, size, 200.0, 10.0)];
    for algorithm in compositing() {
        let settings = composited(algorithm, cuts());
        for (n, camera) in views.iter().enumerate() {
            let pair = Pair::of(&volume, &smooth_transfer(), camera, size, &settings);
            pair.assert_same(&format!("{algorithm:?}, view {n}"), tolerance_of(&settings, n != 1));
        }
    }
}

#[test]
fn every_blend_mode_is_the_reference() {
    let volume = bump();
    let size = viewport(23, 19);
    let far = perspective(&volume, -70.0, 15.0, 30.0);
    let near = Camera { position: far.focal_point + (far.position - far.focal_point) * 0.7, ..far };
    let views = [parallel(&volume, size, 33.0, 21.0), near];
    assert_every_blend(&volume, views, size, cuts());
}

/// Eyes inside the volume, and backgrounds that are visible throughout the support.
#[test]
fn eyes_inside_and_visible_backgrounds() {
    let volume = bump();
    let size = viewport(24, 18);
    let outside = perspective(&volume, 30.0, 20.0, 60.0);
    let eye = outside.focal_point + (outside.position - outside.focal_point).normalize() * 1.6;
    let fog = TransferFunction::new("fog", vec![(-40.0, [1.0, 0.5, 0.2])], vec![(-40.0, 0.05), (255.0, 0.3)]).unwrap();
    let views = [(Camera { position: eye, ..outside }, smooth_transfer()), (parallel(&volume, size, 25.0, 35.0), fog)];
    for algorithm in compositing() {
        for (camera, transfer) in &views {
            let settings = composited(algorithm, cuts());
            let rays = Rays::new(camera, size, volume.grid()).unwrap();
            let plan = Plan::new(&rays, size, volume.grid(), &settings).unwrap();
            let splatted = matches!(algorithm, Algorithm::AxisSheets { .. }) && transfer.name() == "fog";
            if splatted || matches!(plan, Plan::CastSegments(..)) {
                // Axis-aligned sheets do not show the background; cast segments are tested below.
                continue;
            }
            let pair = Pair::of(&volume, transfer, camera, size, &settings);
            pair.assert_allowed(&format!("{algorithm:?}, {}", transfer.name()), tolerance_of(&settings, true));
        }
    }
}

/// Cases without an f64 counterpart: ray casting in segments, and pictures blended from two axes. Compared with the integral.
#[test]
fn cast_segments_and_shared_axes_are_the_integral() {
    /// In dB; measured 36.5 and more.
    const LEAST: f64 = 35.0;
    let volume = Volume::open("builtin:hydrogen@24", &layersplat::OpenOptions::default()).unwrap();
    let transfer = smooth_transfer();
    let size = viewport(40, 40);
    let planes = [plane([9.0, 12.0, 9.0], [1.0, 0.3, 0.5])];
    let clipping = crop([2.3, 4.2, 3.1], [19.4, 13.7, 21.9]).with_planes(planes);
    let wide = perspective(&volume, 45.0, 20.0, 100.0);
    for (camera, expected) in [(wide, "pre-integrated in steps"), (parallel(&volume, size, 45.5, 10.0), " of a lattice")] {
        let settings = Settings { shading: None, ..composited(Layered::default().into(), clipping) };
        let rays = Rays::new(&camera, size, volume.grid()).unwrap();
        let plan = Plan::new(&rays, size, volume.grid(), &settings).unwrap().to_string();
        assert!(plan.contains(expected), "{plan}");
        let mut integral = Integral::new(&volume, &transfer, None);
        let whole = integral.render(&camera, size).unwrap();
        integral.clipping = clipping;
        let found = render(&volume, &transfer, &camera, size, &settings);
        let near = compare(&found, &integral.render(&camera, size).unwrap()).psnr_rgba.unwrap();
        let far = compare(&found, &whole).psnr_rgba.unwrap();
        assert!(near > LEAST && far < 30.0, "{plan}: {near} dB, and {far} without cuts");
    }
}

/// Comparisons must detect these errors.
#[test]
fn errors_are_noticed() {
    let volume = bump();
    let size = viewport(23, 19);
    let camera = parallel(&volume, size, 33.0, 21.0);
    let flipped = plane([3.1, 2.2, 12.0], [-1.0, -0.4, 0.6]);
    let half = crop([1.8, 1.3, 2.87], [9.21, 20.5, 11.7]).with_planes(cuts().planes.into_iter().flatten());
    let one_plane =
        Clipping { planes: Clipping::default().with_planes(cuts().planes.into_iter().flatten().take(1)).planes, ..cuts() };
    let wrong = [
        ("no cuts", Clipping::default()),
        ("half a voxel off", half),
        ("a plane from behind", cuts().with_planes([flipped])),
        ("one plane of two", one_plane),
        ("no crop", Clipping { crop: None, ..cuts() }),
    ];
    for algorithm in compositing() {
        let right = composited(algorithm, cuts());
        for (what, clipping) in wrong {
            let pair = Pair::against(&volume, &smooth_transfer(), &camera, size, &right, &composited(algorithm, clipping));
            let share = pair.differing(tolerance_of(&right, true));
            assert!(share > 0.03, "{algorithm:?}: {what} changes only {share} of the rays");
        }
    }
}

/// A homogeneous block of 200 with a known length inside the crop box.
#[test]
fn beer_lambert_through_a_crop() {
    /// Rounding and table error over tens of samples; below, the ripple of a Gaussian's lattice sums.
    const FLOATS: f64 = 2e-3;
    const RIPPLE: f64 = 0.05;
    let tau = 0.05;
    let volume = volume([16; 3], DVec3::ONE, Voxels::Uint8(vec![200; 4096])).with_background(0.0).unwrap();
    let opacities = (0..=255).map(|v| (f64::from(v), -(-tau * f64::from(v) / 200.0).exp_m1())).collect();
    let transfer = TransferFunction::new("ramp", vec![(0.0, [1.0; 3])], opacities).unwrap();
    let size = viewport(7, 7);
    let box_of = [([4.3, 3.1, 5.6], [11.2, 12.9, 9.9]), ([3.2, 4.45, 4.0], [12.0, 11.0, 11.5])];
    for (lowest, highest) in box_of {
        for (azimuth, elevation) in [(0.0, 0.0), (90.0, 0.0), (0.0, -90.0), (20.0, 10.0)] {
            let camera = scaled(parallel(&volume, size, azimuth, elevation), 0.5);
            let rays = Rays::new(&camera, size, volume.grid()).unwrap();
            for algorithm in compositing() {
                let settings = Settings { shading: None, ..composited(algorithm, crop(lowest, highest)) };
                let rippling = matches!(
                    algorithm,
                    Algorithm::AxisSheets { .. }
                        | Algorithm::ViewSheets { .. }
                        | Algorithm::Raycast { kernel: Kernel::Gaussian, .. }
                );
                let frame = render(&volume, &transfer, &camera, size, &settings);
                for (n, pixel) in frame.pixels().iter().enumerate() {
                    let ray = rays.at((n % 7) as f64 + 0.5, (n / 7) as f64 + 0.5);
                    let (enter, leave) = span_in(&ray, lowest, highest);
                    let length = (leave - enter) * ray.direction.length();
                    let depth = -(1.0 - f64::from(pixel[3])).ln() / tau;
                    let limit = if rippling { RIPPLE * length } else { FLOATS * length };
                    assert!((depth - length).abs() < limit, "{algorithm:?} {azimuth} {elevation}: {depth} for {length}");
                }
            }
        }
    }
}

/// Clip planes at the faces of a crop box cut like it, also on a rotated grid. Clipping outside the volume changes nothing.
#[test]
fn planes_at_the_faces_are_the_crop() {
    let turned = DMat3::from_quat(DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -0.3, 1.1));
    let grid = Grid::oriented([11, 8, 13], DVec3::new(1.0, 0.7, 1.3), DVec3::new(5.0, -3.0, 2.0), turned).unwrap();
    let volume =
        Volume::new("turned", grid, Voxels::Uint8(random_bytes([11, 8, 13], 21))).unwrap().with_background(-40.0).unwrap();
    let (lowest, highest) = ([1.3, 0.8, 2.37], [8.71, 5.2, 11.2]);
    let to_world = volume.grid().index_to_world();
    let face = |i: usize, at: [f64; 3], sign: f64| ClipPlane {
        point: to_world.transform_point3(at.into()),
        normal: turned * (DVec3::AXES[i] * sign * 3.0),
    };
    let faces = (0..3).flat_map(|i| [face(i, lowest, 1.0), face(i, highest, -1.0)]);
    let by_planes = Clipping::default().with_planes(faces);
    let far = crop([-90.0; 3], [70.0; 3]).with_planes([ClipPlane { point: DVec3::splat(-90.0), normal: DVec3::ONE }]);
    let size = viewport(23, 19);
    for camera in [parallel(&volume, size, 33.0, 21.0), perspective(&volume, -70.0, 15.0, 35.0)] {
        for algorithm in compositing() {
            let [boxed, planed, nearly_all, all] = [crop(lowest, highest), by_planes, far, Clipping::default()]
                .map(|clipping| render(&volume, &smooth_transfer(), &camera, size, &composited(algorithm, clipping)));
            assert_close(&format!("{algorithm:?}, planes"), &boxed, &planed, 10.0 * ROUNDING);
            assert_close(&format!("{algorithm:?}, far away"), &nearly_all, &all, 10.0 * ROUNDING);
            assert!(compare(&boxed, &all).max_difference > 0.05, "{algorithm:?}: the crop must be seen");
        }
    }
}

/// An invisible support boundary does not clip: samples of steps that cross it remain, and surfaces between the outermost voxels and the
/// background have no holes.
#[test]
fn an_invisible_end_of_the_field_is_no_cut() {
    let volume = volume([9, 8, 10], DVec3::new(1.0, 1.2, 0.9), Voxels::Uint8(vec![200; 720])).with_background(0.0).unwrap();
    let far = crop([-90.0; 3], [70.0; 3]);
    let size = viewport(23, 19);
    for camera in [parallel(&volume, size, 33.0, 21.0), perspective(&volume, -70.0, 15.0, 35.0)] {
        for algorithm in compositing() {
            let [nearly_all, all] = [far, Clipping::default()]
                .map(|clipping| render(&volume, &smooth_transfer(), &camera, size, &composited(algorithm, clipping)));
            assert_close(&format!("{algorithm:?}"), &nearly_all, &all, 10.0 * ROUNDING);
        }
        let surface = Blend::Iso(100.0);
        for algorithm in algorithms().into_iter().filter(|&a| has(a, surface)) {
            let pair = Pair::of(&volume, &smooth_transfer(), &camera, size, &settings(algorithm, surface));
            pair.assert_same(&format!("{algorithm:?}, a surface"), REFINED_TOLERANCE);
        }
    }
}

/// Rays along or in a face are inside the box over their whole length or not at all.
#[test]
fn rays_in_a_face() {
    let volume = volume([12; 3], DVec3::ONE, Voxels::Uint8(vec![200; 1728])).with_background(0.0).unwrap();
    let size = viewport(12, 12);
    // Pixel centres lie at integer voxel coordinates.
    let camera = scaled(parallel(&volume, size, 0.0, 0.0), 6.0);
    for algorithm in [
        Algorithm::Raycast { kernel: Kernel::Linear, step: 0.6 },
        Layered { evaluation: Evaluation::Direct, ..Layered::default() }.into(),
        Layered { evaluation: Evaluation::Lattice(Density::Fixed(1)), ..Layered::default() }.into(),
    ] {
        let settings = Settings { shading: None, ..composited(algorithm, crop([3.0, -9.0, -9.0], [30.0, 8.0, 30.0])) };
        let frame = render(&volume, &smooth_transfer(), &camera, size, &settings);
        let whole = frame.pixel(6, 6)[3];
        let partial = frame.pixels().iter().filter(|p| p[3] > 0.01 * whole && p[3] < 0.99 * whole).count();
        assert!(whole > 0.9 && partial == 0, "{algorithm:?}: {partial} rays are partly clipped");
        // Modes that reduce values include all voxels, also the outermost.
        let values = clipped(algorithm, Blend::Average, Clipping::default());
        let frame = render(&volume, &smooth_transfer(), &camera, size, &values);
        assert!(frame.pixels().iter().all(|p| p[3] == 0.0 || p[0] == frame.pixel(6, 6)[0]), "{algorithm:?}");
    }
}

/// Permuting the axes of volume, crop box and camera together does not change the picture.
#[test]
fn permuted_axes() {
    let (dims, bytes) = ([11, 8, 13], random_bytes([11, 8, 13], 4));
    let at = |p: [usize; 3]| bytes[p[0] + 11 * (p[1] + 8 * p[2])];
    let turn = |v: DVec3| DVec3::new(v.z, v.x, v.y);
    let turned_dims = [dims[2], dims[0], dims[1]];
    let turned = (0..bytes.len()).map(|n| {
        let (i, j, k) = (n % 13, n / 13 % 11, n / 143);
        at([j, k, i])
    });
    let one = volume(dims, DVec3::ONE, Voxels::Uint8(bytes.clone())).with_background(0.0).unwrap();
    let other = volume(turned_dims, DVec3::ONE, Voxels::Uint8(turned.collect())).with_background(0.0).unwrap();
    let size = viewport(23, 19);
    let clip = |turn: &dyn Fn(DVec3) -> DVec3| {
        let plane = |p: ClipPlane| ClipPlane { point: turn(p.point), normal: turn(p.normal) };
        let crop = cuts().crop.map(|c| CropBox { lowest: turn(c.lowest), highest: turn(c.highest) });
        Clipping { crop, ..Clipping::default() }.with_planes(cuts().planes.into_iter().flatten().map(plane))
    };
    for camera in [parallel(&one, size, 33.0, 21.0), perspective(&one, -70.0, 15.0, 35.0)] {
        let [position, focal_point, view_up] = [camera.position, camera.focal_point, camera.view_up].map(turn);
        let turned_camera = Camera { position, focal_point, view_up, ..camera };
        for algorithm in compositing() {
            let first = render(&one, &smooth_transfer(), &camera, size, &composited(algorithm, clip(&|v| v)));
            let second = render(&other, &smooth_transfer(), &turned_camera, size, &composited(algorithm, clip(&turn)));
            assert_close(&format!("{algorithm:?}"), &first, &second, DEVICE_TOLERANCE);
        }
    }
}

/// A crop box does not change the field: two voxels inside it, the picture equals that of a file with the cropped voxels only.
#[test]
fn two_voxels_inside_it_is_the_cropped_file() {
    let (inner, outer, dims) = ([10, 9, 11], [24, 21, 23], [24usize, 21, 23]);
    // Equal margins on both sides, because planes perpendicular to the view start from the centre of both.
    let first: [usize; 3] = std::array::from_fn(|i| (outer[i] - inner[i]) / 2);
    let noise = random_bytes(dims, 9);
    let value = |p: [usize; 3]| {
        let depth =
            (0..3).map(|i| (p[i] as i64 - first[i] as i64).min((first[i] + inner[i]) as i64 - 1 - p[i] as i64)).min().unwrap();
        // Noise from two voxels inside on, 0 around the cut, and noise outside again. Gradients are relative to the range, which must be equal in
        // both files.
        if p == dims.map(|n| n / 2) {
            return 255;
        }
        if (-2..2).contains(&depth) { 0 } else { noise[p[0] + dims[0] * (p[1] + dims[1] * p[2])].max(1) }
    };
    let voxels = |from: [usize; 3], dims: [usize; 3]| {
        let of = |n: usize| value([from[0] + n % dims[0], from[1] + n / dims[0] % dims[1], from[2] + n / (dims[0] * dims[1])]);
        (0..dims.iter().product()).map(of).collect::<Vec<u8>>()
    };
    let whole = volume(outer, DVec3::ONE, Voxels::Uint8(voxels([0; 3], outer))).with_background(0.0).unwrap();
    let origin = DVec3::from_array(first.map(|n| n as f64));
    let grid = Grid::oriented(inner, DVec3::ONE, origin, DMat3::IDENTITY).unwrap();
    let small = Volume::new("cropped", grid, Voxels::Uint8(voxels(first, inner))).unwrap().with_background(0.0).unwrap();
    assert_eq!(small.range(), whole.range());
    let last = std::array::from_fn(|i| first[i] as f64 + inner[i] as f64 - 1.0);
    let size = viewport(33, 29);
    let orbit = Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
    let camera = Camera::fit_parallel(small.grid().centre(), small.grid().diagonal(), size, orbit);
    for algorithm in compositing() {
        let settings = |clipping| composited(algorithm, clipping);
        let cropped = render(&whole, &smooth_transfer(), &camera, size, &settings(crop(first.map(|n| n as f64), last)));
        let expected = render(&small, &smooth_transfer(), &camera, size, &settings(Clipping::default()));
        assert_close(&format!("{algorithm:?}"), &cropped, &expected, DEVICE_TOLERANCE);
        let uncropped = render(&whole, &smooth_transfer(), &camera, size, &settings(Clipping::default()));
        assert!(
            compare(&uncropped, &expected).max_difference > 0.2,
            "{algorithm:?}: the surroundings must be visible without a crop box"
        );
    }
}

fn differing_bits(a: &Frame, b: &Frame) -> usize {
    a.pixels().iter().zip(b.pixels()).filter(|(a, b)| a.map(f32::to_bits) != b.map(f32::to_bits)).count()
}

#[test]
fn culling_changes_no_bit() {
    let volume = mostly_empty();
    let size = viewport(40, 36);
    let planes = [plane([12.0, 9.0, 14.0], [1.0, 0.4, -0.6])];
    let clipping = crop([1.3, 0.8, 2.37], [36.1, 20.0, 27.2]).with_planes(planes);
    for camera in [parallel(&volume, size, 20.0, 15.0), perspective(&volume, 200.0, -30.0, 40.0)] {
        let with_blends = algorithms().into_iter().flat_map(|a| BLENDS.map(|blend| (a, blend)));
        let cases = compositing().into_iter().map(|a| (a, Blend::Composite)).chain(with_blends);
        for (algorithm, blend) in cases.filter(|&(a, blend)| has(a, blend)) {
            let settings = clipped(algorithm, blend, clipping);
            let [culled, all] = [true, false]
                .map(|culling| render(&volume, &smooth_transfer(), &camera, size, &Settings { culling, ..settings }));
            if matches!(algorithm, Algorithm::ViewSheets { .. }) {
                // Omitted splats weigh less than a thousandth (ARCHITECTURE.md).
                assert_close(&format!("{algorithm:?}"), &culled, &all, DEVICE_TOLERANCE);
            } else {
                assert_eq!(differing_bits(&culled, &all), 0, "{algorithm:?} {blend:?}: pixels with other bits");
            }
            assert!(largest_opacity(&culled) > 0.2, "{algorithm:?} {blend:?}: nothing to see");
        }
    }
}

/// A crop box beside the volume leaves nothing, nor do two clip planes that face away from each other.
#[test]
fn nothing_is_left_of_what_lies_elsewhere() {
    let volume = bump();
    let fog = TransferFunction::new("fog", vec![(-40.0, [1.0; 3])], vec![(-40.0, 0.3), (255.0, 0.3)]).unwrap();
    let size = viewport(15, 15);
    let camera = parallel(&volume, size, 33.0, 21.0);
    let away = [plane([6.0, 0.0, 0.0], [1.0, 0.0, 0.0]), plane([5.0, 0.0, 0.0], [-1.0, 0.0, 0.0])];
    for clipping in [crop([20.0, 0.0, 0.0], [30.0, 7.0, 12.0]), Clipping::default().with_planes(away)] {
        let with_blends = algorithms().into_iter().flat_map(|a| BLENDS.map(|blend| (a, blend)));
        let cases = compositing().into_iter().map(|a| (a, Blend::Composite)).chain(with_blends);
        for (algorithm, blend) in cases.filter(|&(a, blend)| has(a, blend)) {
            let found = render(&volume, &fog, &camera, size, &clipped(algorithm, blend, clipping));
            let shown = found.pixels().iter().filter(|p| **p != [0.0; 4]).count();
            assert_eq!(shown, 0, "{algorithm:?} {blend:?}: pixels that are not transparent");
        }
    }
}

/// Opaque segments of several hues are subdivided: only the unclipped rest of them.
#[test]
fn deep_segments_are_cut_before_they_are_parted() {
    /// In dB, as for whole segments (device_vs_reference.rs).
    const LEAST: f64 = 50.0;
    let (volume, hues) = block_of_hues();
    let size = viewport(20, 20);
    // Clips segments between 0 and 255.
    let (cut, whole) = (crop([4.3, 4.35, 4.4], [14.7, 14.6, 14.55]), crop([-5.0; 3], [30.0; 3]));
    for samples_per_layer in [1, 2] {
        let classification = Classification::Preintegrated { kernel: Kernel::Cubic, samples_per_layer };
        let layered = Layered { classification, evaluation: Evaluation::Direct, ..Layered::default() };
        for (azimuth, elevation) in [(0.0, 0.0), (90.0, 0.0), (183.0, -5.0)] {
            let camera = parallel(&volume, size, azimuth, elevation);
            let settings = composited(layered.into(), cut);
            let found = render(&volume, &hues, &camera, size, &settings);
            let axis = direct_axis(&volume, &camera, size, &settings);
            let psnr = |clipping| {
                let settings = composited(layered.into(), clipping);
                let mut reference = LayeredReference::new(&volume, &hues, &settings);
                reference.in_parts = true;
                compare(&found, &reference.render(&camera, size, axis).unwrap()).psnr.unwrap()
            };
            let (near, far) = (psnr(cut), psnr(whole));
            let what = format!("{samples_per_layer} samples at {azimuth}, {elevation}");
            assert!(near > LEAST && far < near - 6.0, "{what}: {near} dB, and {far} without the cuts");
        }
    }
}
