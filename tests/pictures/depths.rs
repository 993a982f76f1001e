//! Depths: closed forms of fog and of surfaces in both projections, and invariants of all algorithms.

use crate::common::*;
use glam::DVec3;
use layersplat::image::Depths;
use layersplat::layers::Kernel;
use layersplat::renderer::{UploadedColors, UploadedVolume};
use layersplat::settings::{Algorithm, Blend, Clipping, CropBox, GradientOpacity};
use layersplat::volume::{LabelSurfaces, Voxels};
use layersplat::{Camera, Error, Projection, Quality, Renderer, Settings, TransferFunction, Viewport, Volume};

/// Opacity is taken to grow linearly within half a spacing: an error of up to 5e-3 spacings in fog of a fifth per spacing.
const STEP_TOLERANCE: f64 = 1e-2;
/// Rounding over some hundred spacings.
const FLOAT_TOLERANCE: f64 = 2e-4;
/// Fraction of pixels for which two separately compiled programs may round the opacity to different sides of 1/256, and the largest
/// distance from it.
const RIM_SHARE: f64 = 2e-3;
const ROUNDED_OPACITY: f32 = 1e-5;
const N: usize = 40;
const ALPHA: f64 = 0.2;
const SIZE: [u32; 2] = [48, 40];

fn depths(volume: &Volume, transfer: &TransferFunction, camera: &Camera, settings: &Settings) -> Depths {
    let size = viewport(SIZE[0], SIZE[1]);
    Renderer::new(&device(), volume, transfer).unwrap().depths(camera, size, settings).unwrap()
}

/// Each voxel has the index of its layer along z.
fn ramp(spacing: f64) -> Volume<'static> {
    let values = (0..N * N * N).map(|i| (i / N / N) as f32).collect();
    volume([N; 3], DVec3::splat(spacing), Voxels::Float32(values)).with_background(0.0).unwrap()
}

fn fog() -> TransferFunction {
    TransferFunction::new("fog", vec![(0.0, [1.0; 3])], vec![(-1.0, ALPHA), (100.0, ALPHA)]).unwrap()
}

fn linear() -> Settings {
    with_kernel(Quality::Standard, Kernel::Linear).into()
}

/// Ray of a pixel: its point at depth 0, and the vector to depth 1.
fn ray(camera: &Camera, pixel: usize) -> (DVec3, DVec3) {
    let basis = camera.basis().unwrap();
    let [width, height] = SIZE.map(f64::from);
    let (column, row) = ((pixel as u32 % SIZE[0]) as f64 + 0.5, (pixel as u32 / SIZE[0]) as f64 + 0.5);
    let across = basis.right * ((2.0 * column - width) / height) + basis.up * (1.0 - 2.0 * row / height);
    match camera.projection {
        Projection::Parallel { scale } => (camera.position + across * scale, basis.forward),
        Projection::Perspective { field_of_view } => {
            (camera.position, basis.forward + across * (field_of_view.to_radians() / 2.0).tan())
        }
    }
}

/// Depth at which a pixel's ray crosses a z plane, if the crossing lies at least `within` voxels inside the volume.
fn meets(camera: &Camera, pixel: usize, z: f64, within: f64, spacing: f64) -> Option<f64> {
    let (from, way) = ray(camera, pixel);
    let depth = (z * spacing - from.z) / way.z;
    let at = (from + depth * way) / spacing;
    [at.x, at.y].iter().all(|c| (within..=N as f64 - 1.0 - within).contains(c)).then_some(depth)
}

/// Views along z from both ends, and an oblique view from below.
fn views(volume: &Volume) -> [Camera; 4] {
    let size = viewport(SIZE[0], SIZE[1]);
    [
        parallel(volume, size, 180.0, 0.0),
        perspective(volume, 180.0, 0.0, 40.0),
        parallel(volume, size, 160.0, -25.0),
        perspective(volume, 200.0, 15.0, 60.0),
    ]
}

