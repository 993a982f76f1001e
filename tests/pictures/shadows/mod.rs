//! Shadows and ambient occlusion in pictures: closed forms, the f64 reference with marched shadow rays, all algorithms, refusals.

mod known;
mod marched;

use crate::common::reference::Pair;
use crate::common::*;
use glam::DVec3;
use layersplat::device::{LatticeSchedule, Tuning};
use layersplat::layers::Kernel;
use layersplat::settings::{
    Algorithm, AmbientOcclusion, Blend, Classification, Evaluation, Layered, Light, LightGrid, Lights, Look, Shading, Shadows,
};
use layersplat::volume::{Grid, Voxels};
use layersplat::{Camera, Error, Quality, Renderer, Settings, TransferFunction, Volume};

/// Root mean square difference between a picture and one whose samples march to the light. Light volumes interpolate between voxels and
/// store steps of 1/255. Measured: 0.0005 to 0.0008, with soft light and occlusion 0.0016.
const NEAR: f64 = 0.0025;
const EXACT: Shadows = Shadows { strength: 1.0, forgiveness: 1.0 };

/// Blobs with soft edges, between which shadows fall.
fn blobs() -> (Volume<'static>, TransferFunction) {
    let dims = [32, 30, 28];
    let place = |n: usize| DVec3::new((n % 32) as f64, (n / 32 % 30) as f64, (n / 960) as f64);
    let centres = [(DVec3::new(10.0, 20.0, 18.0), 7.0), (DVec3::new(21.0, 11.0, 10.0), 6.0), (DVec3::new(22.0, 22.0, 20.0), 4.0)];
    let value = |p: DVec3| {
        let nearest = centres.iter().map(|&(centre, radius)| p.distance(centre) - radius).fold(f64::INFINITY, f64::min);
        (128.0 - 40.0 * nearest).clamp(0.0, 255.0).round() as u8
    };
    let voxels = (0..dims.iter().product()).map(|n| value(place(n))).collect();
    let volume = Volume::new("blobs", Grid::new(dims, DVec3::new(1.0, 1.1, 1.2)).unwrap(), Voxels::Uint8(voxels)).unwrap();
    let transfer =
        TransferFunction::new("soft", vec![(0.0, [0.9, 0.6, 0.3]), (255.0, [0.4, 0.7, 1.0])], vec![(60.0, 0.0), (200.0, 0.25)])
            .unwrap();
    (volume, transfer)
}

fn shaded(settings: Settings, lights: &[Light]) -> Settings {
    Settings { shading: Some(Shading { lights: Lights::new(lights).unwrap(), ..Shading::default() }), ..settings }
}

fn side() -> Light {
    Light::towards(DVec3::new(-1.0, 1.2, 0.4))
}

fn rms(a: &[[f64; 4]], b: &[[f64; 4]]) -> f64 {
    let squares = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).powi(2));
    (squares.sum::<f64>() / (4 * a.len()) as f64).sqrt()
}

/// Compares with shadow rays of the reference, and shows that missing shadows, other ones and those of another light are noticed.
fn assert_near(volume: &Volume, transfer: &TransferFunction, camera: &Camera, settings: Settings) {
    let size = viewport(40, 36);
    let what = format!("{:?}, {:?}", settings.algorithm, camera.projection);
    let pair = Pair::of(volume, transfer, camera, size, &settings);
    let near = rms(&pair.found, &pair.expected);
    assert!(near < NEAR, "{what}: {near}");
    let away = shaded(settings, &[Light::towards(DVec3::new(1.0, 0.3, 0.2))]).shading;
    let none = Settings { shadows: None, ambient_occlusion: None, ..settings };
    for (wrong, name) in [(none, "no shadows"), (Settings { shading: away, ..settings }, "another light")] {
        let pair = Pair::against(volume, transfer, camera, size, &settings, &wrong);
        let far = rms(&pair.found, &pair.expected);
        assert!(far > 10.0 * NEAR, "{what}: {name} must be noticed, but differs by {far} only");
    }
}

fn direct(classification: Classification) -> Settings {
    Layered { classification, evaluation: Evaluation::Direct, ..Layered::default() }.into()
}

#[test]
fn all_algorithms_have_the_shadows_of_the_reference() {
    let (volume, transfer) = blobs();
    let size = viewport(40, 36);
    let views =
        [parallel(&volume, size, 25.0, -15.0), parallel(&volume, size, 80.0, 10.0), perspective(&volume, 200.0, 30.0, 35.0)];
    let bspline = Classification::Preintegrated { kernel: Kernel::BSpline, samples_per_layer: 2 };
    let algorithms = [
        Layered::default().into(),
        direct(POINTS),
        direct(bspline),
        Layered { classification: SPLATTED, ..Layered::default() }.into(),
        direct(SPLATTED),
        Algorithm::Raycast { kernel: Kernel::Linear, step: 0.6 }.into(),
    ];
    for settings in algorithms {
        for camera in &views {
            assert_near(&volume, &transfer, camera, Settings { shadows: Some(EXACT), ..shaded(settings, &[side()]) });
        }
    }
}

