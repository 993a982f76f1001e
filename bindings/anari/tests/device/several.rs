//! Several volumes in one scene are drawn together.

use crate::client::Object;
use crate::scene::{Expected, SIDE, Scene, difference, voxels};
use anari_sys::*;
use layersplat::glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use layersplat::renderer::{Channel, UploadedVolume};
use layersplat::settings::{AmbientOcclusion, Shadows};
use layersplat::volume::{Grid, Rescale, Volume};
use layersplat::{Background, Device, DeviceChoice, OpenOptions, Renderer, Settings, TransferFunction};

/// A step of a byte.
const STEP: f64 = 1.0;
/// Rounding of floats.
const ROUNDING: f64 = 2e-5;
/// Tables are of optical depths for one length, and interpolated: 9e-4 was measured.
const TABLES: f64 = 2e-3;
/// Mean over the pixels of a volume: 2.4e-3 was measured, since the last voxel fades sooner and lattices are anchored elsewhere; without a
/// background of its own, 0.3.
const EDGES: f32 = 0.01;
/// Voxels along each side of the second field, and its other numbers.
const OTHER_SIDE: usize = 20;
const OTHER_SPACING: f32 = 1.4;
const OTHER_UNIT: f32 = 3.0;
const OTHER_COLORS: [[f32; 3]; 2] = [[0.1, 0.9, 0.3], [0.9, 1.0, 0.8]];
const OTHER_OPACITIES: [f32; 3] = [0.0, 0.0, 0.7];

/// Bytes with all values from 0 to 255.
fn other_voxels() -> Vec<u8> {
    let volume = Volume::open(format!("builtin:gyroid@{OTHER_SIDE}"), &OpenOptions::default()).unwrap();
    let (lo, hi) = volume.range();
    (0..volume.grid().voxel_count()).map(|i| ((volume.value(i) - lo) / (hi - lo) * 255.0).round() as u8).collect()
}

/// A second volume of a scene, of another type and size.
fn other(scene: &Scene) -> (Object, Object) {
    let device = &scene.device;
    let data = device.array(ANARI_UFIXED8, &[OTHER_SIDE as u64; 3], &other_voxels());
    let field = device.make(ANARI_SPATIAL_FIELD, c"structuredRegular");
    field.set_object(c"data", &data).set(c"spacing", [OTHER_SPACING; 3]).commit();
    let volume = device.make(ANARI_VOLUME, c"transferFunction1D");
    let colors = device.array(ANARI_FLOAT32_VEC3, &[2], &OTHER_COLORS);
    let opacities = device.array(ANARI_FLOAT32, &[3], &OTHER_OPACITIES);
    volume.set_object(c"value", &field).set_object(c"color", &colors).set_object(c"opacity", &opacities);
    volume.set(c"unitDistance", OTHER_UNIT).commit();
    (field, volume)
}

/// An instance of volumes.
fn instance(scene: &Scene, volumes: &[&Object], placement: DAffine3) -> Object {
    let group = scene.device.make(ANARI_GROUP, c"");
    group.set_object(c"volume", &scene.device.objects(volumes)).commit();
    let instance = scene.device.make(ANARI_INSTANCE, c"transform");
    instance.set_object(c"group", &group).set(c"transform", DMat4::from(placement).as_mat4().to_cols_array()).commit();
    instance
}

/// The volumes of a world.
fn show(scene: &Scene, volumes: &[&Object]) {
    scene.world.set_object(c"volume", &scene.device.objects(volumes)).commit();
}

fn bytes(scene: &Scene) -> Vec<[u8; 4]> {
    scene.colors(ANARI_UFIXED8_VEC4)
}

/// Colours without a background.
fn floats(scene: &Scene) -> Vec<[f32; 4]> {
    scene.renderer.set(c"background", [0.0f32; 4]).commit();
    scene.colors(ANARI_FLOAT32_VEC4)
}

