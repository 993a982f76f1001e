//! Volumes in the caller's buffers.

use crate::common::{assert_close, device, layered, perspective, smooth_transfer, volume as volume_of};
use crate::host::{Host, SIZE, hosts};
use glam::DVec3;
use layersplat::device::DeviceMemory;
use layersplat::layers::Kernel;
use layersplat::renderer::{DeviceVoxels, UploadedVolume};
use layersplat::settings::{Algorithm, Blend, Classification, Layered};
use layersplat::volume::{Description, VoxelType, Voxels};
use layersplat::{Camera, Frame, Renderer, Settings, TransferFunction, Volume};
use std::sync::Barrier;

const DIMS: [usize; 3] = [19, 14, 16];
const SPACING: DVec3 = DVec3::new(1.0, 1.2, 0.9);
/// Unused voxels before the first one; below, gaps after each row and each layer.
const FIRST: usize = 5;
const ROW_GAP: usize = 3;
const LAYER_GAP: usize = 7;

fn values(seed: u64) -> Vec<u8> {
    crate::common::random_bytes(DIMS, seed)
}

fn cameras(volume: &Volume) -> Vec<Camera> {
    let along = [(80.0, 12.0), (15.0, 72.0), (20.0, -15.0)];
    let parallel = along.map(|(azimuth, elevation)| crate::common::parallel(volume, SIZE, azimuth, elevation));
    parallel.into_iter().chain([perspective(volume, 200.0, -10.0, 30.0)]).collect()
}

fn ways() -> Vec<Settings> {
    let settings = Settings::default();
    let bspline = Classification::Preintegrated { kernel: Kernel::BSpline, samples_per_layer: 1 };
    vec![
        settings,
        Settings { algorithm: Layered { classification: bspline, ..layered(settings) }.into(), ..settings },
        Settings { algorithm: Layered { classification: crate::common::SPLATTED, ..layered(settings) }.into(), ..settings },
        Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.5 }.into(),
    ]
}

/// Copies voxels to a layout with gaps, filled with another value.
fn spread<T: Copy>(voxels: &[T], gap: T) -> Vec<T> {
    let [x, y, _] = DIMS;
    let mut all = vec![gap; FIRST];
    for layer in voxels.chunks(x * y) {
        for row in layer.chunks(x) {
            all.extend_from_slice(row);
            all.extend([gap; ROW_GAP]);
        }
        all.extend([gap; LAYER_GAP]);
    }
    all
}

fn pitches(voxel: usize) -> (usize, usize) {
    let row = DIMS[0] + ROW_GAP;
    (row * voxel, (row * DIMS[1] + LAYER_GAP) * voxel)
}

/// Pictures from all sides, with all render paths.
fn pictures(renderer: &mut Renderer, volume: &Volume, ways: &[Settings]) -> Vec<Frame> {
    let mut frames = Vec::new();
    for settings in ways {
        for camera in cameras(volume) {
            frames.push(renderer.render(&camera, SIZE, settings).unwrap().0);
        }
    }
    frames
}

fn in_place<T: Copy>(
    host: &Host,
    voxels: &[T],
    voxel_type: VoxelType,
    volume: &Volume,
    transfer: &TransferFunction,
    gap: T,
) -> Renderer {
    let buffer = host.filled(&spread(voxels, gap));
    let (row, slice) = pitches(size_of::<T>());
    let memory = DeviceMemory::from_buffer(&buffer).unwrap();
    let placed = DeviceVoxels::new(&memory, voxel_type).with_first(FIRST * size_of::<T>()).with_pitches(row, slice);
    let description = placed.describe(&host.device(), "in place", volume.grid().clone(), &[]).unwrap();
    assert_eq!(description.range(), volume.range());
    assert_eq!(description.has_invalid_voxels(), volume.invalid() > 0);
    Renderer::from_uploaded(&UploadedVolume::in_place(&host.device(), &description, &placed).unwrap(), transfer).unwrap()
}

/// The declared range is not verified, so integrals extend beyond it: a sum in another order.
const GOES_ON: f64 = 2e-6;

#[test]
fn volumes_in_place_look_as_uploaded_ones() {
    for host in hosts() {
        let bytes = values(3);
        let shorts: Vec<i16> = bytes.iter().map(|&v| i16::from(v) * 90 - 7000).collect();
        let mut floats: Vec<f32> = bytes.iter().map(|&v| f32::from(v) * 0.01).collect();
        for (n, odd) in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3e30].into_iter().enumerate() {
            floats[700 * (n + 1)] = odd;
        }
        let uploaded = [Voxels::Uint8(bytes.clone()), Voxels::Int16(shorts.clone()), Voxels::Float32(floats.clone())]
            .map(|voxels| volume_of(DIMS, SPACING, voxels));
        // All for bytes, and each for one other type.
        let ways = ways();
        let ways = [&ways[..], &ways[..2], &ways[2..]];
        for (n, volume) in uploaded.iter().enumerate() {
            let transfer = TransferFunction::builtin("fire", volume).unwrap();
            let expected = pictures(&mut Renderer::new(&device(), volume, &transfer).unwrap(), volume, ways[n]);
            let mut renderer = match n {
                0 => in_place(&host, &bytes, VoxelType::Uint8, volume, &transfer, 255),
                1 => in_place(&host, &shorts, VoxelType::Int16, volume, &transfer, i16::MAX),
                _ => in_place(&host, &floats, VoxelType::Float32, volume, &transfer, f32::NAN),
            };
            for (found, expected) in pictures(&mut renderer, volume, ways[n]).iter().zip(&expected) {
                assert_close("in place", found, expected, GOES_ON);
            }
        }
    }
}

