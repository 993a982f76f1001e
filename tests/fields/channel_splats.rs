//! Splatted layers of several fields against the f64 reference, and in closed form.

use crate::common::*;
use glam::DVec3;
use layersplat::layers::{Correction, Rays};
use layersplat::reference::Layered as LayeredReference;
use layersplat::renderer::{Channel, UploadedVolume};
use layersplat::settings::{Blend, Classification, Clipping, CropBox, GradientOpacity, Layered};
use layersplat::transfer::Extinction;
use layersplat::{Camera, Error, GradientEstimator, Renderer, Settings, TransferFunction, Viewport, Volume};

/// As for one field: eight quadrature nodes approximate the footprints of a perspective (tests/pictures/device_vs_reference.rs).
const QUADRATURE_TOLERANCE: f64 = 1.5e-2;
/// Of the lattice samples of both fields, in dB below the worse of the fields alone.
const SLACK: f64 = 1.0;
/// In dB. Several fields are splatted in tiles, with eight quadrature nodes, also on devices that splat one field with exact footprints.
const OF_TILES: f64 = 75.0;

/// A volume and its transfer function and factor.
struct Field {
    volume: Volume<'static>,
    transfer: TransferFunction,
    factor: f64,
}

fn fields(dims: [usize; 3]) -> [Field; 2] {
    let spacing = DVec3::new(1.0, 0.7, 1.3);
    let reds = vec![(0.0, [0.9, 0.1, 0.2]), (255.0, [1.0, 0.9, 0.1])];
    let other = TransferFunction::new("reds", reds, vec![(0.0, 0.0), (60.0, 0.0), (160.0, 0.3), (255.0, 0.1)]).unwrap();
    let [one, two] = [1, 2].map(|seed| random_volume(dims, spacing, seed));
    [Field { volume: one, transfer: smooth_transfer(), factor: 0.7 }, Field { volume: two, transfer: other, factor: 1.6 }]
}

fn post(correction: Correction) -> Settings {
    let algorithm = Layered { classification: Classification::Post(correction), ..Layered::default() }.into();
    Settings { algorithm, early_termination: false, ..Settings::default() }
}

fn renderer(fields: &[&Field]) -> Renderer {
    let channel = |field: &&Field| {
        let uploaded = UploadedVolume::new(&device(), &field.volume).unwrap();
        Channel::new(&uploaded, &field.transfer).with_factor(field.factor).unwrap()
    };
    Renderer::from_channels(&fields.iter().map(channel).collect::<Vec<_>>()).unwrap()
}

/// Largest difference of a lattice sample, before the warp, from the reference on the same ray, and PSNR in dB. `factors`: of the reference.
fn apart(fields: &[&Field], factors: &[f64], camera: &Camera, size: Viewport, settings: &Settings) -> (f64, f64) {
    let picture = renderer(fields).lattice_picture(camera, size, settings).unwrap().expect("a lattice");
    let rays = Rays::new(camera, size, fields[0].volume.grid()).unwrap();
    let axis = layersplat::layers::Axis::most_parallel(rays.central_direction());
    let reference = |n: usize| {
        let Field { volume, transfer, .. } = fields[n];
        LayeredReference::new(volume, transfer, settings).with_factor(factors[n])
    };
    let all = (1..fields.len()).fold(reference(0), |all, n| all.with_field(reference(n)));
    let [columns, rows] = picture.size;
    let (mut largest, mut squares, mut seen) = (0.0f64, 0.0, 0.0f64);
    for sample in 0..columns * rows {
        let expected = all.composite(&picture.ray(sample % columns, sample / columns), Some(axis), rays.to_eye);
        for (e, f) in expected.iter().zip(picture.samples[sample as usize]) {
            let difference = (e - f64::from(f)).abs();
            (largest, squares) = (largest.max(difference), squares + difference * difference);
        }
        seen = seen.max(expected[3]);
    }
    assert!(seen > 0.1, "nothing to see");
    (largest, -10.0 * (squares / f64::from(4 * columns * rows)).log10())
}

#[track_caller]
fn check(what: &str, camera: &Camera, tolerance: f64, fields: [&Field; 2], settings: &Settings) {
    let size = viewport(24, 20);
    let factors = fields.map(|field| field.factor);
    let [one, other] = [0, 1].map(|n| apart(&fields[n..=n], &factors[n..=n], camera, size, settings));
    let both = apart(&fields, &factors, camera, size, settings);
    println!("{what}: {:.1} and {:.1} alone, {:.1} dB together, off by {:.1e}", one.1, other.1, both.1, both.0);
    assert!(both.0 <= tolerance, "{what}: {}", both.0);
    assert!(both.1 >= (one.1.min(other.1) - SLACK).min(OF_TILES), "{what}: {}, {}, {}", one.1, other.1, both.1);
    // A factor that is off by a tenth would be noticed.
    let wrong = apart(&fields, &[factors[0], 1.1 * factors[1]], camera, size, settings);
    assert!(wrong.0 > 2.0 * both.0 && wrong.1 < both.1 - 6.0, "{what}: {wrong:?} against {both:?}");
}