/// The library's channels of the scene's volume and the other one, with the factors of each field's own smallest spacing.
fn channels(expected: &Expected, placement: DAffine3) -> [Channel; 2] {
    let device = Device::open(&DeviceChoice::Default).unwrap();
    let first = UploadedVolume::new(&device, &expected.volume()).unwrap();
    // As the matrix of floats says.
    let placement = DAffine3::from_mat4(DMat4::from(placement).as_mat4().as_dmat4());
    let spacing = f64::from(OTHER_SPACING);
    let grid = Grid::from_affine([OTHER_SIDE; 3], placement * DAffine3::from_scale(DVec3::splat(spacing))).unwrap();
    let smallest = grid.spacing().min_element();
    let volume = Volume::new("the other", grid, other_voxels()).unwrap().with_rescale(Rescale::new(1.0 / 255.0, 0.0).unwrap());
    let second = UploadedVolume::new(&device, &volume).unwrap();
    let value = |i: usize, n: usize| i as f64 / (n - 1) as f64;
    let colors = OTHER_COLORS.iter().enumerate().map(|(i, color)| (value(i, 2), color.map(f64::from))).collect();
    let opacities = OTHER_OPACITIES.iter().enumerate().map(|(i, &opacity)| (value(i, 3), opacity.into())).collect();
    let transfer = TransferFunction::new("the other", colors, opacities).unwrap();
    [
        Channel::new(&first, &expected.transfer),
        Channel::new(&second, &transfer).with_factor(smallest / f64::from(OTHER_UNIT)).unwrap(),
    ]
}

/// Turned, scaled, mirrored and moved.
fn placement() -> DAffine3 {
    let turn = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -1.0).normalize(), 0.7));
    DAffine3::from_mat3_translation(turn * DMat3::from_diagonal(DVec3::new(-0.8, 0.8, 1.1)), DVec3::new(24.0, 2.0, 8.0))
}

/// The picture is that of the library's channels, each with its unit distance, also where one of them is turned.
#[test]
fn two_volumes_are_the_librarys_channels() {
    for placement in [DAffine3::IDENTITY, placement()] {
        let (scene, expected) = (Scene::new(), Expected::new());
        let (_, other) = other(&scene);
        scene.world.set_object(c"instance", &scene.device.objects(&[&instance(&scene, &[&other], placement)])).commit();
        let found = bytes(&scene);
        scene.device.expect_nothing();
        let draw = |channels: &[Channel]| -> Vec<[u8; 4]> {
            // Opacities of each field are those per its own smallest spacing.
            let settings = Settings { unit_distance: None, ..expected.settings };
            let mut renderer = Renderer::from_channels(channels).unwrap();
            let (bytes, _) = renderer.render_rgba8(&expected.camera, expected.viewport, &settings, Background::BLACK).unwrap();
            bytes.as_chunks().0.to_vec()
        };
        let [first, second] = channels(&expected, placement);
        assert!(difference(&found, &draw(&[first.clone(), second.clone()])) <= STEP);
        assert!(difference(&found, &draw(std::slice::from_ref(&first))) > 20.0, "the other is seen");
        let thicker = second.with_factor(1.0 / f64::from(OTHER_UNIT)).unwrap();
        let changed = difference(&found, &draw(&[first, thicker]));
        assert!(changed > STEP, "an error of the unit distance would be noticed: {changed}");
    }
}

/// Along each ray transparencies are multiplied, with the unit distance of each.
#[test]
fn transparencies_are_multiplied() {
    let scene = Scene::new();
    let second = scene.device.make(ANARI_VOLUME, c"transferFunction1D");
    let opacities = scene.device.array(ANARI_FLOAT32, &[2], &[0.4f32, 0.0]);
    second.set_object(c"value", &scene.field).set_object(c"opacity", &opacities).set(c"unitDistance", 7.0f32).commit();
    scene.volume.set(c"unitDistance", 2.5f32).commit();
    let alone = |volume: &Object| {
        show(&scene, &[volume]);
        floats(&scene)
    };
    let (one, other) = (alone(&scene.volume), alone(&second));
    show(&scene, &[&scene.volume, &second]);
    let mut largest = 0.0f64;
    for ((both, one), other) in floats(&scene).iter().zip(&one).zip(&other) {
        largest = largest.max(f64::from(both[3] - (1.0 - (1.0 - one[3]) * (1.0 - other[3]))).abs());
    }
    assert!(largest < TABLES, "{largest}");
    assert!(one.iter().any(|pixel| pixel[3] > 0.2) && other.iter().any(|pixel| pixel[3] > 0.2));
    scene.device.expect_nothing();
}