/// A layer of fog between two planes: depth at which 1/256 of the light is absorbed, and mean depth of absorption.
#[test]
fn fog_is_met_where_its_closed_form_says() {
    let volume = ramp(1.0);
    let crop = CropBox { lowest: DVec3::new(0.0, 0.0, 10.0), highest: DVec3::new(39.0, 39.0, 30.0) };
    let clipping = Clipping { crop: Some(crop), ..Clipping::default() };
    let settings = Settings { clipping, early_termination: false, ..linear() };
    for camera in views(&volume) {
        let found = depths(&volume, &fog(), &camera, &settings);
        let mut seen = 0;
        let mut shifted = 0;
        for (pixel, (&first, &mean)) in found.first().iter().zip(found.mean()).enumerate() {
            let ends = [10.0, 30.0].map(|z| meets(&camera, pixel, z, 1.0, 1.0));
            let [Some(near), Some(far)] = ends else { continue };
            // Per unit of depth.
            let extinction = -(1.0 - ALPHA).ln() * ray(&camera, pixel).1.length();
            let gone = (-extinction * (far - near)).exp();
            let expected =
                [near + (256.0f64 / 255.0).ln() / extinction, near + 1.0 / extinction - (far - near) * gone / (1.0 - gone)];
            for (found, expected) in [first, mean].map(f64::from).into_iter().zip(expected) {
                assert!((found - expected).abs() <= STEP_TOLERANCE, "pixel {pixel} of {camera:?}: {found}, expected {expected}");
                shifted += usize::from((found + 0.25 - expected).abs() > STEP_TOLERANCE);
            }
            seen += 1;
        }
        assert!(seen > 100 && shifted == 2 * seen, "{seen} pixels seen; a quarter of a spacing is noticed in {shifted} numbers");
    }
}

/// The extinction of a slab of labels rises linearly from the layer in front of it: depth at which 1/256 of the light is absorbed.
#[test]
fn labels_are_met_where_their_closed_form_says() {
    const FIRST: usize = 12;
    let ids = (0..N * N * N).map(|i| u8::from((FIRST..25).contains(&(i / N / N)))).collect();
    let volume = volume([N; 3], DVec3::ONE, Voxels::Uint8(ids));
    let labels = UploadedVolume::new(&device(), &volume).unwrap();
    let colors = UploadedColors::from_labels(&[(&labels, &[[0.0; 4], [0.9, 0.2, 0.1, ALPHA]])], LabelSurfaces::Voxels).unwrap();
    let mut renderer = Renderer::from_colors(&colors).unwrap();
    let cast = Settings { algorithm: converged(Kernel::Linear), ..Settings::default() };
    let size = viewport(SIZE[0], SIZE[1]);
    for camera in views(&volume) {
        let found = renderer.depths(&camera, size, &cast).unwrap();
        let (mut seen, mut shifted) = (0, 0);
        for (pixel, &first) in found.first().iter().enumerate() {
            let way = ray(&camera, pixel).1;
            let rise = (2.0 * (256.0f64 / 255.0).ln() * way.z / way.length() / -(1.0 - ALPHA).ln()).sqrt();
            let Some(expected) = meets(&camera, pixel, FIRST as f64 - 1.0 + rise, 1.0, 1.0) else { continue };
            let first = f64::from(first);
            assert!((first - expected).abs() <= STEP_TOLERANCE, "pixel {pixel} of {camera:?}: {first}, expected {expected}");
            shifted += usize::from((first + 0.25 - expected).abs() > STEP_TOLERANCE);
            seen += 1;
        }
        assert!(seen > 100 && shifted == seen, "{seen} pixels seen; a quarter of a spacing is noticed in {shifted}");
        // The kernels of the default settings, which have negative weights, are replaced as in the picture.
        let sharp = Settings { algorithm: with_kernel(Quality::Standard, Kernel::CatmullRom).into(), ..Settings::default() };
        let soft = Settings { algorithm: with_kernel(Quality::Standard, Kernel::Cubic).into(), ..Settings::default() };
        assert!(renderer.depths(&camera, size, &sharp).unwrap() == renderer.depths(&camera, size, &soft).unwrap());
    }
}

/// An iso-surface plane in worlds of any unit; with ray casting as with layers.
#[test]
fn surfaces_are_where_the_field_has_their_value() {
    for spacing in [1.0, 1e-9, 1e12] {
        let volume = ramp(spacing);
        for camera in views(&volume) {
            for algorithm in [linear().algorithm, Algorithm::Raycast { kernel: Kernel::Linear, step: 0.7 }] {
                let settings = Settings { blend: Blend::Iso(7.3), algorithm, ..Settings::default() };
                let found = depths(&volume, &fog(), &camera, &settings);
                let pixels = 0..found.first().len();
                let expected: Vec<_> = pixels.filter_map(|p| Some((p, meets(&camera, p, 7.3, 1.0, spacing)?))).collect();
                assert!(expected.len() > 100);
                for (pixel, expected) in expected {
                    for found in [found.first()[pixel], found.mean()[pixel]].map(f64::from) {
                        assert!(
                            (found - expected).abs() <= FLOAT_TOLERANCE * spacing,
                            "pixel {pixel}: {found}, expected {expected}"
                        );
                    }
                }
            }
        }
    }
}

