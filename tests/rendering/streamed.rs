//! Streaming of volumes beyond the device's memory is bit-identical to rendering them as a whole.

use crate::common::*;
use glam::DVec3;
use layersplat::layers::{Axis, Kernel};
use layersplat::renderer::{StreamPlan, StreamedRenderer, volume_renderer};
use layersplat::settings::{Algorithm, Blend, LayerAxis, Layered, Quality};
use layersplat::volume::{Endian, OpenOptions, Voxels};
use layersplat::{Camera, Device, Error, Frame, Projection, Renderer, Settings, TransferFunction, Viewport, Volume};
use std::time::Instant;

const DIMS: [usize; 3] = [240, 230, 260];
/// Divisor of the volume's bytes that gives the memory budget.
const SHARE: u64 = 4;
const SEED: u64 = 5;

/// A translucent volume, so that every part contributes.
fn scene() -> (Volume<'static>, TransferFunction, Viewport) {
    (random_volume(DIMS, DVec3::new(1.0, 0.9, 1.1), SEED), smooth_transfer(), viewport(40, 32))
}

fn thin(layered: Layered) -> Settings {
    Settings { unit_distance: Some(60.0), ..layered.into() }
}

fn splatted() -> Layered {
    Layered { classification: Quality::Standard.splatted(), ..Layered::default() }
}

fn bytes(volume: &Volume) -> u64 {
    (volume.grid().voxel_count() * volume.voxel_type().bytes()) as u64
}

/// Whether peak memory matches the announced one: the picture is allocated when the last part, slightly smaller, is present.
fn is_told(peak: u64, told: u64) -> bool {
    (told - told / 32..=told).contains(&peak)
}

/// A streamed picture, its announced plan, and peak memory on the device.
fn streamed(
    device: &Device,
    (volume, transfer): (&Volume, &TransferFunction),
    (camera, size): (&Camera, Viewport),
    settings: &Settings,
) -> (Frame, StreamPlan, u64) {
    let device = device.with_memory(device.memory_budget().unwrap_or(u64::MAX));
    let mut renderer = StreamedRenderer::new(&device, volume, transfer);
    let told = renderer.plan(camera, size, settings).unwrap().expect("layers on a lattice");
    let (frame, _) = renderer.render(camera, size, settings).unwrap();
    (frame, told, device.peak_bytes())
}

/// Asserts that a quarter of the volume's bytes suffices for its picture, bit for bit.
#[track_caller]
fn check(
    what: &str,
    axes: &[Axis],
    (volume, transfer): (&Volume, &TransferFunction),
    view: (&Camera, Viewport),
    settings: &Settings,
) {
    let budget = bytes(volume) / SHARE;
    let (frame, told, peak) = streamed(&device().with_memory(budget), (volume, transfer), view, settings);
    let found: Vec<Axis> = told.lattices.iter().map(|lattice| lattice.axis).collect();
    assert_eq!(found, axes, "{what}");
    for lattice in &told.lattices {
        assert!(lattice.parts as u64 >= SHARE, "{what}: {told}");
    }
    assert!(peak <= budget && told.memory == budget, "{what}: {peak} of {budget} bytes");
    assert!(is_told(peak, told.device_bytes), "{what}: {peak} bytes were taken, {} told", told.device_bytes);
    let whole = render(volume, transfer, view.0, view.1, settings);
    assert_close(what, &frame, &whole, 0.0);
    assert!(largest_opacity(&whole) < 0.99, "{what}: what is behind must count");
}

/// Every layer axis from both sides, in both projections, with both classifications.
#[test]
fn a_volume_of_four_times_the_budget() {
    let (volume, transfer, size) = scene();
    let along = [
        (Axis::X, 80.0, 12.0),
        (Axis::X, -78.0, -10.0),
        (Axis::Y, 15.0, 78.0),
        (Axis::Y, 200.0, -76.0),
        (Axis::Z, 20.0, -15.0),
        (Axis::Z, 170.0, 8.0),
    ];
    // Each projection has one classification from one side, and the other from the other side.
    let both = [Layered::default(), splatted()];
    for (n, (axis, azimuth, elevation)) in along.into_iter().enumerate() {
        // So close that a good part of the lattice is outside the view.
        let near = Projection::Perspective { field_of_view: 15.0 };
        let cameras = [
            scaled(parallel(&volume, size, azimuth, elevation), 110.0),
            Camera { projection: near, ..perspective(&volume, azimuth, elevation, 25.0) },
        ];
        for (camera, layered) in cameras.iter().zip([both[n % 2], both[(n + 1) % 2]]) {
            let what = format!("{axis:?}, {azimuth}, {:?}, {:?}", camera.projection, layered.classification);
            check(&what, &[axis], (&volume, &transfer), (camera, size), &thin(layered));
        }
    }
}