/// Two volumes with half the extinction are the whole.
#[test]
fn two_halves_are_the_whole() {
    let scene = Scene::new();
    let whole = floats(&scene);
    let colors = bytes(&scene);
    let half = scene.device.make(ANARI_VOLUME, c"transferFunction1D");
    let array = scene.device.array(ANARI_FLOAT32_VEC3, &[3], &crate::scene::COLORS);
    let opacities = scene.device.array(ANARI_FLOAT32, &[5], &crate::scene::OPACITIES);
    half.set_object(c"value", &scene.field).set_object(c"color", &array).set_object(c"opacity", &opacities);
    half.set(c"unitDistance", 2.0f32).commit();
    scene.volume.set(c"unitDistance", 2.0f32).commit();
    show(&scene, &[&scene.volume, &half]);
    assert!(difference(&floats(&scene), &whole) < ROUNDING);
    assert!(difference(&bytes(&scene), &colors) <= STEP);
    // Other shares of the whole: 1/4 and 3/4.
    scene.volume.set(c"unitDistance", 4.0f32).commit();
    half.set(c"unitDistance", 4.0f32 / 3.0).commit();
    assert!(difference(&floats(&scene), &whole) < ROUNDING);
    half.set(c"unitDistance", 1.3f32).commit();
    assert!(difference(&floats(&scene), &whole) > 10.0 * ROUNDING, "an error would be noticed");
    scene.device.expect_nothing();
}

/// One of two alone is the picture of a scene with one, to the bit, and both are the same again afterwards.
#[test]
fn volumes_are_hidden_and_shown() {
    let scene = Scene::new();
    let alone = bytes(&scene);
    let (_, other) = other(&scene);
    show(&scene, &[&scene.volume, &other]);
    let both = bytes(&scene);
    assert!(difference(&both, &alone) > 20.0);
    other.set_flag(c"visible", false).commit();
    assert_eq!(bytes(&scene), alone);
    other.set_flag(c"visible", true).commit();
    assert_eq!(bytes(&scene), both);
    scene.volume.set_flag(c"visible", false).commit();
    let second = bytes(&scene);
    show(&scene, &[&other]);
    assert_eq!(bytes(&scene), second);
    // A volume that cannot be drawn is told, and the other is drawn.
    scene.volume.set_flag(c"visible", true).commit();
    show(&scene, &[&scene.volume]);
    let flat = DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::new(0.5, 1.0, 0.0)));
    scene.world.set_object(c"instance", &scene.device.objects(&[&instance(&scene, &[&other], flat)])).commit();
    assert_eq!(bytes(&scene), alone);
    scene.device.expect("lie in one plane");
}

/// A volume is released while it is drawn, then leaves the scene.
#[test]
fn volumes_are_released_during_use() {
    let scene = Scene::new();
    let alone = bytes(&scene);
    let (field, other) = other(&scene);
    show(&scene, &[&scene.volume, &other]);
    let both = bytes(&scene);
    // SAFETY: the frame lives.
    unsafe { anariRenderFrame(scene.device.handle, scene.frame.handle) };
    drop((field, other));
    assert_eq!(scene.frame.channel::<[u8; 4]>(c"channel.color", ANARI_UFIXED8_VEC4), both);
    assert_eq!(bytes(&scene), both, "the world needs it");
    // SAFETY: the frame lives.
    unsafe { anariRenderFrame(scene.device.handle, scene.frame.handle) };
    show(&scene, &[&scene.volume]);
    assert_eq!(scene.frame.channel::<[u8; 4]>(c"channel.color", ANARI_UFIXED8_VEC4), both);
    assert_eq!(bytes(&scene), alone);
    scene.device.expect_nothing();
}

/// Transfer functions change without an upload, which would tell of invalid voxels again; other voxels are uploaded.
#[test]
fn voxels_are_uploaded_once() {
    let scene = Scene::new();
    let (_, other) = other(&scene);
    let mut values = voxels().to_vec();
    values[5000..5007].fill(f32::NAN);
    scene.field.set_object(c"data", &scene.device.array(ANARI_FLOAT32, &[SIDE; 3], &values)).commit();
    show(&scene, &[&scene.volume, &other]);
    let before = bytes(&scene);
    scene.device.expect("7 voxels are NaN");
    for volume in [&scene.volume, &other] {
        volume.set(c"unitDistance", 9.0f32).set(c"color", [1.0f32, 0.0, 0.0]).commit();
        assert!(difference(&bytes(&scene), &before) > 20.0);
    }
    // A second volume of the same voxels at the same place.
    let again = scene.device.make(ANARI_VOLUME, c"transferFunction1D");
    let opacities = scene.device.array(ANARI_FLOAT32, &[2], &[0.0f32, 0.5]);
    again.set_object(c"value", &scene.field).set_object(c"opacity", &opacities).commit();
    show(&scene, &[&again, &other, &scene.volume]);
    bytes(&scene);
    scene.device.expect_nothing();
    scene.field.set(c"origin", [1.0f32; 3]).commit();
    bytes(&scene);
    scene.device.expect("7 voxels are NaN");
}

