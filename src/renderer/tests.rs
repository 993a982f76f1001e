//! Caching and sharing in renderers.

use super::field::Placement;
use super::*;
use crate::camera::Orbit;
use crate::device::DeviceChoice;
use crate::device::launch::VoxelBuffer;
use crate::layers::Kernel;
use crate::settings::{Algorithm, Blend, Evaluation, Layered, Quality};
use crate::volume::{OpenOptions, Sequence};
use glam::DVec3;

fn device() -> Device {
    Device::open(&DeviceChoice::Default).expect("the tests need an OpenCL device: scripts/test installs PoCL")
}

fn hydrogen(size: &str) -> (Volume<'static>, TransferFunction) {
    let volume = Volume::open(format!("builtin:hydrogen@{size}"), &OpenOptions::default()).unwrap();
    let transfer = TransferFunction::builtin("fire", &volume).unwrap();
    (volume, transfer)
}

fn camera(volume: &Volume, viewport: Viewport, azimuth: f64) -> Camera {
    let orbit = Orbit { azimuth, elevation: 10.0, roll: 0.0 };
    Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, orbit)
}

/// A renderer, and two views with different layer axes.
fn renderer() -> (Renderer, [Camera; 2], Viewport) {
    let (volume, transfer) = hydrogen("24");
    let viewport = Viewport::new(40, 32).unwrap();
    let cameras = [20.0, 80.0].map(|azimuth| camera(&volume, viewport, azimuth));
    (Renderer::new(&device(), &volume, &transfer).unwrap(), cameras, viewport)
}

/// Number of values that a renderer has made.
fn made(renderer: &Renderer) -> usize {
    renderer.engine.field().made() + renderer.engine.classification().made()
}

#[test]
fn renderers_can_move_between_threads() {
    fn movable<T: Send>() {}
    movable::<Renderer>();
}

/// Repeated dragging in `draft` and resting in `high`, lit and unlit, from several sides.
#[test]
fn derived_data_are_made_once() {
    let (mut renderer, cameras, viewport) = renderer();
    let unlit = |settings: Settings| Settings { shading: None, ..settings };
    let drag = |renderer: &mut Renderer| {
        for settings in [Quality::Draft.settings(), Quality::High.settings(), unlit(Quality::Draft.settings())] {
            for camera in cameras {
                renderer.render(&camera, viewport, &settings).unwrap();
            }
        }
    };
    drag(&mut renderer);
    let before = made(&renderer);
    assert!(before > 4, "tables, integrals and blocks are made");
    (0..3).for_each(|_| drag(&mut renderer));
    assert_eq!(made(&renderer), before);
    renderer.set_transfer_function(&renderer.transfer_function().clone());
    drag(&mut renderer);
    assert_eq!(made(&renderer), before, "setting an equal transfer function changes nothing");
}

/// Data derived from the voxels alone are made once for all renderers, also measured in bytes on the device.
#[test]
fn renderers_of_an_uploaded_volume_share_derived_data() {
    let (volume, transfer) = hydrogen("40");
    let viewport = Viewport::new(40, 32).unwrap();
    let device = device().with_memory(u64::MAX - 1);
    let uploaded = UploadedVolume::new(&device, &volume).unwrap();
    let mut renderers = [0.5, 1.0].map(|share| Renderer::from_uploaded(&uploaded, &transfer.faded(share).unwrap()).unwrap());
    // The B-spline along x needs coefficients and their layout: twice four bytes per voxel.
    let (along_x, settings) = (camera(&volume, viewport, 80.0), Quality::High.settings());
    let mut grown = renderers.each_mut().map(|renderer| {
        let before = device.taken_bytes();
        renderer.render(&along_x, viewport, &settings).unwrap();
        device.taken_bytes() - before
    });
    let coefficients = 2 * size_of::<f32>() * volume.grid().voxel_count();
    assert!(grown[0] > coefficients as u64, "{grown:?}");
    assert!(grown[1] < grown[0] - coefficients as u64, "{grown:?}: the second has only its tables and pictures");
    // Check that the test detects renderers that share nothing.
    let before = device.taken_bytes();
    let mut alone = Renderer::new(&device, &volume, &transfer).unwrap();
    alone.render(&along_x, viewport, &settings).unwrap();
    grown[1] = device.taken_bytes() - before;
    assert!(grown[1] > coefficients as u64, "{grown:?}");
}

