//! What renderers do after failures: they retry without cached data, and a volume that could not be set is not rendered.

use super::cases::Scene;
use super::host::Host;
use super::{Renderer, SMALL};
use crate::camera::Camera;
use crate::device::Call;
use crate::error::Error;
use crate::image::Frame;
use crate::renderer::StreamedRenderer;
use crate::settings::Settings;
use crate::viewport::Viewport;
use opencl3::error_codes::CL_MEM_OBJECT_ALLOCATION_FAILURE;

const SIZE: Viewport = Viewport { width: 21, height: 17 };

fn picture(renderer: &mut Renderer, camera: &Camera) -> Result<Frame, Error> {
    Ok(renderer.render(camera, SIZE, &Settings::default())?.0)
}

/// Both with a larger volume and with a smaller one, which reuses the buffer.
#[test]
fn a_volume_that_could_not_be_set_is_not_rendered() {
    let host = Host::new(false);
    let device = host.device();
    let [small, large] = [SMALL, "builtin:hydrogen@16x12x18"].map(Scene::new);
    for (before, after) in [(&small, &large), (&large, &small)] {
        let (before_camera, after_camera) = (before.camera(20.0, None), after.camera(20.0, None));
        let new = |scene: &Scene| Renderer::new(&device, &scene.volume, &scene.transfer).unwrap();
        let expected = [(before, &before_camera), (after, &after_camera)].map(|(scene, camera)| {
            let mut renderer = new(scene);
            renderer.set_transfer_function(&before.transfer);
            picture(&mut renderer, camera).unwrap()
        });
        assert!(expected[0] != expected[1]);
        let mut lost = 0;
        for call in [Call::Allocation, Call::Command] {
            for n in 0.. {
                let mut renderer = new(before);
                assert!(picture(&mut renderer, &before_camera).unwrap() == expected[0]);
                device.fail(call, n, CL_MEM_OBJECT_ALLOCATION_FAILURE);
                let set = renderer.set_volume(&after.volume);
                if !device.recover() {
                    set.unwrap();
                    assert!(picture(&mut renderer, &after_camera).unwrap() == expected[1]);
                    break;
                }
                assert!(set.is_err(), "{call:?} {n}");
                match picture(&mut renderer, &before_camera) {
                    Ok(found) => assert!(found == expected[0], "{call:?} {n}"),
                    Err(Error::NoVolume) => lost += 1,
                    Err(error) => panic!("{call:?} {n}: {error}"),
                }
                renderer.set_volume(&after.volume).unwrap();
                assert!(picture(&mut renderer, &after_camera).unwrap() == expected[1], "{call:?} {n}");
            }
        }
        assert!(lost > 0);
    }
}

#[test]
fn a_volume_larger_than_any_buffer_leaves_the_old_one() {
    let host = Host::new(false);
    let [small, large] = [SMALL, "builtin:hydrogen@64"].map(Scene::new);
    let device = host.device().with_largest_buffer(200_000);
    let camera = small.camera(20.0, None);
    let mut renderer = Renderer::new(&device, &small.volume, &small.transfer).unwrap();
    let expected = picture(&mut renderer, &camera).unwrap();
    assert!(matches!(renderer.set_volume(&large.volume), Err(Error::DeviceMemory { needed: 262_144, available: 200_000, .. })));
    assert!(picture(&mut renderer, &camera).unwrap() == expected);
}

/// The first allocation of a frame fails once, and dropping cached data helps.
#[test]
fn frames_are_retried_without_cached_data() {
    let host = Host::new(false);
    let device = host.device();
    let scene = Scene::new(SMALL);
    let [one, other] = [20.0, 80.0].map(|azimuth| scene.camera(azimuth, None));
    let new = || Renderer::new(&device, &scene.volume, &scene.transfer).unwrap();
    let expected = picture(&mut new(), &other).unwrap();
    let mut renderer = new();
    picture(&mut renderer, &one).unwrap();
    device.fail(Call::Allocation, 0, CL_MEM_OBJECT_ALLOCATION_FAILURE);
    let found = picture(&mut renderer, &other);
    assert!(device.recover(), "the frame allocates");
    assert!(found.unwrap() == expected);
}

/// A streaming renderer retries the upload of the whole volume, too, for pictures and for depths.
#[test]
fn streams_are_retried_without_cached_data() {
    let host = Host::new(false);
    let device = host.device();
    let (scene, settings) = (Scene::new(SMALL), Settings::default());
    let camera = scene.camera(20.0, None);
    let mut whole = Renderer::new(&device, &scene.volume, &scene.transfer).unwrap();
    let expected = picture(&mut whole, &camera).unwrap();
    let depths = whole.depths(&camera, SIZE, &settings).unwrap();
    let streamed = || StreamedRenderer::new(&device, &scene.volume, &scene.transfer);
    let fail = || device.fail(Call::Allocation, 0, CL_MEM_OBJECT_ALLOCATION_FAILURE);
    fail();
    let found = streamed().render(&camera, SIZE, &settings);
    assert!(device.recover(), "the volume is uploaded");
    assert!(found.unwrap().0 == expected);
    fail();
    let found = streamed().depths(&camera, SIZE, &settings);
    assert!(device.recover(), "the volume is uploaded");
    assert!(found.unwrap() == depths);
}