/// Near 45°, lattices of several axes are blended, one after the other.
#[test]
fn pictures_shared_by_axes() {
    let (_, transfer, size) = scene();
    let volume = random_volume(DIMS, DVec3::ONE, SEED);
    let camera = scaled(parallel(&volume, size, 45.2, 5.0), 110.0);
    check("shared", &[Axis::X, Axis::Z], (&volume, &transfer), (&camera, size), &thin(Layered::default()));
}

/// Reduced values, and lit samples of `high`, whose lattices are finer.
#[test]
fn other_settings() {
    let (volume, transfer, size) = scene();
    let camera = parallel(&volume, size, 75.0, 10.0);
    for settings in
        [Settings { blend: Blend::Maximum, ..thin(Layered::default()) }, thin(with_kernel(Quality::High, Kernel::Cubic))]
    {
        let (frame, told, peak) =
            streamed(&device().with_memory(bytes(&volume) / 2), (&volume, &transfer), (&camera, size), &settings);
        assert!(told.lattices[0].parts > 2 && peak <= told.device_bytes, "{told}");
        assert_close("other settings", &frame, &render(&volume, &transfer, &camera, size, &settings), 0.0);
    }
}

/// The B-spline's coefficients need 24 more layers; for layer axis x they have a separate layout.
#[test]
fn coefficients_of_parts() {
    for (axis, azimuth, dims) in [(Axis::Z, 3.0, [64, 56, 1300]), (Axis::X, 88.0, [2200, 64, 56])] {
        let volume = random_volume(dims, DVec3::ONE, SEED);
        let (transfer, size) = (smooth_transfer(), viewport(36, 30));
        let camera = scaled(parallel(&volume, size, azimuth, 2.0), 40.0);
        let layered = with_kernel(Quality::Standard, Kernel::BSpline);
        let settings = Settings { unit_distance: Some(600.0), ..layered.into() };
        check(&format!("{axis:?}"), &[axis], (&volume, &transfer), (&camera, size), &settings);
    }
}

/// The limit may be the size of a single buffer.
#[test]
fn the_largest_buffer() {
    let (volume, transfer, size) = scene();
    let camera = parallel(&volume, size, 20.0, -15.0);
    let small = device().with_largest_buffer(bytes(&volume) / SHARE);
    let settings = thin(Layered::default());
    let (frame, told, _) = streamed(&small, (&volume, &transfer), (&camera, size), &settings);
    assert!(told.lattices[0].parts as u64 > SHARE, "{told}");
    assert_close("small buffers", &frame, &render(&volume, &transfer, &camera, size, &settings), 0.0);
    // One part, as without a limit.
    let (_, told, _) = streamed(&device(), (&volume, &transfer), (&camera, size), &settings);
    assert_eq!((told.lattices[0].parts, told.voxel_bytes), (1, bytes(&volume)));
}

/// Mapped voxels are gathered from the file, in any byte order.
#[test]
fn files_in_another_byte_order() {
    let folder = tempfile::tempdir().unwrap();
    let dims = [70, 90, 110];
    let numbers: Vec<u8> = random_bytes(dims, SEED).into_iter().enumerate().flat_map(|(n, b)| [b, (n % 251) as u8]).collect();
    let path = folder.path().join("big_70x90x110_uint16.raw");
    std::fs::write(&path, numbers).unwrap();
    let volume = Volume::open(&path, &OpenOptions { endian: Some(Endian::Big), ..Default::default() }).unwrap();
    let transfer = TransferFunction::builtin("fire", &volume).unwrap();
    let size = viewport(30, 24);
    for (azimuth, elevation) in [(85.0, 5.0), (10.0, 80.0), (10.0, 5.0)] {
        let camera = parallel(&volume, size, azimuth, elevation);
        let settings = Settings { unit_distance: Some(40.0), ..Settings::default() };
        let (frame, told, _) =
            streamed(&device().with_memory(bytes(&volume) / 2), (&volume, &transfer), (&camera, size), &settings);
        assert!(told.lattices[0].parts > 2, "{told}");
        assert_close("big endian", &frame, &render(&volume, &transfer, &camera, size, &settings), 0.0);
    }
}