#[test]
fn a_new_volume_replaces_the_previous_one() {
    let device = device();
    let viewport = Viewport::new(40, 32).unwrap();
    let [(first, transfer), (second, _), (smaller, _)] = ["24", "24x20x22", "12"].map(hydrogen);
    let mut renderer = Renderer::new(&device, &first, &transfer).unwrap();
    let settings = Settings::default();
    renderer.render(&camera(&first, viewport, 20.0), viewport, &settings).unwrap();
    let volumes = [&second, &smaller, &first];
    // Views need different programs; build them now.
    let expected = volumes.map(|volume| {
        let camera = camera(volume, viewport, 20.0);
        Renderer::new(&device, volume, &transfer).unwrap().render(&camera, viewport, &settings).unwrap().0
    });
    let (programs, buffer) = (device.programs(), renderer.engine.field().voxel_buffer());
    for (volume, expected) in volumes.into_iter().zip(expected) {
        renderer.set_volume(volume).unwrap();
        let camera = camera(volume, viewport, 20.0);
        assert!(renderer.render(&camera, viewport, &settings).unwrap().0 == expected, "{}", volume.name());
        assert_eq!(renderer.grid(), volume.grid());
    }
    assert_eq!(device.programs(), programs, "no program is built again");
    assert_eq!(renderer.engine.field().voxel_buffer(), buffer, "the voxels are in the buffer of the first volume");
    // A volume uploaded in the meantime, and one that another renderer uses.
    let uploaded = UploadedVolume::new(&device, &second).unwrap();
    let camera = camera(&second, viewport, 20.0);
    let expected = Renderer::from_uploaded(&uploaded, &transfer).unwrap().render(&camera, viewport, &settings).unwrap().0;
    renderer.set_uploaded_volume(&uploaded).unwrap();
    assert!(renderer.render(&camera, viewport, &settings).unwrap().0 == expected);
    renderer.set_volume(&smaller).unwrap();
    let shared = Renderer::from_uploaded(&uploaded, &transfer).unwrap().render(&camera, viewport, &settings).unwrap().0;
    assert!(shared == expected, "voxels that others use are not overwritten");
}

/// The steps of a sequence share the programs and the buffers of the first, along both layer axes.
#[test]
fn steps_of_a_sequence_need_no_program_and_no_memory() {
    let sources = ["hydrogen", "gyroid", "torus-knot", "shepp-logan"].map(|name| format!("builtin:{name}@40"));
    let sequence = Sequence::open(&sources, &OpenOptions::default()).unwrap();
    let device = device().with_memory(u64::MAX - 1);
    let viewport = Viewport::new(40, 32).unwrap();
    let first = sequence.step(0).unwrap();
    let transfer = TransferFunction::builtin("fire", &sequence.overview().unwrap()).unwrap();
    let cameras = [20.0, 80.0].map(|azimuth| camera(&first, viewport, azimuth));
    let settings = Settings::default();
    let before = device.taken_bytes();
    let mut renderer = Renderer::new(&device, &first, &transfer).unwrap();
    let draw = |renderer: &mut Renderer| cameras.map(|camera| renderer.render(&camera, viewport, &settings).unwrap().0);
    let mut pictures = vec![draw(&mut renderer)];
    let (programs, taken) = (device.programs(), device.taken_bytes() - before);
    for step in sequence.play(vec![1, 2, 3]) {
        renderer.set_volume(&step.unwrap()).unwrap();
        pictures.push(draw(&mut renderer));
        assert_eq!(device.programs(), programs, "no program is built for a step");
        let now = device.taken_bytes() - before;
        assert!(now <= taken, "a step takes no further memory: {now} bytes after {taken}");
    }
    assert!(pictures.windows(2).all(|pair| pair[0] != pair[1]));
    // A second copy of a step would be noticed.
    let one = UploadedVolume::new(&device, &first).unwrap();
    assert!(device.taken_bytes() - before > taken);
    drop(one);
}

