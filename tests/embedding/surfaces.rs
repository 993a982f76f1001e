//! Enqueued frames with surfaces: the bits of rendered ones, whatever has become of the surfaces when they are drawn.

use crate::common::{CONVERGED, perspective, scaled};
use crate::host::{Host, SIZE, frame, hosts, keep, renderer, scene};
use glam::DVec3;
use layersplat::device::DeviceMemory;
use layersplat::renderer::{PictureFormat, PictureMemory};
use layersplat::settings::{Blend, Look};
use layersplat::surface::{Per, Spheres, Surface, Triangles};
use layersplat::{Background, Camera, Settings, Volume};
use opencl3::event::CL_COMPLETE;

/// Triangles across the volume, `count` of them behind each other, in front of most of it and through it, and aslant, so that they intersect.
fn stack(volume: &Volume, count: usize, opacity: f32) -> Surface {
    let (centre, size) = (volume.grid().centre(), volume.grid().diagonal());
    let corner = |n: usize, x: f64, y: f64| {
        let aslant = 0.15 * (n % 5) as f64 * (x + 0.6 * y);
        centre + size * DVec3::new(x, y, 0.6 * n as f64 / count as f64 - 0.4 + aslant)
    };
    let corners = (0..count).flat_map(|n| [corner(n, -0.5, -0.3), corner(n, 0.4, -0.35), corner(n, 0.1, 0.5)]).collect();
    let colors = (0..count).map(|n| [0.9, (n % 3) as f32 / 2.0, (n % 7) as f32 / 6.0, 1.0]).collect();
    let indices = (0..count as u32).map(|n| [3 * n, 3 * n + 1, 3 * n + 2]).collect();
    let mut surface = Surface::new("stack", Triangles::new(corners, indices).unwrap());
    surface = surface.with_colors(Per::Cell(colors)).unwrap();
    surface.opacity = opacity;
    surface
}

/// Two spheres that intersect.
fn spheres(volume: &Volume, opacity: f32) -> Surface {
    let (centre, radius) = (volume.grid().centre(), 0.2 * volume.grid().diagonal());
    let centres = vec![centre, centre + DVec3::new(0.7, 0.4, -0.5) * radius];
    let mut surface = Surface::new("spheres", Spheres::new(centres, vec![radius; 2]).unwrap());
    (surface.color, surface.opacity) = ([0.3, 0.8, 0.4], opacity);
    surface
}

/// Opaque; translucent; both; and so many that they are found in several passes, by rendered frames in sorted lists.
fn scenes(volume: &Volume) -> [Vec<Surface>; 4] {
    [
        vec![spheres(volume, 1.0)],
        vec![spheres(volume, 0.4)],
        vec![spheres(volume, 1.0), stack(volume, 3, 0.3)],
        vec![spheres(volume, 0.2), stack(volume, 40, 0.03)],
    ]
}

/// Parallel and in a perspective, on lattices and along rays.
fn cameras() -> [Camera; 3] {
    let (volume, _, camera) = scene();
    [camera, scaled(camera, 8.0), perspective(&volume, 80.0, 10.0, 30.0)]
}