#[test]
fn two_fields_have_the_splatted_layers_of_their_sum() {
    let fields = fields([11, 8, 13]);
    let fields = fields.each_ref();
    let volume = &fields[0].volume;
    let views = [(30.0, 20.0), (200.0, -35.0), (72.0, 64.0), (90.0, 0.0)];
    let cameras = views.map(|(azimuth, elevation)| parallel(volume, viewport(24, 20), azimuth, elevation));
    for (n, camera) in cameras.iter().enumerate() {
        let [one, several] = [Correction::Constant, Correction::SubLayers(2)].map(post);
        check(&format!("view {n}, lit"), camera, DEVICE_TOLERANCE, fields, &one);
        check(&format!("view {n}, unlit"), camera, DEVICE_TOLERANCE, fields, &Settings { shading: None, ..several });
    }
    for (azimuth, field_of_view) in [(30.0, 20.0), (110.0, 40.0)] {
        let camera = perspective(volume, azimuth, 15.0, field_of_view);
        check(
            &format!("perspective of {field_of_view} degrees"),
            &camera,
            QUADRATURE_TOLERANCE,
            fields,
            &post(Correction::SubLayers(2)),
        );
    }
}

/// Everything that kernels have versions for.
#[test]
fn clipping_gradients_and_extinctions_are_those_of_one_field() {
    let fields = fields([11, 9, 10]);
    let fields = fields.each_ref();
    let volume = &fields[0].volume;
    let base = post(Correction::SubLayers(2));
    let crop = Some(CropBox { lowest: DVec3::new(1.4, 2.0, 0.7), highest: DVec3::new(8.3, 7.2, 8.0) });
    let steep = GradientOpacity::new(&[(0.0, 0.2), (60.0, 1.0)]).unwrap();
    let cases = [
        ("clipped", Settings { clipping: Clipping { crop, ..Clipping::default() }, ..base }),
        ("linear", Settings { extinction: Extinction::Linear, ..base }),
        ("gradient opacity", Settings { gradient_opacity: Some(steep), ..base }),
        ("smoothed gradients", Settings { gradient: Some(GradientEstimator::Gaussian(1.0)), ..base }),
    ];
    for (what, settings) in cases {
        check(what, &parallel(volume, viewport(24, 20), 25.0, 20.0), DEVICE_TOLERANCE, fields, &settings);
        check(what, &perspective(volume, 25.0, 20.0, 25.0), QUADRATURE_TOLERANCE, fields, &settings);
    }
}

/// Two homogeneous fields, unlit: e^(-τ) with the sum of extinctions, and the colours weighted by them.
#[test]
fn homogeneous_fields_add_their_extinctions() {
    const TOLERANCE: f64 = 2e-4;
    let dims = [16, 16, 12];
    let full = volume(dims, DVec3::ONE, layersplat::volume::Voxels::Uint8(vec![200; dims.iter().product()]));
    let field = |color, opacity, factor| {
        let transfer = TransferFunction::new("even", vec![(0.0, color)], vec![(0.0, opacity), (255.0, opacity)]).unwrap();
        Field { volume: full.clone(), transfer, factor }
    };
    let [one, other] = [field([1.0, 0.0, 0.0], 0.1, 1.0), field([0.0, 0.0, 1.0], 0.05, 3.0)];
    let size = viewport(24, 24);
    let camera = parallel(&full, size, 0.0, 0.0);
    let settings = Settings { shading: None, ..post(Correction::SubLayers(2)) };
    let frame = renderer(&[&one, &other]).render(&camera, size, &settings).unwrap().0;
    let pixel = frame.pixels()[(12 * 24 + 12) as usize].map(f64::from);
    let depths = [-(0.9f64.ln()), -3.0 * 0.95f64.ln()];
    // The field ends a voxel beyond the outermost ones, in the middle of layers -1 and n.
    let layers = dims[2] as f64 + 1.0;
    let alpha = 1.0 - (-layers * (depths[0] + depths[1])).exp();
    assert!((pixel[3] - alpha).abs() <= TOLERANCE, "{} instead of {alpha}", pixel[3]);
    for (c, depth) in [(0, depths[0]), (2, depths[1])] {
        let expected = alpha * depth / (depths[0] + depths[1]);
        assert!((pixel[c] - expected).abs() <= TOLERANCE, "{} instead of {expected}", pixel[c]);
    }
}