/// A different range needs different tables.
#[test]
fn another_volume_brings_its_own_range() {
    let device = device();
    let viewport = Viewport::new(40, 32).unwrap();
    let grid = Grid::new([12, 10, 14], DVec3::ONE).unwrap();
    let volume = |scale: i16| {
        let voxels: Vec<i16> = (0..grid.voxel_count() as i16).map(|n| n.wrapping_mul(37).rem_euclid(251) * scale).collect();
        Volume::new("scaled", grid.clone(), voxels).unwrap()
    };
    let [first, second] = [1, 3].map(volume);
    let transfer = TransferFunction::builtin("fire", &second).unwrap();
    let (camera, settings) = (camera(&first, viewport, 20.0), Settings::default());
    let mut renderer = Renderer::new(&device, &first, &transfer).unwrap();
    let before = renderer.render(&camera, viewport, &settings).unwrap().0;
    renderer.set_volume(&second).unwrap();
    let expected = Renderer::new(&device, &second, &transfer).unwrap().render(&camera, viewport, &settings).unwrap().0;
    assert!(renderer.render(&camera, viewport, &settings).unwrap().0 == expected && before != expected);
}

/// Cached data of earlier frames are dropped if memory is insufficient.
#[test]
fn cached_data_are_dropped_if_memory_is_insufficient() {
    let (volume, transfer) = hydrogen("40");
    let viewport = Viewport::new(40, 32).unwrap();
    let cameras = [20.0, 80.0].map(|azimuth| camera(&volume, viewport, azimuth));
    let settings = Quality::High.settings();
    let frame = |device: &Device, camera| {
        Renderer::new(device, &volume, &transfer).unwrap().render(camera, viewport, &settings).unwrap().0
    };
    let needed = cameras.each_ref().map(|camera| {
        let device = device().with_memory(u64::MAX - 1);
        frame(&device, camera);
        device.peak_bytes()
    });
    let small = device().with_memory(needed.into_iter().max().unwrap());
    let mut renderer = Renderer::new(&small, &volume, &transfer).unwrap();
    for camera in [&cameras[0], &cameras[1], &cameras[0], &cameras[1]] {
        assert!(renderer.render(camera, viewport, &settings).unwrap().0 == frame(&device(), camera));
    }
    let less = device().with_memory(needed.into_iter().min().unwrap() / 2);
    let refused = Renderer::new(&less, &volume, &transfer).unwrap().render(&cameras[1], viewport, &settings);
    assert!(matches!(refused, Err(Error::MemoryBudget { .. })));
}

/// Layers whose distance in bytes exceeds an int: rays sample the same voxels there.
#[test]
fn voxels_far_apart() {
    /// Row count that sets the layer distance. 6 layers are 2.3 GB, of which only a few rows are touched.
    const ROWS: usize = 42_000_000;
    const DIMS: [usize; 3] = [9, 8, 6];
    let device = device();
    let bytes: Vec<u8> = (0..DIMS.iter().product()).map(|n: usize| (n * 37 % 251) as u8).collect();
    let grid = Grid::new(DIMS, DVec3::ONE).unwrap();
    let volume = Volume::new("far", grid, bytes.as_slice()).unwrap();
    let transfer = TransferFunction::builtin("fire", &volume).unwrap();
    let viewport = Viewport::new(24, 20).unwrap();
    // A view across the layers, so that the rays of a vector are in several layers.
    let orbit = Orbit { azimuth: 85.0, elevation: 8.0, roll: 70.0 };
    let camera = Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, orbit);
    let mut renderer = Renderer::new(&device, &volume, &transfer).unwrap();
    let raycast = |kernel| Algorithm::Raycast { kernel, step: 0.3 };
    let algorithms = [Algorithm::Slicing { step: 0.5 }, raycast(Kernel::Cubic)];
    let frames =
        |renderer: &mut Renderer| algorithms.map(|algorithm| renderer.render(&camera, viewport, &algorithm.into()).unwrap().0);
    let near = frames(&mut renderer);
    assert!(near.iter().all(|frame| frame.pixels().iter().any(|p| p[3] > 0.1)));
    let layer = DIMS[0] * DIMS[1];
    // Layers of this many rows match the buffer; the min-max blocks are cached from before.
    let placed = Placement::dense([DIMS[0], ROWS, DIMS[2]]);
    match VoxelBuffer::with_gaps(&device, bytes.chunks(layer), DIMS[0] * ROWS) {
        Ok(voxels) => {
            assert!(voxels.kind().far);
            renderer.engine.field_mut().exchange(voxels, placed);
        }
        Err(e) => return eprintln!("SKIPPED: not enough device memory for voxels far apart: {e}"),
    }
    assert!(frames(&mut renderer) == near, "voxels far apart differ");
}

