//! Pictures are those of the library.

use crate::scene::{COLORS, DIRECTION, Expected, FIELD_OF_VIEW, POSITION, SIDE, SIZE, Scene, difference, voxels};
use anari_sys::*;
use layersplat::glam::{DAffine3, DMat3, DQuat, DVec3};
use layersplat::{Background, Projection, Renderer};

/// Frames of floats and bytes agree to rounding; a step of a byte is the limit.
const STEP: f64 = 1.0;

#[test]
fn colours_are_the_librarys_in_every_type() {
    let (scene, expected) = (Scene::new(), Expected::new());
    let (bytes, floats) = (expected.bytes(), expected.floats());
    assert!(bytes.iter().filter(|pixel| pixel[0] > 20).count() > 300, "the volume fills a part of the picture");
    assert_eq!(scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4), bytes);
    // Over opaque black, colours stay and opacities become 1.
    let opaque: Vec<_> = floats.iter().map(|&[r, g, b, _]| [r, g, b, 1.0]).collect();
    assert!(difference(&scene.colors::<[f32; 4]>(ANARI_FLOAT32_VEC4), &opaque) < 1e-6);
    let encoded = |c: f32| {
        let c = f64::from(c);
        let encoded = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
        (encoded * 255.0).round().clamp(0.0, 255.0) as u8
    };
    let srgb: Vec<_> = floats.iter().map(|&[r, g, b, _]| [encoded(r), encoded(g), encoded(b), 255]).collect();
    let found = scene.colors::<[u8; 4]>(ANARI_UFIXED8_RGBA_SRGB);
    assert!(difference(&found, &srgb) <= STEP);
    assert!(difference(&found, &bytes) > 20.0, "sRGB is encoded");
    // A transparent background leaves premultiplied pixels.
    scene.renderer.set(c"background", [0.0f32; 4]).commit();
    assert!(difference(&scene.colors::<[f32; 4]>(ANARI_FLOAT32_VEC4), &floats) < 1e-6);
    scene.renderer.set(c"background", [0.2f32, 0.4, 0.6, 1.0]).commit();
    let (over, _) = expected
        .renderer()
        .render_rgba8(&expected.camera, expected.viewport, &expected.settings, Background::Color([0.2, 0.4, 0.6]))
        .unwrap();
    assert_eq!(scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4).as_flattened(), over);
    scene.device.expect_nothing();
}

#[test]
fn images_are_backgrounds() {
    let (scene, expected) = (Scene::new(), Expected::new());
    // Green below, red above; the middle rows mix them.
    let image = scene.device.array(ANARI_UFIXED8_VEC3, &[1, 2], &[0u8, 255, 0, 255, 0, 0]);
    scene.renderer.set_object(c"background", &image).commit();
    let found = scene.colors::<[f32; 4]>(ANARI_FLOAT32_VEC4);
    let width = SIZE[0] as usize;
    for (i, (found, &[r, g, b, a])) in found.iter().zip(&expected.floats()).enumerate() {
        let height = SIZE[1] as f32;
        let t = (((i / width) as f32 + 0.5) / height * 2.0 - 0.5).clamp(0.0, 1.0);
        let behind = [1.0 - t, t, 0.0].map(|c| c * (1.0 - a));
        let expected = [r + behind[0], g + behind[1], b + behind[2], 1.0];
        assert!(difference(&[*found], &[expected]) < 1e-5, "{found:?} {expected:?}");
    }
    scene.device.expect_nothing();
}

#[test]
fn types_of_voxels_are_values_from_0_to_1() {
    let scene = Scene::new();
    let check = |data: crate::client::Object, stored: Vec<f32>, what: &str| {
        scene.field.set_object(c"data", &data).commit();
        let found = scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4);
        let floats = scene.device.array(ANARI_FLOAT32, &[SIDE; 3], &stored);
        scene.field.set_object(c"data", &floats).commit();
        let expected = scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4);
        assert!(difference(&found, &expected) <= STEP, "{what}: {}", difference(&found, &expected));
    };
    let rounded = |largest: f32| voxels().iter().map(move |v| (v * largest).round());
    let bytes: Vec<u8> = rounded(255.0).map(|v| v as u8).collect();
    let words: Vec<u16> = rounded(65_535.0).map(|v| v as u16).collect();
    let signed: Vec<i16> = rounded(32_767.0).map(|v| v as i16).collect();
    let doubles: Vec<f64> = voxels().iter().map(|&v| v.into()).collect();
    let device = &scene.device;
    check(device.array(ANARI_UFIXED8, &[SIDE; 3], &bytes), rounded(255.0).map(|v| v / 255.0).collect(), "bytes");
    check(device.array(ANARI_UFIXED16, &[SIDE; 3], &words), rounded(65_535.0).map(|v| v / 65_535.0).collect(), "words");
    check(device.array(ANARI_FIXED16, &[SIDE; 3], &signed), rounded(32_767.0).map(|v| v / 32_767.0).collect(), "signed");
    check(device.array(ANARI_FLOAT64, &[SIDE; 3], &doubles), voxels().to_vec(), "doubles");
    scene.device.expect_nothing();
}

