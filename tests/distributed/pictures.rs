//! Pictures of several ranks compared with those of one process.

use crate::common::*;
use crate::devices::{BrickOnDevice, held_bytes};
use glam::DVec3;
use layersplat::distributed::{Brick, DistributedReport, Group, Renderer};
use layersplat::renderer::{Accumulation, VolumeRenderer};
use layersplat::settings::{Blend, Classification, Layered};
use layersplat::volume::VoxelBox;
use layersplat::{Camera, Cancel, Frame, Quality, Settings, TransferFunction, Viewport, Volume};

/// Not multiples of any number of ranks, and all different.
pub const DIMS: [usize; 3] = [23, 19, 26];
const SEED: u64 = 5;
/// Rounding of `over` in another order.
const REASSOCIATED: f64 = 2e-6;
/// Parts behind an opaque front are not terminated.
const TERMINATED: f64 = Settings::OPAQUE + REASSOCIATED;

/// All voxels, which every rank has for comparison.
pub fn whole() -> Volume<'static> {
    whole_of(SEED)
}

fn whole_of(seed: u64) -> Volume<'static> {
    random_volume(DIMS, DVec3::new(1.0, 1.2, 0.8), seed)
}

/// Brick of a rank: a slab along z without ghosts, or a box that another rank's axis divides, with some ghosts.
pub fn brick(group: &Group, axis: usize, ghosts: usize) -> Brick {
    let (rank, size) = (group.rank(), group.size());
    let (mut own, mut held) = (VoxelBox::whole(DIMS), VoxelBox::whole(DIMS));
    let layers = rank * DIMS[axis] / size..(rank + 1) * DIMS[axis] / size;
    (own.first[axis], own.dims[axis]) = (layers.start, layers.len());
    let around = layers.start.saturating_sub(ghosts)..(layers.end + ghosts).min(DIMS[axis]);
    (held.first[axis], held.dims[axis]) = (around.start, around.len());
    Brick { own, held }
}

/// A rank's part of the same voxels.
pub fn shared(group: &Group, axis: usize, ghosts: usize) -> Volume<'static> {
    shared_of(SEED, group, axis, ghosts)
}

fn shared_of(seed: u64, group: &Group, axis: usize, ghosts: usize) -> Volume<'static> {
    let (all, brick) = (random_bytes(DIMS, seed), brick(group, axis, ghosts));
    let VoxelBox { first, dims } = brick.held;
    let voxel = |n: usize| {
        let place = [n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]];
        let [x, y, z] = [0, 1, 2].map(|i| first[i] + place[i]);
        all[x + DIMS[0] * (y + DIMS[1] * z)]
    };
    let voxels: Vec<u8> = (0..brick.held.count()).map(voxel).collect();
    group.volume("shared", whole().grid().clone(), brick, voxels).unwrap().with_background(0.0).unwrap()
}

/// Views along all axes from both sides, in both projections, and one blended from several axes.
fn views(volume: &Volume, size: Viewport) -> Vec<Camera> {
    let turns = [(80.0, 12.0), (-70.0, -20.0), (15.0, 72.0), (20.0, -15.0), (170.0, 8.0), (45.0, 0.0)];
    let parallel = turns.iter().map(|&(azimuth, elevation)| parallel(volume, size, azimuth, elevation));
    parallel.chain(turns[..5].iter().map(|&(azimuth, elevation)| perspective(volume, azimuth, elevation, 25.0))).collect()
}

pub fn drawn(
    renderer: &mut Renderer,
    camera: &Camera,
    size: Viewport,
    settings: &Settings,
) -> Option<(Frame, DistributedReport)> {
    let (frame, report) = renderer.render(camera, size, settings).unwrap();
    frame.map(|frame| (frame, report))
}

fn splatted() -> Settings {
    Settings::from(Layered { classification: SPLATTED, ..layered(Quality::Standard.settings()) })
}