/// After a frame fails behind its first kernel, the next report contains none of its stages.
#[test]
fn a_failed_frame_leaves_nothing_to_the_next() {
    let (mut renderer, [camera, _], viewport) = renderer();
    renderer.measure(true);
    let settings = Settings::default();
    let stages = |renderer: &mut Renderer| -> Vec<&str> {
        let measured = renderer.render(&camera, viewport, &settings).unwrap().1.measured.unwrap();
        measured.stages.into_iter().map(|(stage, _)| stage).collect()
    };
    stages(&mut renderer);
    let alone = stages(&mut renderer);
    let cast = renderer.planned(&camera, viewport, &Algorithm::Slicing { step: 0.5 }.into()).unwrap();
    let failed: Result<((), _), _> = renderer.run(&cast, Output::Floats, |device, _| {
        assert!(!device.stage_times().unwrap().is_empty(), "the failed frame was timed itself");
        Err(Error::Cancelled { stage: "delivering" })
    });
    assert!(failed.is_err());
    assert_eq!(stages(&mut renderer), alone);
}

/// Declared bytes above the peak: tables and integrals are declared by their largest size, and not all buffers exist at the same time.
const DECLARED_MORE: f64 = 1.6;

/// Every buffer of a frame is declared: the device never holds more than the declarations add up to. Sheets are excepted, since the device
/// counts their splats.
#[test]
fn frames_take_what_they_declare() {
    let (volume, transfer) = hydrogen("40");
    let viewport = Viewport::new(40, 32).unwrap();
    let [own, x, two_axes] = [20.0, 80.0, 45.0].map(|azimuth| camera(&volume, viewport, azimuth));
    let inside = Camera { position: volume.grid().centre(), ..own };
    let inside = Camera {
        focal_point: inside.position + DVec3::X,
        projection: crate::camera::Projection::Perspective { field_of_view: 90.0 },
        ..inside
    };
    let standard = Settings::default();
    let splats = Layered { classification: Quality::Standard.splatted(), ..Default::default() };
    let per_pixel = Layered { evaluation: Evaluation::Direct, ..Default::default() };
    let iso = Settings { blend: Blend::Iso(90.0), ..standard };
    let cases = [
        (own, standard),
        (x, standard),
        (two_axes, standard),
        (inside, standard),
        (x, Quality::High.settings()),
        (own, splats.into()),
        (own, per_pixel.into()),
        (own, Quality::Paper.settings()),
        (own, Settings { blend: Blend::Maximum, ..standard }),
        (own, iso),
        (own, Algorithm::Slicing { step: 0.5 }.into()),
        (own, Algorithm::Raycast { kernel: Kernel::Linear, step: 0.5 }.into()),
    ];
    for (camera, settings) in cases {
        let device = device().with_memory(u64::MAX - 1);
        let mut renderer = Renderer::new(&device, &volume, &transfer).unwrap();
        renderer.render(&camera, viewport, &settings).unwrap();
        let Planned { plan, .. } = renderer.planned(&camera, viewport, &settings).unwrap();
        let declare = |declaring: &frame::Declaring| Stage::from_plan(&plan, Output::Floats, false, declaring).resources.bytes();
        let (declared, peak) = (renderer.engine.declaring(viewport, &settings, declare).sum, device.peak_bytes());
        assert!(peak <= declared, "{plan}: {peak} bytes are more than the {declared} declared");
        assert!(declared as f64 <= DECLARED_MORE * peak as f64, "{plan}: {declared} bytes are declared, and {peak} used");
    }
}
