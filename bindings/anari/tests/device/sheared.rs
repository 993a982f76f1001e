//! Instances whose transform shears the grid of a volume.

use crate::client::Object;
use crate::scene::{SIZE, Scene, difference};
use anari_sys::*;
use layersplat::glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use layersplat::volume::Grid;
use std::f64::consts::PI;

/// Numbers of voxels.
const DIMS: [usize; 3] = [30, 26, 22];
/// A step of a byte: 1 was measured. Resampling changes smooth values little.
const STEP: f64 = 2.0;
/// Of depths, but for a twentieth of them, at which rays graze the volume.
const NEAR: f32 = 0.5;
/// Of opacities of a constant field, whose ends lie between voxels.
const OPACITY: f32 = 0.01;

/// A smooth function of a place in voxels, from 0 to 1, that is 0 beyond the outermost ones.
fn function(place: DVec3) -> f32 {
    let share = place / DVec3::from_array(DIMS.map(|n| n as f64 - 1.0));
    if share.min_element() <= 0.0 || share.max_element() >= 1.0 {
        return 0.0;
    }
    let bump = |t: f64| (PI * t).sin().powi(2);
    (bump(share.x) * bump(2.0 * share.y) * (0.6 + 0.4 * share.y) * bump(share.z)) as f32
}

/// The voxels of a grid whose voxel p holds the function at `place · p`.
fn sampled([x, y, z]: [usize; 3], place: DAffine3) -> Vec<f32> {
    let at = |n: usize| DVec3::new((n % x) as f64, (n / x % y) as f64, (n / x / y) as f64);
    (0..x * y * z).map(|n| function(place.transform_point3(at(n)))).collect()
}

/// Sheared along two axes, turned, mirrored, and with three spacings, as floats hold it.
fn placement() -> DAffine3 {
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.5, 1.0, 0.0), DVec3::new(-0.2, 0.35, 1.0));
    let turn = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -1.0).normalize(), 0.7));
    let axes = turn * shear * DMat3::from_diagonal(DVec3::new(-0.8, 1.0, 1.1));
    let affine = DAffine3::from_mat3_translation(axes, DVec3::new(16.0, -4.0, 14.0));
    DAffine3::from_mat4(DMat4::from_cols_array(&columns(affine).map(f64::from)))
}

/// Columns of the matrix of an instance.
fn columns(placement: DAffine3) -> [f32; 16] {
    DMat4::from(placement).as_mat4().to_cols_array()
}

/// Makes the scene's field one with these values.
fn set_values(scene: &Scene, dims: [usize; 3], values: &[f32]) {
    let data = scene.device.array(ANARI_FLOAT32, &dims.map(|n| n as u64), values);
    scene.field.set_object(c"data", &data).commit();
}

/// Makes the scene's volume that of one instance.
fn place(scene: &Scene, placement: DAffine3) -> Object {
    let group = scene.device.make(ANARI_GROUP, c"");
    group.set_object(c"volume", &scene.device.objects(&[&scene.volume])).commit();
    let instance = scene.device.make(ANARI_INSTANCE, c"transform");
    instance.set_object(c"group", &group).set(c"transform", columns(placement)).commit();
    scene.world.unset(c"volume").set_object(c"instance", &scene.device.objects(&[&instance])).commit();
    instance
}

/// A scene of the function in a sheared instance.
fn sheared() -> (Scene, Object) {
    let scene = Scene::new();
    set_values(&scene, DIMS, &sampled(DIMS, DAffine3::IDENTITY));
    let instance = place(&scene, placement());
    (scene, instance)
}

fn bytes(scene: &Scene) -> Vec<[u8; 4]> {
    scene.colors(ANARI_UFIXED8_VEC4)
}

/// The picture is that of the function, sampled on a grid without shear.
#[test]
fn sheared_instances_are_the_field_elsewhere() {
    let (scene, instance) = sheared();
    let found = bytes(&scene);
    scene.device.expect_nothing();
    let plain = Scene::new();
    let grid = Grid::covering(DIMS, placement()).unwrap();
    set_values(&plain, grid.dims(), &sampled(grid.dims(), placement().inverse() * grid.index_to_world()));
    place(&plain, grid.index_to_world());
    let expected = bytes(&plain);
    plain.device.expect_nothing();
    println!("{} steps", difference(&found, &expected));
    assert!(difference(&found, &expected) <= STEP, "{}", difference(&found, &expected));
    assert!(found.iter().filter(|pixel| pixel[0] > 60).count() > 200, "the volume fills a part of the picture");
    // A shear that is off by a tenth would be noticed.
    let mut wrong = placement();
    wrong.matrix3.y_axis += 0.05 * wrong.matrix3.x_axis;
    instance.set(c"transform", columns(wrong)).commit();
    assert!(difference(&bytes(&scene), &expected) > 5.0 * STEP);
    // Depths and ids are those of the field, too.
    instance.set(c"transform", columns(placement())).commit();
    let channels = |scene: &Scene| {
        scene.frame.render();
        let depths = scene.frame.channel::<f32>(c"channel.depth", ANARI_FLOAT32);
        (depths, scene.frame.channel::<u32>(c"channel.objectId", ANARI_UINT32))
    };
    let ((depths, ids), (other_depths, _)) = (channels(&scene), channels(&plain));
    assert!(ids.iter().zip(&depths).all(|(&id, depth)| id == if depth.is_finite() { 0 } else { u32::MAX }));
    let both = depths.iter().zip(&other_depths).filter(|(one, other)| one.is_finite() && other.is_finite());
    let apart: Vec<f32> = both.map(|(one, other)| (one - other).abs()).collect();
    assert!(apart.len() > 300);
    let far = apart.iter().filter(|&&apart| apart > NEAR).count();
    println!("{far} of {} depths", apart.len());
    assert!(far < apart.len() / 20, "{far} of {} depths", apart.len());
    scene.device.expect_nothing();
}