/// Columns of the matrix of an instance.
fn columns(placement: DAffine3) -> [f32; 16] {
    layersplat::glam::DMat4::from(placement).as_mat4().to_cols_array()
}

fn instance(scene: &Scene, placement: DAffine3) {
    let group = scene.device.make(ANARI_GROUP, c"");
    group.set_object(c"volume", &scene.device.objects(&[&scene.volume])).commit();
    let instance = scene.device.make(ANARI_INSTANCE, c"transform");
    instance.set_object(c"group", &group).set(c"transform", columns(placement)).commit();
    scene.world.unset(c"volume").set_object(c"instance", &scene.device.objects(&[&instance])).commit();
}

#[test]
fn instances_place_volumes() {
    let (scene, mut expected) = (Scene::new(), Expected::new());
    let turn = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -1.0).normalize(), 0.7));
    // Mirrored, and longer along one axis.
    let stretched = turn * DMat3::from_diagonal(DVec3::new(-0.8, 0.8, 1.1));
    let placement = DAffine3::from_mat3_translation(stretched, DVec3::new(28.0, -3.0, 8.0));
    instance(&scene, placement);
    // As the matrix of floats says.
    expected.placement = DAffine3::from_mat4(layersplat::glam::DMat4::from_cols_array(&columns(placement).map(f64::from)));
    let (found, plain) = (scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4), Expected::new().bytes());
    assert!(difference(&found, &expected.bytes()) <= STEP && difference(&found, &plain) > 50.0);
    scene.device.expect_nothing();
    let [low, high] = scene.world.property_of::<[[f32; 3]; 2]>(c"bounds", ANARI_FLOAT32_BOX3).unwrap();
    let corners = (0..8).map(|corner| {
        let at = |bit: usize| if corner >> bit & 1 == 1 { SIDE as f64 - 1.0 } else { 0.0 };
        placement.transform_point3(DVec3::new(at(0), at(1), at(2)))
    });
    let (least, most) = corners.fold((DVec3::MAX, DVec3::MIN), |(least, most), corner| (least.min(corner), most.max(corner)));
    assert!((DVec3::from_array(low.map(f64::from)) - least).length() < 1e-4);
    assert!((DVec3::from_array(high.map(f64::from)) - most).length() < 1e-4);
}

#[test]
fn what_cannot_be_drawn_is_told_once() {
    let scene = Scene::new();
    let flat = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::new(0.5, 1.0, 0.0));
    instance(&scene, DAffine3::from_mat3(flat));
    scene.frame.render();
    scene.device.expect("lie in one plane");
    scene.frame.render();
    scene.device.expect_nothing();
    let background = scene.frame.channel::<[u8; 4]>(c"channel.color", ANARI_UFIXED8_VEC4);
    assert!(background.iter().all(|&pixel| pixel == [0, 0, 0, 255]));
    let scene = Scene::new();
    let surface = scene.device.make(ANARI_SURFACE, c"");
    scene.world.set_object(c"surface", &scene.device.objects(&[&surface])).commit();
    scene.frame.render();
    scene.device.expect("1 surfaces are not drawn");
}