/// The announced memory suffices, and a byte less does not.
#[test]
fn too_little_is_refused_with_what_is_needed() {
    let (volume, transfer, size) = scene();
    for (azimuth, layered) in [(20.0, Layered::default()), (80.0, splatted())] {
        let camera = parallel(&volume, size, azimuth, 5.0);
        let settings = thin(layered);
        let plan =
            |budget: u64| StreamedRenderer::new(&device().with_memory(budget), &volume, &transfer).plan(&camera, size, &settings);
        let Err(Error::MemoryBudget { needed, budget, .. }) = plan(1000) else { panic!("1000 bytes are too little") };
        assert!(needed > 100_000 && budget == 1000, "{needed} of {budget}");
        assert!(matches!(plan(needed - 1), Err(Error::MemoryBudget { needed: again, .. }) if again == needed));
        let (frame, told, peak) = streamed(&device().with_memory(needed), (&volume, &transfer), (&camera, size), &settings);
        assert!(told.lattices[0].held_layers == 5 && told.device_bytes == needed, "a layer and two on each side: {told}");
        assert!(is_told(peak, needed), "{peak} of {needed}");
        assert_close("least memory", &frame, &render(&volume, &transfer, &camera, size, &settings), 0.0);
    }
    let message = StreamedRenderer::new(&device().with_largest_buffer(9000), &volume, &transfer)
        .plan(&parallel(&volume, size, 20.0, 5.0), size, &thin(Layered::default()))
        .unwrap_err()
        .to_string();
    assert!(message.contains("9000 in one buffer"), "{message}");
}

/// Rays with different axes, and other algorithms, need the whole volume: rejected if it does not fit, rendered otherwise.
#[test]
fn views_that_need_the_whole_volume() {
    let (volume, transfer, size) = scene();
    let outside = parallel(&volume, size, 20.0, 5.0);
    let inside = Camera { position: volume.grid().centre() + DVec3::X, ..perspective(&volume, 20.0, 5.0, 60.0) };
    let paper = Layered { layer_axis: LayerAxis::Auto, ..Quality::Paper.layered() };
    let raycast = Algorithm::Raycast { kernel: Kernel::Linear, step: 1.0 };
    for (camera, settings) in [(inside, thin(Layered::default())), (outside, raycast.into()), (outside, thin(paper))] {
        let mut small = StreamedRenderer::new(&device().with_memory(bytes(&volume) / SHARE), &volume, &transfer);
        let found = small.render(&camera, size, &settings).expect_err("too little");
        assert!(matches!(found, Error::MemoryBudget { needed, .. } if needed > bytes(&volume)), "{found}");
        assert!(found.to_string().contains("needs the whole volume"), "{found}");
    }
    // The announced memory suffices, and a byte less does not.
    for (camera, settings) in [
        (inside, thin(Layered::default())),
        (outside, Settings { unit_distance: Some(60.0), ..raycast.into() }),
        (outside, thin(paper)),
    ] {
        let render_with = |budget| {
            let mut renderer = StreamedRenderer::new(&device().with_memory(budget), &volume, &transfer);
            renderer.render(&camera, size, &settings).map(|(frame, _)| frame)
        };
        let Err(Error::MemoryBudget { needed, .. }) = render_with(1000) else { panic!("1000 bytes are too little") };
        assert!(matches!(render_with(needed - 1), Err(Error::MemoryBudget { needed: again, .. }) if again == needed));
        assert_close("least memory", &render_with(needed).unwrap(), &render(&volume, &transfer, &camera, size, &settings), 0.0);
    }
    // Eight times the volume suffices for all data of ray casting.
    let large = device().with_memory(8 * bytes(&volume));
    let mut renderer = StreamedRenderer::new(&large, &volume, &transfer);
    let settings = Settings { unit_distance: Some(60.0), ..raycast.into() };
    assert!(renderer.plan(&outside, size, &settings).unwrap().is_none(), "nothing is streamed");
    let whole = render(&volume, &transfer, &outside, size, &settings);
    assert_close("rays", &renderer.render(&outside, size, &settings).unwrap().0, &whole, 0.0);
    // Cached data stay, and are evicted when needed.
    let settings = thin(Layered::default());
    let whole = render(&volume, &transfer, &outside, size, &settings);
    assert_close("layers", &renderer.render(&outside, size, &settings).unwrap().0, &whole, 0.0);
}