#[test]
fn more_volumes_than_can_be_drawn_are_told() {
    let scene = Scene::new();
    let opacities = scene.device.array(ANARI_FLOAT32, &[2], &[0.0f32, 0.02]);
    let volumes: Vec<Object> = (0..Channel::MOST + 1)
        .map(|i| {
            let volume = scene.device.make(ANARI_VOLUME, c"transferFunction1D");
            let name = std::ffi::CString::new(format!("volume {i}")).unwrap();
            volume.set_text(c"name", &name).set_object(c"value", &scene.field).set_object(c"opacity", &opacities).commit();
            volume
        })
        .collect();
    let all: Vec<&Object> = volumes.iter().collect();
    show(&scene, &all[..Channel::MOST]);
    let most = bytes(&scene);
    scene.device.expect_nothing();
    show(&scene, &all);
    assert_eq!(bytes(&scene), most);
    let messages = scene.device.messages();
    let [message] = &messages[..] else { panic!("{messages:?}") };
    assert!(
        message.contains("9 volumes are visible: only the first 8") && message.contains("'volume 0', 'volume 1'"),
        "{message}"
    );
    assert!(message.contains("'volume 7'") && !message.contains("'volume 8'"), "{message}");
    scene.frame.render();
    scene.device.expect_nothing();
}

/// Shadows and ambient occlusion are those of the library's channels.
#[test]
fn volumes_shade_each_other() {
    let (scene, expected) = (Scene::new(), Expected::new());
    let (_, other) = other(&scene);
    show(&scene, &[&scene.volume, &other]);
    let plain = bytes(&scene);
    let mut renderer = Renderer::from_channels(&channels(&expected, DAffine3::IDENTITY)).unwrap();
    let unlimited = Settings { unit_distance: None, ..expected.settings };
    let shadows = Settings { shadows: Some(Shadows::default()), ..unlimited };
    let occlusion = Settings { ambient_occlusion: Some(AmbientOcclusion::default()), ..unlimited };
    for (name, settings) in [(c"shadows", shadows), (c"ambientOcclusion", occlusion)] {
        scene.renderer.set_flag(name, true).commit();
        let found = bytes(&scene);
        scene.device.expect_nothing();
        let (drawn, _) = renderer.render_rgba8(&expected.camera, expected.viewport, &settings, Background::BLACK).unwrap();
        assert!(difference(&found, drawn.as_chunks().0) <= STEP, "{name:?}");
        assert!(difference(&found, &plain) > STEP, "{name:?} is seen");
        scene.renderer.unset(name).commit();
    }
}

/// What the library draws of one volume only is told once, and left out.
#[test]
fn what_several_volumes_cannot_have_is_told() {
    let scene = Scene::new();
    let (field, other) = other(&scene);
    show(&scene, &[&scene.volume, &other]);
    let before = bytes(&scene);
    scene.renderer.set_flag(c"clipToBounds", true).commit();
    assert_eq!(bytes(&scene), before);
    scene.device.expect("no effect");
    scene.frame.render();
    scene.device.expect_nothing();
    scene.renderer.unset(c"clipToBounds").commit();
    scene.frame.render();
    scene.renderer.set_text(c"quality", c"paper").commit();
    assert_eq!(bytes(&scene), before);
    scene.device.expect("'paper' draws one");
    scene.renderer.unset(c"quality").commit();
    field.set_text(c"filter", c"cubic").commit();
    bytes(&scene);
    scene.device.expect("their filters differ");
    scene.renderer.set_text(c"kernel", c"linear").commit();
    assert_eq!(bytes(&scene), before);
    scene.device.expect_nothing();
}

