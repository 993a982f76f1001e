//! Several lights in all lit algorithms: the f64 reference and invariants. Manual calculations: appearance.rs.

mod common;

use common::blends::{ISO, algorithms, composited, compositing, cuts, has, settings, tolerance, tolerance_of};
use common::reference::Pair;
use common::*;
use glam::DVec3;
use layersplat::settings::{Blend, Clipping, Light, Lights, Shading};
use layersplat::{Camera, Error, Frame, Settings, Volume};

/// Sums of floats in another order, to the 20th power, over tens of samples.
const REORDERED_LIGHTS: f64 = 2e-5;

fn light(direction: [f64; 3], strength: f64) -> Light {
    Light { strength, ..Light::towards(direction.into()) }
}

fn three() -> [Light; 3] {
    [light([-2.0, 1.0, 0.5], 0.7), Light { strength: 0.4, ..Light::AT_CAMERA }, light([1.0, 3.0, -2.0], 0.2)]
}

fn shaded(lights: &[Light]) -> Option<Shading> {
    Some(Shading { lights: Lights::new(lights).unwrap(), ..Shading::default() })
}

fn lit(lights: &[Light], settings: Settings) -> Settings {
    Settings { shading: shaded(lights), ..settings }
}

fn each() -> impl Iterator<Item = Settings> {
    compositing().into_iter().map(|algorithm| composited(algorithm, Clipping::default()))
}

fn scene() -> (Volume<'static>, [Camera; 2]) {
    let volume = random_volume([14, 11, 12], DVec3::new(1.0, 0.7, 1.3), 21);
    let views = [parallel(&volume, viewport(25, 22), 25.0, -15.0), perspective(&volume, 200.0, 30.0, 35.0)];
    (volume, views)
}

fn draw(volume: &Volume, camera: &Camera, settings: &Settings) -> Frame {
    render(volume, &smooth_transfer(), camera, viewport(25, 22), settings)
}

#[test]
fn device_and_reference() {
    let (volume, views) = scene();
    let lights = [three().as_slice(), &[light([0.2, -1.0, 0.1], 1.5)]].concat();
    let size = viewport(25, 22);
    for (camera, is_parallel) in views.into_iter().zip([true, false]) {
        for settings in each().map(|settings| lit(&lights, settings)) {
            let what = format!("{:?}, parallel {is_parallel}", settings.algorithm);
            let tolerance = tolerance_of(&settings, is_parallel);
            Pair::of(&volume, &smooth_transfer(), &camera, size, &settings).assert_same(&what, tolerance);
            // Without the last light, and without the first.
            for fewer in [&lights[..3], &lights[1..]] {
                let pair = Pair::against(&volume, &smooth_transfer(), &camera, size, &settings, &lit(fewer, settings));
                assert!(pair.differing(2.0 * tolerance) > 0.3, "{what}: a missing light must be detected");
            }
        }
    }
}

#[test]
fn cut_and_of_surfaces() {
    let (volume, [camera, _]) = scene();
    let surfaces = algorithms().into_iter().filter(|&a| has(a, Blend::Iso(ISO))).map(|a| settings(a, Blend::Iso(ISO)));
    let cut = each().map(|settings| Settings { clipping: cuts(), ..settings });
    for settings in surfaces.chain(cut).map(|settings| lit(&three(), settings)) {
        let pair = Pair::of(&volume, &smooth_transfer(), &camera, viewport(25, 22), &settings);
        let tolerance = tolerance_of(&settings, true).max(tolerance(&settings, true));
        pair.assert_same(&format!("{:?}, {:?}", settings.algorithm, settings.blend), tolerance);
    }
}

/// Lights may be in any order, and two of half the strength equal one.
#[test]
fn lights_add_up() {
    let (volume, views) = scene();
    let [a, b, c] = three();
    let half = |light: Light| Light { strength: 0.5 * light.strength, ..light };
    for camera in views {
        for settings in each() {
            let expected = draw(&volume, &camera, &lit(&[a, b, c], settings));
            for same in [vec![b, c, a], vec![c, b, a], vec![half(a), b, c, half(a)], vec![b, half(c), a, half(c)]] {
                let found = draw(&volume, &camera, &lit(&same, settings));
                assert_close(&format!("{same:?} in {:?}", settings.algorithm), &found, &expected, REORDERED_LIGHTS);
            }
            let other = draw(&volume, &camera, &lit(&[half(a), b, c], settings));
            assert!(compare(&other, &expected).max_difference > 100.0 * REORDERED_LIGHTS, "a weaker light must be noticed");
        }
    }
}

/// Bit-identical.
#[test]
fn lights_of_no_strength_leave_what_is_ambient() {
    let (volume, views) = scene();
    let ambient = Some(Shading { diffuse: 0.0, specular: 0.0, ..Shading::default() });
    let dark = three().map(|light| Light { strength: 0.0, ..light });
    let [first, ..] = three();
    for camera in views {
        for settings in each() {
            let expected = draw(&volume, &camera, &Settings { shading: ambient, ..settings });
            assert_eq!(draw(&volume, &camera, &lit(&dark, settings)), expected, "{:?}", settings.algorithm);
            let alone = draw(&volume, &camera, &lit(&[first], settings));
            assert_eq!(draw(&volume, &camera, &lit(&[first, dark[1]], settings)), alone, "{:?}", settings.algorithm);
            assert_ne!(alone, expected, "{:?}", settings.algorithm);
        }
    }
}

#[test]
fn refusals() {
    let wrong = [
        vec![],
        vec![Light::AT_CAMERA; 5],
        vec![Light::AT_CAMERA, light([0.0; 3], 1.0)],
        vec![light([f64::NAN, 0.0, 1.0], 1.0)],
        vec![light([1.0, 0.0, f64::INFINITY], 1.0)],
        vec![light([1.0, 0.0, 0.0], -0.1)],
        vec![Light { strength: f64::NAN, ..Light::AT_CAMERA }],
        vec![Light { strength: 100.5, ..Light::AT_CAMERA }],
    ];
    for lights in wrong {
        let refused = Lights::new(&lights);
        assert!(matches!(refused, Err(Error::OutOfRange { name: "light", .. })), "{lights:?}: {refused:?}");
    }
    assert_eq!(Lights::new(&[Light::AT_CAMERA]).unwrap(), Lights::default());
}
