//! GPU schedule of layers, one work-item per lattice sample: against the f64 reference and against tiles, on any device.

use crate::common::blends::*;
use crate::common::reference::{Pair, largest};
use crate::common::*;
use glam::DVec3;
use layersplat::device::{LatticeSchedule, Tuning};
use layersplat::layers::{Correction, Density, Kernel, Rays};
use layersplat::renderer::{LatticePicture, Plan};
use layersplat::settings::{Blend, Classification, Evaluation, Layered};
use layersplat::volume::Voxels;
use layersplat::{Camera, Device, Renderer, Settings, TransferFunction, Viewport, Volume};

/// Sums of the same floats in another order. A few rays differ more, because a value rounds to another node or entry of the table.
const REORDERED: f64 = 1e-5;
const ANOTHER_NODE: f64 = 1e-4;
const ANOTHER_NODE_SHARE: f64 = 4e-3;
/// Tiles continue until all their rays are opaque, so they show some light behind an opaque ray: less than a sixteenth of an 8-bit step
/// (`SampleParams::opaque`).
const BEHIND_OPAQUE: f64 = 2.6e-4;

/// Each axis from both sides, and views in between.
const VIEWS: [(f64, f64); 9] = [
    (0.0, 0.0),
    (20.0, -15.0),
    (90.0, 0.0),
    (-75.0, 10.0),
    (0.0, 90.0),
    (180.0, 0.0),
    (10.0, -80.0),
    (-160.0, 25.0),
    (100.0, 30.0),
];

fn with(lattice_schedule: LatticeSchedule) -> Device {
    let device = device();
    device.with_tuning(Tuning { lattice_schedule, ..*device.tuning() }).unwrap()
}

fn points(kernel: Kernel, samples_per_layer: u32) -> Settings {
    let classification = Classification::Preintegrated { kernel, samples_per_layer };
    let evaluation = Evaluation::Lattice(Density::Fixed(2));
    let settings: Settings = Layered { classification, evaluation, ..Layered::default() }.into();
    Settings { early_termination: false, ..settings }
}

fn splats(correction: Correction) -> Settings {
    let (classification, evaluation) = (Classification::Post(correction), Evaluation::Lattice(Density::Fixed(2)));
    let settings: Settings = Layered { classification, evaluation, ..Layered::default() }.into();
    Settings { early_termination: false, ..settings }
}

fn unlit(settings: Settings) -> Settings {
    Settings { shading: None, ..settings }
}

fn cut(settings: Settings) -> Settings {
    Settings { clipping: cuts(), ..settings }
}

fn blended(blend: Blend, settings: Settings) -> Settings {
    Settings { blend, ..settings }
}

/// Every kernel, one and two samples per layer, lit and unlit, clipped and not, and every blend mode, but not all combinations.
fn variants() -> Vec<Settings> {
    use Kernel::{BSpline, CatmullRom, Cubic, Linear};
    vec![
        points(Cubic, 1),
        unlit(points(Cubic, 2)),
        cut(points(Cubic, 2)),
        cut(unlit(points(Linear, 1))),
        points(CatmullRom, 1),
        cut(points(CatmullRom, 2)),
        unlit(points(CatmullRom, 2)),
        points(BSpline, 2),
        cut(points(BSpline, 1)),
        blended(Blend::Maximum, unlit(points(Cubic, 1))),
        blended(Blend::Minimum, cut(unlit(points(CatmullRom, 2)))),
        blended(Blend::Average, unlit(points(BSpline, 1))),
        blended(Blend::Average, cut(unlit(points(Cubic, 2)))),
        blended(Blend::Iso(ISO), points(Cubic, 1)),
        blended(Blend::Iso(ISO), cut(points(BSpline, 2))),
        splats(Correction::Constant),
        cut(splats(Correction::SubLayers(2))),
        unlit(splats(Correction::SubLayers(3))),
        blended(Blend::Maximum, unlit(splats(Correction::None))),
        blended(Blend::Average, cut(unlit(splats(Correction::SubLayers(2))))),
    ]
}

/// A view, alternating between both projections.
fn camera(volume: &Volume, size: Viewport, n: usize) -> (Camera, bool) {
    let (azimuth, elevation) = VIEWS[n % VIEWS.len()];
    let is_parallel = n.is_multiple_of(2);
    (
        if is_parallel { parallel(volume, size, azimuth, elevation) } else { perspective(volume, azimuth, elevation, 25.0) },
        is_parallel,
    )
}

