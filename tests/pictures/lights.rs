//! Several lights in all lit algorithms: the f64 reference and invariants. Manual calculations: appearance.rs.

use crate::common::blends::{ISO, algorithms, composited, compositing, cuts, has, settings, tolerance, tolerance_of};
use crate::common::reference::Pair;
use crate::common::*;
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

const AMBIENT_COLOR: [f64; 3] = [0.3, 0.6, 1.0];

/// Red from the side, bluish from the camera, and green from above.
fn colored() -> [Light; 3] {
    let [a, b, c] = three();
    [Light { color: [1.0, 0.2, 0.1], ..a }, Light { color: [0.5, 0.6, 1.0], ..b }, Light { color: [0.0, 1.0, 0.0], ..c }]
}

/// Colours of lights and of the ambient light, also where gradients are too weak for shading.
#[test]
fn colored_lights_of_device_and_reference() {
    let (volume, views) = scene();
    let flat = cube([14, 11, 12], DVec3::ONE);
    let with = |color, lights: &[Light], settings| {
        let shading = shaded(lights).map(|shading| Shading { ambient_color: color, ..shading });
        Settings { shading, ..settings }
    };
    let size = viewport(25, 22);
    let surfaces = algorithms().into_iter().filter(|&a| has(a, Blend::Iso(ISO))).map(|a| settings(a, Blend::Iso(ISO)));
    for (n, settings) in each().chain(surfaces).enumerate() {
        // Each has programs of its own to build: the default, and every third.
        if !n.is_multiple_of(3) && settings != Settings::default() {
            continue;
        }
        // Edges of the flat volume are too sharp for the tolerance in perspectives.
        for (volume, camera, is_parallel) in [(&volume, views[0], true), (&volume, views[1], false), (&flat, views[0], true)] {
            let what = format!("{:?}, parallel {is_parallel}", settings.algorithm);
            let tolerance = tolerance_of(&settings, is_parallel).max(tolerance(&settings, is_parallel));
            // Several lights, and by default a single one, which has a program of its own.
            let first = if settings == Settings::default() { 1 } else { colored().len() };
            for count in [first, colored().len()] {
                let lights = &colored()[..count];
                let settings = with(AMBIENT_COLOR, lights, settings);
                Pair::of(volume, &smooth_transfer(), &camera, size, &settings).assert_same(&what, tolerance);
            }
            if !is_parallel {
                continue;
            }
            let [a, b, c] = colored();
            let swapped = Light { color: [0.1, 0.2, 1.0], ..a };
            let drawn = with(AMBIENT_COLOR, &colored(), settings);
            for other in [with(AMBIENT_COLOR, &[swapped, b, c], settings), with([1.0; 3], &colored(), settings)] {
                let pair = Pair::against(volume, &smooth_transfer(), &camera, size, &drawn, &other);
                assert!(pair.differing(2.0 * tolerance) > 0.1, "{what}: another colour must be detected");
            }
        }
    }
}

/// Each component of a colour is lit as white lights of its strengths light it, where gradients are strong enough for shading.
#[test]
fn components_are_lit_apart() {
    let (volume, views) = scene();
    let standard = Settings::default();
    let shading = shaded(&colored()).map(|shading| Shading { ambient_color: AMBIENT_COLOR, ..shading });
    for camera in views {
        let found = draw(&volume, &camera, &Settings { shading, ..standard });
        for (i, ambient) in AMBIENT_COLOR.into_iter().enumerate() {
            let white = colored().map(|light| Light { strength: light.strength * light.color[i], color: [1.0; 3], ..light });
            let shading = shaded(&white).map(|shading| Shading { ambient: shading.ambient * ambient, ..shading });
            let expected = draw(&volume, &camera, &Settings { shading, ..standard });
            let largest = |i: usize, j: usize| {
                let pairs = found.pixels().iter().zip(expected.pixels());
                pairs.map(|(found, expected)| (found[i] - expected[j]).abs()).fold(0.0, f32::max)
            };
            assert!(f64::from(largest(i, i)) < REORDERED_LIGHTS, "component {i}: {}", largest(i, i));
            assert!(f64::from(largest((i + 1) % 3, i)) > 100.0 * REORDERED_LIGHTS, "another component must differ");
        }
    }
}

/// White light is the same with the programs of colours.
#[test]
fn almost_white_is_white() {
    let (volume, views) = scene();
    let nearly = three().map(|light| Light { color: [1.0, 1.0, 1.0 - 1e-9], ..light });
    for camera in views {
        let [white, nearly] = [three(), nearly].map(|lights| draw(&volume, &camera, &lit(&lights, Settings::default())));
        assert_close("nearly white", &nearly, &white, REORDERED_LIGHTS);
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
        vec![Light { color: [0.5, 1.1, 0.5], ..Light::AT_CAMERA }],
        vec![Light { color: [0.5, -0.1, f64::NAN], ..Light::AT_CAMERA }],
    ];
    for lights in wrong {
        let refused = Lights::new(&lights);
        assert!(matches!(refused, Err(Error::OutOfRange { name: "light", .. })), "{lights:?}: {refused:?}");
    }
    assert_eq!(Lights::new(&[Light::AT_CAMERA]).unwrap(), Lights::default());
}