pub fn are_those_of_one_process(group: &Group) {
    let (volume, size, transfer) = (whole(), viewport(56, 44), smooth_transfer());
    let (device, ghosts) = (device(), 2);
    let mut alone = layersplat::Renderer::new(&device, &volume, &transfer).unwrap();
    for axis in [2, 0] {
        let mut together = Renderer::new(group, &device, &shared(group, axis, ghosts), &transfer).unwrap();
        for settings in [Quality::Standard.settings(), Quality::High.settings(), splatted()] {
            for early_termination in [false, true] {
                let settings = Settings { early_termination, ..settings };
                for (n, camera) in views(&volume, size).iter().enumerate() {
                    let Some((frame, report)) = drawn(&mut together, camera, size, &settings) else { continue };
                    let (expected, _) = alone.render(camera, size, &settings).unwrap();
                    assert!(largest_opacity(&expected) > 0.2);
                    let tolerance = if early_termination { TERMINATED } else { REASSOCIATED };
                    let what = format!("view {n} of {group:?}, slabs along {axis}, {settings:?}");
                    assert_close(&what, &frame, &expected, if group.size() == 1 { 0.0 } else { tolerance });
                    assert_eq!(report.ranks.len(), group.size());
                    let drawn: usize = report.ranks.iter().map(|rank| rank.layers).sum();
                    assert_eq!(drawn, report.axes.iter().map(|axis| DIMS[axis.index()]).sum::<usize>());
                }
            }
        }
    }
    // Several lattices of a picture are rendered correctly even if the cache holds nothing for the next one.
    let mut forgetful = Renderer::new(group, &device, &shared(group, 2, ghosts), &transfer).unwrap();
    forgetful.keep(false);
    let settings = Settings { early_termination: false, ..Settings::default() };
    for camera in [parallel(&volume, size, 45.0, 0.0), parallel(&volume, size, 80.0, 12.0), parallel(&volume, size, 45.0, 0.0)] {
        if let Some((frame, _)) = drawn(&mut forgetful, &camera, size, &settings) {
            let (expected, _) = alone.render(&camera, size, &settings).unwrap();
            assert_close("forgetful", &frame, &expected, if group.size() == 1 { 0.0 } else { REASSOCIATED });
        }
    }
    // The comparison must detect a small change of the view.
    let settings = Settings { early_termination: false, ..Settings::default() };
    let mut together = Renderer::new(group, &device, &shared(group, 2, ghosts), &transfer).unwrap();
    let turned = parallel(&volume, size, 20.05, -15.0);
    if let Some((frame, _)) = drawn(&mut together, &turned, size, &settings) {
        let (other, _) = alone.render(&parallel(&volume, size, 20.0, -15.0), size, &settings).unwrap();
        assert!(compare(&frame, &other).max_difference > 10.0 * REASSOCIATED);
    }
}

pub fn in_every_blend_mode(group: &Group) {
    let (volume, size, transfer) = (whole(), viewport(48, 40), smooth_transfer());
    let device = device();
    let mut alone = layersplat::Renderer::new(&device, &volume, &transfer).unwrap();
    let mut together = Renderer::new(group, &device, &shared(group, 2, 0), &transfer).unwrap();
    for blend in [Blend::Maximum, Blend::Minimum, Blend::Average, Blend::Iso(128.0)] {
        for camera in
            [parallel(&volume, size, 30.0, 20.0), parallel(&volume, size, 200.0, -10.0), parallel(&volume, size, 85.0, 3.0)]
        {
            let settings = Settings { blend, early_termination: false, ..Settings::default() };
            let Some((frame, _)) = drawn(&mut together, &camera, size, &settings) else { continue };
            let (expected, _) = alone.render(&camera, size, &settings).unwrap();
            // Means are sums of about 25 layers in another order, looked up in a colour table.
            let tolerance = if blend == Blend::Average { 1e-4 } else { REASSOCIATED };
            assert_close(&format!("{blend:?} of {group:?}"), &frame, &expected, tolerance);
        }
    }
}