#[test]
fn several_lights_with_occlusion() {
    let (volume, transfer) = blobs();
    let camera = parallel(&volume, viewport(40, 36), 30.0, 20.0);
    let lights = [
        side(),
        Light { strength: 0.4, ..Light::AT_CAMERA },
        Light { strength: 0.5, angle: 20.0, ..Light::towards(DVec3::X) },
        side(),
    ];
    let settings = shaded(Settings::default(), &lights);
    let occlusion = Some(AmbientOcclusion { reach: Some(12.0), gain: 1.5 });
    let (shadows, ambient) =
        (Some(Shadows { strength: 0.9, forgiveness: 2.0 }), Shading { ambient: 0.8, ..settings.shading.unwrap() });
    assert_near(
        &volume,
        &transfer,
        &camera,
        Settings { shadows, ambient_occlusion: occlusion, shading: Some(ambient), ..settings },
    );
}

/// Gradient opacity and linear extinction change shadows as they change the picture.
#[test]
fn shadows_follow_the_extinction() {
    let (volume, transfer) = blobs();
    let camera = parallel(&volume, viewport(40, 36), 30.0, 20.0);
    let gradient_opacity = Some(layersplat::settings::GradientOpacity::new(&[(5.0, 0.2), (30.0, 1.0)]).unwrap());
    let lit = Settings { shadows: Some(EXACT), ..shaded(direct(POINTS), &[side()]) };
    for settings in [
        Settings { gradient_opacity, ..lit },
        Settings { extinction: layersplat::transfer::Extinction::Linear, ..lit },
        Settings { unit_distance: Some(2.0), ..lit },
    ] {
        let pair = Pair::of(&volume, &transfer, &camera, viewport(40, 36), &settings);
        let near = rms(&pair.found, &pair.expected);
        assert!(near < NEAR, "{settings:?}: {near}");
    }
}

#[test]
fn both_schedules_and_runs_agree() {
    let (volume, transfer) = blobs();
    let size = viewport(60, 50);
    let camera = parallel(&volume, size, 25.0, -15.0);
    let settings = Settings {
        shadows: Some(EXACT),
        ambient_occlusion: Some(AmbientOcclusion::default()),
        ..shaded(Settings::default(), &[side()])
    };
    let tiles = render(&volume, &transfer, &camera, size, &settings);
    assert_eq!(tiles.pixels(), render(&volume, &transfer, &camera, size, &settings).pixels(), "the same bits from run to run");
    let tuning = Tuning { lattice_schedule: LatticeSchedule::Samples, ..*device().tuning() };
    let mut renderer = Renderer::new(&device().with_tuning(tuning).unwrap(), &volume, &transfer).unwrap();
    let samples = renderer.render(&camera, size, &settings).unwrap().0;
    assert_eq!(pixels_apart(&tiles, &samples, DEVICE_TOLERANCE), 0);
}

/// A light that moves with the camera is the light of the world in its place, and one at the camera casts no shadow.
#[test]
fn lights_of_the_camera() {
    let (volume, transfer) = blobs();
    let size = viewport(40, 36);
    for camera in [parallel(&volume, size, 25.0, -15.0), perspective(&volume, 200.0, 30.0, 35.0)] {
        let moving = Light::from_camera(DVec3::new(-1.0, 1.0, 1.0));
        let fixed = moving.in_world(&camera).unwrap();
        let shadows = Some(Shadows::default());
        let [one, other] = [moving, fixed].map(|light| {
            render(&volume, &transfer, &camera, size, &Settings { shadows, ..shaded(Settings::default(), &[light]) })
        });
        assert_eq!(pixels_apart(&one, &other, 1e-5), 0);
        let headlight = Settings::default();
        let plain = render(&volume, &transfer, &camera, size, &headlight);
        let shadowed = render(&volume, &transfer, &camera, size, &Settings { shadows, ..headlight });
        assert_eq!(pixels_apart(&plain, &shadowed, 1e-5), 0);
        assert!(pixels_apart(&plain, &one, 0.05) > 100, "the moving light is noticed");
    }
}