/// Maximum, minimum and average are those of each field, and the colours add, at most to 1.
#[test]
fn projections_of_fields_add() {
    let fields = fields([11, 9, 10]);
    let size = viewport(24, 20);
    let volume = &fields[0].volume;
    let cameras = [
        ("parallel", parallel(volume, size, 25.0, 20.0), DEVICE_TOLERANCE),
        ("perspective", perspective(volume, 110.0, 15.0, 30.0), QUADRATURE_TOLERANCE),
    ];
    let crop = Some(CropBox { lowest: DVec3::new(1.4, 2.0, 0.7), highest: DVec3::new(8.3, 7.2, 8.0) });
    for clipping in [Clipping::default(), Clipping { crop, ..Clipping::default() }] {
        for blend in [Blend::Maximum, Blend::Minimum, Blend::Average] {
            let settings = Settings { blend, shading: None, clipping, ..post(Correction::SubLayers(2)) };
            for (what, camera, tolerance) in &cameras {
                let picture = renderer(&fields.each_ref()).lattice_picture(camera, size, &settings).unwrap().expect("a lattice");
                let rays = Rays::new(camera, size, volume.grid()).unwrap();
                let axis = layersplat::layers::Axis::most_parallel(rays.central_direction());
                let references = fields.each_ref().map(|field| LayeredReference::new(&field.volume, &field.transfer, &settings));
                let [columns, rows] = picture.size;
                let (mut largest, mut without, mut clamped) = (0.0f64, 0.0f64, 0);
                for sample in 0..columns * rows {
                    let ray = picture.ray(sample % columns, sample / columns);
                    let [one, other] = [0, 1].map(|n| {
                        let [r, g, b, alpha] = references[n].composite(&ray, Some(axis), rays.to_eye);
                        let [r, g, b] = [r, g, b].map(|component| (fields[n].factor * component).min(1.0));
                        [r, g, b, alpha]
                    });
                    for (c, found) in picture.samples[sample as usize].into_iter().enumerate() {
                        largest = largest.max((f64::from(found) - (one[c] + other[c]).min(1.0)).abs());
                        without = without.max((f64::from(found) - one[c]).abs());
                        clamped += usize::from(c < 3 && one[c] + other[c] > 1.0);
                    }
                }
                println!("{what}, {blend:?}: off by {largest:.1e}, {clamped} clamped");
                assert!(largest <= *tolerance, "{what}, {blend:?}: {largest}");
                assert!(without > 0.1, "the other field is seen");
            }
        }
    }
}

/// The order of fields changes rounding at most.
#[test]
fn the_order_of_fields_does_not_matter() {
    /// Sums of three floats, of which some are fused with products.
    const ROUNDING: f64 = 1e-6;
    let [one, two] = fields([11, 9, 10]);
    let third =
        Field { volume: random_volume([11, 9, 10], DVec3::new(1.0, 0.7, 1.3), 5), transfer: two.transfer.clone(), factor: 0.4 };
    let size = viewport(24, 20);
    let base = post(Correction::SubLayers(2));
    let maximum = Settings { blend: Blend::Maximum, shading: None, ..base };
    let terminating = Settings { early_termination: true, ..base };
    for camera in [parallel(&one.volume, size, 25.0, 20.0), perspective(&one.volume, 110.0, 15.0, 30.0)] {
        for settings in [base, maximum, terminating] {
            let draw = |fields: &[&Field]| renderer(fields).render(&camera, size, &settings).unwrap().0;
            let first = draw(&[&one, &two, &third]);
            assert!(largest_opacity(&first) > 0.1);
            for order in [[&two, &third, &one], [&third, &two, &one]] {
                assert_close("another order", &draw(&order), &first, ROUNDING);
            }
            assert!(
                compare(&draw(&[&one, &two]), &first).max_difference > 100.0 * ROUNDING,
                "a field that is left out is noticed"
            );
        }
    }
}

/// Surfaces have no place in splatted layers, of one field or of several.
#[test]
fn surfaces_are_refused() {
    let fields = fields([9, 8, 7]);
    let size = viewport(24, 20);
    let camera = parallel(&fields[0].volume, size, 25.0, 20.0);
    let settings = Settings { blend: Blend::Iso(100.0), ..post(Correction::Constant) };
    for fields in [&fields.each_ref()[..], &[&fields[0]]] {
        let refused = renderer(fields).render(&camera, size, &settings);
        assert!(matches!(refused, Err(Error::Settings { field: "blend", .. })));
    }
}