/// Means of jittered frames are those of one process: in both projections, with lattices of one and of several axes.
pub fn accumulate(group: &Group) {
    let (volume, size, transfer) = (whole(), viewport(48, 40), smooth_transfer());
    let (device, settings) = (device(), Settings { early_termination: false, ..Settings::default() });
    let mut alone = layersplat::Renderer::new(&device, &volume, &transfer).unwrap();
    let mut together = Renderer::new(group, &device, &shared(group, 2, 2), &transfer).unwrap();
    let tolerance = if group.size() == 1 { 0.0 } else { REASSOCIATED };
    for (n, camera) in views(&volume, size).iter().enumerate().filter(|(n, _)| [1, 3, 5, 8].contains(n)) {
        let [mut expected, mut found] = [(); 2].map(|()| Accumulation::new(size).unwrap());
        for _ in 0..5 {
            alone.accumulate(camera, &settings, &mut expected).unwrap();
            let through_trait: &mut dyn VolumeRenderer = &mut together;
            through_trait.accumulate(camera, &settings, &mut found).unwrap();
        }
        assert_eq!(found.frames(), 5);
        let (found, expected) = (found.mean().unwrap(), expected.mean().unwrap());
        if group.rank() > 0 {
            assert!(largest_opacity(&found) == 0.0, "only rank 0 gets pictures");
            continue;
        }
        assert_close(&format!("view {n} of {group:?}"), &found, &expected, tolerance);
        let (plain, _) = alone.render(camera, size, &settings).unwrap();
        assert!(compare(&plain, &expected).max_difference > 10.0 * REASSOCIATED, "the rays must move");
    }
    // A cancelled frame counts on no rank.
    let (mut accumulation, cancel) = (Accumulation::new(size).unwrap(), Cancel::new());
    cancel.cancel();
    together.set_cancel(Some(cancel));
    let camera = parallel(&volume, size, 20.0, -15.0);
    assert!(together.accumulate(&camera, &settings, &mut accumulation).is_err() && accumulation.frames() == 0);
}

/// Frame statistics of all ranks: without early termination, the ranks together composite the samples of one process.
pub fn are_measured(group: &Group) {
    let (volume, size, transfer) = (whole(), viewport(48, 40), smooth_transfer());
    let device = device();
    let mut alone = layersplat::Renderer::new(&device, &volume, &transfer).unwrap();
    alone.measure(true);
    let mut together = Renderer::new(group, &device, &shared(group, 2, 2), &transfer).unwrap();
    let through_trait: &mut dyn VolumeRenderer = &mut together;
    let views = views(&volume, size);
    for settings in [Settings::default(), splatted()] {
        let settings = Settings { early_termination: false, ..settings };
        for (n, camera) in [1, 3, 5, 8].map(|n| (n, &views[n])) {
            let what = format!("view {n} of {group:?}, {settings:?}");
            through_trait.measure(true);
            let (_, report) = through_trait.render(camera, size, &settings).unwrap();
            let (measured, ranks) = (report.measured.expect("measuring"), report.processes.expect("several processes").ranks);
            let expected = alone.render(camera, size, &settings).unwrap().1.measured.unwrap();
            let of_ranks: Vec<_> = ranks.iter().map(|rank| rank.measured.clone().expect("measuring")).collect();
            assert_eq!(of_ranks.len(), group.size());
            assert_eq!(of_ranks.iter().map(|rank| rank.active_samples).sum::<u64>(), expected.active_samples, "{what}");
            assert_eq!(measured.active_samples, expected.active_samples, "{what}");
            // A count without the layers of one rank would differ.
            assert!(of_ranks.iter().all(|rank| rank.active_samples > 0), "{what}: {of_ranks:?}");
            let time = |stages: &[(String, f64)], name: &str| stages.iter().find(|(stage, _)| stage == name).map(|(_, ms)| *ms);
            for (rank, own) in of_ranks.iter().enumerate() {
                assert!(time(&own.stages, "lattice").is_some_and(|ms| ms > 0.0), "{what}: {own:?}");
                assert_eq!(time(&own.stages, "warp").is_some(), rank == 0, "only rank 0 warps: {own:?}");
            }
            let own: Vec<_> = measured.stages.iter().map(|&(stage, ms)| (stage.to_owned(), ms)).collect();
            assert_eq!(own, of_ranks[group.rank()].stages);
            through_trait.measure(false);
            let (_, report) = through_trait.render(camera, size, &settings).unwrap();
            assert!(report.measured.is_none() && report.processes.unwrap().ranks.iter().all(|rank| rank.measured.is_none()));
        }
    }
}