#[test]
fn enqueued_frames_with_surfaces_have_the_bits_of_rendered_ones() {
    let (volume, transfer, _) = scene();
    let own = Settings { unit_distance: Some(4.0), ..Settings::default() };
    let ways = [own, Settings { blend: Blend::Maximum, ..own }, CONVERGED.into(), own.with_look(Look::Studio)];
    for host in hosts() {
        let mut renderer = renderer(&host.device(), &volume, &transfer);
        for (n, surfaces) in scenes(&volume).iter().enumerate() {
            renderer.set_surfaces(surfaces).unwrap();
            for settings in &ways {
                for camera in &cameras() {
                    // Enqueued first, so that it shares nothing with the other.
                    let enqueued = host.floats(&mut renderer, camera, settings);
                    let (expected, _) = renderer.render(camera, SIZE, settings).unwrap();
                    assert!(enqueued == expected, "scene {n}, {settings:?}");
                    assert!(host.floats(&mut renderer, camera, settings) == expected, "scene {n}, once more");
                    let background = Background::Color([0.2, 0.5, 1.0]);
                    let (expected, _) = renderer.render_rgba8(camera, SIZE, settings, background).unwrap();
                    let picture = host.room::<u8>(4 * SIZE.pixels());
                    let memory = DeviceMemory::from_buffer(&picture).unwrap();
                    let onto = PictureMemory::new(&memory, PictureFormat::Rgba8(background));
                    let event = renderer.enqueue(camera, SIZE, settings, &onto, &[]).unwrap();
                    assert_eq!(host.read(&picture, expected.len(), &[&event]), expected, "scene {n}, {settings:?}");
                    let sizes = renderer.scratch_bytes(camera, SIZE, settings, &onto).unwrap();
                    let scratch: Vec<_> =
                        sizes.iter().map(|&bytes| DeviceMemory::from_buffer(&host.room::<u8>(bytes)).unwrap()).collect();
                    renderer.set_scratch(&scratch).unwrap();
                    let event = renderer.enqueue(camera, SIZE, settings, &onto, &[]).unwrap();
                    assert_eq!(host.read(&picture, expected.len(), &[&event]), expected, "scene {n}, in the caller's memory");
                    renderer.set_scratch(&[]).unwrap();
                }
            }
        }
    }
}

/// While a frame waits for its event, surfaces and camera are replaced, and further frames are enqueued.
#[test]
fn surfaces_are_replaced_while_frames_wait() {
    let (volume, transfer, _) = scene();
    let settings = Settings { unit_distance: Some(4.0), ..Settings::default() };
    let views = || scenes(&volume).into_iter().zip(cameras().into_iter().cycle());
    for host in hosts() {
        let mut renderer = renderer(&host.device(), &volume, &transfer);
        let rendered = |(surfaces, camera): (Vec<Surface>, Camera)| {
            renderer.set_surfaces(&surfaces).unwrap();
            renderer.render(&camera, SIZE, &settings).unwrap().0
        };
        let expected: Vec<_> = views().map(rendered).collect();
        // Before the promise, for which all that is in an in-order queue waits.
        let pictures: Vec<_> = expected.iter().map(|_| host.room::<f32>(4 * SIZE.pixels())).collect();
        let promise = host.promise();
        let mut enqueue = |((surfaces, camera), picture): ((Vec<Surface>, Camera), _)| {
            renderer.set_surfaces(&surfaces).unwrap();
            let onto = PictureMemory::new(&DeviceMemory::from_buffer(picture).unwrap(), PictureFormat::Floats);
            renderer.enqueue(&camera, SIZE, &settings, &onto, &[&promise]).unwrap()
        };
        let frames: Vec<_> = views().zip(&pictures).map(&mut enqueue).collect();
        renderer.set_surfaces(&[]).unwrap();
        assert!(frames.iter().all(|event| event.command_execution_status().unwrap().0 != CL_COMPLETE));
        keep(&promise);
        for ((event, picture), expected) in frames.iter().zip(&pictures).zip(&expected) {
            assert!(frame(&host.read(picture, 4 * SIZE.pixels(), &[event])) == *expected);
        }
    }
}

#[test]
fn hundreds_of_translucent_surfaces_are_refused() {
    let (volume, transfer, camera) = scene();
    let host = Host::new(0);
    let mut renderer = renderer(&host.device(), &volume, &transfer);
    let settings = Settings::default();
    renderer.set_surfaces(&[stack(&volume, 300, 0.01)]).unwrap();
    let picture = host.room::<f32>(4 * SIZE.pixels());
    let onto = PictureMemory::new(&DeviceMemory::from_buffer(&picture).unwrap(), PictureFormat::Floats);
    let error = renderer.enqueue(&camera, SIZE, &settings, &onto, &[]).map(|_| ()).unwrap_err();
    assert_eq!(error.fields(), ["surfaces"]);
    let message = error.to_string();
    assert!(["300", "376 passes", "256", "use `render`"].iter().all(|part| message.contains(part)), "{message}");
    // Opaque ones end rays.
    renderer.set_surfaces(&[stack(&volume, 300, 1.0)]).unwrap();
    let (expected, _) = renderer.render(&camera, SIZE, &settings).unwrap();
    assert!(host.floats(&mut renderer, &camera, &settings) == expected, "and the queue goes on");
}