fn lattice(
    device: &Device,
    volume: &Volume,
    transfer: &TransferFunction,
    camera: &Camera,
    size: Viewport,
    settings: &Settings,
) -> LatticePicture {
    let mut renderer = Renderer::new(device, volume, transfer).unwrap();
    renderer.lattice_picture(camera, size, settings).unwrap().expect("a lattice")
}

fn largest_difference(a: &LatticePicture, b: &LatticePicture) -> f64 {
    assert_eq!(a.size, b.size);
    let channels = a.samples.as_flattened().iter().zip(b.samples.as_flattened());
    largest(channels.map(|(a, b)| f64::from(a - b).abs()))
}

/// Fraction of samples that differ by more than a tolerance in a channel, alpha included.
fn differing(a: &LatticePicture, b: &LatticePicture, tolerance: f64) -> f64 {
    let beyond = |(a, b): (&[f32; 4], &[f32; 4])| !(0..4).all(|i| f64::from(a[i] - b[i]).abs() <= tolerance);
    a.samples.iter().zip(&b.samples).filter(|&pair| beyond(pair)).count() as f64 / a.samples.len() as f64
}

#[test]
fn every_kernel_and_blend_mode_is_the_references() {
    let (volume, transfer, size) = (bump(), smooth_transfer(), viewport(21, 19));
    let device = with(LatticeSchedule::Samples);
    for (n, settings) in variants().into_iter().enumerate() {
        // In both projections.
        for view in [n, n + 5] {
            let (camera, is_parallel) = camera(&volume, size, view);
            let plan = Plan::new(&Rays::new(&camera, size, volume.grid()).unwrap(), size, volume.grid(), &settings).unwrap();
            assert!(matches!(plan, Plan::Lattice(..)), "view {view}: {plan}");
            let pair = Pair::on(&device, &volume, &transfer, &camera, size, &settings);
            // This schedule uses exact footprints in both projections.
            let is_exact = is_parallel || is_splatted(settings.algorithm);
            pair.assert_same(&format!("view {view}: {settings:?}"), tolerance_of(&settings, is_exact));
        }
    }
}

#[test]
fn samples_are_those_of_tiles() {
    let volume = random_volume([23, 19, 21], DVec3::new(1.0, 0.8, 1.2), 3);
    let (transfer, size) = (smooth_transfer(), viewport(37, 29));
    let [tiles, samples] = [LatticeSchedule::Tiles, LatticeSchedule::Samples].map(with);
    let every_third = variants().into_iter().enumerate().filter(|(n, settings)| n % 3 == 0 || is_splatted(settings.algorithm));
    for (n, settings) in every_third {
        // Tiles use eight quadrature nodes for footprints in a perspective.
        let (camera, _) = camera(&volume, size, if is_splatted(settings.algorithm) { 2 * n } else { n });
        let draw = |device, settings: &Settings| lattice(device, &volume, &transfer, &camera, size, settings);
        let (of_tiles, of_samples) = (draw(&tiles, &settings), draw(&samples, &settings));
        let difference = largest_difference(&of_tiles, &of_samples);
        assert!(difference <= ANOTHER_NODE, "{settings:?}: {difference}");
        let share = differing(&of_tiles, &of_samples, REORDERED);
        assert!(share <= ANOTHER_NODE_SHARE, "{settings:?}: {share} of the samples differ");
        let mut shifted = of_tiles.clone();
        shifted.samples.rotate_right(1);
        let noticed = differing(&shifted, &of_samples, REORDERED);
        assert!(noticed > 10.0 * ANOTHER_NODE_SHARE, "{settings:?}: a shift by one sample changes only {noticed} of them");
        let ends_early = Settings { early_termination: true, ..settings };
        let difference = largest_difference(&of_tiles, &draw(&samples, &ends_early));
        assert!(difference <= BEHIND_OPAQUE + ANOTHER_NODE, "{ends_early:?}: {difference}");
    }
}

#[test]
fn thin_volumes_are_the_references() {
    let device = with(LatticeSchedule::Samples);
    let (transfer, size) = (smooth_transfer(), viewport(21, 19));
    for (n, dims) in [[1, 1, 1], [1, 7, 4], [6, 1, 5], [5, 9, 1], [2, 3, 33]].into_iter().enumerate() {
        let volume = random_volume(dims, DVec3::new(1.0, 0.7, 1.3), n as u64);
        let (splatted, settings) = (splats(Correction::SubLayers(2)), |kernel| points(kernel, 1));
        let all = [settings(Kernel::Cubic), settings(Kernel::CatmullRom), settings(Kernel::BSpline), splatted];
        for (settings, view) in all.into_iter().zip((n..).step_by(2)) {
            let (azimuth, elevation) = VIEWS[view % VIEWS.len()];
            let camera = parallel(&volume, size, azimuth, elevation);
            let pair = Pair::on(&device, &volume, &transfer, &camera, size, &settings);
            assert!(pair.expected.iter().any(|pixel| pixel[3] > 0.02), "{dims:?} from {view}: the picture is empty");
            let largest = pair.largest();
            assert!(largest <= DEVICE_TOLERANCE, "{dims:?} from {view}, {settings:?}: {largest}");
        }
    }
}