pub fn are_the_same_again(group: &Group) {
    let (volume, size, transfer) = (whole(), viewport(64, 48), smooth_transfer());
    let once = || {
        let mut together = Renderer::new(group, &device(), &shared(group, 2, 2), &transfer).unwrap();
        views(&volume, size).iter().map(|camera| drawn(&mut together, camera, size, &Settings::default())).collect::<Vec<_>>()
    };
    for (first, second) in once().into_iter().zip(once()) {
        assert!(first.map(|(frame, _)| frame) == second.map(|(frame, _)| frame), "not the same bits");
    }
}

/// A new transfer function, a kernel that needs more layers, and a new volume.
pub fn follow_changes(group: &Group) {
    let (volume, size, transfer) = (whole(), viewport(48, 40), smooth_transfer());
    let device = device();
    let mut together = Renderer::new(group, &device, &shared(group, 2, 2), &transfer).unwrap();
    let camera = parallel(&volume, size, 30.0, 20.0);
    let plain = Settings { early_termination: false, ..Settings::default() };
    let wide =
        Settings { early_termination: false, ..with_kernel(Quality::Standard, layersplat::layers::Kernel::BSpline).into() };
    assert!(matches!(layered(wide).classification, Classification::Preintegrated { .. }));
    let steep = step_transfer(180.0, 0.4);
    for (transfer, settings) in [(&transfer, plain), (&transfer, wide), (&steep, wide), (&steep, plain)] {
        together.set_transfer_function(transfer);
        if let Some((frame, _)) = drawn(&mut together, &camera, size, &settings) {
            let expected = render(&volume, transfer, &camera, size, &settings);
            assert_close(&format!("{settings:?} of {group:?}"), &frame, &expected, REASSOCIATED);
        }
    }
    // Other voxels, in bricks along another axis, and back.
    for (seed, axis) in [(SEED + 1, 0), (SEED, 2)] {
        together.set_volume(&shared_of(seed, group, axis, 2)).unwrap();
        if let Some((frame, _)) = drawn(&mut together, &camera, size, &plain) {
            let expected = render(&whole_of(seed), &steep, &camera, size, &plain);
            assert_close(&format!("volume {seed} of {group:?}"), &frame, &expected, REASSOCIATED);
        }
    }
    // Nothing is sent without a change, and bricks that must not be moved for balance stay.
    if let Some((_, report)) = drawn(&mut together, &camera, size, &plain) {
        assert!(report.ranks.iter().all(|rank| rank.exchanged.received_bytes == 0), "{report:?}");
    }
    let corner = TransferFunction::new("corner", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0), (250.0, 0.0), (255.0, 0.5)]).unwrap();
    let lopsided = || {
        let brick = brick(group, 2, 2);
        let z = |n: usize| brick.held.first[2] + n / DIMS[0] / DIMS[1];
        let voxels: Vec<u8> = (0..brick.held.count()).map(|n| if z(n) < 6 { 255 } else { (z(n) * 3) as u8 }).collect();
        group.volume("lopsided", whole().grid().clone(), brick, voxels).unwrap()
    };
    for balance in [true, false] {
        let mut together = Renderer::new(group, &device, &lopsided(), &corner).unwrap();
        together.balance(balance);
        let Some((_, report)) = drawn(&mut together, &parallel(&volume, size, 5.0, 5.0), size, &plain) else { continue };
        let received: u64 = report.ranks.iter().map(|rank| rank.exchanged.received_bytes).sum();
        assert_eq!(received > 0, balance && group.size() > 1, "{report:?}");
        let layers: Vec<usize> = report.ranks.iter().map(|rank| rank.layers).collect();
        // All visible values lie in the first six layers.
        assert_eq!(layers.iter().all(|&n| n.abs_diff(DIMS[2] / group.size()) <= 1), !balance || group.size() == 1, "{layers:?}");
    }
}

