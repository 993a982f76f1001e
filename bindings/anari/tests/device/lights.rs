//! Lights of instances, of discs and of many. Colours: settings.rs.

use crate::client::Object;
use crate::scene::{LIGHT, Scene, difference};
use anari_sys::*;
use std::f32::consts::PI;

fn light(scene: &Scene, direction: [f32; 3]) -> Object {
    let light = scene.device.make(ANARI_LIGHT, c"directional");
    light.set(c"direction", direction).commit();
    light
}

fn use_lights(scene: &Scene, lights: &[&Object]) -> Vec<[u8; 4]> {
    scene.world.set_object(c"light", &scene.device.objects(lights)).commit();
    scene.colors(ANARI_UFIXED8_VEC4)
}

#[test]
fn lights_turn_with_their_instance() {
    let scene = Scene::new();
    // A quarter turn about z takes x to y.
    let [x, y, z] = LIGHT;
    let expected = use_lights(&scene, &[&light(&scene, [-y, x, z])]);
    let plain = use_lights(&scene, &[&scene.light]);
    scene.world.unset(c"light");
    let group = scene.device.make(ANARI_GROUP, c"");
    group.set_object(c"light", &scene.device.objects(&[&scene.light])).commit();
    let instance = scene.device.make(ANARI_INSTANCE, c"transform");
    let turn = [0.0f32, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 5.0, 6.0, 7.0, 1.0];
    instance.set_object(c"group", &group).set(c"transform", turn).commit();
    scene.world.set_object(c"instance", &scene.device.objects(&[&instance])).commit();
    let found = scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4);
    assert!(difference(&found, &expected) <= 1.0 && difference(&found, &plain) > 4.0);
    scene.device.expect_nothing();
}

#[test]
fn the_brightness_of_a_colour_and_the_radiance_of_a_disc_are_strengths() {
    let scene = Scene::new();
    let half = light(&scene, LIGHT);
    half.set(c"irradiance", 0.7152f32).commit();
    let scene_of = |color: [f32; 3]| {
        let light = light(&scene, LIGHT);
        light.set(c"color", color).commit();
        use_lights(&scene, &[&light])
    };
    let expected = use_lights(&scene, &[&half]);
    assert!(difference(&scene_of([0.7152; 3]), &expected) <= 1.0);
    assert!(difference(&scene_of([0.0, 0.7152, 0.0]), &expected) > 4.0);
    // The solid angle of a disc, weighted by its cosine: π sin² of half its diameter.
    let disc = light(&scene, LIGHT);
    let diameter = 0.2f32;
    disc.set(c"angularDiameter", diameter).set(c"radiance", 0.7152 / (PI * (diameter / 2.0).sin().powi(2))).commit();
    assert!(difference(&use_lights(&scene, &[&disc]), &expected) <= 1.0);
    scene.device.expect_nothing();
}

#[test]
fn the_four_strongest_lights_are_taken() {
    let scene = Scene::new();
    let lights: Vec<_> = (0..6u8)
        .map(|i| {
            let light = light(&scene, [f32::from(i) - 2.5, -1.0, -1.0]);
            light.set(c"irradiance", f32::from(i) * 0.1).commit();
            light
        })
        .collect();
    let expected = use_lights(&scene, &[&lights[5], &lights[4], &lights[3], &lights[2]]);
    scene.device.expect_nothing();
    let found = use_lights(&scene, &lights.iter().collect::<Vec<_>>());
    assert!(difference(&found, &expected) <= 1.0);
    // One of the six has no strength.
    scene.device.expect("5 lights: the 4 strongest");
    lights[0].set(c"direction", [0.0f32; 3]).commit();
    scene.frame.render();
    assert!(scene.device.messages().iter().any(|message| message.contains("it gives no light")));
}