/// Ids are those of the nearest volume, and channels of one frame belong together.
#[test]
fn ids_are_of_the_nearest_volume() {
    let scene = Scene::new();
    let device = &scene.device;
    let block = device.array(ANARI_FLOAT32, &[4; 3], &[1.0f32; 64]);
    let block_at = |origin: [f32; 3], id: u32| {
        let field = device.make(ANARI_SPATIAL_FIELD, c"structuredRegular");
        field.set_object(c"data", &block).set(c"origin", origin).commit();
        let volume = device.make(ANARI_VOLUME, c"transferFunction1D");
        volume.set_object(c"value", &field).set(c"id", id).commit();
        volume
    };
    // The nearer one covers a part of the other.
    let (far, near) = (block_at([0.0, 0.0, 0.0], 5), block_at([3.0, 0.0, 8.0], 6));
    show(&scene, &[&far, &near]);
    let camera = device.make(ANARI_CAMERA, c"orthographic");
    camera.set(c"position", [3.0f32, 1.5, 30.0]).set(c"height", 7.0f32).commit();
    scene.frame.set_object(c"camera", &camera).commit().render();
    let depths = scene.frame.channel::<f32>(c"channel.depth", ANARI_FLOAT32);
    let ids = scene.frame.channel::<u32>(c"channel.objectId", ANARI_UINT32);
    for (&id, &depth) in ids.iter().zip(&depths) {
        // The surfaces are at the last vertices, or up to a voxel in front of them.
        match id {
            5 => assert!((26.0..=27.0).contains(&depth), "{depth}"),
            6 => assert!((18.0..=19.0).contains(&depth), "{depth}"),
            _ => assert!(id == u32::MAX && depth.is_infinite(), "{id}, {depth}"),
        }
    }
    assert!([5, 6, u32::MAX].iter().all(|id| ids.contains(id)));
    // Both are shown again after the ids.
    let before = bytes(&scene);
    assert_eq!(bytes(&scene), before);
    scene.device.expect_nothing();
}

/// From within, rays have no common layer axis.
#[test]
fn views_from_within_are_drawn() {
    let scene = Scene::new();
    let (_, other) = other(&scene);
    show(&scene, &[&scene.volume, &other]);
    scene.camera.set(c"position", [16.0f32, 15.0, 17.0]).set(c"fovy", 1.5f32).commit();
    let found = bytes(&scene);
    let expected = Expected::new();
    let mut camera = expected.camera;
    camera.focal_point += DVec3::new(16.0, 15.0, 17.0) - camera.position;
    camera.position = DVec3::new(16.0, 15.0, 17.0);
    camera.projection = layersplat::Projection::Perspective { field_of_view: f64::from(1.5f32).to_degrees() };
    let settings = Settings { unit_distance: None, ..expected.settings };
    let mut renderer = Renderer::from_channels(&channels(&expected, DAffine3::IDENTITY)).unwrap();
    let (bytes, _) = renderer.render_rgba8(&camera, expected.viewport, &settings, Background::BLACK).unwrap();
    assert!(difference(&found, bytes.as_chunks().0) <= STEP);
    assert!(found.iter().any(|pixel| pixel[1] > 50));
    // Frames of such views are averaged, too.
    scene.frame.set_flag(c"accumulation", true).commit().render().render();
    assert_eq!(scene.frame.property::<f32>(c"refinementProgress"), Some(2.0 / 16.0));
    scene.device.expect_nothing();
}

/// A volume whose smallest value is visible ends with its grid, as it does alone, though the common grid is larger.
#[test]
fn volumes_end_with_their_grids() {
    let scene = Scene::new();
    let device = &scene.device;
    let veil = device.make(ANARI_VOLUME, c"transferFunction1D");
    // The field has values from 0 to 1, and is visible everywhere.
    veil.set_object(c"value", &scene.field).set(c"opacity", 0.03f32).commit();
    show(&scene, &[&veil]);
    let alone = floats(&scene);
    // An invisible volume that extends the grid.
    let data = device.array(ANARI_UFIXED8, &[2; 3], &[0u8, 255, 0, 0, 0, 0, 0, 255]);
    let field = device.make(ANARI_SPATIAL_FIELD, c"structuredRegular");
    field.set_object(c"data", &data).set(c"origin", [-40.0f32, -30.0, -20.0]).set(c"spacing", [4.0f32; 3]).commit();
    let far = device.make(ANARI_VOLUME, c"transferFunction1D");
    far.set_object(c"value", &field).set(c"opacity", 0.0f32).commit();
    show(&scene, &[&veil, &far]);
    let both = floats(&scene);
    let mean = |a: &[[f32; 4]], b: &[[f32; 4]]| {
        let sum: f32 = a.iter().zip(b).map(|(a, b)| (a[3] - b[3]).abs()).sum();
        sum / a.iter().filter(|pixel| pixel[3] > 0.0).count() as f32
    };
    assert!(mean(&alone, &both) < EDGES, "{}", mean(&alone, &both));
    // So it does when the smallest value becomes visible later.
    let opacities = device.array(ANARI_FLOAT32, &[2], &[0.0f32, 0.03]);
    veil.set_object(c"opacity", &opacities).commit();
    assert!(mean(&floats(&scene), &both) > 0.1);
    veil.set(c"opacity", 0.03f32).commit();
    assert_eq!(floats(&scene), both);
    scene.device.expect_nothing();
}