/// Devices without a buffer for all layers of a rank.
pub fn in_several_buffers(group: &Group) {
    // Of 64 layers of 4096 voxels, 35 and those around them fit; the tables of a picture fit, too.
    let little = device().with_largest_buffer(160_000);
    let (size, transfer, options) = (viewport(20, 16), smooth_transfer(), layersplat::OpenOptions::default());
    let volume = Volume::open("builtin:gyroid@64", &options).unwrap();
    let shared = group.open("builtin:gyroid@64", &options).unwrap();
    let mut alone = layersplat::Renderer::new(&device(), &volume, &transfer).unwrap();
    let mut together = Renderer::new(group, &little, &shared, &transfer).unwrap();
    assert!(layersplat::Renderer::new(&little, &volume, &transfer).is_err(), "the volume must not fit into one buffer");
    for settings in [Quality::Standard.settings(), splatted()] {
        let settings = Settings { early_termination: false, ..settings };
        for camera in views(&volume, size).iter().take(6) {
            let Some((frame, _)) = drawn(&mut together, camera, size, &settings) else { continue };
            let (expected, _) = alone.render(camera, size, &settings).unwrap();
            assert_close(&format!("{group:?}"), &frame, &expected, if group.size() == 1 { 0.0 } else { REASSOCIATED });
        }
    }
}

/// Voxels in the ranks' own buffers, which change.
pub fn of_bricks_on_devices(group: &Group) {
    let (volume, size, transfer) = (whole(), viewport(48, 40), smooth_transfer());
    let mut there = BrickOnDevice::new(group, volume.grid());
    let BrickOnDevice { device, brick, all_bytes, description, .. } = &there;
    let (brick, all_bytes) = (*brick, all_bytes.clone());
    let mut together = Renderer::in_place(group, device, description, brick, &there.voxels(), &transfer).unwrap();
    let settings = Settings { early_termination: false, ..Settings::default() };
    let camera = parallel(&volume, size, 30.0, 20.0);
    let frame = drawn(&mut together, &camera, size, &settings);
    let all = |bytes: Vec<u8>| Volume::new("all", volume.grid().clone(), bytes).unwrap().with_background(0.0).unwrap();
    let expected = |bytes| render(&all(bytes), &transfer, &camera, size, &settings);
    if let Some((frame, report)) = frame {
        assert_close("on devices", &frame, &expected(all_bytes.clone()), REASSOCIATED);
        assert!(report.ranks.iter().all(|rank| rank.exchanged.received_bytes == 0));
    }
    let inverted = |bytes: Vec<u8>| bytes.into_iter().map(|byte| 255 - byte).collect::<Vec<u8>>();
    let voxels = inverted(held_bytes(&all_bytes, &brick).to_vec());
    // SAFETY: the buffer has as many bytes as there are voxels, which exist until they are written.
    unsafe { there.queue.enqueue_write_buffer(&mut there.buffer, 1, 0, &voxels, &[]).unwrap() };
    together.volume_changed(&[]).unwrap();
    if let Some((frame, _)) = drawn(&mut together, &camera, size, &settings) {
        assert_close("changed on devices", &frame, &expected(inverted(all_bytes)), REASSOCIATED);
    }
    // Along x, a rank lacks most of its layers.
    let across = together.render(&parallel(&volume, size, 85.0, 5.0), size, &settings).map(drop);
    if group.size() == 1 {
        across.unwrap();
    } else {
        let refused = across.unwrap_err().to_string();
        assert!(refused.contains("layer_axis") && refused.contains("ghost layers") && brick.held.dims[2] < DIMS[2], "{refused}");
    }
}