#[test]
fn runs_groups_and_culling_change_no_bit() {
    let (volume, transfer, size) = (mostly_empty(), smooth_transfer(), viewport(45, 39));
    let samples = with(LatticeSchedule::Samples);
    let large = samples.with_tuning(Tuning { sample_tile: [16, 12], ..*samples.tuning() }).unwrap();
    let some = variants().into_iter().enumerate().filter(|(n, settings)| n % 4 == 0 || is_splatted(settings.algorithm));
    for (n, settings) in some {
        let (camera, _) = camera(&volume, size, n);
        let draw = |device, settings: &Settings| lattice(device, &volume, &transfer, &camera, size, settings);
        let first = draw(&samples, &settings);
        assert!(first.samples.iter().any(|sample| sample[3] > 0.02), "{settings:?}: the picture is empty");
        assert_eq!(first.samples, draw(&samples, &settings).samples, "{settings:?}: another run");
        assert_eq!(first.samples, draw(&large, &settings).samples, "{settings:?}: larger groups");
        let everything = Settings { culling: false, ..settings };
        assert_eq!(first.samples, draw(&samples, &everything).samples, "{settings:?}: without culling");
        let other = draw(&samples, &unlit(points(Kernel::Linear, 1)));
        assert_ne!(first.samples, other.samples, "{settings:?}: a different picture must be detected");
    }
}

/// Isolated voxels, which few slabs and rays meet: a sample that a group omits would be visible.
#[test]
fn culling_changes_no_bit_of_scattered_voxels() {
    const DIMS: [usize; 3] = [41, 37, 46];
    const EVERY: usize = 331;
    let voxels = (0..DIMS.iter().product()).map(|n| if n % EVERY == 7 { 255 } else { 0 }).collect();
    let volume = volume(DIMS, DVec3::new(1.0, 1.1, 0.9), Voxels::Uint8(voxels));
    let opacities = vec![(0.0, 0.0), (15.0, 0.0), (60.0, 0.6), (255.0, 0.9)];
    let (transfer, size) = (smooth_transfer().with_opacities(opacities).unwrap(), viewport(101, 93));
    let device = with(LatticeSchedule::Samples);
    let small = device.with_tuning(Tuning { sample_tile: [8, 4], ..*device.tuning() }).unwrap();
    let mut renderer = Renderer::new(&small, &volume, &transfer).unwrap();
    let relaxed = Layered { evaluation: Evaluation::Lattice(Density::Relaxed), ..layered(points(Kernel::Cubic, 1)) };
    let all = [
        points(Kernel::Cubic, 1),
        points(Kernel::BSpline, 2),
        splats(Correction::SubLayers(2)),
        Settings { algorithm: relaxed.into(), ..points(Kernel::Cubic, 1) },
    ];
    for (azimuth, elevation) in VIEWS {
        for camera in [parallel(&volume, size, azimuth, elevation), perspective(&volume, azimuth, elevation, 40.0)] {
            for settings in &all {
                let mut draw = |culling| {
                    renderer
                        .lattice_picture(&camera, size, &Settings { culling, ..*settings })
                        .unwrap()
                        .expect("a lattice")
                        .samples
                };
                let (culled, whole) = (draw(true), draw(false));
                assert!(culled.iter().any(|sample| sample[3] > 0.3), "the picture is empty");
                assert!(culled == whole, "{azimuth}, {elevation}, {:?}, {settings:?}", camera.projection);
            }
        }
    }
}