#[test]
fn changed_voxels_are_seen() {
    let transfer = smooth_transfer();
    let [before, after] = [3, 4].map(values);
    // Much of the new volume is empty, and some empty parts become visible.
    let after: Vec<u8> = after.iter().enumerate().map(|(n, &v)| if n % (19 * 14) < 100 { 0 } else { v / 2 + 40 }).collect();
    let [old, new] = [&before, &after].map(|v| volume_of(DIMS, SPACING, Voxels::Uint8(v.clone())));
    let description = Description::new("changing", old.grid().clone(), VoxelType::Uint8, (0.0, 255.0)).unwrap();
    let expect = |volume: &Volume| {
        let whole = Description::clone(&description);
        let buffer = Host::new(0);
        let memory = DeviceMemory::from_buffer(
            &buffer.filled(&(0..volume.grid().voxel_count()).map(|n| volume.value(n) as u8).collect::<Vec<_>>()),
        )
        .unwrap();
        let placed = DeviceVoxels::new(&memory, VoxelType::Uint8);
        let volume_there = UploadedVolume::in_place(&buffer.device(), &whole, &placed).unwrap();
        pictures(&mut Renderer::from_uploaded(&volume_there, &transfer).unwrap(), volume, &ways())
    };
    let expected = [&old, &new].map(expect);
    assert!(expected[0] != expected[1]);
    for host in hosts() {
        let mut buffer = host.filled(&before);
        let placed = DeviceVoxels::new(&DeviceMemory::from_buffer(&buffer).unwrap(), VoxelType::Uint8);
        let volume = UploadedVolume::in_place(&host.device(), &description, &placed).unwrap();
        let mut renderer = Renderer::from_uploaded(&volume, &transfer).unwrap();
        assert!(pictures(&mut renderer, &old, &ways()) == expected[0]);
        // SAFETY: the write does not block, and `after` lives until it completes.
        let written = unsafe { host.queue.enqueue_write_buffer(&mut buffer, 0, 0, &after, &[]) }.unwrap();
        let allocated = host.device().allocated_bytes();
        renderer.volume_changed(&[&written]).unwrap();
        assert!(pictures(&mut renderer, &new, &ways()) == expected[1]);
        assert_eq!(host.device().allocated_bytes(), allocated);
        written.wait().unwrap();
    }
}

/// A renderer of floats in place, with a declared range of 60 to 180.
fn promised(host: &Host, floats: &[f32]) -> (Renderer, Volume<'static>) {
    let within = floats.iter().map(|v| v.clamp(60.0, 180.0)).collect();
    let volume = volume_of(DIMS, SPACING, Voxels::Float32(within)).with_background(60.0).unwrap();
    let colors = vec![(60.0, [0.1, 0.2, 0.9]), (180.0, [1.0, 0.6, 0.2])];
    let transfer = TransferFunction::new("promised", colors, vec![(60.0, 0.05), (180.0, 0.6)]).unwrap();
    let placed = DeviceVoxels::new(&DeviceMemory::from_buffer(&host.filled(floats)).unwrap(), VoxelType::Float32);
    let description = Description::new("promised", volume.grid().clone(), VoxelType::Float32, (60.0, 180.0)).unwrap();
    let there = UploadedVolume::in_place(&host.device(), &description, &placed).unwrap();
    (Renderer::from_uploaded(&there, &transfer).unwrap(), volume)
}

/// Values outside the declared range are rendered like its ends.
#[test]
fn values_beyond_the_promised_range_show_as_its_ends() {
    let host = Host::new(0);
    let unlit = Settings { shading: None, ..Settings::default() };
    let maximum = Settings { blend: Blend::Maximum, ..unlit };
    let ends = |value: f32| promised(&host, &vec![value; DIMS.iter().product()]);
    for (beyond, end) in [(500.0, 180.0), (-300.0, 60.0)] {
        let [(mut beyond, volume), (mut end, _)] = [beyond, end].map(ends);
        for camera in cameras(&volume) {
            // Modes that reduce values repeat edge voxels: the field is constant.
            let [beyond, end] = [&mut beyond, &mut end].map(|renderer| renderer.render(&camera, SIZE, &maximum).unwrap().0);
            assert!(end.pixels().iter().any(|p| p[3] > 0.04));
            assert!(beyond == end);
        }
    }
    let floats: Vec<f32> = values(9).into_iter().map(f32::from).collect();
    let (mut renderer, volume) = promised(&host, &floats);
    for camera in cameras(&volume) {
        let (frame, _) = renderer.render(&camera, SIZE, &unlit).unwrap();
        assert!(frame.pixels().iter().flatten().all(|x| x.is_finite() && (0.0..=1.0 + 1e-5).contains(x)));
        assert!(frame.pixels().iter().any(|p| p[3] > 0.05));
    }
}