/// Like pictures that need the whole volume: the announced memory suffices, also beside cached data of an earlier picture, and a byte
/// less does not.
#[test]
fn depths_need_the_whole_volume() {
    let (volume, transfer, size) = scene();
    let (camera, settings) = (parallel(&volume, size, 20.0, 5.0), thin(Layered::default()));
    let expected = Renderer::new(&device(), &volume, &transfer).unwrap().depths(&camera, size, &settings).unwrap();
    let renderer_with = |budget| StreamedRenderer::new(&device().with_memory(budget), &volume, &transfer);
    let depths_with = |budget| renderer_with(budget).depths(&camera, size, &settings);
    let error = depths_with(1000).expect_err("1000 bytes are too little");
    let message = error.to_string();
    assert!(message.starts_with("a depth picture (rays") && message.contains("needs the whole volume"), "{message}");
    let Error::MemoryBudget { needed, taken: 0, budget: 1000, .. } = error else { panic!("{message}") };
    assert!(needed > bytes(&volume) && message.ends_with(&format!("set at least {needed}")), "{message}");
    assert!(matches!(depths_with(needed - 1), Err(Error::MemoryBudget { needed: again, .. }) if again == needed));
    assert!(depths_with(needed).unwrap() == expected);
    let mut renderer = renderer_with(needed);
    renderer.render(&camera, size, &settings).unwrap();
    assert!(renderer.depths(&camera, size, &settings).unwrap() == expected);
    // Invalid settings are reported before the memory.
    let maximum = Settings { blend: Blend::Maximum, ..settings };
    assert!(matches!(renderer_with(1000).depths(&camera, size, &maximum), Err(Error::Settings { field: "blend", .. })));
    // Pictures of layers still fit in parts.
    assert!(renderer_with(needed - 1).render(&camera, size, &settings).is_ok());
}

/// Streamed in parts, and as a whole; with other dimensions, another type and another range.
#[test]
fn another_volume_is_streamed() {
    let (volume, transfer, size) = scene();
    let dims = [120, 92, 161];
    let numbers = random_bytes(dims, SEED).into_iter().map(|b| i16::from(b) * 5 - 300).collect();
    let other = crate::common::volume(dims, DVec3::new(1.0, 1.2, 0.8), Voxels::Int16(numbers));
    let (settings, camera) = (thin(Layered::default()), parallel(&other, size, 20.0, 5.0));
    let expected = render(&other, &transfer, &camera, size, &settings);
    for (budget, is_in_parts) in [(bytes(&volume) / SHARE, true), (1 << 30, false)] {
        let mut renderer = StreamedRenderer::new(&device().with_memory(budget), &volume, &transfer);
        renderer.render(&parallel(&volume, size, 20.0, 5.0), size, &settings).unwrap();
        renderer.set_volume(&other);
        let plan = renderer.plan(&camera, size, &settings).unwrap().expect("a lattice");
        assert_eq!(plan.lattices[0].parts > 1, is_in_parts, "{plan}");
        assert_close("another volume", &renderer.render(&camera, size, &settings).unwrap().0, &expected, 0.0);
    }
}

/// By every kind of renderer behind the trait.
#[test]
fn another_volume_replaces_the_first() {
    let (volume, transfer, size) = scene();
    let other = random_volume([40, 52, 61], DVec3::new(1.0, 1.2, 0.8), SEED + 1);
    let (settings, camera) = (thin(Layered::default()), parallel(&other, size, 20.0, 5.0));
    let expected = render(&other, &transfer, &camera, size, &settings);
    for device in [device(), device().with_memory(bytes(&volume) / SHARE)] {
        let mut renderer = volume_renderer(&device, &volume, &transfer).unwrap();
        renderer.render(&parallel(&volume, size, 20.0, 5.0), size, &settings).unwrap();
        renderer.set_volume(&other).unwrap();
        let (frame, _) = renderer.render(&camera, size, &settings).unwrap();
        assert_close("another volume", &frame.expect("one process"), &expected, 0.0);
    }
}