/// Visible pixels have a depth, others do not. The mean depth is at least the first, and inside the volume.
#[test]
fn depths_are_where_something_is_seen() {
    let volume = random_volume([31, 22, 27], DVec3::new(1.0, 1.4, 0.9), 5);
    let size = viewport(SIZE[0], SIZE[1]);
    let edges = GradientOpacity::new(&[(20.0, 0.0), (60.0, 1.0)]).unwrap();
    for gradient_opacity in [None, Some(edges)] {
        for camera in [parallel(&volume, size, 30.0, 20.0), perspective(&volume, 250.0, -40.0, 50.0)] {
            let settings = Settings { gradient_opacity, ..Settings::default() };
            let found = depths(&volume, &smooth_transfer(), &camera, &settings);
            let cast = Settings { algorithm: Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.5 }, ..settings };
            let picture = render(&volume, &smooth_transfer(), &camera, size, &cast);
            let visible = |alpha: f32| alpha >= 1.0 / 256.0;
            let both = found.first().iter().zip(picture.pixels());
            let apart: Vec<f32> = both.filter(|(first, p)| first.is_finite() != visible(p[3])).map(|(_, p)| p[3]).collect();
            assert!(apart.iter().all(|alpha| (alpha - 1.0 / 256.0).abs() <= ROUNDED_OPACITY), "opacities of {apart:?}");
            let apart = apart.len();
            assert!(
                apart as f64 <= RIM_SHARE * picture.pixels().len() as f64,
                "{apart} pixels have depths and show nothing, or the reverse"
            );
            let seen = found.first().iter().filter(|first| first.is_finite()).count();
            assert!((100..picture.pixels().len() - 100).contains(&seen), "{seen} pixels are seen");
            let (middle, radius) = ((volume.grid().centre() - camera.position).length(), volume.grid().diagonal() / 2.0 + 2.0);
            for (first, mean) in found.first().iter().zip(found.mean()).filter(|(first, _)| first.is_finite()) {
                assert!(
                    first <= mean && (f64::from(*first) - middle).abs() < radius && (f64::from(*mean) - middle).abs() < radius
                );
            }
        }
    }
    let hidden = Settings { gradient_opacity: Some(GradientOpacity::new(&[(0.0, 0.0)]).unwrap()), ..Settings::default() };
    let nothing = depths(&volume, &smooth_transfer(), &parallel(&volume, size, 30.0, 20.0), &hidden);
    assert!(nothing.first().iter().chain(nothing.mean()).all(|&depth| depth == f32::INFINITY));
}

#[test]
fn what_has_no_depth_is_refused() {
    let volume = ramp(1.0);
    let size = viewport(8, 8);
    let mut renderer = Renderer::new(&device(), &volume, &fog()).unwrap();
    let camera = parallel(&volume, size, 10.0, 20.0);
    for blend in [Blend::Maximum, Blend::Minimum, Blend::Average] {
        let refused = renderer.depths(&camera, size, &Settings { blend, ..Settings::default() });
        assert!(matches!(refused, Err(Error::Settings { field: "blend", .. })), "{blend:?}: {refused:?}");
    }
    // The renderer remains usable.
    assert!(renderer.depths(&camera, size, &Settings::default()).unwrap().first().iter().any(|depth| depth.is_finite()));
}

#[test]
fn exr_files_have_depths_beside_the_picture() {
    use exr::prelude::*;
    let volume = ramp(1.0);
    let size = viewport(SIZE[0], SIZE[1]);
    let camera = perspective(&volume, 200.0, 20.0, 40.0);
    let found = depths(&volume, &fog(), &camera, &Settings::default());
    let picture = render(&volume, &fog(), &camera, size, &Settings::default());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    picture.save_with_depths(&path, None, &found).unwrap();
    assert_eq!(layersplat::image::read_image(&path).unwrap(), picture);
    let layer = read_first_flat_layer_from_file(&path).unwrap().layer_data;
    let channel = |name: &str| -> Vec<f32> {
        let channel = layer.channel_data.list.iter().find(|channel| channel.name.to_string() == name).expect(name);
        channel.sample_data.values_as_f32().collect()
    };
    assert_eq!((channel("Z"), channel("mean.Z")), (found.first().to_vec(), found.mean().to_vec()));
    assert!(picture.save_with_depths(folder.path().join("a.png"), None, &found).is_err());
    let other = layersplat::Frame::new(Viewport::new(1, 1).unwrap(), vec![[0.0; 4]]);
    assert!(other.save_with_depths(&path, None, &found).is_err());
    assert_eq!(layersplat::image::read_image(&path).unwrap(), picture, "a rejected write must not change the file");
}