/// More layers than a group looks up at once (kernels/layered/visible_group.cl): layers behind these must be visible from either side.
#[test]
fn volumes_of_very_many_layers_are_those_of_tiles() {
    const DIMS: [usize; 3] = [9, 7, 8300];
    const FULL: usize = 60;
    let noise = random_bytes([DIMS[0], DIMS[1], FULL], 5);
    let mut voxels = vec![0; DIMS[0] * DIMS[1] * (DIMS[2] - FULL)];
    voxels.extend(noise);
    let volume = volume(DIMS, DVec3::new(1.0, 1.0, 1e-3), Voxels::Uint8(voxels));
    let (transfer, size) = (smooth_transfer(), viewport(31, 27));
    let [tiles, samples] = [LatticeSchedule::Tiles, LatticeSchedule::Samples].map(with);
    let [points, splats] = [points(Kernel::Cubic, 1), splats(Correction::Constant)];
    for (settings, azimuth) in [(points, 0.0), (points, 180.0), (splats, 0.0), (splats, 180.0)] {
        let camera = parallel(&volume, size, azimuth, 0.01);
        let of = |device| lattice(device, &volume, &transfer, &camera, size, &settings);
        let (of_tiles, of_samples) = (of(&tiles), of(&samples));
        let seen = of_tiles.samples.iter().filter(|sample| sample[3] > 0.02).count();
        assert!(seen > 100, "{settings:?} from {azimuth}: {seen} samples to see");
        // Thousands of layers from the centre, positions are rounded to a ten-thousandth of a voxel.
        let difference = largest_difference(&of_tiles, &of_samples);
        assert!(difference <= ANOTHER_NODE, "{settings:?} from {azimuth}: {difference}");
    }
}

/// Bands of voxels around the last slab that a group looks up, counted from either side. Slabs behind it count as visible.
#[test]
fn slabs_around_the_last_one_looked_up_are_seen() {
    const DIMS: [usize; 3] = [9, 7, 8300];
    /// kernels/layered/visible_group.cl.
    const MOST_LOOKED_UP: usize = 8192;
    const HALF_BAND: usize = 6;
    let mut voxels = vec![0; DIMS.iter().product()];
    let layer = DIMS[0] * DIMS[1];
    let noise = random_bytes([DIMS[0], DIMS[1], 2 * HALF_BAND], 6);
    for middle in [MOST_LOOKED_UP, DIMS[2] - MOST_LOOKED_UP] {
        voxels[(middle - HALF_BAND) * layer..(middle + HALF_BAND) * layer].copy_from_slice(&noise);
    }
    let volume = volume(DIMS, DVec3::new(1.0, 1.0, 1e-3), Voxels::Uint8(voxels));
    // Faint, so that the second band is seen behind the first.
    let (transfer, size) = (smooth_transfer().faded(0.02).unwrap(), viewport(31, 27));
    let [tiles, samples] = [LatticeSchedule::Tiles, LatticeSchedule::Samples].map(with);
    let once = points(Kernel::Cubic, 1);
    let all = [once, points(Kernel::BSpline, 1), unlit(points(Kernel::Cubic, 2)), splats(Correction::Constant)];
    for settings in all.into_iter().chain([blended(Blend::Maximum, unlit(once))]) {
        for azimuth in [0.0, 180.0] {
            let camera = parallel(&volume, size, azimuth, 0.01);
            let of = |device, culling| lattice(device, &volume, &transfer, &camera, size, &Settings { culling, ..settings });
            let (culled, whole) = (of(&samples, true), of(&samples, false));
            let seen = culled.samples.iter().filter(|sample| sample[3] > 0.02).count();
            assert!(seen > 100, "{settings:?} from {azimuth}: {seen} samples to see");
            assert!(culled.samples == whole.samples, "{settings:?} from {azimuth}: culling changes samples");
            // Thousands of layers from the middle, places are rounded to a ten-thousandth of a voxel.
            let difference = largest_difference(&of(&tiles, true), &culled);
            assert!(difference <= ANOTHER_NODE, "{settings:?} from {azimuth}: {difference}");
        }
    }
}

/// The warp skips by the counts per group: its picture must equal that of tiles.
#[test]
fn frames_are_those_of_tiles() {
    let (volume, transfer, size) = (mostly_empty(), smooth_transfer(), viewport(45, 39));
    let camera = perspective(&volume, 20.0, 10.0, 25.0);
    let settings = points(Kernel::Cubic, 1);
    let [tiles, samples] = [LatticeSchedule::Tiles, LatticeSchedule::Samples].map(|schedule| {
        let mut renderer = Renderer::new(&with(schedule), &volume, &transfer).unwrap();
        renderer.measure(true);
        let (frame, report) = renderer.render(&camera, size, &settings).unwrap();
        (frame, report.measured.unwrap().active_samples)
    });
    let difference = compare(&tiles.0, &samples.0).max_difference;
    assert!(difference <= ANOTHER_NODE, "{difference}");
    assert!(tiles.1 > 1000, "the count must not be trivial: {}", tiles.1);
    assert_eq!(tiles.1, samples.1, "samples with opacity");
}