/// Two renderers of one field, each in its own thread, draw at the same time what each draws alone: they share the voxels, and what is
/// prepared from them when the first frame needs it.
#[test]
fn two_threads_render_one_field() {
    const ROUNDS: usize = 2;
    let volume = volume_of(DIMS, SPACING, Voxels::Uint8(values(3)));
    let transfers = [smooth_transfer(), smooth_transfer().faded(0.4).unwrap()];
    let frames: Vec<(Settings, Camera)> =
        ways().into_iter().flat_map(|settings| cameras(&volume).into_iter().map(move |camera| (settings, camera))).collect();
    let draw =
        |renderer: &mut Renderer, (settings, camera): &(Settings, Camera)| renderer.render(camera, SIZE, settings).unwrap().0;
    let alone = transfers.each_ref().map(|transfer| {
        let mut renderer = Renderer::new(&device(), &volume, transfer).unwrap();
        frames.iter().map(|frame| draw(&mut renderer, frame)).collect::<Vec<Frame>>()
    });
    assert!(alone[0].iter().zip(&alone[1]).all(|(a, b)| a != b), "the picture of the other renderer must be noticed");
    for round in 0..ROUNDS {
        // First both prepare the same at the same time, then each what the other has not begun.
        let first = [0, round * frames.len() / ROUNDS];
        let field = UploadedVolume::new(&device(), &volume).unwrap();
        let start = Barrier::new(2);
        std::thread::scope(|scope| {
            for n in 0..2 {
                let (field, start, frames, draw) = (field.clone(), &start, &frames, &draw);
                let (transfer, expected) = (&transfers[n], &alone[n]);
                scope.spawn(move || {
                    let mut renderer = Renderer::from_uploaded(&field, transfer).unwrap();
                    start.wait();
                    for frame in (0..frames.len()).map(|i| (first[n] + i) % frames.len()) {
                        let found = draw(&mut renderer, &frames[frame]);
                        assert!(found == expected[frame], "round {round}, renderer {n}: {:?}", frames[frame]);
                    }
                });
            }
        });
    }
}

/// The next volume is uploaded while frames of this one are rendered.
#[test]
fn a_volume_is_uploaded_while_another_is_rendered() {
    const FRAMES: usize = 20;
    let [volume, next] = [3, 4].map(|seed| volume_of(DIMS, SPACING, Voxels::Uint8(values(seed))));
    let (camera, settings) = (cameras(&volume)[0], Settings::default());
    let drawn = |renderer: &mut Renderer| renderer.render(&camera, SIZE, &settings).unwrap().0;
    let expected = [&volume, &next].map(|volume| drawn(&mut Renderer::new(&device(), volume, &smooth_transfer()).unwrap()));
    assert!(expected[0] != expected[1]);
    let mut renderer = Renderer::new(&device(), &volume, &smooth_transfer()).unwrap();
    let start = Barrier::new(2);
    let uploaded = std::thread::scope(|scope| {
        let upload = scope.spawn(|| {
            start.wait();
            let mut uploaded = UploadedVolume::new(&device(), &next).unwrap();
            (1..FRAMES).for_each(|_| uploaded = UploadedVolume::new(&device(), &next).unwrap());
            uploaded
        });
        start.wait();
        (0..FRAMES).for_each(|frame| assert!(drawn(&mut renderer) == expected[0], "frame {frame}"));
        upload.join().unwrap()
    });
    renderer.set_uploaded_volume(&uploaded).unwrap();
    assert!(drawn(&mut renderer) == expected[1]);
}

/// A look at voxels on the device warns as one at voxels in memory does.
#[test]
fn invalid_voxels_in_place_are_told_once() {
    let host = Host::new(0);
    let mut floats: Vec<f32> = values(3).into_iter().map(f32::from).collect();
    let grid = volume_of(DIMS, SPACING, Voxels::Float32(floats.clone())).grid().clone();
    let warnings = |floats: &[f32]| {
        let buffer = host.filled(floats);
        let placed = DeviceVoxels::new(&DeviceMemory::from_buffer(&buffer).unwrap(), VoxelType::Float32);
        crate::told::warnings(|| {
            let description = placed.describe(&host.device(), "in place", grid.clone(), &[]).unwrap();
            UploadedVolume::in_place(&host.device(), &description, &placed).unwrap();
        })
    };
    assert_eq!(warnings(&floats), [""; 0]);
    (floats[5], floats[77]) = (3e30, f32::NAN);
    let found = warnings(&floats);
    assert!(matches!(&found[..], [one] if one.contains("in place: 2 voxels are NaN")), "{found:?}");
}
