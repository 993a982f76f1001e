//! Caller-provided scratch memory.

use crate::common::{POINTS, SPLATTED, layered, perspective};
use crate::host::{Host, SIZE, renderer, scene};
use layersplat::device::DeviceMemory;
use layersplat::renderer::{PictureFormat, PictureMemory};
use layersplat::settings::{Algorithm, Evaluation, Layered};
use layersplat::{Background, Camera, Orbit, Settings};

#[test]
fn a_frame_needs_as_much_as_it_says() {
    let (volume, transfer, camera) = scene();
    let host = Host::new(0);
    let device = host.device();
    let mut renderer = renderer(&device, &volume, &transfer);
    let shared = Orbit { azimuth: 45.5, elevation: 0.0, roll: 0.0 };
    let shared = Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), SIZE, shared);
    let settings = Settings::default();
    let of = |classification, evaluation| Settings {
        algorithm: Layered { classification, evaluation, ..layered(settings) }.into(),
        ..settings
    };
    let ways = [
        settings,
        of(SPLATTED, layered(settings).evaluation),
        of(POINTS, Evaluation::Direct),
        Algorithm::Slicing { step: 0.8 }.into(),
    ];
    // Beside the volume: the lattice is empty.
    let beside = glam::DVec3::new(1e4, 0.0, 0.0);
    let off_screen = Camera { position: camera.position + beside, focal_point: camera.focal_point + beside, ..camera };
    for settings in ways {
        for camera in [camera, shared, perspective(&volume, 80.0, 10.0, 30.0), off_screen] {
            let (floats, _) = renderer.render(&camera, SIZE, &settings).unwrap();
            let floats: Vec<u8> = floats.pixels().iter().flatten().flat_map(|c| c.to_ne_bytes()).collect();
            let (bytes, _) = renderer.render_rgba8(&camera, SIZE, &settings, Background::Transparent).unwrap();
            for format in [PictureFormat::Floats, PictureFormat::Rgba8(Background::Transparent)] {
                for gap in [0, 16] {
                    let pitch = SIZE.width as usize * format.bytes() + gap;
                    let picture = host.room::<u8>(pitch * SIZE.height as usize);
                    let onto = PictureMemory::new(&DeviceMemory::from_buffer(&picture).unwrap(), format).with_row_pitch(pitch);
                    let mut sizes = renderer.scratch_bytes(&camera, SIZE, &settings, &onto).unwrap();
                    let give = |renderer: &mut layersplat::Renderer, sizes: &[usize]| {
                        let of = |&bytes| DeviceMemory::from_buffer(&host.room::<u8>(bytes)).unwrap();
                        renderer.set_scratch(&sizes.iter().map(of).collect::<Vec<_>>()).unwrap();
                    };
                    give(&mut renderer, &sizes);
                    let own = device.allocated_bytes();
                    for _ in 0..2 {
                        let event = renderer.enqueue(&camera, SIZE, &settings, &onto, &[]).unwrap();
                        let found = host.read(&picture, pitch * SIZE.height as usize, &[&event]);
                        let expected = if format == PictureFormat::Floats { &floats } else { &bytes };
                        let rows = found.chunks(pitch).map(|row| &row[..pitch - gap]);
                        assert!(rows.eq(expected.chunks(pitch - gap)), "{settings:?}");
                    }
                    // Tables of splatted layers belong to the renderer, and are computed for every frame.
                    assert!(device.allocated_bytes() <= own, "pictures and lattices must be in the caller's memory");
                    let largest = sizes.iter_mut().max().unwrap();
                    *largest -= 16.min(*largest - 1);
                    give(&mut renderer, &sizes);
                    let error = renderer.enqueue(&camera, SIZE, &settings, &onto, &[]).map(|_| ()).unwrap_err().to_string();
                    assert!(error.contains("scratch_bytes"), "{error}");
                    renderer.set_scratch(&[]).unwrap();
                    renderer.enqueue(&camera, SIZE, &settings, &onto, &[]).unwrap().wait().unwrap();
                }
            }
        }
    }
}