#[test]
fn strength_zero_is_no_shadow_and_half_is_between() {
    let (volume, transfer) = blobs();
    let (size, camera) = (viewport(40, 36), parallel(&volume, viewport(40, 36), 25.0, 15.0));
    let at = |strength: f64| {
        let shadows = Some(Shadows { strength, ..EXACT });
        render(&volume, &transfer, &camera, size, &Settings { shadows, ..shaded(Settings::default(), &[side()]) })
    };
    let none = render(&volume, &transfer, &camera, size, &shaded(Settings::default(), &[side()]));
    let [zero, half, whole] = [0.0, 0.5, 1.0].map(at);
    assert_eq!(pixels_apart(&none, &zero, 1e-5), 0);
    let sum = |frame: &layersplat::Frame| frame.pixels().iter().map(|p| f64::from(p[0])).sum::<f64>();
    assert!(
        (sum(&half) - 0.5 * (sum(&zero) + sum(&whole))).abs() < 0.01 * sum(&zero),
        "light is linear in the strength, before it is clamped"
    );
}

#[test]
fn settings_without_effect_are_refused() {
    let (volume, transfer) = blobs();
    let camera = parallel(&volume, viewport(20, 20), 25.0, 15.0);
    let shadows = Some(Shadows::default());
    let occlusion = Some(AmbientOcclusion::default());
    let base = Settings { shadows, ..Settings::default() };
    let refused = [
        Settings { shading: None, ..base },
        Settings { shading: None, shadows: None, ambient_occlusion: occlusion, ..base },
        Settings { blend: Blend::Maximum, ..base },
        Settings { shadows, ..Algorithm::Slicing { step: 0.5 }.into() },
        Settings { ambient_occlusion: occlusion, ..Algorithm::ViewSheets { sheet_distance: 1.0 }.into() },
        Settings { shadows: Some(Shadows { strength: 1.1, ..EXACT }), ..base },
        Settings { shadows: Some(Shadows { strength: f64::NAN, ..EXACT }), ..base },
        Settings { shadows: Some(Shadows { forgiveness: 0.5, ..EXACT }), ..base },
        Settings { ambient_occlusion: Some(AmbientOcclusion { reach: Some(0.0), gain: 3.0 }), ..base },
        Settings { ambient_occlusion: Some(AmbientOcclusion { reach: Some(f64::NAN), gain: 3.0 }), ..base },
    ];
    let mut renderer = Renderer::new(&device(), &volume, &transfer).unwrap();
    for settings in refused {
        let error = renderer.render(&camera, viewport(20, 20), &settings).expect_err("refused");
        assert!(matches!(error, Error::Settings { .. } | Error::OutOfRange { .. }), "{error}");
    }
    assert!(Lights::new(&[Light { angle: 46.0, ..side() }]).is_err() && Lights::new(&[Light { angle: -1.0, ..side() }]).is_err());
}

/// Volumes of one voxel, of one layer, with spacings of 1 to 20, and transfer functions that show all or nothing.
#[test]
fn extremes_have_shadows() {
    let shadows = Some(Shadows::default());
    let occlusion = Some(AmbientOcclusion::default());
    for (dims, spacing) in
        [([1, 1, 1], DVec3::ONE), ([1, 20, 15], DVec3::ONE), ([9, 8, 7], DVec3::new(1.0, 20.0, 3.0)), ([300, 2, 2], DVec3::ONE)]
    {
        let volume = random_volume(dims, spacing, 5);
        for opacity in [0.0, 1.0] {
            let transfer = TransferFunction::new("constant", vec![(0.0, [1.0; 3])], vec![(0.0, opacity)]).unwrap();
            for lights in [
                vec![Light::towards(DVec3::X)],
                vec![Light::towards(DVec3::ONE), side(), Light::towards(-DVec3::Y), Light { angle: 45.0, ..side() }],
            ] {
                for light_grid in LightGrid::ALL {
                    let settings =
                        Settings { shadows, ambient_occlusion: occlusion, light_grid, ..shaded(Settings::default(), &lights) };
                    let frame =
                        render(&volume, &transfer, &parallel(&volume, viewport(16, 16), 30.0, 20.0), viewport(16, 16), &settings);
                    assert!(
                        frame.pixels().iter().flatten().all(|c| (0.0..=1.0001).contains(c)),
                        "{dims:?}, {opacity}, {light_grid:?}"
                    );
                }
            }
        }
    }
}

/// Frames of every quality render with everything enabled.
#[test]
fn all_qualities_have_shadows() {
    let (volume, transfer) = blobs();
    let camera = parallel(&volume, viewport(40, 36), 44.9, 15.0);
    for quality in [Quality::Draft, Quality::Standard, Quality::High, Quality::Paper] {
        let plain = shaded(quality.settings(), &[side()]);
        let with = Settings { shadows: Some(EXACT), ..plain };
        let [plain, with] = [plain, with].map(|settings| render(&volume, &transfer, &camera, viewport(40, 36), &settings));
        assert!(pixels_apart(&plain, &with, 0.05) > 50, "{quality:?}");
    }
}