#[test]
fn regions_of_the_image() {
    let (scene, expected) = (Scene::new(), Expected::new());
    let region = [[0.25f32, 0.25], [0.75, 0.75]];
    scene.camera.set(c"imageRegion", region).commit();
    let found = scene.colors::<[f32; 4]>(ANARI_FLOAT32_VEC4);
    let whole = layersplat::Viewport::new(2 * SIZE[0], 2 * SIZE[1]).unwrap();
    let part = |pixels: &[[f32; 4]]| -> Vec<[f32; 4]> {
        let rows = pixels.chunks_exact(whole.width as usize).skip(SIZE[1] as usize / 2).take(SIZE[1] as usize);
        let columns = SIZE[0] as usize / 2..SIZE[0] as usize * 3 / 2;
        rows.flat_map(|row| &row[columns.clone()]).map(|&[r, g, b, _]| [r, g, b, 1.0]).collect()
    };
    let mut renderer = expected.renderer();
    let (frame, _) = renderer.render(&expected.camera, whole, &expected.settings).unwrap();
    // Lattices of parts have other places.
    assert!(difference(&found, &part(frame.pixels())) < 0.02);
    let depths = renderer.depths(&expected.camera, whole, &expected.settings).unwrap();
    let hit = scene.frame.channel::<f32>(c"channel.depth", ANARI_FLOAT32);
    assert_eq!(hit.iter().filter(|depth| depth.is_finite()).count(), {
        let finite: Vec<_> = depths.first().iter().map(|d| [f32::from(u8::from(d.is_finite())); 4]).collect();
        part(&finite).iter().filter(|pixel| pixel[0] > 0.0).count()
    });
    let camera = scene.device.make(ANARI_CAMERA, c"orthographic");
    camera.set(c"position", POSITION).set(c"direction", DIRECTION).set(c"height", 40.0f32).set(c"imageRegion", region).commit();
    scene.frame.set_object(c"camera", &camera).commit();
    let found = scene.colors::<[f32; 4]>(ANARI_FLOAT32_VEC4);
    let parallel = layersplat::Camera { projection: Projection::Parallel { scale: 20.0 }, ..expected.camera };
    let (frame, _) = renderer.render(&parallel, whole, &expected.settings).unwrap();
    assert!(difference(&found, &part(frame.pixels())) < 0.02);
    scene.device.expect_nothing();
    scene.camera.set(c"imageRegion", [[1.0f32, 0.0], [0.0, 1.0]]).commit();
    scene.frame.set_object(c"camera", &scene.camera).commit().render();
    scene.device.expect("mirrored");
}

/// Depths are distances along rays, and ids tell where they are.
#[test]
fn depths_and_ids() {
    let (scene, expected) = (Scene::new(), Expected::new());
    scene.volume.set(c"id", 7u32).commit();
    scene.frame.render();
    let depths = scene.frame.channel::<f32>(c"channel.depth", ANARI_FLOAT32);
    let ids = scene.frame.channel::<u32>(c"channel.objectId", ANARI_UINT32);
    let planes = expected.renderer().depths(&expected.camera, expected.viewport, &expected.settings).unwrap();
    let tangent = (f64::from(FIELD_OF_VIEW) / 2.0).tan();
    for (i, (&depth, &plane)) in depths.iter().zip(planes.first()).enumerate() {
        let [width, height] = SIZE.map(f64::from);
        let x = ((i % SIZE[0] as usize) as f64 + 0.5 - width / 2.0) * 2.0 * tangent / height;
        let y = ((i / SIZE[0] as usize) as f64 + 0.5 - height / 2.0) * 2.0 * tangent / height;
        let expected = f64::from(plane) * (1.0 + x * x + y * y).sqrt();
        assert!(
            depth.is_infinite() == plane.is_infinite() && (depth.is_infinite() || (f64::from(depth) - expected).abs() < 1e-3)
        );
        assert_eq!(ids[i], if depth.is_finite() { 7 } else { u32::MAX });
    }
    assert!(ids.contains(&7) && ids.contains(&u32::MAX));
    // An opaque block: the distance of a parallel camera is known.
    let block = scene.device.array(ANARI_FLOAT32, &[4; 3], &[1.0f32; 64]);
    scene.field.set_object(c"data", &block).commit();
    scene.volume.unset(c"color").unset(c"opacity").unset(c"id").commit();
    let camera = scene.device.make(ANARI_CAMERA, c"orthographic");
    camera.set(c"position", [1.5f32, 1.5, 20.0]).set(c"height", 2.0f32).commit();
    scene.frame.set_object(c"camera", &camera).commit().render();
    let depths = scene.frame.channel::<f32>(c"channel.depth", ANARI_FLOAT32);
    let centre = depths[depths.len() / 2 + SIZE[0] as usize / 2];
    // The surface is at the last vertices, or half the reach of the kernel in front of them.
    assert!((16.0..=17.0).contains(&centre), "{centre}");
    let ids = scene.frame.channel::<u32>(c"channel.objectId", ANARI_UINT32);
    assert!(ids.contains(&0), "without an id, the index counts");
    scene.device.expect_nothing();
}