/// If all voxels fit, data cached between frames are evicted for another axis.
#[test]
fn what_is_kept_makes_room() {
    let volume = random_volume([120, 100, 110], DVec3::ONE, SEED);
    let (transfer, size) = (smooth_transfer(), viewport(40, 32));
    let views = [(80.0, 5.0), (20.0, 5.0), (20.0, 80.0), (45.0, 5.0), (80.0, 5.0), (80.0, 5.0)];
    let settings = thin(Layered::default());
    let cameras = views.map(|(azimuth, elevation)| parallel(&volume, size, azimuth, elevation));
    let needed = |camera| {
        let large = device().with_memory(1 << 30);
        StreamedRenderer::new(&large, &volume, &transfer).plan(camera, size, &settings).unwrap().unwrap().device_bytes
    };
    let budget = cameras.iter().map(needed).max().unwrap();
    let small = device().with_memory(budget);
    let mut renderer = StreamedRenderer::new(&small, &volume, &transfer);
    let mut whole = Renderer::new(&device(), &volume, &transfer).unwrap();
    for (n, camera) in cameras.iter().enumerate() {
        let told = renderer.plan(camera, size, &settings).unwrap().unwrap();
        assert!(told.memory == budget && told.lattices.iter().all(|lattice| lattice.parts == 1), "view {n}: {told}");
        let expected = whole.render(camera, size, &settings).unwrap().0;
        assert_close(&format!("view {n}"), &renderer.render(camera, size, &settings).unwrap().0, &expected, 0.0);
    }
    assert!(small.peak_bytes() <= budget);
    // Two renderers share a budget: data cached by one reduce that of the other.
    let other = StreamedRenderer::new(&small, &volume, &transfer).plan(&cameras[0], size, &settings);
    let Err(Error::MemoryBudget { needed, taken, budget: all, .. }) = other else {
        panic!("the budget must not suffice for two")
    };
    assert!(all == budget && needed + taken > budget && taken > bytes(&volume), "{needed} beside {taken} of {all}");
    drop(renderer);
    let alone = StreamedRenderer::new(&small, &volume, &transfer).plan(&cameras[0], size, &settings).unwrap().unwrap();
    assert_eq!(alone.memory, budget);
}

/// 4 GiB of voxels with a budget of 512 MiB. Prints time and memory.
#[test]
#[ignore = "renders 4 GiB of voxels, some minutes on two cores: cargo test --release --test rendering streamed:: -- --ignored --nocapture"]
fn four_gibibytes() {
    let begun = Instant::now();
    let volume = Volume::open("builtin:marschner-lobb@2048x2048x1024", &OpenOptions::default()).unwrap();
    let first_pass = begun.elapsed().as_secs_f64();
    let transfer = TransferFunction::builtin("fire", &volume).unwrap();
    let (size, memory) = (viewport(512, 512), 512 << 20);
    let small = device().with_memory(memory);
    for (azimuth, elevation) in [(20.0, 15.0), (75.0, 15.0), (20.0, 70.0)] {
        let camera = parallel(&volume, size, azimuth, elevation);
        let begun = Instant::now();
        let settings = Settings { unit_distance: Some(100.0), ..Settings::default() };
        let (frame, told, peak) = streamed(&small, (&volume, &transfer), (&camera, size), &settings);
        let seconds = begun.elapsed().as_secs_f64();
        assert!(peak <= memory && largest_opacity(&frame) > 0.1);
        eprintln!(
            "{told}\n  first pass {first_pass:.1} s; picture {seconds:.1} s, {:.0} MB/s of the volume; {peak} bytes on the device",
            bytes(&volume) as f64 / seconds / 1e6
        );
    }
    // If the system reports it: the whole volume must never be in memory.
    if let Ok(status) = std::fs::read_to_string("/proc/self/status") {
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
        let most: u64 = line.trim().strip_suffix(" kB").unwrap().trim().parse().unwrap();
        eprintln!("at most {} MiB of the process", most >> 10);
        assert!(most << 10 < bytes(&volume) / 2);
    }
}
