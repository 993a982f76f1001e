//! Parameters are the library's settings.

use crate::scene::{DIRECTION, Expected, LIGHT, POSITION, SIDE, SIZE, Scene, difference};
use anari_sys::*;
use layersplat::color::Tone;
use layersplat::glam::DVec3;
use layersplat::settings::{AmbientOcclusion, ClipPlane, Clipping, CropBox, Light, Lights, Look, Shadows, Sky, Studio};
use layersplat::{Kernel, Projection, Quality};

/// Frames of floats and bytes agree to rounding; a step of a byte is the limit.
const STEP: f64 = 1.0;

/// A change of the scene and of what is expected.
type Change = fn(&Scene, &mut Expected);

/// Parameters of camera, lights and renderer, each with the library's settings.
const CHANGES: [(&str, Change); 21] = [
    ("gamma", |scene, expected| {
        scene.renderer.set(c"gamma", 2.0f32).commit();
        expected.settings.gamma = 2.0;
    }),
    ("clip to bounds", |scene, expected| {
        scene.renderer.set_flag(c"clipToBounds", true).commit();
        let highest = DVec3::splat(SIDE as f64 - 1.0);
        expected.settings.clipping.crop = Some(CropBox { lowest: DVec3::ZERO, highest });
        // Otherwise the outermost values are transparent.
        scene.volume.unset(c"opacity").set(c"opacity", 0.5f32).commit();
        expected.transfer = expected.transfer.with_opacities(vec![(0.0, 0.5)]).unwrap();
    }),
    ("orthographic", |scene, expected| {
        let camera = scene.device.make(ANARI_CAMERA, c"orthographic");
        camera.set(c"position", POSITION).set(c"direction", DIRECTION).set(c"height", 40.0f32).commit();
        scene.frame.set_object(c"camera", &camera).commit();
        expected.camera.projection = Projection::Parallel { scale: 20.0 };
    }),
    ("aspect", |scene, expected| {
        scene.camera.set(c"aspect", 2.0f32).commit();
        expected.settings.pixel_aspect = 2.0 * f64::from(SIZE[1]) / f64::from(SIZE[0]);
    }),
    ("aspect of a region of a parallel view", |scene, expected| {
        let camera = scene.device.make(ANARI_CAMERA, c"orthographic");
        camera.set(c"position", POSITION).set(c"direction", DIRECTION).set(c"height", 40.0f32).set(c"aspect", 1.5f32);
        camera.set(c"imageRegion", [[0.25f32, 0.125], [0.75, 0.875]]).commit();
        scene.frame.set_object(c"camera", &camera).commit();
        expected.camera.projection = Projection::Parallel { scale: 15.0 };
        expected.settings.pixel_aspect = 1.5 * 0.5 * f64::from(SIZE[1]) / (0.75 * f64::from(SIZE[0]));
    }),
    ("up", |scene, expected| {
        scene.camera.set(c"up", [1.0f32, 0.5, 0.0]).commit();
        expected.camera.view_up = DVec3::new(1.0, 0.5, 0.0);
    }),
    ("near and far", |scene, expected| {
        scene.camera.set(c"near", 95.0f32).set(c"far", 115.0f32).commit();
        let forward = expected.camera.basis().unwrap().forward;
        let plane = |d: f64, side: f64| ClipPlane { point: expected.camera.position + forward * d, normal: forward * side };
        expected.settings.clipping = Clipping::default().with_planes([plane(95.0, 1.0), plane(115.0, -1.0)]);
    }),
    ("cubic filter", |scene, expected| {
        scene.field.set_text(c"filter", c"cubic").commit();
        set_kernel(expected, Quality::Standard, Kernel::BSpline);
    }),
    ("quality and kernel", |scene, expected| {
        scene.renderer.set_text(c"quality", c"high").set_text(c"kernel", c"catmull-rom").commit();
        set_kernel(expected, Quality::High, Kernel::CatmullRom);
    }),
    ("gradient", |scene, expected| {
        scene.renderer.set_text(c"gradient", c"central").commit();
        expected.settings.gradient = Some("central".parse().unwrap());
    }),
    ("two lights", |scene, expected| {
        let second = scene.device.make(ANARI_LIGHT, c"directional");
        second.set(c"direction", [-1.0f32, 0.0, 0.0]).set(c"irradiance", 0.5f32).commit();
        scene.world.set_object(c"light", &scene.device.objects(&[&scene.light, &second])).commit();
        let first = Light::towards(-DVec3::from_array(LIGHT.map(f64::from)));
        set_lights(expected, &[first, Light { strength: 0.5, ..Light::towards(DVec3::X) }]);
    }),
    ("coloured lights", |scene, expected| {
        scene.light.set(c"color", [0.5f32, 0.25, 0.0]).commit();
        let second = scene.device.make(ANARI_LIGHT, c"directional");
        second.set(c"direction", [-1.0f32, 0.0, 0.0]).set(c"color", [0.0f32, 0.5, 1.0]).commit();
        scene.world.set_object(c"light", &scene.device.objects(&[&scene.light, &second])).commit();
        let first = Light::towards(-DVec3::from_array(LIGHT.map(f64::from)));
        let first = Light { strength: 0.5, color: [1.0, 0.5, 0.0], ..first };
        set_lights(expected, &[first, Light { color: [0.0, 0.5, 1.0], ..Light::towards(DVec3::X) }]);
    }),
    ("coloured ambient light", |scene, expected| {
        scene.renderer.set(c"ambientColor", [1.0f32, 0.0, 0.5]).set(c"ambientRadiance", 0.75f32).commit();
        let shading = expected.settings.shading.as_mut().unwrap();
        (shading.ambient, shading.ambient_color) = (0.75, [1.0, 0.0, 0.5]);
    }),
    ("shadows of a wide light", |scene, expected| {
        scene.light.set(c"angularDiameter", 0.1f32).commit();
        scene.renderer.set_flag(c"shadows", true).commit();
        let light = Light::towards(-DVec3::from_array(LIGHT.map(f64::from)));
        set_lights(expected, &[Light { angle: f64::from(0.1f32).to_degrees(), ..light }]);
        expected.settings.shadows = Some(Shadows::default());
    }),
    ("ambient occlusion", |scene, expected| {
        scene.renderer.set_flag(c"ambientOcclusion", true).set(c"ambientRadiance", 0.6f32).commit();
        expected.settings.shading.as_mut().unwrap().ambient = f64::from(0.6f32);
        expected.settings.ambient_occlusion = Some(AmbientOcclusion::default());
    }),
    ("the studio of the scene", |scene, expected| {
        let look = scene.renderer.set_text(c"look", c"studio").set_text(c"tone", c"none").set(c"scattering", 0.5f32);
        look.set(c"exposure", 1.0f32).set(c"ambientColor", [1.0f32, 0.5, 0.25]).set(c"ambientRadiance", 0.5f32).commit();
        // Radiance comes from all around, and a light of strength 1 has an irradiance of pi.
        let light = Light::towards(-DVec3::from_array(LIGHT.map(f64::from)));
        expected.settings = expected.settings.with_look(Look::Studio);
        set_lights(expected, &[Light { strength: 1.0 / std::f64::consts::PI, ..light }]);
        let color = [0.5, 0.25, 0.125];
        let sky = Sky { top: color, bottom: color, strength: 1.0, ..Sky::default() };
        expected.settings.studio = Some(Studio { sky, scattering: 0.5, exposure: 1.0, tone: Tone::None });
    }),
    ("a sky alone", |scene, expected| {
        scene.world.unset(c"light").commit();
        scene.renderer.set_text(c"look", c"studio").set(c"ambientRadiance", 0.75f32).commit();
        expected.settings = expected.settings.with_look(Look::Studio);
        set_lights(expected, &[Light { strength: 0.0, ..Light::AT_CAMERA }]);
        expected.settings.studio.as_mut().unwrap().sky =
            Sky { top: [0.75; 3], bottom: [0.75; 3], strength: 1.0, ..Sky::default() };
    }),
    ("the light of the studio", |scene, expected| {
        scene.world.unset(c"light").commit();
        scene.renderer.unset(c"ambientRadiance").set_text(c"look", c"studio").commit();
        expected.settings = expected.settings.with_look(Look::Studio);
    }),
    ("no light", |scene, expected| {
        scene.world.unset(c"light").commit();
        scene.renderer.unset(c"ambientRadiance").commit();
        expected.settings.shading = None;
    }),
    ("unit distance", |scene, expected| {
        scene.volume.set(c"unitDistance", 3.0f32).commit();
        expected.settings.unit_distance = Some(3.0);
    }),
    ("range of values", |scene, expected| {
        let ends = [0.1f32, 0.7];
        scene.volume.set_raw(c"valueRange", ANARI_FLOAT32_VEC2, ends.as_ptr().cast()).commit();
        expected.transfer = expected.transfer.stretched(f64::from(ends[0]), f64::from(ends[1])).unwrap();
    }),
];

fn set_kernel(expected: &mut Expected, quality: Quality, kernel: Kernel) {
    let mut layered = quality.layered();
    layered.classification = layered.classification.with_kernel(kernel);
    expected.settings.algorithm = layered.into();
}

fn set_lights(expected: &mut Expected, lights: &[Light]) {
    expected.settings.shading.as_mut().unwrap().lights = Lights::new(lights).unwrap();
}

#[test]
fn parameters_are_the_librarys_settings() {
    let usual = Expected::new().bytes();
    for (what, change) in CHANGES {
        let (scene, mut expected) = (Scene::new(), Expected::new());
        change(&scene, &mut expected);
        let (found, expected) = (scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4), expected.bytes());
        assert!(difference(&found, &expected) <= STEP, "{what}: {}", difference(&found, &expected));
        assert!(difference(&usual, &expected) > 4.0, "{what} changes the picture");
        scene.device.expect_nothing();
    }
}