#[test]
fn rays_and_frames_are_averaged() {
    let (scene, expected) = (Scene::new(), Expected::new());
    let mut mean = layersplat::renderer::Accumulation::new(expected.viewport).unwrap();
    let mut renderer: Renderer = expected.renderer();
    let mut expected_mean = |frames: u32| -> Vec<[f32; 4]> {
        while mean.frames() < frames {
            renderer.accumulate(&expected.camera, &expected.settings, &mut mean).unwrap();
        }
        mean.mean().unwrap().pixels().iter().map(|&[r, g, b, _]| [r, g, b, 1.0]).collect()
    };
    scene.renderer.set(c"pixelSamples", 4i32).commit();
    assert!(difference(&scene.colors(ANARI_FLOAT32_VEC4), &expected_mean(4)) < 1e-6);
    scene.renderer.unset(c"pixelSamples").commit();
    scene.frame.set_flag(c"accumulation", true).set_type(c"channel.color", ANARI_FLOAT32_VEC4).commit();
    for _ in 0..6 {
        scene.frame.render();
    }
    assert_eq!(scene.frame.property::<f32>(c"refinementProgress"), Some(6.0 / 16.0));
    assert!(difference(&scene.frame.channel(c"channel.color", ANARI_FLOAT32_VEC4), &expected_mean(6)) < 1e-6);
    for _ in 0..14 {
        scene.frame.render();
    }
    assert_eq!(scene.frame.property::<f32>(c"refinementProgress"), Some(1.0));
    assert!(difference(&scene.frame.channel(c"channel.color", ANARI_FLOAT32_VEC4), &expected_mean(16)) < 1e-6);
    // Any change begins anew.
    scene.volume.set(c"unitDistance", 2.0f32).commit();
    scene.frame.render();
    assert_eq!(scene.frame.property::<f32>(c"refinementProgress"), Some(1.0 / 16.0));
    scene.device.expect_nothing();
}

/// The library's warnings are messages.
#[test]
fn invalid_voxels_are_told() {
    let scene = Scene::new();
    let mut values = voxels().to_vec();
    values[5000..5007].fill(f32::NAN);
    scene.field.set_object(c"data", &scene.device.array(ANARI_FLOAT32, &[SIDE; 3], &values)).commit();
    scene.frame.render();
    scene.device.expect("7 voxels are NaN");
    scene.frame.render();
    scene.device.expect_nothing();
}

#[test]
fn ranges_of_values_in_both_precisions() {
    let scene = Scene::new();
    let mut expected = Expected::new();
    expected.transfer = expected.transfer.stretched(0.25, 0.75).unwrap();
    scene.volume.set(c"valueRange", [0.25f64, 0.75]).commit();
    let found = scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4);
    assert_eq!(found, expected.bytes());
    let ends = [0.25f32, 0.75];
    scene.volume.set_raw(c"valueRange", ANARI_FLOAT32_BOX1, ends.as_ptr().cast()).commit();
    assert_eq!(scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4), found);
    scene.device.expect_nothing();
}

/// Colours of arrays in sRGB are decoded, and their opacities multiplied.
#[test]
fn colours_with_opacities() {
    let scene = Scene::new();
    let floats: Vec<[f32; 4]> = [0.25, 0.5, 1.0].iter().zip(COLORS).map(|(&a, [r, g, b])| [r, g, b, a]).collect();
    let array = scene.device.array(ANARI_FLOAT32_VEC4, &[3], &floats);
    scene.volume.set_object(c"color", &array).set(c"opacity", 0.5f32).commit();
    let found = scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4);
    let mut expected = Expected::new();
    expected.transfer = expected.transfer.with_opacities(vec![(0.0, 0.125), (0.5, 0.25), (1.0, 0.5)]).unwrap();
    assert!(difference(&found, &expected.bytes()) <= STEP);
    let encoded: Vec<u8> = vec![255, 0, 0, 128, 188, 188, 188, 128];
    let srgb = scene.device.array(ANARI_UFIXED8_RGBA_SRGB, &[2], &encoded);
    scene.volume.set_object(c"color", &srgb).set(c"opacity", 1.0f32).commit();
    let found = scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4);
    // 188 is a linear 0.5029.
    let half = 128.0 / 255.0;
    expected.transfer =
        layersplat::TransferFunction::new("", vec![(0.0, [1.0, 0.0, 0.0]), (1.0, [0.502_886; 3])], vec![(0.0, half)]).unwrap();
    assert!(difference(&found, &expected.bytes()) <= STEP);
    // A region of an array: its last two colours alone.
    let array = scene.device.array(ANARI_FLOAT32_VEC3, &[3], &COLORS);
    array.set(c"region", [1u64, 9]).commit();
    scene.volume.set_object(c"color", &array).set(c"opacity", half as f32).commit();
    let found = scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4);
    let colors = [1, 2].map(|i| COLORS[i].map(f64::from));
    expected.transfer =
        layersplat::TransferFunction::new("", vec![(0.0, colors[0]), (1.0, colors[1])], vec![(0.0, half)]).unwrap();
    assert!(difference(&found, &expected.bytes()) <= STEP);
    scene.device.expect_nothing();
}