#[test]
fn bounds_are_those_of_the_sheared_corners() {
    let (scene, instance) = sheared();
    let corner = |n: usize, axis: usize| if n >> axis & 1 == 0 { 0.0 } else { DIMS[axis] as f64 - 1.0 };
    let corners = (0..8).map(|n| placement().transform_point3(DVec3::new(corner(n, 0), corner(n, 1), corner(n, 2))));
    let (least, most) = corners.fold((DVec3::MAX, DVec3::MIN), |(least, most), corner| (least.min(corner), most.max(corner)));
    for object in [&scene.world, &instance] {
        let [low, high] = object.property_of::<[[f32; 3]; 2]>(c"bounds", ANARI_FLOAT32_BOX3).unwrap();
        assert!((DVec3::from_array(low.map(f64::from)) - least).length() < 1e-4);
        assert!((DVec3::from_array(high.map(f64::from)) - most).length() < 1e-4);
    }
}

/// A volume whose smallest value is visible ends with its voxels, not with the grid that covers them, alone and with others.
#[test]
fn sheared_volumes_end_with_their_voxels() {
    let scene = Scene::new();
    let device = &scene.device;
    let (sides, opacity) = ([32usize, 24, 17], 0.04f32);
    set_values(&scene, sides, &vec![1.0; sides.iter().product()]);
    scene.volume.unset(c"color").set(c"opacity", opacity).commit();
    // x leans by 0.75 y.
    place(&scene, DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::new(0.75, 1.0, 0.0), DVec3::Z)));
    let camera = device.make(ANARI_CAMERA, c"orthographic");
    let ([x, y], height) = ([24.0f32, 11.5], 28.0f32);
    camera.set(c"position", [x, y, 60.0]).set(c"height", height).commit();
    scene.frame.set_object(c"camera", &camera).commit();
    scene.renderer.set(c"background", [0.0f32; 4]).commit();
    // Along z, in which rays go, there are 16 voxels, and it fades within one at each end.
    let [thin, thick] = [16.0, 18.0].map(|length| 1.0 - (1.0 - opacity).powf(length));
    let check = |what: &str| {
        let pixels: Vec<[f32; 4]> = scene.colors(ANARI_FLOAT32_VEC4);
        let (mut inside, mut beyond) = (0, 0);
        let [width, rows] = SIZE.map(|side| side as usize);
        for (n, &[.., found]) in pixels.iter().enumerate() {
            let pixel = |n: usize, side: usize| (n as f32 + 0.5 - side as f32 / 2.0) * height / rows as f32;
            let j = y - pixel(n / width, rows);
            let i = x + pixel(n % width, width) - 0.75 * j;
            let within = |by: f32| i > -by && i < 31.0 + by && j > -by && j < 23.0 + by;
            if within(-1.5) {
                assert!((thin - OPACITY..thick + OPACITY).contains(&found), "{what}: {found} at {i}, {j}, not {thin} to {thick}");
                inside += 1;
            } else if !within(2.0) {
                assert!(found < 1e-6, "{what}: {found} at {i}, {j}");
                // Some of these pixels show the grid that covers the volume.
                beyond += 1;
            }
        }
        assert!(inside > 1000 && beyond > 500, "{what}: {inside}, {beyond}");
    };
    check("alone");
    // An invisible volume that extends the grid.
    let far = device.make(ANARI_VOLUME, c"transferFunction1D");
    let field = device.make(ANARI_SPATIAL_FIELD, c"structuredRegular");
    field.set_object(c"data", &device.array(ANARI_FLOAT32, &[2; 3], &[0.0f32; 8])).set(c"spacing", [60.0f32; 3]).commit();
    far.set_object(c"value", &field).set(c"opacity", 0.0f32).commit();
    scene.world.set_object(c"volume", &device.objects(&[&far])).commit();
    check("with another");
    device.expect_nothing();
}

/// A volume is sheared and straightened again, and drawn in every quality.
#[test]
fn transforms_change() {
    let (scene, instance) = sheared();
    let before = bytes(&scene);
    let straight = DAffine3::from_translation(DVec3::new(5.0, 3.0, 8.0));
    instance.set(c"transform", columns(straight)).commit();
    let moved = bytes(&scene);
    assert!(difference(&moved, &before) > 50.0);
    let fresh = Scene::new();
    set_values(&fresh, DIMS, &sampled(DIMS, DAffine3::IDENTITY));
    place(&fresh, straight);
    assert_eq!(moved, bytes(&fresh));
    instance.set(c"transform", columns(placement())).commit();
    assert_eq!(bytes(&scene), before);
    // Other colours need no other voxels.
    scene.volume.set(c"opacity", 0.0f32).commit();
    assert!(bytes(&scene).iter().all(|&pixel| pixel == [0, 0, 0, 255]));
    for quality in [c"draft", c"high", c"paper"] {
        scene.renderer.set_text(c"quality", quality).commit();
        bytes(&scene);
    }
    scene.device.expect_nothing();
}

/// What a sheared volume cannot have is told once, and left out.
#[test]
fn clipping_to_sheared_bounds_is_told() {
    let (scene, _) = sheared();
    let before = bytes(&scene);
    scene.renderer.set_flag(c"clipToBounds", true).commit();
    assert_eq!(bytes(&scene), before);
    scene.device.expect("sheared: clipToBounds has no effect");
    scene.frame.render();
    scene.device.expect_nothing();
}
